//! What is shown: the picture or a debug view; the camera's lens.

use super::rows::{angle, row, slider};
use super::{Command, Stage};
use crate::app::actions::{ACTIONS, ActionId, Group, hint};
use crate::app::view::Mode;
use egui::Ui;

/// The views and their parameters.
pub(super) fn show(ui: &mut Ui, stage: &mut Stage<'_>) {
    ui.horizontal_wrapped(|ui| {
        for action in ACTIONS.iter().filter(|a| a.group == Group::Show) {
            let ActionId::Show(mode) = action.id else { continue };
            let button = ui.selectable_label(stage.session.view.mode == mode, action.name);
            let help = if action.help.is_empty() { String::new() } else { format!(": {}", action.help) };
            if button.on_hover_text(format!("{}{help}", hint(action.id))).clicked() {
                stage.commands.push(Command::Act(action.id));
            }
        }
    });
    let view = &mut stage.session.view;
    match view.mode {
        Mode::Slice => {
            row(ui, "Across", "axis of the view's grid", |ui| {
                for (axis, name) in [(0, "x"), (1, "y"), (2, "z (depth)")] {
                    ui.selectable_value(&mut view.slice_axis, axis, name);
                }
            });
            slider(ui, "Slice", "0 to 1 along the axis", &mut view.slice_position, 0.0..=1.0);
        }
        Mode::LightVolume => {
            slider(ui, "Slice", "0 to 1 along the light", &mut view.light_position, 0.0..=1.0);
        }
        Mode::Thickness => {
            slider(ui, "Brightest", "thickness shown brightest, world units", &mut view.thickness_max, 0.05..=10.0);
        }
        _ => {}
    }
    let fov = &mut stage.session.scene.camera.fov_deg;
    angle(ui, "Field of view", "vertical", fov, 5.0..=110.0);
}
