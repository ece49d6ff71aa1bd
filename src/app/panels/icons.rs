//! Small drawn icons: crisp at every scale, and no font need have them.

use egui::{Color32, Painter, Pos2, Rect, Response, Sense, Shape, Stroke, Ui, Vec2};

/// An icon.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Icon {
    Menu,
    Undo,
    Redo,
    Help,
    Play,
    Pause,
    ToStart,
    More,
    Close,
}

/// A button with an icon.
pub(super) fn button(ui: &mut Ui, icon: Icon, enabled: bool, hint: &str) -> Response {
    let size = Vec2::new(28.0, 22.0);
    ui.add_enabled_ui(enabled, |ui| {
        let (rect, response) = ui.allocate_exact_size(size, Sense::click());
        let visuals = ui.style().interact(&response);
        let fill = if icon == Icon::Close { Color32::TRANSPARENT } else { visuals.weak_bg_fill };
        let color = if enabled { visuals.fg_stroke.color } else { ui.visuals().weak_text_color() };
        ui.painter().rect_filled(rect, visuals.corner_radius, fill);
        draw(ui.painter(), icon, rect.center(), color);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, enabled, hint));
        response
    })
    .inner
    .on_hover_text(hint)
}

/// Draws an icon about 12 points high around `center`.
fn draw(painter: &Painter, icon: Icon, center: Pos2, color: Color32) {
    let stroke = Stroke::new(1.5, color);
    let at = |x: f32, y: f32| center + Vec2::new(x, y);
    let line = |a: Pos2, b: Pos2| painter.line_segment([a, b], stroke);
    let filled = |points: Vec<Pos2>| {
        painter.add(Shape::convex_polygon(points, color, Stroke::NONE));
    };
    match icon {
        Icon::Menu => {
            for y in [-4.0, 0.0, 4.0] {
                line(at(-6.0, y), at(6.0, y));
            }
        }
        Icon::Undo => turn(painter, center, stroke, -1.0),
        Icon::Redo => turn(painter, center, stroke, 1.0),
        Icon::Help => {
            let font = egui::FontId::proportional(14.0);
            painter.text(center, egui::Align2::CENTER_CENTER, "?", font, color);
        }
        Icon::Play => filled(vec![at(-4.0, -6.0), at(6.0, 0.0), at(-4.0, 6.0)]),
        Icon::Pause => {
            for x in [-3.5, 3.5] {
                painter.rect_filled(Rect::from_center_size(at(x, 0.0), Vec2::new(3.0, 11.0)), 1.0, color);
            }
        }
        Icon::ToStart => {
            painter.rect_filled(Rect::from_center_size(at(-5.0, 0.0), Vec2::new(2.0, 10.0)), 0.5, color);
            filled(vec![at(5.0, -5.0), at(5.0, 5.0), at(-3.0, 0.0)]);
        }
        Icon::More => {
            line(at(-4.0, -2.0), at(0.0, 2.5));
            line(at(0.0, 2.5), at(4.0, -2.0));
        }
        Icon::Close => {
            line(at(-4.0, -4.0), at(4.0, 4.0));
            line(at(-4.0, 4.0), at(4.0, -4.0));
        }
    }
}

/// An arc with an arrow's head: back for −1, forth for +1.
fn turn(painter: &Painter, center: Pos2, stroke: Stroke, way: f32) {
    let arc = |i: u8| {
        let angle = std::f32::consts::PI * (1.05 - 1.2 * f32::from(i) / 12.0);
        center + Vec2::new(angle.cos() * 5.5 * -way, 2.0 - angle.sin() * 5.5)
    };
    let points: Vec<Pos2> = (0..=12).rev().map(arc).collect();
    let tip = points[points.len() - 1];
    painter.add(Shape::line(points, stroke));
    let head = [Vec2::new(-4.0 * way, -1.0), Vec2::new(1.5 * way, -4.5)];
    for end in head {
        painter.line_segment([tip, tip + Vec2::new(-end.x, end.y)], stroke);
    }
}
