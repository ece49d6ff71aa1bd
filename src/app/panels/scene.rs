//! The scene: its file, its models and where they stand.

use super::icons::{self, Icon};
use super::rows::{name_choice, quiet, row, slider, vector};
use super::{Command, Stage};
use crate::app::actions::{ACTIONS, ActionId, Group, hint};
use crate::scene::description::{Model, Source};
use crate::scene::geometry::Geometry;
use egui::{CollapsingHeader, DragValue, Popup, RichText, Ui};
use std::path::PathBuf;

/// What the file's default clip is called in the menu.
const FIRST_CLIP: &str = "(first)";
/// What the file's own materials are called in the menu.
const NO_VARIANT: &str = "(as the file)";

/// Name of the scene, menu, undo.
pub(super) fn header(ui: &mut Ui, stage: &mut Stage<'_>) {
    ui.horizontal(|ui| {
        let opener = icons::button(ui, Icon::Menu, true, "Menu");
        Popup::menu(&opener).show(|ui| menu(ui, stage));
        let edited = if stage.session.is_edited() { " •" } else { "" };
        let name = RichText::new(format!("{}{edited}", stage.session.name())).heading().strong();
        ui.add(egui::Label::new(name).truncate()).on_hover_text(match &stage.session.path {
            Some(path) => path.display().to_string(),
            None => "the built-in scene".to_owned(),
        });
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let (undo, redo) = (stage.session.history.can_undo(), stage.session.history.can_redo());
            for (icon, action, enabled) in [
                (Icon::Help, ActionId::Help, true),
                (Icon::Redo, ActionId::Redo, redo),
                (Icon::Undo, ActionId::Undo, undo),
            ] {
                if icons::button(ui, icon, enabled, &hint(action)).clicked() {
                    stage.commands.push(Command::Act(action));
                }
            }
        });
    });
}

fn button(ui: &mut Ui, stage: &mut Stage<'_>, text: &str, action: ActionId, enabled: bool) {
    if ui.add_enabled(enabled, egui::Button::new(text)).on_hover_text(hint(action)).clicked() {
        stage.commands.push(Command::Act(action));
    }
}

/// Every action of the table.
fn menu(ui: &mut Ui, stage: &mut Stage<'_>) {
    for (group, title) in Group::ALL {
        ui.menu_button(*title, |ui| {
            for action in ACTIONS.iter().filter(|a| a.group == *group) {
                let keys = action.keys.first().map(super::super::actions::Chord::text).unwrap_or_default();
                let line = egui::Button::new(action.name).shortcut_text(keys);
                if ui.add(line).clicked() {
                    stage.commands.push(Command::Act(action.id));
                    ui.close();
                }
            }
        });
    }
}

/// File buttons and models.
pub(super) fn show(ui: &mut Ui, stage: &mut Stage<'_>) {
    ui.horizontal_wrapped(|ui| {
        button(ui, stage, "Reload", ActionId::Reload, true);
        button(ui, stage, "Reset", ActionId::ResetScene, stage.session.is_edited());
        button(ui, stage, "Save", ActionId::Save, true);
        ui.menu_button("Save as…", |ui| save_as(ui, stage));
    });
    quiet(ui, "Drop a scene or a model on the window to open it, or an .hdr to be lit by it.");
    let session = &mut *stage.session;
    for (index, model) in session.scene.models.iter_mut().enumerate() {
        let geometry = session.world.models.get(index);
        CollapsingHeader::new(&model.name).id_salt(("model", index)).show(ui, |ui| {
            placement(ui, model);
            if let Some(geometry) = geometry {
                choices(ui, model, geometry);
            }
        });
    }
    session.settle_time();
}

fn save_as(ui: &mut Ui, stage: &mut Stage<'_>) {
    if stage.chrome.save_as.is_empty() {
        stage.chrome.save_as = stage.session.save_path().display().to_string();
    }
    ui.set_min_width(300.0);
    let field = ui.add(egui::TextEdit::singleline(&mut stage.chrome.save_as).desired_width(f32::INFINITY));
    let entered = field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
    if ui.button("Save").clicked() || entered {
        stage.commands.push(Command::SaveAs(PathBuf::from(stage.chrome.save_as.trim())));
        stage.chrome.save_as.clear();
        ui.close();
    }
}

fn placement(ui: &mut Ui, model: &mut Model) {
    if let Source::File(file) = &model.source {
        quiet(ui, file.display().to_string());
    }
    vector(ui, "Position", "world units", &mut model.translate, 0.01, "");
    vector(ui, "Rotation", "degrees about x, then y, then z", &mut model.rotate_deg, 0.5, "°");
    row(ui, "Scale", "uniform", |ui| {
        ui.add(
            DragValue::new(&mut model.scale)
                .speed(0.005)
                .range(1e-4..=1e4)
                .clamp_existing_to_range(false)
                .max_decimals(4),
        )
    });
}

fn choices(ui: &mut Ui, model: &mut Model, geometry: &Geometry) {
    if !geometry.clips.is_empty() {
        let chosen = model.animation.clone().unwrap_or_else(|| FIRST_CLIP.to_owned());
        let first = std::iter::once((FIRST_CLIP, ""));
        let names = first.chain(geometry.clips.iter().map(|c| (c.name.as_str(), "")));
        if let Some(name) = name_choice(ui, "Clip", "the animation that plays", &chosen, names) {
            model.animation = (name != FIRST_CLIP).then_some(name);
        }
    }
    if !geometry.clips.is_empty() || !model.deformers.is_empty() {
        slider(ui, "Speed", "of the animation", &mut model.speed, 0.0..=4.0);
    }
    if !geometry.variants.is_empty() {
        let chosen = model.variant.clone().unwrap_or_else(|| NO_VARIANT.to_owned());
        let first = std::iter::once((NO_VARIANT, ""));
        let names = first.chain(geometry.variants.iter().map(|v| (v.as_str(), "")));
        if let Some(name) = name_choice(ui, "Variant", "the file's sets of materials", &chosen, names) {
            model.variant = (name != NO_VARIANT).then_some(name);
        }
    }
}
