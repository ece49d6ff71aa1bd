//! All keys and gestures, from the action table.

use super::{Stage, theme};
use crate::app::actions::{GESTURES, Group, help_lines};
use egui::{Align2, Rect, RichText, ScrollArea, Ui, Window};

/// Width of the column of keys, points.
const KEYS: f32 = 210.0;
/// Height of a line, points.
const ROW: f32 = 16.0;

/// The help, in the middle of the picture.
pub(super) fn show(ui: &Ui, stage: &mut Stage<'_>, place: Rect) {
    let mut open = true;
    Window::new("Keys and gestures")
        .open(&mut open)
        .collapsible(false)
        .resizable(false)
        .pivot(Align2::CENTER_CENTER)
        .fixed_pos(place.center())
        .show(ui.ctx(), |ui| {
            ScrollArea::vertical().max_height((place.height() - 90.0).max(80.0)).show(ui, |ui| {
                ui.set_min_height((place.height() - 120.0).clamp(80.0, 560.0));
                title(ui, "Mouse");
                for (gesture, what) in GESTURES {
                    line(ui, gesture, what, "");
                }
                for (group, name) in Group::ALL {
                    title(ui, name);
                    for each in help_lines(*group) {
                        line(ui, &each.keys, each.name, each.help);
                    }
                }
            });
        });
    stage.chrome.help &= open;
}

fn title(ui: &mut Ui, text: &str) {
    ui.add_space(6.0);
    ui.label(RichText::new(text).strong().color(theme::ACCENT));
}

fn line(ui: &mut Ui, keys: &str, name: &str, help: &str) {
    ui.horizontal(|ui| {
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        ui.allocate_ui_with_layout(egui::vec2(KEYS, ROW), layout, |ui| {
            ui.set_min_width(KEYS);
            ui.label(RichText::new(keys).monospace());
        });
        ui.label(name);
        if !help.is_empty() {
            ui.label(RichText::new(help).weak());
        }
    });
}
