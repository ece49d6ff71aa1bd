//! What is drawn around the picture: sections at the right, time below, notices and help above it.

mod effect;
mod grid;
mod help;
mod icons;
mod laboratory;
mod leaving;
mod lights;
mod materials;
mod notices;
mod rows;
mod scene;
mod stats;
mod timeline;
mod view;
mod voxelizer;

use super::actions::ActionId;
use super::pictures::Measured;
use super::session::Session;
use super::theme;
use crate::frame::Frame;
use egui::{CentralPanel, CollapsingHeader, Panel, PointerButton, Rect, RichText, ScrollArea, Sense, Ui};
use std::path::PathBuf;

/// Width of the sections at first, points.
const WIDTH: f32 = 316.0;
/// Left free at the right of the sections, so that the scroll bar covers nothing, points.
const SCROLL_BAR: f32 = 10.0;
/// Turning by dragging across the height of the picture, radians.
const ORBIT_RAD: f32 = std::f32::consts::PI;
/// Distance to the target after scrolling by one point.
const ZOOM_PER_POINT: f32 = 0.998;

/// What of the interface is open.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chrome {
    /// The sections and the time bar.
    pub panels: bool,
    /// Every section starts unfolded, not just those that are needed most.
    pub unfolded: bool,
    /// The help.
    pub help: bool,
    /// Text of the field that "Save as" writes to.
    pub save_as: String,
    /// A file is held over the window.
    pub dropping: bool,
    /// What is being read, if anything.
    pub loading: Option<String>,
    /// What waits until it is known what becomes of unsaved edits.
    pub leaving: Option<Leaving>,
}

/// What would lose unsaved edits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Leaving {
    /// Closing the window.
    Close,
    /// Opening another file.
    Open(PathBuf),
}

impl Leaving {
    /// As the question names it.
    #[must_use]
    pub fn words(&self) -> String {
        match self {
            Self::Close => "closing the window".to_owned(),
            Self::Open(path) => {
                let name = path.file_name().map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into());
                format!("opening {name}")
            }
        }
    }
}

impl Default for Chrome {
    fn default() -> Self {
        Self {
            panels: true,
            unfolded: false,
            help: false,
            save_as: String::new(),
            dropping: false,
            loading: None,
            leaving: None,
        }
    }
}

/// What a panel asks the shell to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Command {
    /// An action of the table.
    Act(ActionId),
    /// Opens a file.
    Open(PathBuf),
    /// Writes the scene there.
    SaveAs(PathBuf),
    /// Times every stage once.
    Measure,
    /// Saves the scene, then does what [`Chrome::leaving`] says.
    SaveAndLeave,
    /// Does what [`Chrome::leaving`] says; unsaved edits are lost.
    Leave,
    /// Does not do it.
    Stay,
}

/// What the panels are made from.
#[derive(Debug)]
pub struct Stage<'a> {
    /// The scene and its state: read and changed.
    pub session: &'a mut Session,
    /// What is open.
    pub chrome: &'a mut Chrome,
    /// The last frame's figures.
    pub measured: &'a Measured,
    /// The frame, for its counts.
    pub frame: Option<&'a Frame>,
    /// The adapter's name and driver.
    pub adapter: &'a str,
    /// Filled: what is to be done.
    pub commands: Vec<Command>,
}

/// Draws everything; returns the picture's place in points, and whether the stage times are on view.
pub fn show(ui: &mut Ui, stage: &mut Stage<'_>) -> (Rect, bool) {
    let mut times_on_view = false;
    if stage.chrome.panels {
        Panel::right("sections").default_size(WIDTH).size_range(260.0..=520.0).show(ui, |ui| {
            times_on_view = sections(ui, stage);
        });
        if stage.session.timeline.moves() {
            Panel::bottom("time").resizable(false).show(ui, |ui| timeline::show(ui, stage));
        }
    }
    let place = CentralPanel::no_frame().show(ui, |ui| picture(ui, stage)).inner;
    notices::show(ui, stage, place);
    if stage.chrome.help {
        help::show(ui, stage, place);
    }
    leaving::show(ui, stage);
    if stage.chrome.dropping {
        let painter = ui.ctx().layer_painter(egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("drop")));
        painter.rect_filled(place, 0.0, egui::Color32::from_black_alpha(150));
        let font = egui::FontId::proportional(20.0);
        painter.text(place.center(), egui::Align2::CENTER_CENTER, "Drop to open", font, theme::ACCENT);
    }
    (place, times_on_view)
}

