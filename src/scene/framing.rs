//! Fits a scene to bodies whose size was not known when it was written.
//!
//! A framed scene (`camera.frame = true`) is written around a body that stands on the origin and has radius 1: [`frame`]
//! carries its planes and lights to the true bounds and moves the camera, along its own direction, to show them whole.

use super::description::{Bounds, Camera, LightKind, Scene, Shape, Source};
use super::world::World;
use glam::{DVec3, Vec3};

/// Poses that the framed bounds are gathered over, so that a body that walks stays in the picture.
const POSES: u32 = 8;
/// How much larger than its bounds the framed body is taken to be.
const MARGIN: f64 = 1.12;

/// The bounds of all parts but planes, at one time.
#[must_use]
pub fn bounds_at(scene: &Scene, world: &World, time_secs: f64) -> Bounds {
    let is_plane = |model: u32| {
        let source = scene.models.get(model as usize).map(|m| &m.source);
        matches!(source, Some(Source::Shape(Shape::Plane { .. })))
    };
    let pose = world.pose(scene, time_secs);
    let bodies = world.parts.iter().zip(&pose.part_bounds).filter(|(part, b)| !is_plane(part.model) && !b.is_empty());
    bodies.fold(Bounds::EMPTY, |all, (_, bounds)| all.union(*bounds))
}

/// The bounds of all parts but planes, over the whole animation.
#[must_use]
pub fn bounds_of_bodies(scene: &Scene, world: &World) -> Bounds {
    let duration_secs = world.duration_secs(scene);
    let poses = if duration_secs > 0.0 { POSES } else { 1 };
    let times = (0..poses).map(|i| duration_secs * f64::from(i) / f64::from(POSES));
    times.fold(Bounds::EMPTY, |all, time_secs| all.union(bounds_at(scene, world, time_secs)))
}

/// Fits a scene that asks for it to its bodies; others stay as they are.
pub fn frame(scene: &mut Scene, world: &World) {
    if scene.frame_camera {
        scene.frame_camera = false;
        let bounds = bounds_of_bodies(scene, world);
        fit(scene, &bounds);
    }
}

/// Carries planes and lights from the unit body to `bounds` and frames the camera. Bounds of nothing change nothing.
fn fit(scene: &mut Scene, bounds: &Bounds) {
    let radius = bounds.radius();
    if bounds.is_empty() || !radius.is_finite() || radius <= 0.0 {
        return;
    }
    let center = bounds.center();
    let foot = DVec3::new(center.x, bounds.min.y, center.z).as_vec3();
    #[expect(clippy::cast_possible_truncation, reason = "scenes are written in f32")]
    let unit = radius as f32;
    for model in &mut scene.models {
        if matches!(model.source, Source::Shape(Shape::Plane { .. })) {
            model.translate = foot + model.translate * unit;
            model.scale *= unit;
            for material in &mut model.materials {
                material.checker_square = material.checker_square.map(|side| side * unit);
            }
        }
    }
    for light in &mut scene.lights {
        match &mut light.kind {
            LightKind::Directional { .. } => {}
            LightKind::Point { position } | LightKind::Spot { position, .. } => {
                *position = foot + *position * unit;
                light.intensity *= unit * unit;
            }
        }
    }
    scene.camera = scene.camera.framing(bounds, scene.camera.target - scene.camera.eye);
}

impl Camera {
    /// This camera moved so that it looks along `direction` at all of `bounds`, in pictures at least as wide as high.
    #[must_use]
    pub fn framing(&self, bounds: &Bounds, direction: Vec3) -> Self {
        let forward = direction.as_dvec3().try_normalize().unwrap_or(DVec3::NEG_Z);
        if bounds.is_empty() {
            return *self;
        }
        let up = match self.up.as_dvec3().reject_from(forward) {
            across if across.length() > 1e-3 => self.up,
            _ => forward.any_orthonormal_vector().as_vec3(),
        };
        let right = forward.cross(up.as_dvec3()).normalize();
        let above = right.cross(forward);
        let center = bounds.center();
        let tan = (f64::from(self.fov_deg).to_radians() * 0.5).tan();
        let distance = bounds.corners().into_iter().map(|corner| {
            let p = corner - center;
            let across = p.dot(right).abs().max(p.dot(above).abs()) * MARGIN;
            across / tan - p.dot(forward)
        });
        let distance = distance.fold(bounds.radius().max(1e-6) * 0.1, f64::max);
        let eye = center - forward * distance;
        Self { eye: eye.as_vec3(), target: center.as_vec3(), up, fov_deg: self.fov_deg }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tangent_of(camera: &Camera, point: DVec3) -> (f64, f64) {
        let forward = (camera.target - camera.eye).as_dvec3().normalize();
        let right = forward.cross(camera.up.as_dvec3()).normalize();
        let p = point - camera.eye.as_dvec3();
        (p.dot(right) / p.dot(forward), p.dot(right.cross(forward)) / p.dot(forward))
    }

    #[test]
    fn a_framed_box_is_whole_in_the_picture_and_fills_it() {
        for direction in [Vec3::NEG_Z, Vec3::new(-1.0, -0.7, 0.3), Vec3::NEG_Y] {
            let bounds = Bounds { min: DVec3::new(-30.0, 2.0, 5.0), max: DVec3::new(90.0, 80.0, 12.0) };
            let camera = Camera::default().framing(&bounds, direction);
            let tan = (f64::from(camera.fov_deg).to_radians() * 0.5).tan();
            let largest = bounds.corners().iter().fold(0.0, |most: f64, corner| {
                let (x, y) = tangent_of(&camera, *corner);
                most.max(x.abs()).max(y.abs())
            });
            assert!(largest < tan, "{direction}: a corner is outside the picture");
            assert!(largest > 0.7 * tan, "{direction}: the box is small in the picture");
        }
    }

    #[test]
    fn the_ground_goes_under_the_body_and_grows_with_it() {
        let plane = super::super::description::Model {
            source: Source::Shape(Shape::Plane { size: 60.0 }),
            ..Default::default()
        };
        let mut scene = Scene { models: vec![plane], frame_camera: true, ..Scene::default() };
        let bounds = Bounds { min: DVec3::new(-3.0, -7.0, -4.0), max: DVec3::new(3.0, 17.0, 4.0) };
        fit(&mut scene, &bounds);
        assert_eq!(scene.models[0].translate, Vec3::new(0.0, -7.0, 0.0));
        assert!((scene.models[0].scale - 13.0).abs() < 1e-5);
    }
}
