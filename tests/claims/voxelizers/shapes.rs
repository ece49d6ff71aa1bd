//! The same promises in grids of every shape: no cubes, no whole words, long and flat; and about our own models.

use super::{
    BOTH, Triangle, assert_all_exact, count, exact_ways, faults, in_perspective, needles, sliced, soup, sphere, torus,
    turned, upload, words,
};

use glam::UVec3;
use murrine::grid::Grid;
use murrine::scene::description::{Bounds, Model, Scene, Separability, Source};
use murrine::scene::{World, pose::pose_vertices};
use murrine::voxelize::exact_voxels;
use std::path::Path;

const SHAPES: [UVec3; 3] = [UVec3::new(16, 48, 80), UVec3::new(33, 17, 100), UVec3::new(512, 16, 16)];

fn world_aligned(cells: UVec3) -> Grid {
    let size = 2.0 / f64::from(cells.min_element());
    Grid::world_aligned(cells.as_dvec3() * (-0.5 * size) + 0.0123, size, cells)
}

#[test]
fn exact_methods_equal_the_truth_in_grids_of_every_shape() {
    for cells in SHAPES {
        for grid in [world_aligned(cells), turned(cells), in_perspective(cells)] {
            assert_all_exact("torus", grid, &torus());
            assert_all_exact("soup", grid, &soup(120));
            assert_all_exact("needles", grid, &needles());
        }
    }
}

#[test]
fn overlapping_slices_mark_a_superset_in_grids_of_every_shape() {
    for cells in SHAPES {
        for grid in [world_aligned(cells), turned(cells), in_perspective(cells)] {
            for body in [sphere(), torus()] {
                let triangles = upload(&body);
                let mut before = sliced(grid, &triangles, 0.0);
                assert!(count(&before) > 30, "{cells}");
                for overlap in [0.2, 0.5, 1.0] {
                    let words = sliced(grid, &triangles, overlap);
                    let lost: u32 = before.iter().zip(&words).map(|(b, w)| (b & !w).count_ones()).sum();
                    // A middle line that just grazes an outline may go: clipping's corners are moved to 1/256 pixel.
                    assert!(lost * 60 <= count(&before), "{lost} of {} are lost at {overlap}, {cells}", count(&before));
                    assert!(count(&words) > count(&before), "{overlap} adds nothing, {cells}");
                    before = words;
                }
            }
        }
    }
}

#[test]
fn thin_voxels_are_among_the_thick_ones_whatever_the_method_and_fewer() {
    for grid in [turned(SHAPES[0]), in_perspective(SHAPES[1]), world_aligned(SHAPES[2])] {
        let body = torus();
        let triangles = upload(&body);
        let truth = exact_voxels(&grid, &body, Separability::TwentySix);
        let [thick, thin] = BOTH.map(exact_ways);
        for ((name, thick), (_, thin)) in thick.iter().zip(&thin) {
            let [thick, thin] = [thick, thin].map(|settings| words(grid, &triangles, settings));
            let beyond = faults(&thin, &truth).spurious;
            assert_eq!(beyond, 0, "{name}: thin voxels that the surface does not touch");
            assert!(count(&thin) > 50 && count(&thin) * 10 < count(&thick) * 9, "{name}");
        }
    }
}

/// Our own models, posed at 0.3 s and scaled into the grids: skinned, morphed, open, of many parts.
fn own(name: &str) -> Vec<Triangle> {
    let source = Source::File(Path::new(env!("CARGO_MANIFEST_DIR")).join("assets").join(name));
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let model = Model { name: "own".into(), source, ..Model::default() };
    let scene = Scene { models: vec![model], folder, ..Scene::default() };
    let world = World::load(&scene, None).unwrap();
    let posed = pose_vertices(&world, &scene, &world.pose(&scene, 0.3));
    let mut bounds = Bounds::EMPTY;
    posed.iter().for_each(|(p, _)| bounds.add(p.as_dvec3()));
    let scale = 1.7 / (bounds.max - bounds.min).length();
    let at = |v: u32| ((posed[v as usize].0.as_dvec3() - bounds.center()) * scale).as_vec3();
    let triangles: Vec<Triangle> = world.models[0].triangles.iter().map(|t| t.map(at)).collect();
    assert!(triangles.len() > 1000, "{name}");
    triangles
}

#[test]
fn exact_methods_equal_the_truth_on_our_own_models() {
    for (name, sizes) in [
        ("fish.glb", [UVec3::splat(64), UVec3::new(40, 37, 96)]),
        ("shell.glb", [UVec3::splat(48), UVec3::new(33, 17, 100)]),
        ("tree.glb", [UVec3::splat(64), UVec3::new(16, 48, 80)]),
    ] {
        let body = own(name);
        for cells in sizes {
            assert_all_exact(name, turned(cells), &body);
        }
    }
}
