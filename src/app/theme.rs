//! The look of the panels: calm and dark, so that the glass is the brightest thing in the window.

use egui::{Color32, CornerRadius, FontFamily, FontId, Margin, Shadow, Stroke, TextStyle, Theme, Visuals};

/// The one warm colour: what is chosen, what plays, what is held.
pub const ACCENT: Color32 = Color32::from_rgb(222, 160, 92);
/// Of the panels: what the window is cleared to, so that egui need not fill it.
pub const PANEL: Color32 = Color32::from_rgb(24, 25, 28);
/// Of cards and pop-ups, a little above the panels.
const RAISED: Color32 = Color32::from_rgb(32, 34, 38);
/// Body text.
const TEXT: Color32 = Color32::from_rgb(196, 198, 202);
/// Labels and units.
const QUIET: Color32 = Color32::from_rgb(140, 144, 150);
/// What went wrong.
pub const ERROR: Color32 = Color32::from_rgb(232, 112, 98);
/// What is odd.
pub const WARNING: Color32 = Color32::from_rgb(226, 182, 96);
/// What went well.
pub const DONE: Color32 = Color32::from_rgb(134, 190, 146);

/// Applies the look.
pub fn apply(ctx: &egui::Context) {
    ctx.set_theme(Theme::Dark);
    ctx.set_visuals_of(Theme::Dark, visuals());
    ctx.style_mut_of(Theme::Dark, |style| {
        let size = |size: f32| FontId::new(size, FontFamily::Proportional);
        style.text_styles.insert(TextStyle::Heading, size(15.0));
        style.text_styles.insert(TextStyle::Body, size(13.0));
        style.text_styles.insert(TextStyle::Button, size(13.0));
        style.text_styles.insert(TextStyle::Small, size(11.0));
        style.text_styles.insert(TextStyle::Monospace, FontId::new(12.0, FontFamily::Monospace));
        style.spacing.item_spacing = egui::vec2(8.0, 6.0);
        style.spacing.button_padding = egui::vec2(8.0, 3.0);
        style.spacing.interact_size = egui::vec2(36.0, 20.0);
        style.spacing.slider_width = 120.0;
        style.spacing.slider_rail_height = 4.0;
        style.spacing.combo_width = 150.0;
        style.spacing.indent = 12.0;
        style.spacing.tooltip_width = 320.0;
        style.spacing.window_margin = Margin::same(14);
        style.interaction.selectable_labels = false;
        style.animation_time = 0.08;
    });
    ctx.options_mut(|o| o.zoom_with_keyboard = false); // the action table has these keys
}

fn visuals() -> Visuals {
    let mut v = Visuals::dark();
    v.panel_fill = Color32::TRANSPARENT;
    v.window_fill = RAISED;
    v.window_stroke = Stroke::new(1.0, Color32::from_rgb(52, 54, 60));
    v.window_corner_radius = CornerRadius::same(8);
    v.window_shadow = Shadow { offset: [0, 6], blur: 24, spread: 0, color: Color32::from_black_alpha(120) };
    v.popup_shadow = v.window_shadow;
    v.extreme_bg_color = Color32::from_rgb(17, 18, 20);
    v.faint_bg_color = Color32::from_rgb(29, 31, 34);
    v.hyperlink_color = ACCENT;
    v.warn_fg_color = WARNING;
    v.error_fg_color = ERROR;
    v.weak_text_color = Some(QUIET);
    v.selection.bg_fill = Color32::from_rgb(104, 76, 46);
    v.selection.stroke = Stroke::new(1.0, Color32::from_rgb(250, 232, 208));
    v.slider_trailing_fill = true;
    v.handle_shape = egui::style::HandleShape::Circle;
    v.indent_has_left_vline = false;
    v.collapsing_header_frame = false;
    let radius = CornerRadius::same(5);
    let widgets = &mut v.widgets;
    for widget in [
        &mut widgets.noninteractive,
        &mut widgets.inactive,
        &mut widgets.hovered,
        &mut widgets.active,
        &mut widgets.open,
    ] {
        widget.corner_radius = radius;
        widget.expansion = 0.0;
        widget.bg_stroke = Stroke::NONE;
    }
    widgets.noninteractive.bg_stroke = Stroke::new(1.0, Color32::from_rgb(42, 44, 49));
    widgets.noninteractive.fg_stroke = Stroke::new(1.0, TEXT);
    widgets.inactive.weak_bg_fill = Color32::from_rgb(43, 45, 50);
    widgets.inactive.bg_fill = Color32::from_rgb(50, 53, 58);
    widgets.inactive.fg_stroke = Stroke::new(1.0, TEXT);
    widgets.hovered.weak_bg_fill = Color32::from_rgb(54, 57, 63);
    widgets.hovered.bg_fill = Color32::from_rgb(62, 65, 71);
    widgets.hovered.fg_stroke = Stroke::new(1.0, Color32::from_rgb(236, 237, 239));
    widgets.active.weak_bg_fill = Color32::from_rgb(62, 65, 71);
    widgets.active.bg_fill = Color32::from_rgb(72, 75, 82);
    widgets.active.fg_stroke = Stroke::new(1.0, Color32::WHITE);
    widgets.open.weak_bg_fill = Color32::from_rgb(50, 53, 58);
    widgets.open.bg_fill = Color32::from_rgb(43, 45, 50);
    widgets.open.fg_stroke = Stroke::new(1.0, TEXT);
    v
}
