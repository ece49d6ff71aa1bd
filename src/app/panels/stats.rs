//! Where the time goes, and the memory.

use super::rows::quiet;
use super::{Command, Stage};
use egui::{Grid, RichText, Ui};

/// Times, resolution, counts, adapter.
pub(super) fn show(ui: &mut Ui, stage: &mut Stage<'_>) {
    let measured = stage.measured;
    Grid::new("times").num_columns(2).spacing([24.0, 3.0]).show(ui, |ui| {
        line(ui, "frame", &format!("{:.1} ms", measured.frame_ms));
        line(ui, "recording", &format!("{:.1} ms", measured.record_ms));
        line(ui, "marched at", &format!("{} × {}", measured.size.x, measured.size.y));
        line(ui, "shown at", &format!("{} × {}", measured.full.x, measured.full.y));
        for (stage, ms) in &measured.stages {
            line(ui, stage, &format!("{ms:.2} ms"));
        }
    });
    if measured.stages.is_empty() {
        quiet(ui, "This adapter's own stage times are not true, or not there.");
    }
    let hint = "runs every stage once, each on its own, and waits for it: true on every adapter";
    if ui.button("Time each stage").on_hover_text(hint).clicked() {
        stage.commands.push(Command::Measure);
    }
    quiet(ui, stage.adapter.to_owned());
}

fn line(ui: &mut Ui, label: &str, value: &str) {
    ui.label(RichText::new(label).weak());
    ui.label(RichText::new(value).monospace());
    ui.end_row();
}
