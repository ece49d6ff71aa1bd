//! The voxel list of any method: each voxel once, in the order of the ranks, with attributes of its own surface point.

use crate::gpu;
use crate::stages::Stages;
use glam::{DMat4, DVec2, DVec3, UVec3, Vec3};
use murrine::gpu::{Recorder, Timing};
use murrine::grid::Grid;
use murrine::scene::description::{Model, Scene, Shape, Source};
use murrine::scene::geometry::uv_from_color;
use murrine::scene::{World, shapes};
use murrine::voxel_list::{ListedVoxel, LockedList, VoxelList};
use murrine::voxelize::{self, METHODS};
use std::sync::Arc;

const TORUS: Shape = Shape::Torus { radius: 0.8, tube: 0.3, segments: 24 };

fn grids() -> [Grid; 2] {
    let eye = DVec3::new(1.0, 3.0, 2.0);
    let z = -eye.normalize();
    let x = z.cross(DVec3::Y).normalize();
    let world_from_eye = DMat4::from_translation(eye) * DMat4::from_mat3(glam::DMat3::from_cols(x, z.cross(x), z));
    let spot = Grid::perspective(world_from_eye, DVec2::splat(-0.55), DVec2::splat(0.55), 2.2, 5.3, UVec3::splat(40));
    [Grid::world_aligned(DVec3::splat(-1.2), 2.4 / 50.0, UVec3::new(50, 50, 70)), spot]
}

/// The colour of the surface at a place: linear in the place.
fn ramp(p: Vec3) -> Vec3 {
    Vec3::splat(0.5) + Vec3::new(0.3 * p.x, 0.2 * p.y - 0.1 * p.z, 0.35 * p.z)
}

/// A body of few, large triangles whose vertices carry the ramp's colours.
fn ramped(shape: Shape) -> (Scene, World) {
    let scene = Scene { models: vec![Model { source: Source::Shape(shape), ..Model::default() }], ..Scene::default() };
    let mut geometry = shapes::shape(&shape);
    geometry.parts[0].vertex_colors = true;
    geometry.parts[0].material.opaque = true;
    for vertex in &mut geometry.vertices {
        (vertex.u, vertex.v) = uv_from_color(ramp(vertex.position));
    }
    let world = World::from_geometry(&scene, vec![Arc::new(geometry)]);
    (scene, world)
}

fn listed(stages: &mut Stages, grid: Grid) -> Vec<ListedVoxel> {
    for _ in 0..3 {
        stages.render(&[grid]);
        if stages.volume.settle(gpu()).unwrap() {
            break;
        }
    }
    VoxelList::new(gpu()).unwrap().read(gpu(), &stages.volume, 0, &stages.triangles).unwrap()
}

#[test]
fn the_list_of_every_method_has_each_marked_voxel_once_in_the_order_of_ranks() {
    let mut stages = Stages::of(&[TORUS]);
    for method in METHODS {
        stages.voxelizer = (method.new)(gpu()).unwrap();
        let list = listed(&mut stages, grids()[0]);
        let cells: Vec<UVec3> = list.iter().map(ListedVoxel::cell).collect();
        assert_eq!(cells, stages.cells(0), "{}", method.name);
        assert!(cells.len() > 1000, "{}: {} voxels", method.name, cells.len());
    }
}

#[test]
fn the_list_of_locks_is_the_same_set_as_that_of_ranks() {
    let mut stages = Stages::of(&[TORUS]);
    stages.voxelizer = (voxelize::method("triangle-parallel").unwrap().new)(gpu()).unwrap();
    for grid in grids() {
        let mut by_rank: Vec<[u32; 3]> = listed(&mut stages, grid).iter().map(|v| v.cell().to_array()).collect();
        let locks = LockedList::new(gpu(), 1 << 16).unwrap();
        let mut rec = Recorder::new(gpu(), Timing::Off);
        stages.volume.clear(&mut rec, 0);
        locks.record(&mut rec, &stages.volume, 0, &stages.triangles);
        rec.finish().unwrap();
        let mut by_lock: Vec<[u32; 3]> = locks.read(gpu()).unwrap().iter().map(|c| c.to_array()).collect();
        by_rank.sort_unstable();
        by_lock.sort_unstable();
        assert!(by_rank.len() > 1000);
        assert_eq!(by_rank, by_lock);
        by_lock.dedup();
        assert_eq!(by_rank.len(), by_lock.len(), "no voxel twice");
        // Where there is no room, voxels are left out, and nothing else happens.
        let few = LockedList::new(gpu(), 100).unwrap();
        let mut rec = Recorder::new(gpu(), Timing::Off);
        stages.volume.clear(&mut rec, 0);
        few.record(&mut rec, &stages.volume, 0, &stages.triangles);
        rec.finish().unwrap();
        assert_eq!(few.read(gpu()).unwrap().len(), 100);
    }
}

#[test]
fn colours_and_normals_are_those_of_the_voxels_own_surface_point_also_where_triangles_are_dilated() {
    let (scene, world) = ramped(TORUS);
    let mut stages = Stages::of_world(&scene, &world);
    let corners = stages.corners();
    for name in ["fragment-parallel", "triangle-parallel", "hybrid", "slice-amplified"] {
        stages.voxelizer = (voxelize::method(name).unwrap().new)(gpu()).unwrap();
        for grid in grids() {
            let (mut worst_color, mut worst_normal, mut worst_place) = (0.0_f32, 1.0_f32, 0.0_f64);
            let (mut worst_control, mut checked) = (0.0_f32, 0);
            for voxel in listed(&mut stages, grid) {
                let Some([a, b, c]) = corners.get(voxel.triangle as usize).copied() else { continue };
                checked += 1;
                // Every vertex has the ramp's colour, so has every point of every triangle, up to 12 bits a component.
                worst_color = worst_color.max((voxel.color - ramp(voxel.position)).abs().max_element());
                // The negative control: the colour of the triangle's middle.
                let middle = ((a + b + c) / 3.0).as_vec3();
                worst_control = worst_control.max((voxel.color - ramp(middle)).abs().max_element());
                let n = (b - a).cross(c - a);
                let weight =
                    |p: DVec3, q: DVec3| (q - p).cross(voxel.position.as_dvec3() - p).dot(n) / n.length_squared();
                let weights = DVec3::new(weight(b, c), weight(c, a), weight(a, b));
                assert!(weights.min_element() > -1e-3, "{name}: {weights}: outside its triangle");
                let t = stages.indices[voxel.triangle as usize];
                let smooth: DVec3 = (0..3).map(|i| weights[i] * stages.positions[t[i] as usize].1.as_dvec3()).sum();
                worst_normal = worst_normal.min(voxel.normal.dot(smooth.normalize().as_vec3()));
                let p = grid.grid_point(voxel.position.as_dvec3());
                let cell = voxel.cell().as_dvec3();
                let off = DVec3::new(p.x, p.y, grid.slice_of(p.z)) - (cell + 0.5);
                worst_place = worst_place.max(off.abs().max_element());
            }
            assert!(checked > 500, "{name}: {checked} voxels");
            assert!(worst_color < 1.0 / 4095.0, "{name}: colours are off by {worst_color}");
            assert!(worst_normal > 0.999_99, "{name}: normals are off by {}°", worst_normal.acos().to_degrees());
            assert!(worst_place < 0.75, "{name}: a surface point lies {worst_place} cells from its voxel's centre");
            assert!(worst_control > 0.01, "{name}: {worst_control}: the ramp is too flat to tell points apart");
        }
    }
}
