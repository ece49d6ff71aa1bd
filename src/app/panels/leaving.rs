//! Asks what to do with unsaved edits before they would be lost.

use super::{Command, Stage};
use egui::{Frame, Id, Margin, Modal, RichText, Ui};

/// The question, over everything, while there is one.
pub(super) fn show(ui: &Ui, stage: &mut Stage<'_>) {
    let Some(leaving) = &stage.chrome.leaving else { return };
    let frame = Frame::popup(ui.style()).inner_margin(Margin::same(16));
    let modal = Modal::new(Id::unique("leaving")).frame(frame).show(ui.ctx(), |ui| {
        ui.set_width(340.0);
        ui.label(RichText::new(format!("Save the changes to “{}”?", stage.session.name())).heading());
        ui.add_space(4.0);
        ui.label(format!("They would be lost by {}.", leaving.words()));
        ui.add_space(10.0);
        let mut answer = None;
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let save = ui.button("Save").on_hover_text(stage.session.save_path().display().to_string());
            for (button, command) in [
                (save, Command::SaveAndLeave),
                (ui.button("Discard"), Command::Leave),
                (ui.button("Cancel"), Command::Stay),
            ] {
                if button.clicked() {
                    answer = Some(command);
                }
            }
        });
        answer
    });
    let outside = modal.should_close().then_some(Command::Stay);
    stage.commands.extend(modal.inner.or(outside));
}
