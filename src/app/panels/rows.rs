//! The rows that all sections are made of: a label, then a control that fills the rest.

use crate::scene::words::Words;
use egui::{ComboBox, DragValue, Response, RichText, Slider, Ui};
use glam::Vec3;
use std::ops::RangeInclusive;

/// Width of the labels, points.
const LABEL: f32 = 96.0;
/// Width left for a slider's number, points.
const NUMBER: f32 = 66.0;

/// A label and what stands beside it.
pub(super) fn row<R>(ui: &mut Ui, label: &str, hint: &str, content: impl FnOnce(&mut Ui) -> R) -> R {
    ui.horizontal(|ui| {
        let size = egui::vec2(LABEL, ui.spacing().interact_size.y);
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        let label = ui.allocate_ui_with_layout(size, layout, |ui| {
            ui.set_min_width(LABEL);
            ui.add(egui::Label::new(RichText::new(label).weak()).truncate())
        });
        if !hint.is_empty() {
            label.inner.on_hover_text(hint);
        }
        content(ui)
    })
    .inner
}

/// A slider over a range.
pub(super) fn slider(ui: &mut Ui, label: &str, hint: &str, value: &mut f32, range: RangeInclusive<f32>) -> Response {
    row(ui, label, hint, |ui| {
        fit_slider(ui);
        ui.add(plain(value, range).max_decimals(3))
    })
}

/// A slider of degrees.
pub(super) fn angle(ui: &mut Ui, label: &str, hint: &str, value: &mut f32, range: RangeInclusive<f32>) -> Response {
    row(ui, label, hint, |ui| {
        fit_slider(ui);
        ui.add(plain(value, range).max_decimals(1).suffix("°"))
    })
}

/// A slider whose steps grow with the value.
pub(super) fn log_slider(
    ui: &mut Ui,
    label: &str,
    hint: &str,
    value: &mut f32,
    range: RangeInclusive<f32>,
) -> Response {
    row(ui, label, hint, |ui| {
        fit_slider(ui);
        ui.add(plain(value, range).logarithmic(true).max_decimals(3))
    })
}

/// A slider of whole numbers.
pub(super) fn whole_slider(
    ui: &mut Ui,
    label: &str,
    hint: &str,
    value: &mut u32,
    range: RangeInclusive<u32>,
) -> Response {
    row(ui, label, hint, |ui| {
        fit_slider(ui);
        ui.add(plain(value, range))
    })
}

/// A linear colour.
pub(super) fn color(ui: &mut Ui, label: &str, hint: &str, value: &mut Vec3) -> Response {
    row(ui, label, hint, |ui| {
        let mut rgb = value.to_array();
        let response = ui.color_edit_button_rgb(&mut rgb);
        if response.changed() {
            *value = Vec3::from_array(rgb);
        }
        response
    })
}

/// A tick.
pub(super) fn tick(ui: &mut Ui, label: &str, hint: &str, value: &mut bool) -> Response {
    row(ui, label, hint, |ui| ui.checkbox(value, ""))
}

/// Three numbers.
pub(super) fn vector(ui: &mut Ui, label: &str, hint: &str, value: &mut Vec3, speed: f64, suffix: &str) -> bool {
    row(ui, label, hint, |ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let width = (ui.available_width() - 8.0) / 3.0;
        let mut changed = false;
        for part in [&mut value.x, &mut value.y, &mut value.z] {
            let drag = DragValue::new(part).speed(speed).max_decimals(3).suffix(suffix);
            changed |= ui.add_sized([width, ui.spacing().interact_size.y], drag).changed();
        }
        changed
    })
}

/// A menu of a choice's words, with a line about each.
pub(super) fn choice<T: Words>(ui: &mut Ui, label: &str, hint: &str, value: &mut T) -> bool {
    choice_of(ui, label, hint, value, |_| true)
}

/// As [`choice`], with those words alone whose variants `offered` is true for.
pub(super) fn choice_of<T: Words>(
    ui: &mut Ui,
    label: &str,
    hint: &str,
    value: &mut T,
    offered: impl Fn(&T) -> bool,
) -> bool {
    let before = *value;
    row(ui, label, hint, |ui| {
        let menu = ComboBox::from_id_salt(label).selected_text(value.word()).width(ui.available_width());
        menu.show_ui(ui, |ui| {
            for (variant, word, about) in T::WORDS.iter().filter(|(variant, ..)| offered(variant)) {
                ui.selectable_value(value, *variant, *word).on_hover_text(*about);
            }
        });
    });
    *value != before
}

/// A menu of names.
pub(super) fn name_choice<'a>(
    ui: &mut Ui,
    label: &str,
    hint: &str,
    chosen: &str,
    names: impl Iterator<Item = (&'a str, &'a str)>,
) -> Option<String> {
    row(ui, label, hint, |ui| {
        let mut picked = None;
        let menu = ComboBox::from_id_salt(label).selected_text(chosen).width(ui.available_width());
        menu.show_ui(ui, |ui| {
            for (name, about) in names {
                let line = ui.selectable_label(name == chosen, name);
                let line = if about.is_empty() { line } else { line.on_hover_text(about) };
                if line.clicked() {
                    picked = Some(name.to_owned());
                }
            }
        });
        picked
    })
}

/// A line of quiet text.
pub(super) fn quiet(ui: &mut Ui, text: impl Into<String>) {
    ui.label(RichText::new(text.into()).weak().small());
}

/// A slider that rounds and clamps what the user sets, and nothing else: showing a value is no edit.
pub(super) fn plain<Num: egui::emath::Numeric>(value: &mut Num, range: RangeInclusive<Num>) -> Slider<'_> {
    Slider::new(value, range).clamping(egui::SliderClamping::Edits)
}

fn fit_slider(ui: &mut Ui) {
    ui.spacing_mut().slider_width = (ui.available_width() - NUMBER - ui.spacing().item_spacing.x).max(40.0);
}
