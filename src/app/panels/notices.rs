//! Errors and warnings over the picture, each once, each with a cross.

use super::icons::{self, Icon};
use super::{Stage, theme};
use crate::app::notices::Severity;
use egui::{Area, Frame, Margin, Rect, Ui};

/// The strip at the picture's upper left.
pub(super) fn show(ui: &Ui, stage: &mut Stage<'_>, place: Rect) {
    let notices = &mut stage.session.notices;
    if notices.shown().is_empty() {
        return;
    }
    let mut dismissed = None;
    let at = place.left_top() + egui::vec2(12.0, 12.0);
    Area::new(egui::Id::unique("notices")).fixed_pos(at).show(ui.ctx(), |ui| {
        ui.set_max_width((place.width() - 24.0).clamp(120.0, 640.0));
        for (index, notice) in notices.shown().iter().enumerate() {
            let color = match notice.severity {
                Severity::Done => theme::DONE,
                Severity::Warning => theme::WARNING,
                Severity::Error => theme::ERROR,
            };
            let frame = Frame::popup(ui.style()).inner_margin(Margin { left: 14, right: 4, top: 6, bottom: 6 });
            let card = frame.show(ui, |ui| {
                ui.horizontal_top(|ui| {
                    let width = ui.available_width() - 40.0;
                    ui.allocate_ui(egui::vec2(width, 0.0), |ui| {
                        ui.add(egui::Label::new(&notice.text).wrap().selectable(true));
                    });
                    if icons::button(ui, Icon::Close, true, "Dismiss").clicked() {
                        dismissed = Some(index);
                    }
                });
            });
            // A bar at the left says how bad it is.
            let bar = card.response.rect.shrink(1.0);
            ui.painter().rect_filled(bar.with_max_x(bar.left() + 3.0), 2.0, color);
        }
    });
    if let Some(index) = dismissed {
        notices.dismiss(index);
    }
}
