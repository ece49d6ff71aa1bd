//! `murrine voxelize`.

use super::arguments::{Adapter, Voxelize};
use super::output::Progress;
use super::{Failure, Outcome, Output, interrupt, open_gpu, tell_warnings};
use crate::gpu::Gpu;
use crate::grid::Grid;
use crate::headless::{self, VoxelSlabs};
use crate::image;
use crate::scene::description::Bounds;
use crate::scene::{Scene, World, framing};
use crate::voxel_file::{self, VoxelFormat};
use glam::UVec3;
use std::sync::atomic::Ordering;

/// How much wider than the model a fitted grid is, so that no surface lies on its rim.
const RIM: f64 = 1.0 + 1e-4;

pub(super) fn run(options: &Voxelize, adapter: &Adapter, out: &mut Output) -> Result<Outcome, Failure> {
    let format = VoxelFormat::of(&options.output, options.grid, options.solid)?;
    let (scene, world, warnings) = headless::open(&options.model, &assignments(options))?;
    tell_warnings(&warnings);
    let grid = match (options.origin, options.cell) {
        (Some(origin), Some(cell)) => Grid::world_aligned(origin, cell, options.grid),
        _ => fitted(&scene, &world, options)?,
    };
    let gpu = open_gpu(adapter)?;
    let (marked, ms) = match format {
        VoxelFormat::Npy => write_in_slabs(options, &gpu, &scene, &world, grid)?,
        _ => {
            let (body, ms) = headless::voxel_body(&gpu, &scene, &world, options.time, grid, options.solid)?;
            voxel_file::write(&options.output, format, &body)?;
            (body.marked.iter().map(|v| u64::from(*v)).sum(), ms)
        }
    };

    let [nx, ny, nz] = grid.cells.to_array();
    let triangles: usize = world.models.iter().map(|m| m.triangles.len()).sum();
    let origin = grid.world_from_grid.w_axis.truncate();
    out.line(format_args!("voxelizer  {}", scene.voxelizer.method))?;
    out.line(format_args!("triangles  {triangles}"))?;
    out.line(format_args!("cells      {nx} {ny} {nz}"))?;
    out.line(format_args!("origin     {} {} {}", origin.x, origin.y, origin.z))?;
    out.line(format_args!("cell       {}", grid.cell_size))?;
    out.line(format_args!("{}   {marked}", if options.solid { "inside  " } else { "surface " }))?;
    out.line(format_args!("ms         {ms:.3}"))?;
    Ok(Outcome::Good)
}

/// Writes the array slab by slab, so that neither the device nor the host holds all of it. Voxels, and milliseconds.
fn write_in_slabs(
    options: &Voxelize,
    gpu: &Gpu,
    scene: &Scene,
    world: &World,
    grid: Grid,
) -> Result<(u64, f64), Failure> {
    let [nx, ny, nz] = grid.cells.to_array().map(u64::from);
    let mut slabs = VoxelSlabs::new(gpu, scene, world, options.time, grid, options.solid)?;
    let (stopped, mut progress) = (interrupt::flag()?, Progress::new());
    let slices = slabs.by_ref().flat_map(|slab| {
        let (slices, error) = match slab {
            Ok(slab) => {
                progress.tell(format_args!("voxelized: {} of {nz} slices", slab.slab.slices.end));
                (Some(slab.into_slices()), None)
            }
            Err(error) => (None, Some(Err(Failure::from(error)))),
        };
        slices.into_iter().flatten().map(Ok).chain(error)
    });
    let mut marked = 0;
    let slices = slices.map(|slice: Result<Vec<u8>, Failure>| {
        if stopped.load(Ordering::Relaxed) {
            return Err(Failure::Other(format!("{}: stopped; nothing was left behind", options.output.display())));
        }
        slice.inspect(|slice| marked += slice.iter().map(|v| u64::from(*v)).sum::<u64>())
    });
    image::write_bytes(&options.output, &[nz, ny, nx], slices)?;
    Ok((marked, slabs.ms()))
}

fn assignments(options: &Voxelize) -> Vec<String> {
    let method = options.voxelizer.as_ref().map(|name| format!("voxelizer.method=\"{name}\""));
    let separability = options.separability.as_ref().map(|s| format!("voxelizer.separability={s}"));
    let conservative = options.conservative.as_ref().map(|c| format!("voxelizer.conservative={c}"));
    let depth = options.conservative_depth.then(|| "voxelizer.conservative_depth=true".to_owned());
    let sets = [method, separability, conservative, depth].into_iter().flatten();
    sets.chain(options.sets.iter().cloned()).collect()
}

/// The grid whose cubes just hold the bodies at the chosen time, in its middle.
fn fitted(scene: &Scene, world: &World, options: &Voxelize) -> Result<Grid, Failure> {
    let bounds = framing::bounds_at(scene, world, options.time);
    if bounds.is_empty() {
        return Err(Failure::Other(format!("{}: it has no triangles to voxelize", options.model.display())));
    }
    Ok(grid_around(&bounds, options.grid))
}

fn grid_around(bounds: &Bounds, cells: UVec3) -> Grid {
    let extent = bounds.max - bounds.min;
    let side = ((extent / cells.as_dvec3()).max_element() * RIM).max(1e-9);
    let origin = bounds.center() - cells.as_dvec3() * (side * 0.5);
    Grid::world_aligned(origin, side, cells)
}
