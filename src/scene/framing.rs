//! Fits a scene to bodies whose size was not known when it was written.
//!
//! A framed scene (`camera.frame = true`) is written around a body that stands on the origin and has radius 1: [`frame`]
//! carries its planes and lights to the true bounds and moves the camera, along its own direction, to show them whole.

use super::description::{Bounds, Camera, LightKind, Scene, Shape, Source};
use super::pose::pose_vertices;
use super::world::World;
use glam::{DVec3, Vec3};

/// Poses that the framed bounds are gathered over, so that a body that walks stays in the picture.
const POSES: u32 = 8;
/// How much wider the framed field of view is than the body.
const MARGIN: f64 = 1.15;
/// Up to so many posed vertices are framed exactly; beyond it the parts' bounds do.
const MOST_POINTS: usize = 1_000_000;

fn is_plane(scene: &Scene, model: usize) -> bool {
    matches!(scene.models.get(model).map(|m| &m.source), Some(Source::Shape(Shape::Plane { .. })))
}

/// Times whose poses stand for the whole animation, seconds.
fn times(scene: &Scene, world: &World) -> impl Iterator<Item = f64> + use<> {
    let duration_secs = world.duration_secs(scene);
    let poses = if duration_secs > 0.0 { POSES } else { 1 };
    (0..poses).map(move |i| duration_secs * f64::from(i) / f64::from(POSES))
}

/// The bounds of all parts but planes, at one time.
#[must_use]
pub fn bounds_at(scene: &Scene, world: &World, time_secs: f64) -> Bounds {
    let world = world.at(scene, time_secs, None);
    let pose = world.pose(scene, time_secs);
    let parts = world.parts.iter().zip(&pose.part_bounds);
    let bodies = parts.filter(|(part, b)| !is_plane(scene, part.model as usize) && !b.is_empty());
    bodies.fold(Bounds::EMPTY, |all, (_, bounds)| all.union(*bounds))
}

/// The bounds of all parts but planes, over the whole animation.
#[must_use]
pub fn bounds_of_bodies(scene: &Scene, world: &World) -> Bounds {
    times(scene, world).fold(Bounds::EMPTY, |all, time_secs| all.union(bounds_at(scene, world, time_secs)))
}

/// Points that enclose all parts but planes, over the whole animation.
fn points_of_bodies(scene: &Scene, world: &World) -> Vec<DVec3> {
    let mut points = Vec::new();
    let vertices: usize = world.models.iter().map(|m| m.vertices.len()).sum();
    for time_secs in times(scene, world) {
        if points.len() + vertices > MOST_POINTS {
            points.extend(bounds_at(scene, world, time_secs).corners());
            continue;
        }
        let world = world.at(scene, time_secs, None);
        let posed = pose_vertices(&world, scene, &world.pose(scene, time_secs));
        let mut first = 0;
        for (model, geometry) in world.models.iter().enumerate() {
            let of_model = &posed[first..first + geometry.vertices.len()];
            first += geometry.vertices.len();
            if !is_plane(scene, model) {
                points.extend(of_model.iter().map(|(position, _)| position.as_dvec3()).filter(|p| p.is_finite()));
            }
        }
    }
    points
}

/// Fits a scene that asks for it to its bodies; others stay as they are.
pub fn frame(scene: &mut Scene, world: &World) {
    if scene.frame_camera {
        scene.frame_camera = false;
        let points = points_of_bodies(scene, world);
        fit(scene, &points);
    }
}

/// Carries planes and lights from the unit body to that of `points` and frames the camera. No points change nothing.
fn fit(scene: &mut Scene, points: &[DVec3]) {
    let mut bounds = Bounds::EMPTY;
    points.iter().for_each(|point| bounds.add(*point));
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
    scene.camera = scene.camera.framing_points(points, scene.camera.target - scene.camera.eye);
}

impl Camera {
    /// This camera moved so that it looks along `direction` at all of `bounds`, in pictures at least as wide as high.
    #[must_use]
    pub fn framing(&self, bounds: &Bounds, direction: Vec3) -> Self {
        if bounds.is_empty() { *self } else { self.framing_points(&bounds.corners(), direction) }
    }

    /// This camera moved so that it looks along `direction` at all of the points, which fill the middle of the picture.
    #[must_use]
    pub fn framing_points(&self, points: &[DVec3], direction: Vec3) -> Self {
        let forward = direction.as_dvec3().try_normalize().unwrap_or(DVec3::NEG_Z);
        let up = match self.up.as_dvec3().reject_from(forward) {
            across if across.length() > 1e-3 => self.up,
            _ => forward.any_orthonormal_vector().as_vec3(),
        };
        let right = forward.cross(up.as_dvec3()).normalize();
        let above = right.cross(forward);
        let tan = (f64::from(self.fov_deg).to_radians() * 0.5).tan() / MARGIN;
        // Along an axis: a point at depth z and offset x is seen from eye (ex, ez) where |x − ex| ≤ (z − ez)·tan. The
        // outermost points of either side say how far the eye must stand back, and where between them.
        let most = |axis: DVec3| points.iter().map(|p| p.dot(axis) - p.dot(forward) * tan).fold(f64::MIN, f64::max);
        let across = (most(right), most(-right));
        let upward = (most(above), most(-above));
        let depth_of_eye = (-(across.0 + across.1) / (2.0 * tan)).min(-(upward.0 + upward.1) / (2.0 * tan));
        let eye =
            right * ((across.0 - across.1) * 0.5) + above * ((upward.0 - upward.1) * 0.5) + forward * depth_of_eye;
        let depths = points.iter().map(|p| p.dot(forward));
        let (near, far) = depths.fold((f64::MAX, f64::MIN), |(near, far), z| (near.min(z), far.max(z)));
        let distance = 0.5 * (near + far) - depth_of_eye;
        if !eye.is_finite() || !distance.is_finite() || distance < 1e-9 {
            return *self; // no points, or all in one place
        }
        Self { eye: eye.as_vec3(), target: (eye + forward * distance).as_vec3(), up, fov_deg: self.fov_deg }
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
    fn points_in_one_place_or_none_leave_the_camera_alone() {
        let camera = Camera::default();
        assert_eq!(camera.framing_points(&[], Vec3::NEG_Z), camera);
        assert_eq!(camera.framing_points(&[DVec3::ONE; 3], Vec3::NEG_Z), camera);
        assert_eq!(camera.framing(&Bounds::EMPTY, Vec3::NEG_Z), camera);
        assert_ne!(camera.framing_points(&[DVec3::ONE, DVec3::ZERO], Vec3::NEG_Z), camera);
    }

    #[test]
    fn the_ground_goes_under_the_body_and_grows_with_it() {
        let plane = super::super::description::Model {
            source: Source::Shape(Shape::Plane { size: 60.0 }),
            ..Default::default()
        };
        let mut scene = Scene { models: vec![plane], frame_camera: true, ..Scene::default() };
        let bounds = Bounds { min: DVec3::new(-3.0, -7.0, -4.0), max: DVec3::new(3.0, 17.0, 4.0) };
        fit(&mut scene, &bounds.corners());
        assert_eq!(scene.models[0].translate, Vec3::new(0.0, -7.0, 0.0));
        assert!((scene.models[0].scale - 13.0).abs() < 1e-5);
    }
}
