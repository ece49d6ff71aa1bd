//! Bodies that are made of other models, worked out on the grids' words.
//!
//! Source: [`papers::DONG_2004`](crate::papers::DONG_2004), §5.2: operands are voxelized one by one, and "constructions
//! are done from bottom to top … since boolean operations on 2D textures are well-defined".
//! Differs: solids by our own parity fill, 32 slices a word. Surfaces are not the solid's boundary voxels but those of the
//! operands' own records that lie on it: exact normals (turned round where an operand is taken away) and places, so that
//! light bends as at the true surface. Where two operands' surfaces share a voxel both are kept, and the ray decides, so
//! edges are sharper than cells.
//! Promises: the solid is, cell by cell, what the operations make of the operands' solids. Walls thinner than half a cell
//! may be lost.
//! Costs: a grid's words for each operand; ranks and winners twice; the first surface of such a body is walked to and not
//! rasterized.

use crate::animate::{Triangles, Vertex};
use crate::fill;
use crate::gpu::{ComputePass, Gpu, GpuError, GpuStruct, Recorder, buffer};
use crate::grid::{Grid, PERSPECTIVE};
use crate::resolve::{LargeTriangles, Resolve, Resources, resources, triangle_resources};
use crate::scene::World;
use crate::scene::csg::{Bodies, MAX_OPERANDS, Operation, Step};
use crate::scene::material::PartMaterial;
use crate::volume::{Record, Volume};
use glam::UVec4;

crate::gpu_struct! {
    /// All bodies, for the device.
    pub struct CsgProgram {
        /// How many operands there are.
        pub operand_count: u32,
        /// How many steps.
        pub step_count: u32,
        /// Padding.
        pub _pad: glam::UVec2,
        /// Four each: an operand's number, or 32 union, 33 intersection, 34 difference, 35 the body's end.
        pub steps: [UVec4; 32],
        /// Four each: of each operand its body's part.
        pub body_parts: [UVec4; 8],
    }
}

/// The passes.
#[derive(Debug)]
pub struct Csg {
    toggle_by_projection: [[ComputePass; 2]; 2],
    large: LargeTriangles,
    sweep: ComputePass,
    combine: ComputePass,
    unmark: ComputePass,
    prune: ComputePass,
    turn: ComputePass,
    program: wgpu::Buffer,
    solids: wgpu::Buffer,
    bodies: Bodies,
}

