//! The lights and the background.

use super::rows::{angle, color, log_slider, quiet, row, slider, tick, vector};
use crate::scene::Scene;
use crate::scene::description::{ANGULAR_RADIUS_DEG, Background, Light, LightKind};
use crate::surroundings::MAX_LIGHTS;
use egui::{CollapsingHeader, ComboBox, Ui};
use glam::Vec3;

/// Radians above which a direction counts as straight up or down, whose azimuth is anything.
const POLE_RAD: f32 = 1.55;

/// Every light, then the background.
pub(super) fn show(ui: &mut Ui, scene: &mut Scene) {
    let mut removed = None;
    for (index, light) in scene.lights.iter_mut().enumerate() {
        let kind = match light.kind {
            LightKind::Directional { .. } => "directional",
            LightKind::Point { .. } => "point",
            LightKind::Spot { .. } => "spot",
        };
        let title = if index == 0 { format!("Key light · {kind}") } else { format!("Light {index} · {kind}") };
        CollapsingHeader::new(title).id_salt(("light", index)).default_open(index == 0).show(ui, |ui| {
            edit(ui, light, kind);
            if ui.button("Remove").clicked() {
                removed = Some(index);
            }
        });
    }
    if let Some(index) = removed {
        scene.lights.remove(index);
    }
    if scene.lights.len() < MAX_LIGHTS && ui.button("Add a light").clicked() {
        scene.lights.push(Light { intensity: 1.0, ..Light::default() });
    }
    ui.add_space(4.0);
    background(ui, &mut scene.background);
}

fn edit(ui: &mut Ui, light: &mut Light, kind: &str) {
    row(ui, "Kind", "", |ui| {
        ComboBox::from_id_salt("kind").selected_text(kind).width(ui.available_width()).show_ui(ui, |ui| {
            for other in ["directional", "point", "spot"] {
                if ui.selectable_label(kind == other, other).clicked() && kind != other {
                    light.kind = turned_into(light.kind, other);
                }
            }
        });
    });
    match &mut light.kind {
        LightKind::Directional { direction } => aim(ui, direction),
        LightKind::Point { position } => {
            vector(ui, "Position", "world units", position, 0.02, "");
        }
        LightKind::Spot { position, direction, angle_deg, blend } => {
            vector(ui, "Position", "world units", position, 0.02, "");
            aim(ui, direction);
            angle(ui, "Half angle", "of the cone", angle_deg, 1.0..=89.0);
            slider(ui, "Softness", "fraction of the half angle over which it fades", blend, 0.0..=1.0);
        }
    }
    color(ui, "Colour", "linear", &mut light.color);
    log_slider(ui, "Intensity", "irradiance; point and spot: radiant intensity", &mut light.intensity, 0.01..=1000.0);
    let seen = "half the angle under which it is seen: wider highlights, softer shadows";
    angle(ui, "Size", seen, &mut light.angular_radius_deg, ANGULAR_RADIUS_DEG);
    tick(ui, "Casts shadow", "has a grid of its own", &mut light.casts_shadow);
}

/// The same light as another kind, from about the same side.
fn turned_into(kind: LightKind, other: &str) -> LightKind {
    let (position, direction) = match kind {
        LightKind::Directional { direction } => (-direction * 6.0, direction),
        LightKind::Point { position } => (position, (-position).normalize_or(Vec3::NEG_Y)),
        LightKind::Spot { position, direction, .. } => (position, direction),
    };
    match other {
        "point" => LightKind::Point { position },
        "spot" => LightKind::Spot { position, direction, angle_deg: 30.0, blend: 0.2 },
        _ => LightKind::Directional { direction },
    }
}

/// A direction as the height and the bearing that the light comes from.
fn aim(ui: &mut Ui, direction: &mut Vec3) {
    let from = -direction.normalize_or(Vec3::NEG_Y);
    let height = from.y.clamp(-1.0, 1.0).asin();
    let bearing = if height.abs() > POLE_RAD { 0.0 } else { from.x.atan2(from.z) };
    let (mut height_deg, mut bearing_deg) = (height.to_degrees(), bearing.to_degrees());
    let mut changed = angle(ui, "Height", "above the horizon", &mut height_deg, -88.0..=88.0).changed();
    changed |= angle(ui, "Bearing", "about the vertical", &mut bearing_deg, -180.0..=180.0).changed();
    if changed {
        let (height, bearing) = (height_deg.to_radians(), bearing_deg.to_radians());
        *direction = -Vec3::new(height.cos() * bearing.sin(), height.sin(), height.cos() * bearing.cos());
    }
}

fn background(ui: &mut Ui, background: &mut Background) {
    CollapsingHeader::new("Background").show(ui, |ui| {
        kinds(ui, background);
        match background {
            Background::Color { color: value } => {
                color(ui, "Colour", "linear radiance", value);
            }
            Background::Sky { horizon, zenith, ground, exponent, intensity } => {
                color(ui, "Zenith", "overhead", zenith);
                color(ui, "Horizon", "", horizon);
                color(ui, "Ground", "below the horizon", ground);
                slider(ui, "Falloff", "power of the height", exponent, 0.05..=4.0);
                log_slider(ui, "Intensity", "scales all three", intensity, 0.01..=20.0);
            }
            Background::Checker { a, b, square, distance } => {
                color(ui, "One colour", "", a);
                color(ui, "The other", "", b);
                log_slider(ui, "Square", "side, world units", square, 0.01..=20.0);
                log_slider(ui, "Distance", "beyond the camera's target, world units", distance, 0.1..=100.0);
            }
            Background::Environment { file, rotate_deg, intensity } => {
                quiet(ui, file.display().to_string());
                angle(ui, "Turn", "about the vertical", rotate_deg, -180.0..=180.0);
                log_slider(ui, "Intensity", "", intensity, 0.01..=20.0);
            }
        }
    });
}

/// The kinds that need no file.
fn kinds(ui: &mut Ui, background: &mut Background) {
    row(ui, "Kind", "an environment is named in the scene file", |ui| {
        let is = |b: &Background, other: &Background| std::mem::discriminant(b) == std::mem::discriminant(other);
        let checker = Background::Checker { a: Vec3::splat(0.8), b: Vec3::splat(0.2), square: 0.5, distance: 3.0 };
        let others = [
            ("colour", Background::Color { color: Vec3::splat(0.5) }),
            ("sky", Background::default()),
            ("checker", checker),
        ];
        for (name, other) in others {
            if ui.selectable_label(is(background, &other), name).clicked() && !is(background, &other) {
                *background = other;
            }
        }
        if matches!(background, Background::Environment { .. }) {
            let _ = ui.selectable_label(true, "environment");
        }
    });
}
