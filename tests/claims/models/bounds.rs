//! Bounds contain what they bound, and little more.

use glam::{DVec3, Vec3};
use murrine::scene::World;
use murrine::scene::description::{Deformer, Model, Scene, Shape, Source};
use murrine::scene::pose::pose_vertices;

/// Every posed vertex lies within its part's bounds; tells the share of the bounds' volume that the vertices fill.
pub(super) fn assert_contained(world: &World, scene: &Scene, time_secs: f64) -> f64 {
    let pose = world.pose(scene, time_secs);
    let posed = pose_vertices(world, scene, &pose);
    let (mut first, mut part_number, mut least_share) = (0, 0, 1.0_f64);
    for geometry in &world.models {
        for part in &geometry.parts {
            let bounds = pose.part_bounds[part_number];
            let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            let used = geometry.triangles[part.triangles.start as usize..part.triangles.end as usize].iter().flatten();
            for &v in used {
                let p = posed[first + v as usize].0.as_dvec3();
                let inside = p.cmpge(bounds.min).all() && p.cmple(bounds.max).all();
                assert!(inside, "{} at {time_secs} s: {p} is outside {bounds:?}", world.parts[part_number].name);
                (min, max) = (min.min(p), max.max(p));
            }
            let share = (max - min).max_element() / (bounds.max - bounds.min).max_element();
            least_share = least_share.min(share);
            part_number += 1;
        }
        first += geometry.vertices.len();
    }
    least_share
}

fn deformed_ball(deformers: Vec<Deformer>) -> Scene {
    let source = Source::Shape(Shape::Icosphere { radius: 1.0, subdivisions: 4 });
    let (translate, rotate_deg) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(10.0, 20.0, 30.0));
    let model = Model { name: "b".into(), source, deformers, translate, rotate_deg, scale: 1.5, ..Model::default() };
    Scene { models: vec![model], ..Scene::default() }
}

#[test]
fn bounds_contain_deformed_shapes_at_many_times() {
    let twist = |axis, deg_per_unit, hz| Deformer::Twist { axis, deg_per_unit, hz };
    let wave = |axis, along, amplitude| Deformer::Wave { axis, along, amplitude, wavelength: 0.7, hz: 0.3 };
    let cases = [
        vec![twist(0, 40.0, 0.0)],
        vec![twist(1, 200.0, 0.7)],
        vec![twist(2, -15.0, 1.0)],
        vec![wave(0, 1, 0.3)],
        vec![wave(2, 2, 0.2)],
        vec![wave(0, 1, 0.3), twist(1, 60.0, 0.2), wave(1, 2, -0.4)],
    ];
    for deformers in cases {
        let scene = deformed_ball(deformers);
        let world = World::load(&scene, None).unwrap();
        for step in 0..20 {
            let share = assert_contained(&world, &scene, f64::from(step) * 0.37);
            assert!(share > 0.3, "bounds are {share} filled: {:?}", scene.models[0].deformers);
        }
    }
}

#[test]
#[should_panic(expected = "is outside")]
fn a_vertex_out_of_bounds_is_noticed() {
    let mut scene = deformed_ball(vec![]);
    let mut world = World::load(&scene, None).unwrap();
    let mut geometry = (*world.models[0]).clone();
    geometry.vertices[0].position *= 1.3;
    world = World::from_geometry(&scene, vec![geometry.into()]);
    scene.models[0].rotate_deg = Vec3::ZERO;
    assert_contained(&world, &scene, 0.0);
}

#[test]
fn a_deformers_jacobian_is_the_derivative_of_its_motion() {
    let p = DVec3::new(0.3, -0.8, 0.5);
    for deformer in [
        Deformer::Twist { axis: 0, deg_per_unit: 70.0, hz: 0.3 },
        Deformer::Twist { axis: 1, deg_per_unit: 70.0, hz: 0.0 },
        Deformer::Wave { axis: 0, along: 2, amplitude: 0.4, wavelength: 0.9, hz: 0.5 },
        Deformer::Wave { axis: 1, along: 1, amplitude: 0.1, wavelength: 2.0, hz: 0.5 },
    ] {
        let deformation = deformer.at(0.4);
        let (_, jacobian) = deformation.apply(p);
        for axis in DVec3::AXES {
            let h = 1e-6;
            let slope = (deformation.apply(p + axis * h).0 - deformation.apply(p - axis * h).0) / (2.0 * h);
            assert!((slope - jacobian * axis).length() < 1e-8, "{deformer:?}");
        }
    }
}