impl Csg {
    fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let layouts = [Grid::LAYOUT, Vertex::LAYOUT, PartMaterial::LAYOUT, Record::LAYOUT, CsgProgram::LAYOUT];
        let pass = |entry, unmarks: f64| {
            ComputePass::with_constants(gpu, "csg.wgsl", entry, &layouts, &[("unmarks", unmarks)])
        };
        Ok(Self {
            toggle_by_projection: fill::toggles(gpu, true)?,
            large: LargeTriangles::new(gpu)?,
            sweep: pass("sweep", 0.0)?,
            combine: pass("combine", 0.0)?,
            unmark: pass("prune", 1.0)?,
            prune: pass("prune", 0.0)?,
            turn: pass("turn", 0.0)?,
            program: buffer::uniform(gpu, "csg", &program(&World::default())),
            solids: buffer::storage(gpu, "solids", 16)?,
            bodies: Bodies::default(),
        })
    }

    /// What a world needs, of which `made` is the last: nothing where there are no bodies. Takes the bodies, and makes
    /// room for their operands in any of the volume's grids.
    ///
    /// # Errors
    /// When a shader is wrong, or the device refuses that much.
    pub fn for_world(made: Option<Self>, gpu: &Gpu, world: &World, volume: &Volume) -> Result<Option<Self>, GpuError> {
        if world.bodies.operands.is_empty() {
            return Ok(None);
        }
        let mut csg = made.map_or_else(|| Self::new(gpu), Ok)?;
        csg.prepare(gpu, world, volume)?;
        Ok(Some(csg))
    }

    fn prepare(&mut self, gpu: &Gpu, world: &World, volume: &Volume) -> Result<(), GpuError> {
        self.bodies = world.bodies.clone();
        let largest = volume.grids.iter().map(|g| u64::from(g.word_count())).max().unwrap_or(0);
        let bytes = largest * 4 * self.bodies.operands.len() as u64;
        if bytes > self.solids.size() {
            self.solids = buffer::storage(gpu, "solids", bytes)?;
        }
        gpu.queue.write_buffer(&self.program, 0, bytemuck::bytes_of(&program(world)));
        Ok(())
    }

    /// Records the operands' solids in one grid.
    fn record_solids(&self, rec: &mut Recorder<'_>, volume: &Volume, grid: usize, triangles: &Triangles) {
        rec.encoder.clear_buffer(&self.solids, 0, None);
        let g = &volume.grids[grid];
        let mut all = resources(volume, grid);
        all.retain(|(name, _)| *name != "interior");
        all.push(("interior", self.solids.as_entire_binding()));
        all.extend(triangle_resources(triangles));
        let [main, large] = &self.toggle_by_projection[usize::from(g.projection == PERSPECTIVE)];
        self.large.record(rec, [main, large], &all, triangles.triangle_count);
        let columns = g.cells.x * g.cells.y * u32::try_from(self.bodies.operands.len()).unwrap_or(0);
        self.dispatch(rec, &self.sweep, volume, grid, triangles, columns);
    }

    /// Adds the bodies' solids to the interior.
    pub fn record_interior(&self, rec: &mut Recorder<'_>, volume: &Volume, grid: usize, triangles: &Triangles) {
        self.record_solids(rec, volume, grid, triangles);
        self.dispatch(rec, &self.combine, volume, grid, triangles, volume.grids[grid].word_count());
    }

    /// Unmarks voxels that hold hidden parts of operands alone.
    pub fn record_unmark(
        &self,
        rec: &mut Recorder<'_>,
        resolve: &Resolve,
        volume: &Volume,
        grid: usize,
        triangles: &Triangles,
    ) {
        self.record_solids(rec, volume, grid, triangles);
        resolve.record_rank(rec, volume, grid);
        resolve.record_winners(rec, volume, grid, triangles);
        self.over_winners(rec, &self.unmark, resolve, volume, grid, triangles);
    }

    fn resources<'a>(&'a self, volume: &'a Volume, grid: usize, triangles: &'a Triangles) -> Resources<'a> {
        let mut all = resources(volume, grid);
        all.extend(triangle_resources(triangles));
        all.push(("csg", self.program.as_entire_binding()));
        all.push(("solids", self.solids.as_entire_binding()));
        all
    }

    fn over_winners(
        &self,
        rec: &mut Recorder<'_>,
        pass: &ComputePass,
        resolve: &Resolve,
        volume: &Volume,
        grid: usize,
        triangles: &Triangles,
    ) {
        let mut all = self.resources(volume, grid, triangles);
        all.push(("voxel_dispatch", resolve.voxel_dispatch().as_entire_binding()));
        let group = pass.bind_used(rec.gpu, &all);
        pass.dispatch_indirect(&mut rec.encoder, &group, resolve.voxel_dispatch(), 0);
    }

    fn dispatch(
        &self,
        rec: &mut Recorder<'_>,
        pass: &ComputePass,
        volume: &Volume,
        grid: usize,
        triangles: &Triangles,
        threads: u32,
    ) {
        let group = pass.bind_used(rec.gpu, &self.resources(volume, grid, triangles));
        pass.dispatch(&mut rec.encoder, &group, [threads, 1, 1]);
    }
}

/// Ranks, chooses and records the surfaces of one grid, those of bodies among them: [`Resolve::record`] where there are
/// none.
pub fn record_resolve(
    csg: Option<&Csg>,
    rec: &mut Recorder<'_>,
    resolve: &Resolve,
    volume: &Volume,
    grid: usize,
    triangles: &Triangles,
) {
    let Some(csg) = csg else {
        resolve.record(rec, volume, grid, triangles);
        return;
    };
    csg.record_unmark(rec, resolve, volume, grid, triangles);
    resolve.record_rank(rec, volume, grid);
    resolve.record_winners(rec, volume, grid, triangles);
    csg.over_winners(rec, &csg.prune, resolve, volume, grid, triangles);
    resolve.record_records(rec, volume, grid, triangles);
    csg.dispatch(rec, &csg.turn, volume, grid, triangles, volume.grids[grid].word_count());
}

fn program(world: &World) -> CsgProgram {
    let Bodies { steps, operands } = &world.bodies;
    let number = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    let mut program: CsgProgram = bytemuck::Zeroable::zeroed();
    program.operand_count = number(operands.len());
    program.step_count = number(steps.len());
    for (i, step) in steps.iter().enumerate().take(4 * program.steps.len()) {
        program.steps[i / 4][i % 4] = match *step {
            Step::Operand(operand) => operand,
            Step::Combine(Operation::Union) => 32,
            Step::Combine(Operation::Intersection) => 33,
            Step::Combine(Operation::Difference) => 34,
            Step::End => 35,
        };
    }
    for (i, operand) in operands.iter().enumerate().take(MAX_OPERANDS) {
        let part = world.parts.iter().position(|part| part.model as usize == operand.body).unwrap_or(0);
        program.body_parts[i / 4][i % 4] = number(part);
    }
    program
}
