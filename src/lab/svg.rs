//! One plot: lines over a horizontal scale whose ticks are given, a logarithmic vertical one, names at the lines' ends.

use std::fmt::Write as _;

/// Size of a plot, and of the frame around its lines: left, right, top, bottom. SVG units.
const WIDTH: f64 = 580.0;
const HEIGHT: f64 = 320.0;
const LEFT: f64 = 58.0;
const RIGHT: f64 = 390.0;
const TOP: f64 = 34.0;
const BOTTOM: f64 = 276.0;
/// Least distance between two names, SVG units.
const NAME_STEP: f64 = 13.0;
/// What a line of 0 stands above the frame's foot.
const ZERO: f64 = 6.0;
/// The frame's share below the least power of ten, where zeros have their place.
const ZERO_ROOM: f64 = 22.0;

/// A line of a plot.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Line {
    /// Written at its end.
    pub(super) name: String,
    /// CSS colour.
    pub(super) color: &'static str,
    /// Drawn in dashes.
    pub(super) dashed: bool,
    /// By rising x; y ≥ 0.
    pub(super) points: Vec<(f64, f64)>,
}

/// A plot.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plot {
    /// Above it.
    pub(super) title: String,
    /// Below it.
    pub(super) x_label: &'static str,
    /// The horizontal scale's ticks, with their names.
    pub(super) x_ticks: Vec<(f64, String)>,
    /// Its lines; those without points are not drawn.
    pub(super) lines: Vec<Line>,
}

/// Vertical scale: powers of ten, and a place for 0 where there is one.
struct Scale {
    least_power: f64,
    powers: f64,
    foot: f64,
}

impl Scale {
    fn of(lines: &[Line]) -> Self {
        let values = || lines.iter().flat_map(|line| line.points.iter().map(|p| p.1));
        let positive = || values().filter(|y| *y > 0.0);
        let least = positive().fold(f64::INFINITY, f64::min);
        let most = positive().fold(0.0, f64::max);
        let (least, most) = if most > 0.0 { (least.log10().floor(), most.log10().ceil()) } else { (0.0, 1.0) };
        let has_zero = values().any(|y| y <= 0.0);
        let foot = if has_zero { BOTTOM - ZERO_ROOM } else { BOTTOM };
        Self { least_power: least, powers: (most - least).max(1.0), foot }
    }

    fn y(&self, value: f64) -> f64 {
        if value <= 0.0 {
            return BOTTOM - ZERO;
        }
        self.foot - (value.log10() - self.least_power) / self.powers * (self.foot - TOP)
    }
}

