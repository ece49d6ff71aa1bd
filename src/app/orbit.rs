//! Moves the camera: a turntable about the target, whose poles are never passed.

use crate::scene::description::{Bounds, Camera};
use glam::{Quat, Vec2, Vec3};

/// How near the view may come to the poles, radians.
const POLE_RAD: f32 = 0.02;
/// Nearest and farthest the eye may be from its target, world units.
const DISTANCES: std::ops::RangeInclusive<f32> = 1e-3..=1e6;

/// Turns the eye about the target: `yaw_rad` about `up`, `pitch_rad` towards it.
pub fn orbit(camera: &mut Camera, yaw_rad: f32, pitch_rad: f32) {
    let (up, back) = axes(camera);
    let distance = (camera.eye - camera.target).length().clamp(*DISTANCES.start(), *DISTANCES.end());
    let polar = back.angle_between(up);
    let wanted = (polar - pitch_rad).clamp(POLE_RAD, std::f32::consts::PI - POLE_RAD);
    let right = up.cross(back).normalize_or(up.any_orthonormal_vector());
    let turned = Quat::from_axis_angle(up, yaw_rad) * Quat::from_axis_angle(right, wanted - polar) * back;
    if turned.is_finite() {
        camera.eye = camera.target + turned.normalize() * distance;
    }
}

/// Moves eye and target in the picture's plane; `by` is in heights of the picture, y down, at the target's distance.
pub fn pan(camera: &mut Camera, by: Vec2) {
    let (up, back) = axes(camera);
    let right = up.cross(back).normalize_or(up.any_orthonormal_vector());
    let height = 2.0 * (camera.eye - camera.target).length() * (camera.fov_deg.to_radians() * 0.5).tan();
    let shift = (right * -by.x + back.cross(right) * by.y) * height;
    if shift.is_finite() {
        camera.eye += shift;
        camera.target += shift;
    }
}

/// Scales the distance from the eye to the target: below 1 comes nearer.
pub fn zoom(camera: &mut Camera, factor: f32) {
    let (_, back) = axes(camera);
    let distance = (camera.eye - camera.target).length() * factor;
    if distance.is_finite() {
        camera.eye = camera.target + back * distance.clamp(*DISTANCES.start(), *DISTANCES.end());
    }
}

/// Moves the camera, without turning it, so that `bounds` fill a picture of this aspect (width over height).
pub fn frame(camera: &mut Camera, bounds: &Bounds, aspect: f32) {
    if bounds.is_empty() || !bounds.radius().is_finite() {
        return;
    }
    let (_, back) = axes(camera);
    *camera = camera.framing(bounds, -back);
    if aspect < 1.0 {
        zoom(camera, 1.0 / aspect.max(0.01));
    }
}

/// Unit `up`, and the unit direction from the target to the eye; sane even for a camera that is not.
fn axes(camera: &Camera) -> (Vec3, Vec3) {
    let up = camera.up.normalize_or(Vec3::Y);
    (up, (camera.eye - camera.target).normalize_or(up.any_orthonormal_vector()))
}
