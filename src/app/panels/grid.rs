//! The view's grid and the lights'.

use super::Stage;
use super::rows::{choice, plain, quiet, row};
use crate::scene::description::{Align, CELLS, Cells, GridSettings};
use egui::{DragValue, RichText, Ui};
use glam::UVec3;

/// Both grids' settings.
pub(super) fn show(ui: &mut Ui, stage: &mut Stage<'_>) {
    let scene = &mut stage.session.scene;
    ui.label(RichText::new("View").strong());
    ui.push_id("view grid", |ui| settings(ui, &mut scene.grid, true));
    ui.add_space(4.0);
    ui.label(RichText::new("Lights").strong());
    ui.push_id("light grid", |ui| settings(ui, &mut scene.light_grid, false));
    for warning in stage.frame.map(crate::frame::Frame::warnings).unwrap_or_default() {
        quiet(ui, warning.clone());
    }
}

fn settings(ui: &mut Ui, grid: &mut GridSettings, of_view: bool) {
    let mut each = matches!(grid.cells, Cells::Each(_));
    row(ui, "Voxels", "cubes along the longest axis, or a count for each axis", |ui| {
        ui.selectable_value(&mut each, false, "longest axis");
        ui.selectable_value(&mut each, true, "each axis");
    });
    grid.cells = match (grid.cells, each) {
        (Cells::Longest(cells), true) => Cells::Each(UVec3::splat(cells)),
        (Cells::Each(cells), false) => Cells::Longest(cells.max_element()),
        (cells, _) => cells,
    };
    match &mut grid.cells {
        Cells::Longest(cells) => {
            row(ui, "", "", |ui| {
                ui.spacing_mut().slider_width = (ui.available_width() - 58.0).max(40.0);
                ui.add(plain(cells, CELLS))
            });
            row(ui, "", "", |ui| {
                ui.spacing_mut().item_spacing.x = 4.0;
                for preset in [64, 128, 256, 512] {
                    ui.selectable_value(cells, preset, preset.to_string());
                }
            });
        }
        Cells::Each(cells) => {
            row(ui, "", "", |ui| {
                for count in [&mut cells.x, &mut cells.y, &mut cells.z] {
                    ui.add(DragValue::new(count).range(CELLS).clamp_existing_to_range(false).speed(1.0));
                }
            });
        }
    }
    if of_view {
        choice(ui, "Align", "what the grid is turned to", &mut grid.align);
    } else {
        let mut to_light = grid.align == Align::Camera;
        row(ui, "Align", "what the grid is turned to", |ui| {
            ui.selectable_value(&mut to_light, true, "light");
            ui.selectable_value(&mut to_light, false, "world");
        });
        grid.align = if to_light { Align::Camera } else { Align::World };
    }
    choice(ui, "Projection", "of the grid's columns", &mut grid.projection);
}
