//! What the voxelizers promise.

use crate::gpu;
use glam::{DVec3, UVec3, Vec3};
use murrine::animate::{Triangles, Vertex};
use murrine::gpu::{Recorder, Timing, buffer};
use murrine::grid::Grid;
use murrine::scene::description::VoxelizerSettings;
use murrine::scene::material::PartMaterial;
use murrine::volume::Volume;
use murrine::voxelize::{self, Input};

/// Triangles in world space, as `animate` would leave them.
fn upload(triangles: &[[Vec3; 3]]) -> Triangles {
    let vertices: Vec<Vertex> =
        triangles.iter().flatten().map(|&position| Vertex { position, part: 0, normal: Vec3::Z, _pad: 0 }).collect();
    let count = u32::try_from(triangles.len()).unwrap();
    let indices: Vec<[u32; 3]> = (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let material: PartMaterial = bytemuck::Zeroable::zeroed();
    Triangles::still(gpu(), &vertices, &indices, &[material]).unwrap()
}

/// The words of `grid` as `method` marks them.
fn words(method: &str, grid: Grid, triangles: &Triangles, settings: &VoxelizerSettings) -> Vec<u32> {
    let mut volume = Volume::new(gpu()).unwrap();
    let count = grid.word_count() as usize;
    volume.occupancy = buffer::storage(gpu(), "occupancy", 4 * count as u64).unwrap();
    gpu().queue.write_buffer(&volume.grid_data, 0, bytemuck::bytes_of(&grid));
    volume.grids = vec![grid];
    let mut voxelizer = (voxelize::method(method).unwrap().new)(gpu()).unwrap();
    let mut rec = Recorder::new(gpu(), Timing::Off);
    voxelizer.record(&mut rec, &Input { volume: &volume, grid: 0, triangles, settings }).unwrap();
    rec.finish().unwrap();
    buffer::read(gpu(), &volume.occupancy, 0, count).unwrap()
}

#[test]
fn a_needle_marks_its_column_and_a_triangle_its_cells_and_those_it_touches() {
    let grid = Grid::world_aligned(DVec3::ZERO, 1.0, UVec3::splat(64));
    let triangles = upload(&[
        [Vec3::new(1.5, 1.5, 1.5), Vec3::new(1.5, 1.5, 40.5), Vec3::new(1.6, 1.5, 1.5)],
        [Vec3::new(10.5, 10.5, 10.5), Vec3::new(20.5, 10.5, 10.5), Vec3::new(10.5, 20.5, 10.5)],
    ]);
    let words = words("triangle-parallel", grid, &triangles, &VoxelizerSettings::default());
    let marked: u32 = words.iter().map(|w| w.count_ones()).sum();
    // The long side passes through ten corners of cells that it otherwise misses.
    assert_eq!(marked, 40 + 11 * 12 / 2 + 10);
}
