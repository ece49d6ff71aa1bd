//! Built-in shapes are the surfaces that they are named after.

use crate::mesh::{corners, open_edges, volume};
use glam::{DVec3, Vec3};
use murrine::scene::description::{Model, Scene, Shape, Source};
use murrine::scene::pose::pose_vertices;
use murrine::scene::{World, shapes};
use std::f64::consts::PI;

const SMOOTH: [Shape; 3] = [
    Shape::Sphere { radius: 0.75, rings: 40 },
    Shape::Icosphere { radius: 0.75, subdivisions: 4 },
    Shape::Torus { radius: 1.0, tube: 0.3, segments: 96 },
];
const BOX: Shape = Shape::Box { min: Vec3::new(-1.0, -0.5, -0.25), max: Vec3::new(1.0, 0.5, 0.75) };

#[test]
fn shapes_are_closed_to_the_bit_and_wind_outwards() {
    for shape in SMOOTH.into_iter().chain([BOX]) {
        let mut geometry = shapes::shape(&shape);
        assert_eq!(open_edges(&geometry), 0, "{shape:?}");
        assert!(volume(&geometry) > 0.0, "{shape:?}");
        for &t in &geometry.triangles {
            let [a, b, c] = corners(&geometry, t);
            let face = (b - a).cross(c - a);
            assert!(face.length() > 0.0, "{shape:?} has an empty face");
            for v in t {
                assert!(face.dot(geometry.vertices[v as usize].normal.as_dvec3()) > 0.0, "{shape:?}");
            }
        }
        geometry.triangles.pop();
        assert_eq!(open_edges(&geometry), 6, "a missing triangle must be seen");
    }
}

#[test]
fn shapes_enclose_the_volume_of_the_true_body() {
    let ball = 4.0 / 3.0 * PI * 0.75_f64.powi(3);
    let ring = 2.0 * PI * PI * 0.3 * 0.3;
    for (shape, expected, tolerance) in
        [(SMOOTH[0], ball, 5e-3), (SMOOTH[1], ball, 5e-3), (SMOOTH[2], ring, 5e-3), (BOX, 2.0, 1e-6)]
    {
        let found = volume(&shapes::shape(&shape)) / expected;
        assert!((found - 1.0).abs() < tolerance, "{shape:?}: {found}");
    }
}

#[test]
fn a_sphere_has_the_normals_of_the_true_sphere() {
    for shape in &SMOOTH[..2] {
        for v in &shapes::shape(shape).vertices {
            assert!((v.position / 0.75 - v.normal).length() < 2e-7);
            assert!((v.normal.length() - 1.0).abs() < 2e-7);
        }
    }
    let ico = shapes::shape(&Shape::Icosphere { radius: 1.0, subdivisions: 3 });
    assert_eq!((ico.vertices.len(), ico.triangles.len()), (642, 1280));
}

#[test]
fn a_scene_of_shapes_is_loaded_placed_and_bounded() {
    let mut ball = Model { name: "ball".into(), translate: Vec3::new(3.0, 0.0, 0.0), scale: 2.0, ..Model::default() };
    ball.rotate_deg = Vec3::new(20.0, 40.0, 60.0);
    let ground =
        Model { name: "ground".into(), source: Source::Shape(Shape::Plane { size: 80.0 }), ..Model::default() };
    let scene = Scene { models: vec![ball, ground], ..Scene::default() };
    let world = World::load(&scene, None).unwrap();
    let names: Vec<_> = world.parts.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["ball/icosphere", "ground/plane"]);
    let pose = world.pose(&scene, 0.0);
    let bounds = pose.part_bounds[0];
    assert!(
        (bounds.min - DVec3::new(1.0, -2.0, -2.0)).length() < 1e-4,
        "a turned sphere reaches no further: {bounds:?}"
    );
    assert!((bounds.max - DVec3::new(5.0, 2.0, 2.0)).length() < 1e-4);
    for (position, normal) in pose_vertices(&world, &scene, &pose) {
        let p = position.as_dvec3();
        assert!(p.cmpge(bounds.min).all() && p.cmple(bounds.max).all());
        assert!((p - DVec3::new(3.0, 0.0, 0.0) - normal.as_dvec3() * 2.0).length() < 1e-5);
    }
    assert!((pose.part_bounds[1].max - DVec3::new(40.0, 0.0, 40.0)).length() < 1e-3);
    let materials = world.materials(&scene);
    assert!(!materials[0].opaque && materials[1].opaque);
}
