//! Stage 3: ranks the occupied voxels, picks the triangles that win them, works out their records.
//!
//! Whatever method marked the voxels, the same passes follow. `rank` numbers them by a prefix sum over the words' bit
//! counts. `winners` lets every triangle compete, by one `atomicMax`, for the marked voxels that it comes near; in six
//! slots a voxel, by the dominant axis and the side of its normal, so that walls thinner than a voxel keep both their
//! faces. `records` keeps up to three sheets a voxel that face each other or clearly differ; voxels that no triangle
//! claims (an approximate method's) take the mean normal of their neighbours.

mod large;

use crate::animate::{Triangles, Vertex};
use crate::gpu::{ComputePass, Gpu, GpuError, GpuStruct, Recorder, buffer};
use crate::grid::{Grid, ORTHOGRAPHIC, PERSPECTIVE};
use crate::scene::material::PartMaterial;
use crate::volume::{CHUNK, GridCounters, Record, Volume};
pub(crate) use large::LargeTriangles;

/// `VoxelDispatch` of `lib/volume.inc.wgsl`.
const VOXEL_DISPATCH_BYTES: u64 = 16;

/// The passes.
#[derive(Debug)]
pub struct Resolve {
    rank: RankPasses,
    /// Orthographic, then perspective.
    by_projection: [ClaimPasses; 2],
    place_sheets: ComputePass,
    mend: ComputePass,
    voxel_dispatch: wgpu::Buffer,
    large: LargeTriangles,
}

/// Passes that work out claims in grid space: compiled for one projection.
#[derive(Debug)]
struct ClaimPasses {
    winners: ComputePass,
    winners_large: ComputePass,
    records: ComputePass,
}

#[derive(Debug)]
struct RankPasses {
    reduce: ComputePass,
    scan_words: ComputePass,
    spread: ComputePass,
    list: ComputePass,
    scan_sheets: ComputePass,
}