/// The sections at the right; true while the stage times are on view.
fn sections(ui: &mut Ui, stage: &mut Stage<'_>) -> bool {
    ui.add_space(6.0);
    scene::header(ui, stage);
    ui.add_space(4.0);
    let mut times_on_view = false;
    let all = stage.chrome.unfolded;
    ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
        ui.set_max_width(ui.available_width() - SCROLL_BAR);
        section(ui, "Scene", true, |ui| scene::show(ui, stage));
        section(ui, "Materials", true, |ui| materials::show(ui, stage.session));
        section(ui, "View", true, |ui| view::show(ui, stage));
        section(ui, "Effect", all, |ui| effect::show(ui, stage.session));
        section(ui, "Voxelizer", all, |ui| voxelizer::show(ui, stage));
        section(ui, "Laboratory", all, |ui| laboratory::show(ui, stage));
        section(ui, "Grids", all, |ui| grid::show(ui, stage));
        section(ui, "Lights", all, |ui| lights::show(ui, &mut stage.session.scene));
        times_on_view = section(ui, "Times and memory", all, |ui| stats::show(ui, stage));
        ui.add_space(12.0);
    });
    times_on_view
}

/// A section with a title that folds; true while it is open.
fn section(ui: &mut Ui, title: &str, open: bool, content: impl FnOnce(&mut Ui)) -> bool {
    let header = CollapsingHeader::new(RichText::new(title).heading()).default_open(open);
    let response = header.show(ui, content);
    ui.add_space(4.0);
    ui.separator();
    response.body_returned.is_some()
}

/// The camera's controls on the picture, which the painter draws; returns its place.
fn picture(ui: &mut Ui, stage: &mut Stage<'_>) -> Rect {
    let place = ui.available_rect_before_wrap();
    let response = ui.allocate_rect(place, Sense::click_and_drag());
    if let Some(name) = &stage.chrome.loading {
        let at = place.left_bottom() + egui::vec2(14.0, -12.0);
        let font = egui::FontId::proportional(13.0);
        let text = format!("Loading {name}…");
        ui.painter().text(at, egui::Align2::LEFT_BOTTOM, text, font, theme::ACCENT);
    }
    if !stage.session.is_open || place.height() < 1.0 {
        return place;
    }
    if response.drag_started() || response.clicked() {
        ui.ctx().memory_mut(|m| {
            if let Some(focused) = m.focused() {
                m.surrender_focus(focused);
            }
        });
    }
    let wiping = laboratory::wipe(ui, stage, place, &response);
    let camera = &mut stage.session.scene.camera;
    let by = response.drag_delta() / place.height();
    let shift = ui.input(|i| i.modifiers.shift);
    if wiping {
        // The drag is the wipe's.
    } else if response.dragged_by(PointerButton::Middle) || (response.dragged_by(PointerButton::Primary) && shift) {
        super::orbit::pan(camera, glam::Vec2::new(by.x, by.y));
    } else if response.dragged_by(PointerButton::Primary) && by != egui::Vec2::ZERO {
        super::orbit::orbit(camera, -by.x * ORBIT_RAD, by.y * ORBIT_RAD);
    }
    if response.contains_pointer() {
        // Shift turns a wheel sideways on some systems; zooming means the same either way.
        let (scroll, pinch) = ui.input(|i| (i.smooth_scroll_delta(), i.zoom_delta()));
        let factor = ZOOM_PER_POINT.powf(scroll.x + scroll.y) / pinch;
        #[expect(clippy::float_cmp, reason = "exactly one means: no wheel")]
        if factor != 1.0 {
            super::orbit::zoom(camera, factor);
        }
    }
    place
}
