//! How the grids are marked and filled.

use super::Stage;
use super::rows::{choice, choice_of, log_slider, name_choice, quiet, row, slider};
use crate::frame::Frame;
use crate::scene::description::{Conservative, Separability};
use crate::voxelize::{METHODS, Promise, method};
use egui::Ui;

/// Where the slider starts when the device's own cut-off is let go.
const DEFAULT_CUTOFF_CELLS2: f32 = 4.0;

/// Method and its options.
pub(super) fn show(ui: &mut Ui, stage: &mut Stage<'_>) {
    let cutoff = stage.frame.and_then(Frame::cutoff);
    let settings = &mut stage.session.scene.voxelizer;
    let names = METHODS.iter().map(|m| (m.name, m.summary));
    if let Some(name) = name_choice(ui, "Method", "how triangles mark voxels", &settings.method, names) {
        settings.method = name;
        if method(&settings.method).is_ok_and(|m| !m.conservative.contains(&settings.conservative)) {
            settings.conservative = Conservative::None;
        }
    }
    if let Ok(method) = method(&settings.method) {
        let promise = match method.promise {
            Promise::Exact => "exact",
            Promise::Approximate => "approximate",
        };
        quiet(ui, format!("{} · {promise} · {}", method.summary, method.paper.short));
        if !method.conservative.is_empty() {
            let hint = "which columns a triangle reaches";
            let takes = |way: &Conservative| *way == Conservative::None || method.conservative.contains(way);
            choice_of(ui, "Conservative", hint, &mut settings.conservative, takes);
            let hint = "every slice that a triangle's plane reaches over a column";
            row(ui, "", hint, |ui| ui.checkbox(&mut settings.conservative_depth, "in depth too").on_hover_text(hint));
        }
    }
    row(ui, "Separability", "26: every voxel that the surface touches; 6: thin", |ui| {
        ui.selectable_value(&mut settings.separability, Separability::TwentySix, "26");
        ui.selectable_value(&mut settings.separability, Separability::Six, "6");
    });
    match settings.method.as_str() {
        "slice-amplified" => {
            let hint = "fraction of a voxel by which slices overlap";
            slider(ui, "Slice overlap", hint, &mut settings.slice_overlap, 0.0..=1.0);
        }
        "exact-columns" => {
            choice(ui, "Loop", "how a column's cells are walked", &mut settings.column_loop);
        }
        "three-axis" => {
            let hint = "how sheet buffers take bits";
            choice(ui, "Blending", hint, &mut settings.three_axis_blending);
        }
        "hybrid" => {
            let hint = "triangles that cover more voxels² than this go to fragments";
            row(ui, "Cut-off", hint, |ui| {
                let mut auto = settings.cutoff_cells2.is_none();
                if ui.checkbox(&mut auto, "auto").changed() {
                    settings.cutoff_cells2 = (!auto).then_some(DEFAULT_CUTOFF_CELLS2);
                }
            });
            if let Some(cutoff_cells2) = &mut settings.cutoff_cells2 {
                log_slider(ui, "", hint, cutoff_cells2, 0.1..=10_000.0);
            }
            if let Some(cutoff) = cutoff {
                quiet(ui, cutoff.to_string());
            }
            choice(ui, "Size", "what is compared with the cut-off", &mut settings.size_measure);
            choice(ui, "Classify", "when triangles are told apart", &mut settings.classify);
        }
        _ => {}
    }
    choice(ui, "Fill", "how the interior is made", &mut settings.fill);
}
