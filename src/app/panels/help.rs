//! All keys and gestures, from the action table.

use super::{Stage, theme};
use crate::app::actions::{GESTURES, Group, help_lines};
use egui::{Align2, Grid, Rect, RichText, ScrollArea, Ui, Window};

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
                title(ui, "Mouse");
                Grid::new("gestures").num_columns(2).spacing([20.0, 3.0]).show(ui, |ui| {
                    for (gesture, what) in GESTURES {
                        line(ui, gesture, what, "");
                    }
                });
                for (group, name) in Group::ALL {
                    title(ui, name);
                    Grid::new(*name).num_columns(2).spacing([20.0, 3.0]).show(ui, |ui| {
                        for each in help_lines(*group) {
                            line(ui, &each.keys, each.name, each.help);
                        }
                    });
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
    ui.add_sized([170.0, 16.0], egui::Label::new(RichText::new(keys).monospace()).halign(egui::Align::LEFT));
    ui.horizontal(|ui| {
        ui.label(name);
        if !help.is_empty() {
            ui.label(RichText::new(help).weak());
        }
    });
    ui.end_row();
}
