//! Voxelizes one world-aligned grid and reads it back.

use crate::animate::{Animate, Triangles, Vertex};
use crate::csg::{self, Csg};
use crate::fill::FillInterior;
use crate::gpu::{Gpu, GpuError, Recorder, Timing, buffer};
use crate::grid::Grid;
use crate::resolve::Resolve;
use crate::scene::description::{Fill, VoxelizerSettings};
use crate::scene::material::Material;
use crate::scene::{Scene, World};
use crate::volume::Volume;
use crate::voxel_file::VoxelBody;
use crate::voxel_list::VoxelList;
use crate::voxelize::{self, Voxelizer};

/// Times a grid is resolved again until every record has room.
const MAX_TRIES: u32 = 4;

/// What marks one grid.
struct Marking {
    triangles: Triangles,
    fill: FillInterior,
    /// Whether the inside is asked for, of a method that does not make it by itself.
    fills: bool,
    settings: VoxelizerSettings,
    voxelizer: Box<dyn Voxelizer>,
    volume: Volume,
    /// Where models are made of others.
    csg: Option<(Csg, Resolve)>,
}

/// The voxels of `grid` that the scene's surfaces meet at a time, or with `solid` those whose centre is inside too: all
/// that a file can hold of them. For the marks alone there is [`VoxelSlabs`](super::VoxelSlabs).
///
/// # Errors
/// When the device refuses a buffer, or is lost.
pub fn voxel_body(
    gpu: &Gpu,
    scene: &Scene,
    world: &World,
    time_secs: f64,
    grid: Grid,
    solid: bool,
) -> Result<(VoxelBody, f64), GpuError> {
    let world = &world.at(scene, time_secs, None);
    let mut marking = Marking::new(gpu, scene, world, time_secs, grid, solid)?;
    let ms = marking.time(gpu)?;
    let words = if solid { &marking.volume.interior } else { &marking.volume.occupancy };
    let marked = grid.cell_bytes(&marking.words(gpu, words)?);
    let materials = world.materials(scene);
    let interior = if solid { Some(marking.parts_inside(gpu, world, &materials)?) } else { None };
    let voxels = marking.list(gpu)?;
    let names = world.parts.iter().map(|part| part.name.clone());
    let body = VoxelBody {
        cells: grid.cells,
        origin: grid.world_from_grid.w_axis.truncate().as_dvec3(),
        cell: f64::from(grid.cell_size),
        marked,
        interior,
        voxels,
        parts: names.zip(materials).collect(),
    };
    Ok((body, ms))
}

impl Marking {
    fn new(gpu: &Gpu, scene: &Scene, world: &World, time_secs: f64, grid: Grid, solid: bool) -> Result<Self, GpuError> {
        let mut animate = Animate::new(gpu)?;
        let triangles = animate.upload(gpu, world)?;
        animate.write_materials(gpu, &triangles, &world.materials(scene));
        let mut settings = scene.voxelizer.clone();
        if solid {
            settings.fill = Fill::Eager;
        }
        let method = voxelize::method(&settings.method)?;
        let mut volume = Volume::new(gpu)?;
        volume.fit(gpu, &[grid])?;
        let mut rec = Recorder::new(gpu, Timing::Submit);
        rec.stage("animate")?;
        animate.record(&mut rec, &triangles, world, scene, &world.pose(scene, time_secs));
        rec.finish()?;
        let csg = Csg::for_world(None, gpu, world, &volume)?;
        let csg = csg.map(|csg| Ok::<_, GpuError>((csg, Resolve::new(gpu)?))).transpose()?;
        let fills = solid && (!method.interior || csg.is_some());
        let (fill, voxelizer) = (FillInterior::new(gpu)?, (method.new)(gpu)?);
        Ok(Self { triangles, fill, fills, settings, voxelizer, volume, csg })
    }

    fn mark(&mut self, rec: &mut Recorder<'_>) -> Result<(), GpuError> {
        self.volume.clear(rec, 0);
        let Self { volume, triangles, settings, .. } = self;
        self.voxelizer.record(rec, &voxelize::Input { volume, grid: 0, triangles, settings })
    }