impl Resolve {
    /// Compiles the passes.
    ///
    /// # Errors
    /// When a shader is wrong.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let layouts = [Grid::LAYOUT, GridCounters::LAYOUT, Record::LAYOUT, Vertex::LAYOUT, PartMaterial::LAYOUT];
        let pass = |shader, entry| ComputePass::new(gpu, shader, entry, &layouts);
        let claims = |projection: u32| -> Result<ClaimPasses, GpuError> {
            let constants = [("perspective", f64::from(projection))];
            let pass = |shader, entry| ComputePass::with_constants(gpu, shader, entry, &layouts, &constants);
            Ok(ClaimPasses {
                winners: pass("resolve/winners.wgsl", "main")?,
                winners_large: pass("resolve/winners.wgsl", "large")?,
                records: pass("resolve/records.wgsl", "main")?,
            })
        };
        let rank = |entry| pass("resolve/rank.wgsl", entry);
        let dispatch = buffer::STORAGE | wgpu::BufferUsages::INDIRECT;
        Ok(Self {
            rank: RankPasses {
                reduce: rank("reduce")?,
                scan_words: rank("scan_words")?,
                spread: rank("spread")?,
                list: rank("list")?,
                scan_sheets: rank("scan_sheets")?,
            },
            by_projection: [claims(ORTHOGRAPHIC)?, claims(PERSPECTIVE)?],
            place_sheets: pass("resolve/records.wgsl", "place_sheets")?,
            mend: pass("resolve/records.wgsl", "mend")?,
            voxel_dispatch: buffer::with_usage(gpu, "voxel_dispatch", 3 * VOXEL_DISPATCH_BYTES, dispatch)?,
            large: LargeTriangles::new(gpu)?,
        })
    }

    /// Records the stage for one grid.
    pub fn record(&self, rec: &mut Recorder<'_>, volume: &Volume, grid: usize, triangles: &Triangles) {
        self.record_rank(rec, volume, grid);
        self.record_winners(rec, volume, grid, triangles);
        self.record_records(rec, volume, grid, triangles);
    }

    /// Numbers the occupied voxels and leaves each one's cell in its record's place.
    pub fn record_rank(&self, rec: &mut Recorder<'_>, volume: &Volume, grid: usize) {
        let Some(g) = volume.grids.get(grid) else { return };
        self.record_scan(rec, volume, grid);
        let group = self.rank.list.bind_used(rec.gpu, &resources(volume, grid));
        self.rank.list.dispatch(&mut rec.encoder, &group, [g.word_count(), 1, 1]);
    }

    /// Numbers the occupied voxels: a prefix sum over the words' bit counts.
    pub fn record_scan(&self, rec: &mut Recorder<'_>, volume: &Volume, grid: usize) {
        let Some(g) = volume.grids.get(grid) else { return };
        let RankPasses { reduce, scan_words, spread, .. } = &self.rank;
        let chunks = g.word_count().div_ceil(CHUNK);
        let mut all = resources(volume, grid);
        all.push(("voxel_dispatch", self.voxel_dispatch.as_entire_binding()));
        for (pass, threads) in [(reduce, chunks), (scan_words, 1), (spread, chunks)] {
            let group = pass.bind_used(rec.gpu, &all);
            pass.dispatch(&mut rec.encoder, &group, [threads, 1, 1]);
        }
    }

    /// Lets every triangle compete for the voxels; leaves the winners in `keys`.
    pub fn record_winners(&self, rec: &mut Recorder<'_>, volume: &Volume, grid: usize, triangles: &Triangles) {
        let Some(claims) = self.claims(volume, grid) else { return };
        let mut all = resources(volume, grid);
        all.extend(triangle_resources(triangles));
        self.large.record(rec, [&claims.winners, &claims.winners_large], &all, triangles.triangle_count);
    }

    /// `VoxelDispatch` of `lib/volume.inc.wgsl`, three times: how many voxels there are.
    pub(crate) fn voxel_dispatch(&self) -> &wgpu::Buffer {
        &self.voxel_dispatch
    }

    fn claims(&self, volume: &Volume, grid: usize) -> Option<&ClaimPasses> {
        volume.grids.get(grid).map(|g| &self.by_projection[usize::from(g.projection == PERSPECTIVE)])
    }

    /// Makes the records of the winners and clears `keys` for the next grid.
    pub fn record_records(&self, rec: &mut Recorder<'_>, volume: &Volume, grid: usize, triangles: &Triangles) {
        let Some(claims) = self.claims(volume, grid) else { return };
        rec.encoder.clear_buffer(&volume.chunk_sums, 0, None);
        let mut all = resources(volume, grid);
        all.extend(triangle_resources(triangles));
        all.push(("voxel_dispatch", self.voxel_dispatch.as_entire_binding()));
        let over_voxels = |rec: &mut Recorder<'_>, pass: &ComputePass, index: u64| {
            let group = pass.bind_used(rec.gpu, &all);
            pass.dispatch_indirect(&mut rec.encoder, &group, &self.voxel_dispatch, index * VOXEL_DISPATCH_BYTES);
        };
        over_voxels(rec, &claims.records, 0);
        let group = self.rank.scan_sheets.bind_used(rec.gpu, &all);
        self.rank.scan_sheets.dispatch(&mut rec.encoder, &group, [1, 1, 1]);
        over_voxels(rec, &self.place_sheets, 1);
        over_voxels(rec, &self.mend, 2);
    }
}

/// Names and buffers.
pub(crate) type Resources<'a> = Vec<(&'static str, wgpu::BindingResource<'a>)>;

/// What passes over one grid bind.
pub(crate) fn resources(volume: &Volume, grid: usize) -> Resources<'_> {
    vec![
        ("grids", volume.grid_data.as_entire_binding()),
        ("grid_index", volume.grid_index[grid].as_entire_binding()),
        ("occupancy", volume.occupancy.as_entire_binding()),
        ("ranks", volume.ranks.as_entire_binding()),
        ("records", volume.records.as_entire_binding()),
        ("keys", volume.keys.as_entire_binding()),
        ("chunk_sums", volume.chunk_sums.as_entire_binding()),
        ("interior", volume.interior.as_entire_binding()),
        ("counters", volume.counters.as_entire_binding()),
    ]
}

/// What passes over the triangles bind.
pub(crate) fn triangle_resources(triangles: &Triangles) -> Resources<'_> {
    vec![
        ("vertices", triangles.vertices.as_entire_binding()),
        ("indices", triangles.indices.as_entire_binding()),
        ("materials", triangles.materials.as_entire_binding()),
    ]
}
