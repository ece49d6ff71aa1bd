//! The scene that is shown where no scene file is at hand: a twisting ring of amber glass over pale stone.

use crate::scene::Scene;
use crate::scene::description::{Camera, Deformer, Light, LightKind, MaterialOverride, Model, Shape, Source};
use glam::Vec3;

/// The built-in scene; it needs no file.
#[must_use]
pub fn scene() -> Scene {
    let glass = MaterialOverride {
        ior: Some(1.5),
        attenuation_color: Some(Vec3::new(0.95, 0.55, 0.18)),
        attenuation_distance: Some(0.5),
        ..MaterialOverride::default()
    };
    let ring = Model {
        name: "ring".to_owned(),
        source: Source::Shape(Shape::Torus { radius: 0.8, tube: 0.3, segments: 160 }),
        translate: Vec3::new(0.0, 1.2, 0.0),
        rotate_deg: Vec3::new(70.0, 0.0, 20.0),
        deformers: vec![Deformer::Twist { axis: 0, deg_per_unit: 35.0, hz: 0.2 }],
        materials: vec![glass],
        ..Model::default()
    };
    let stone = MaterialOverride {
        opaque: Some(true),
        base_color: Some(Vec3::new(0.62, 0.59, 0.55)),
        checker_color: Some(Vec3::new(0.50, 0.475, 0.44)),
        checker_square: Some(0.6),
        ..MaterialOverride::default()
    };
    let ground = Model {
        name: "ground".to_owned(),
        source: Source::Shape(Shape::Plane { size: 60.0 }),
        materials: vec![stone],
        ..Model::default()
    };
    Scene {
        camera: Camera {
            eye: Vec3::new(1.6, 1.9, 4.6),
            target: Vec3::new(0.0, 0.95, 0.0),
            fov_deg: 32.0,
            ..Camera::default()
        },
        lights: vec![Light {
            kind: LightKind::Directional { direction: Vec3::new(0.75, -0.8, 0.35).normalize() },
            color: Vec3::new(1.0, 0.86, 0.68),
            ..Light::default()
        }],
        models: vec![ring, ground],
        ..Scene::default()
    }
}