impl Plot {
    /// As an `<svg>` element.
    pub(super) fn svg(&self) -> String {
        let lines: Vec<Line> = self.lines.iter().filter(|line| !line.points.is_empty()).cloned().collect();
        let scale = Scale::of(&lines);
        let ends = self.x_ticks.iter().map(|t| t.0).chain(lines.iter().flat_map(|l| l.points.iter().map(|p| p.0)));
        let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        let span = if high > low { high - low } else { 1.0 };
        let x = |value: f64| LEFT + 14.0 + (value - low) / span * (RIGHT - LEFT - 28.0);

        let mut svg =
            format!("<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\">\n", escaped(&self.title));
        // Writing to a string can't fail.
        let _ = writeln!(svg, "<text class=\"title\" x=\"{LEFT}\" y=\"18\">{}</text>", escaped(&self.title));
        for (value, name) in y_ticks(&scale) {
            let y = scale.y(value);
            let _ = writeln!(svg, "<line class=\"rule\" x1=\"{LEFT}\" x2=\"{RIGHT}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>");
            let _ = writeln!(
                svg,
                "<text class=\"tick\" text-anchor=\"end\" x=\"{:.1}\" y=\"{:.1}\">{name}</text>",
                LEFT - 6.0,
                y + 4.0
            );
        }
        for (value, name) in &self.x_ticks {
            let x = x(*value);
            let _ = writeln!(
                svg,
                "<line class=\"mark\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{BOTTOM}\" y2=\"{:.1}\"/>",
                BOTTOM + 4.0
            );
            let _ = writeln!(
                svg,
                "<text class=\"tick\" text-anchor=\"middle\" x=\"{x:.1}\" y=\"{:.1}\">{}</text>",
                BOTTOM + 17.0,
                escaped(name)
            );
        }
        let _ = writeln!(svg, "<line class=\"axis\" x1=\"{LEFT}\" x2=\"{RIGHT}\" y1=\"{BOTTOM}\" y2=\"{BOTTOM}\"/>");
        let _ = writeln!(
            svg,
            "<text class=\"tick\" text-anchor=\"middle\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            (LEFT + RIGHT) * 0.5,
            BOTTOM + 35.0,
            self.x_label
        );
        let mut names: Vec<(f64, &Line)> = Vec::new();
        for line in &lines {
            let places: Vec<String> =
                line.points.iter().map(|p| format!("{:.1},{:.1}", x(p.0), scale.y(p.1))).collect();
            let dashes = if line.dashed { " stroke-dasharray=\"5 4\"" } else { "" };
            let _ = writeln!(
                svg,
                "<polyline class=\"line\" stroke=\"{}\"{dashes} points=\"{}\"/>",
                line.color,
                places.join(" ")
            );
            for (place, point) in places.iter().zip(&line.points) {
                let (cx, cy) = place.split_once(',').unwrap_or(("0", "0"));
                let hint = escaped(&format!("{}: {}", line.name, number(point.1)));
                let _ = writeln!(
                    svg,
                    "<circle fill=\"{}\" cx=\"{cx}\" cy=\"{cy}\" r=\"2.6\"><title>{hint}</title></circle>",
                    line.color
                );
            }
            let end = line.points[line.points.len() - 1];
            names.push((scale.y(end.1), line));
        }
        for (y, end_y, end_x, line) in apart(names, |line| x(line.points[line.points.len() - 1].0)) {
            let _ = writeln!(
                svg,
                "<line class=\"leader\" stroke=\"{}\" x1=\"{:.1}\" y1=\"{end_y:.1}\" x2=\"{:.1}\" y2=\"{y:.1}\"/>",
                line.color,
                end_x + 4.0,
                RIGHT + 4.0
            );
            let _ = writeln!(
                svg,
                "<text class=\"name\" fill=\"{}\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
                line.color,
                RIGHT + 8.0,
                y + 4.0,
                escaped(&line.name)
            );
        }
        svg.push_str("</svg>\n");
        svg
    }
}

/// Places of the names, none nearer to another than [`NAME_STEP`]: where each stands, and where its line ends.
fn apart(mut names: Vec<(f64, &Line)>, end_x: impl Fn(&Line) -> f64) -> Vec<(f64, f64, f64, &Line)> {
    names.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut places: Vec<f64> = Vec::new();
    for (y, _) in &names {
        let least = places.last().map_or(TOP - 8.0, |last| last + NAME_STEP);
        places.push(y.max(least));
    }
    // What went below the foot pushes the others up again.
    let mut most = HEIGHT - 8.0;
    for place in places.iter_mut().rev() {
        *place = place.min(most);
        most = *place - NAME_STEP;
    }
    names.iter().zip(places).map(|((end_y, line), y)| (y, *end_y, end_x(line), *line)).collect()
}

fn y_ticks(scale: &Scale) -> Vec<(f64, String)> {
    #[expect(clippy::cast_possible_truncation, reason = "few powers")]
    let powers = 0..=(scale.powers as i32);
    let mut ticks: Vec<_> =
        powers.map(|i| 10_f64.powf(scale.least_power + f64::from(i))).map(|v| (v, number(v))).collect();
    if scale.foot < BOTTOM {
        ticks.push((0.0, "0".to_owned()));
    }
    ticks
}

/// As people read it: `0.05`, `12.3`, `4,567`, `1.2 M`.
pub(super) fn number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        v if v >= 1e6 => format!("{} M", short(value / 1e6)),
        v if v >= 1e4 => format!("{} k", short(value / 1e3)),
        _ => short(value),
    }
}

/// Three digits that count, without zeros at the end.
fn short(value: f64) -> String {
    let digits = match value.abs() {
        v if v >= 100.0 => 0,
        v if v >= 10.0 => 1,
        v if v >= 1.0 => 2,
        v if v >= 0.01 => 3,
        _ => 5,
    };
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Text as HTML and SVG hold it.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
