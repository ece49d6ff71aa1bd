//! Materials: every part's glass or opaque colour, written as overrides into the scene.

use super::icons::{self, Icon};
use super::rows::{color, log_slider, plain, quiet, row, slider, tick};
use crate::app::session::Session;
use crate::scene::description::{MaterialOverride, Model};
use crate::scene::geometry::Part;
use crate::scene::material::Material;
use egui::{CollapsingHeader, DragValue, Popup, Ui};
use glam::Vec3;

/// Common refraction indices.
const PRESETS: &[(&str, f32)] =
    &[("air", 1.0), ("ice", 1.31), ("water", 1.333), ("glass", 1.5), ("crystal", 1.7), ("diamond", 2.417)];
/// Absorption below which a part counts as clear, per world unit.
const CLEAR: f32 = 1e-4;

/// All parts of all models.
pub(super) fn show(ui: &mut Ui, session: &mut Session) {
    let materials = session.world.materials(&session.scene);
    let many = session.world.parts.len() > 1;
    let first_glass = materials.iter().position(|m| !m.opaque);
    for (number, (part, material)) in session.world.parts.iter().zip(&materials).enumerate() {
        let index = part.model as usize;
        let (Some(model), Some(geometry)) = (session.scene.models.get_mut(index), session.world.models.get(index))
        else {
            continue;
        };
        let Some(rest) = geometry.parts.get(part.part as usize) else { continue };
        let is_only = geometry.parts.len() == 1;
        if many {
            let title = if is_only { &model.name } else { &part.name };
            CollapsingHeader::new(title)
                .id_salt(("part", part.model, part.part))
                .default_open(first_glass == Some(number))
                .show(ui, |ui| edit(ui, model, rest, is_only, material));
        } else {
            edit(ui, model, rest, is_only, material);
        }
    }
}

/// The rows of one part. `material` is what it has now, all overrides applied.
fn edit(ui: &mut Ui, model: &mut Model, part: &Part, is_only: bool, material: &Material) {
    let mut now = material.clone();
    if tick(ui, "Opaque", "light does not pass", &mut now.opaque).changed() {
        target(model, part, is_only).opaque = Some(now.opaque);
    }
    if now.opaque {
        if color(ui, "Colour", "diffuse reflectance", &mut now.base_color).changed() {
            target(model, part, is_only).base_color = Some(now.base_color);
        }
        checker(ui, model, part, is_only, &mut now);
    } else {
        glass(ui, model, part, is_only, &mut now);
    }
    if slider(ui, "Roughness", "of the surface, 0 to 1", &mut now.roughness, 0.0..=1.0).changed() {
        target(model, part, is_only).roughness = Some(now.roughness);
    }
}

fn checker(ui: &mut Ui, model: &mut Model, part: &Part, is_only: bool, now: &mut Material) {
    if part.plane_half.is_none() {
        return;
    }
    if slider(
        ui,
        "Squares",
        "side of a checkerboard's squares, world units; 0 is plain",
        &mut now.checker_square,
        0.0..=4.0,
    )
    .changed()
    {
        target(model, part, is_only).checker_square = Some(now.checker_square);
    }
    if now.checker_square > 0.0 && color(ui, "Other colour", "of the checkerboard", &mut now.checker_color).changed() {
        target(model, part, is_only).checker_color = Some(now.checker_color);
    }
}

fn glass(ui: &mut Ui, model: &mut Model, part: &Part, is_only: bool, now: &mut Material) {
    let changed = row(ui, "Refraction index", "speed of light outside over inside", |ui| {
        let response = {
            ui.spacing_mut().slider_width = (ui.available_width() - 108.0).max(40.0);
            ui.add(plain(&mut now.ior, 1.0..=2.6).max_decimals(3))
        };
        let mut changed = response.changed();
        let opener = icons::button(ui, Icon::More, true, "common indices");
        Popup::menu(&opener).show(|ui| {
            for (name, ior) in PRESETS {
                if ui.button(format!("{name}  {ior}")).clicked() {
                    now.ior = *ior;
                    changed = true;
                    ui.close();
                }
            }
        });
        changed
    });
    if changed {
        target(model, part, is_only).ior = Some(now.ior);
    }
    absorption(ui, model, part, is_only, now.sigma);
    if color(ui, "Tint", "of the surface", &mut now.base_color).changed() {
        target(model, part, is_only).base_color = Some(now.base_color);
    }
    if slider(ui, "Dispersion", "20 over the Abbe number; 0 is none", &mut now.dispersion, 0.0..=2.0).changed() {
        target(model, part, is_only).dispersion = Some(now.dispersion);
    }
    let hint = "where glasses overlap the higher one counts; equal: the later model";
    if row(ui, "Priority", hint, |ui| ui.add(DragValue::new(&mut now.priority).speed(0.05)).changed()) {
        target(model, part, is_only).priority = Some(now.priority);
    }
}

/// Absorption as the colour that white light has after a distance.
fn absorption(ui: &mut Ui, model: &mut Model, part: &Part, is_only: bool, sigma: Vec3) {
    let said = |pick: fn(&MaterialOverride) -> Option<f32>| {
        model.materials.iter().rev().filter(|o| names(o, part)).find_map(pick)
    };
    let strongest = sigma.max_element();
    let mut distance = said(|o| o.attenuation_distance)
        .filter(|d| d.is_finite() && *d > 0.0)
        .unwrap_or(if strongest > CLEAR { 1.0 / strongest } else { 1.0 });
    let mut at_distance = (-sigma * distance).map(f32::exp);
    let recolored =
        color(ui, "Absorption", "colour of white light after the distance below", &mut at_distance).changed();
    let moved = log_slider(ui, "at distance", "world units inside the glass", &mut distance, 0.01..=100.0).changed();
    quiet(ui, format!("σ = {:.3}, {:.3}, {:.3} per unit", sigma.x, sigma.y, sigma.z));
    if recolored || moved {
        let over = target(model, part, is_only);
        over.sigma = None;
        over.attenuation_color = Some(at_distance.clamp(Vec3::splat(1e-4), Vec3::ONE));
        over.attenuation_distance = Some(distance);
    }
}

fn names(over: &MaterialOverride, part: &Part) -> bool {
    over.part == "*" || over.part == part.name
}

/// The override that an edit of this part goes to: the last one that counts for it and for it alone, else a new one.
fn target<'m>(model: &'m mut Model, part: &Part, is_only: bool) -> &'m mut MaterialOverride {
    let last = model.materials.iter().rposition(|o| names(o, part));
    let own = last.filter(|i| is_only || model.materials[*i].part == part.name);
    let index = own.unwrap_or_else(|| {
        model.materials.push(MaterialOverride { part: part.name.clone(), ..MaterialOverride::default() });
        model.materials.len() - 1
    });
    &mut model.materials[index]
}