    /// Marks, and fills. Milliseconds.
    fn time(&mut self, gpu: &Gpu) -> Result<f64, GpuError> {
        let mut ms = 0.0;
        // The first round compiles, the second is timed.
        for _ in 0..2 {
            let mut rec = Recorder::new(gpu, Timing::Submit);
            rec.stage("voxelize")?;
            self.mark(&mut rec)?;
            if self.fills {
                rec.stage("fill")?;
                self.fill.record(&mut rec, &self.volume, 0, &self.triangles, true);
            }
            if let Some((csg, resolve)) = &self.csg {
                rec.stage("csg")?;
                if self.fills {
                    csg.record_interior(&mut rec, &self.volume, 0, &self.triangles);
                }
                csg.record_unmark(&mut rec, resolve, &self.volume, 0, &self.triangles);
            }
            ms = rec.finish()?.iter().map(|(_, ms)| ms).sum();
        }
        Ok(ms)
    }

    /// The surface's list, by rank.
    fn list(&mut self, gpu: &Gpu) -> Result<Vec<crate::voxel_list::ListedVoxel>, GpuError> {
        let resolve = Resolve::new(gpu)?;
        let grid = self.volume.grids[0];
        for _ in 0..MAX_TRIES {
            self.volume.fit(gpu, &[grid])?;
            let mut rec = Recorder::new(gpu, Timing::Off);
            self.mark(&mut rec)?;
            let csg = self.csg.as_ref().map(|(csg, _)| csg);
            csg::record_resolve(csg, &mut rec, &resolve, &self.volume, 0, &self.triangles);
            rec.finish()?;
            if self.volume.settle(gpu)? {
                return VoxelList::new(gpu)?.read(gpu, &self.volume, 0, &self.triangles);
            }
        }
        Err(GpuError::Lost(format!("the volume was still too small after {MAX_TRIES} rounds; choose a smaller grid")))
    }

    /// What fills each cell: 1 + its part, or 0. Each part is filled by itself; where several enclose a cell, the one of
    /// the highest priority rules, then the last.
    fn parts_inside(&self, gpu: &Gpu, world: &World, materials: &[Material]) -> Result<Vec<u16>, GpuError> {
        let grid = &self.volume.grids[0];
        let vertices: Vec<Vertex> =
            buffer::read(gpu, &self.triangles.vertices, 0, self.triangles.vertex_count as usize)?;
        let triangles: Vec<[u32; 3]> =
            buffer::read(gpu, &self.triangles.indices, 0, self.triangles.triangle_count as usize)?;
        let mut inside = vec![0_u16; grid.cells.element_product() as usize];
        let mut order: Vec<usize> = (0..materials.len()).collect();
        order.sort_by_key(|part| materials[*part].priority);
        for part in order {
            let own = |t: &&[u32; 3]| vertices.get(t[0] as usize).is_some_and(|v| v.part as usize == part);
            let own: Vec<[u32; 3]> = triangles.iter().filter(own).copied().collect();
            let body = world.bodies.alone(world.parts[part].model as usize);
            let is_empty = own.is_empty() && body.is_none();
            let Some(label) = u16::try_from(part + 1).ok().filter(|_| !is_empty) else { continue };
            let mut rec = Recorder::new(gpu, Timing::Off);
            self.volume.clear(&mut rec, 0);
            rec.encoder.clear_buffer(&self.volume.interior, 0, None);
            if !own.is_empty() {
                self.fill.record(&mut rec, &self.volume, 0, &self.triangles.of(gpu, &own)?, true);
            }
            if let Some(bodies) = body {
                let world = World { bodies, ..world.clone() };
                let csg = Csg::for_world(None, gpu, &world, &self.volume)?;
                csg.iter().for_each(|csg| csg.record_interior(&mut rec, &self.volume, 0, &self.triangles));
            }
            rec.finish()?;
            let filled = grid.cell_bytes(&self.words(gpu, &self.volume.interior)?);
            inside.iter_mut().zip(filled).filter(|(_, filled)| *filled == 1).for_each(|(cell, _)| *cell = label);
        }
        Ok(inside)
    }

    fn words(&self, gpu: &Gpu, of: &wgpu::Buffer) -> Result<Vec<u32>, GpuError> {
        let grid = &self.volume.grids[0];
        buffer::read(gpu, of, u64::from(grid.word_base), grid.word_count() as usize)
    }
}
