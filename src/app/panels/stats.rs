//! Where the time goes, and the memory.

use super::rows::quiet;
use super::{Command, Stage};
use crate::volume::Volume;
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
    if let Some(frame) = stage.frame {
        counts(ui, frame.volume());
    }
    if measured.stages.is_empty() {
        quiet(ui, "This adapter's own stage times are not true, or not there.");
    }
    let hint = "runs every stage once, each on its own, and waits for it: true on every adapter";
    if ui.button("Time each stage").on_hover_text(hint).clicked() {
        stage.commands.push(Command::Measure);
    }
    quiet(ui, stage.adapter.to_owned());
}

/// What each grid holds, and the memory of all.
fn counts(ui: &mut Ui, volume: &Volume) {
    ui.add_space(4.0);
    Grid::new("grids").num_columns(4).spacing([14.0, 3.0]).show(ui, |ui| {
        for title in ["grid", "voxels", "occupied", "memory"] {
            ui.label(RichText::new(title).weak());
        }
        ui.end_row();
        for (index, grid) in volume.grids.iter().enumerate() {
            let cells = grid.cells;
            ui.label(RichText::new(if index == 0 { "view".to_owned() } else { index.to_string() }).weak());
            ui.label(RichText::new(format!("{}×{}×{}", cells.x, cells.y, cells.z)).monospace());
            let occupied = volume.counts().get(index).map_or(0, |c| c.occupied);
            ui.label(RichText::new(occupied.to_string()).monospace());
            ui.label(RichText::new(mebibytes(volume.grid_memory(index))).monospace());
            ui.end_row();
        }
    });
    let total: u64 = volume.memory().iter().map(|(_, bytes)| bytes).sum();
    let parts: Vec<String> =
        volume.memory().iter().map(|(name, bytes)| format!("{name}: {}", mebibytes(*bytes))).collect();
    let line = RichText::new(format!("all buffers of the volume: {}", mebibytes(total))).weak().small();
    ui.label(line).on_hover_text(parts.join("\n"));
}

#[expect(clippy::cast_precision_loss, reason = "shown with one decimal")]
fn mebibytes(bytes: u64) -> String {
    format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
}

fn line(ui: &mut Ui, label: &str, value: &str) {
    ui.label(RichText::new(label).weak());
    ui.label(RichText::new(value).monospace());
    ui.end_row();
}
