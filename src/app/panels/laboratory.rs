//! Two methods side by side, and both against the truth.

use super::Stage;
use super::rows::{name_choice, quiet, slider, tick};
use crate::app::laboratory::Held;
use crate::app::theme;
use crate::app::view::Mode;
use crate::voxelize::METHODS;
use egui::{Align2, Color32, CursorIcon, FontId, Grid, Rect, Response, RichText, Ui, pos2, vec2};

/// What the menu calls the absence of a second method.
const NOTHING: &str = "none";
/// Within so many points the pointer takes hold of the wipe.
const REACH: f32 = 9.0;
/// The wipe leaves so much of either side.
const LEAST: f32 = 0.02;
/// As cubes and slices show voxels that are missing and spurious.
const MISSING: Color32 = Color32::from_rgb(237, 51, 41);
const SPURIOUS: Color32 = Color32::from_rgb(86, 140, 255);

/// The section.
pub(super) fn show(ui: &mut Ui, stage: &mut Stage<'_>) {
    let current = stage.session.held().cloned();
    let laboratory = &mut stage.session.laboratory;
    let names =
        std::iter::once((NOTHING, "the scene's own method alone")).chain(METHODS.iter().map(|m| (m.name, m.summary)));
    let chosen = laboratory.beside.clone().unwrap_or_else(|| NOTHING.to_owned());
    if let Some(name) = name_choice(ui, "Beside it", "a second method, at the right of the wipe", &chosen, names) {
        laboratory.beside = (name != NOTHING).then_some(name);
    }
    if laboratory.beside.is_some() {
        slider(ui, "Wipe", "or drag the line in the picture", &mut laboratory.wipe, LEAST..=1.0 - LEAST);
    }
    let hint = "counts the voxels that are missing and spurious, and shows them in the views Voxels and Slice";
    tick(ui, "Hold to truth", hint, &mut laboratory.holds);
    if !laboratory.holds {
        return;
    }
    match current {
        Some(held) => table(ui, &held),
        None if stage.session.timeline.is_running() => quiet(ui, "Pause: the truth takes longer than a frame."),
        None => quiet(ui, "Working out the truth of this frame…"),
    }
    if !matches!(stage.session.view.mode, Mode::Cubes | Mode::Slice) {
        quiet(ui, "Voxels (2) and Slice (3) show where they differ.");
    }
}

fn table(ui: &mut Ui, held: &Held) {
    Grid::new("held").num_columns(5).spacing([8.0, 3.0]).show(ui, |ui| {
        for (title, color) in
            [("", None), ("ms", None), ("found", None), ("missing", Some(MISSING)), ("spurious", Some(SPURIOUS))]
        {
            let text = RichText::new(title).small();
            ui.label(color.map_or_else(|| text.clone().weak(), |color| text.clone().color(color)));
        }
        ui.end_row();
        for line in &held.lines {
            ui.label(RichText::new(&line.method).small());
            ui.label(RichText::new(format!("{:.2}", line.ms)).monospace());
            for n in [line.faults.found, line.faults.missing, line.faults.spurious] {
                ui.label(RichText::new(n.to_string()).monospace());
            }
            ui.end_row();
        }
    });
}

/// The wipe over the picture: its line, the methods' names; true while the pointer holds it.
pub(super) fn wipe(ui: &Ui, stage: &mut Stage<'_>, place: Rect, picture: &Response) -> bool {
    let own = stage.session.scene.voxelizer.method.clone();
    let laboratory = &mut stage.session.laboratory;
    let Some(beside) = &laboratory.beside else { return false };
    let id = ui.scope_id().with("wipe");
    let x = place.left() + laboratory.wipe * place.width();
    let is_near = |at: egui::Pos2| (at.x - x).abs() <= REACH;
    if picture.drag_started() {
        let holds = ui.input(|i| i.pointer.press_origin()).is_some_and(is_near);
        ui.data_mut(|data| data.insert_temp(id, holds));
    }
    let holds = picture.dragged() && ui.data(|data| data.get_temp(id)).unwrap_or(false);
    if holds && let Some(at) = picture.interact_pointer_pos() {
        laboratory.wipe = ((at.x - place.left()) / place.width()).clamp(LEAST, 1.0 - LEAST);
    }
    if holds || picture.hover_pos().is_some_and(is_near) {
        ui.set_cursor_icon(CursorIcon::ResizeHorizontal);
    }
    let painter = ui.painter();
    let shadow = egui::Stroke::new(3.0, Color32::from_black_alpha(90));
    painter.vline(x, place.y_range(), shadow);
    painter.vline(x, place.y_range(), egui::Stroke::new(1.2, Color32::WHITE));
    painter.circle(pos2(x, place.center().y), 7.0, Color32::WHITE, shadow);
    painter.circle_filled(pos2(x, place.center().y), 4.0, theme::ACCENT);
    for (name, align, side) in [(own.as_str(), Align2::RIGHT_TOP, -1.0), (beside.as_str(), Align2::LEFT_TOP, 1.0)] {
        let at = pos2(x, place.top()) + vec2(side * 12.0, 10.0);
        let font = FontId::proportional(13.0);
        painter.text(at + vec2(1.0, 1.0), align, name, font.clone(), Color32::from_black_alpha(160));
        painter.text(at, align, name, font, Color32::WHITE);
    }
    holds
}
