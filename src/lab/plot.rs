//! Which lines stand in which plot: the figures of TR's chapter 3, of CL §4 and of RB's Figs. 13 and 14.

use super::svg::{Line, Plot};
use super::{Figures, Outcome, Report, Row, Series, Way};
use crate::voxelize::METHODS;

/// Told apart without full colour vision as far as a dozen goes; one a method, in the order of the list.
const COLORS: [&str; 14] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#7a5195", "#8c6d1f", "#e2445c", "#2a9d9d", "#5b6b7a", "#a3501d",
    "#3b4cc0", "#6a994e", "#b23a8e", "#1b1b1b",
];

/// A measure and its name.
pub(super) type Measure = (&'static str, fn(&Figures) -> f64);

/// The measures that TR's chapter 3 draws, and the memory.
pub(super) const MEASURES: &[Measure] = &[
    ("time, ms", |f| f.ms.median),
    ("voxels found", |f| count(f.faults.found)),
    ("voxels missing", |f| count(f.faults.missing)),
    ("spurious voxels", |f| count(f.faults.spurious)),
    ("memory, MiB", |f| f.bytes.map_or(0.0, |bytes| count(bytes) / f64::from(1 << 20))),
];

#[expect(clippy::cast_precision_loss, reason = "drawn")]
fn count(n: u64) -> f64 {
    n as f64
}

pub(super) fn color(method: &str) -> &'static str {
    let index = METHODS.iter().position(|m| m.name == method).unwrap_or(0);
    COLORS[index % COLORS.len()]
}

fn figures(row: &Row) -> Option<&Figures> {
    match &row.outcome {
        Outcome::Measured(figures) => Some(figures),
        Outcome::LeftOut(_) => None,
    }
}

/// The ways that a plot of one body shows: each method's plain one and, dashed, that of its conservative ones that
/// misses least in the finest grid measured, the faster of two.
pub(super) fn shown(report: &Report, subject: usize) -> Vec<Way> {
    let of_body = |row: &&Row| row.subject == subject && row.station.series == Series::Grid;
    let mut ways: Vec<Way> = Vec::new();
    for method in METHODS {
        let of_method = report.rows.iter().filter(of_body).filter(|row| row.way.method.name == method.name);
        let (plain, bent): (Vec<&Row>, Vec<&Row>) = of_method.partition(|row| row.way.is_plain());
        ways.extend(plain.first().map(|row| row.way));
        let finest = bent.iter().filter(|row| figures(row).is_some()).map(|row| row.station.cells.x).max();
        let best = (bent.iter().filter(|row| Some(row.station.cells.x) == finest))
            .filter_map(|row| figures(row).map(|f| (f.faults.missing + f.faults.spurious, f.ms.median, row.way)))
            .min_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        ways.extend(best.map(|(.., way)| way));
    }
    ways
}

/// A measure of one body over the stations of a series.
pub(super) fn over(report: &Report, subject: usize, series: fn(Series) -> bool, measure: Measure) -> Plot {
    let rows: Vec<&Row> = report.rows.iter().filter(|r| r.subject == subject && series(r.station.series)).collect();
    let mut stations: Vec<_> = Vec::new();
    for row in &rows {
        if !stations.contains(&row.station) {
            stations.push(row.station);
        }
    }
    stations.sort_by(|a, b| place(*a).total_cmp(&place(*b)));
    let x_of = |row: &Row| place(row.station);
    let line = |way: &Way| Line {
        name: way.name(),
        color: color(way.method.name),
        dashed: !way.is_plain(),
        points: {
            let mut points: Vec<(f64, f64)> = rows
                .iter()
                .filter(|r| r.way.is(way))
                .filter_map(|r| Some((x_of(r), (measure.1)(figures(r)?))))
                .collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            points
        },
    };
    Plot {
        title: format!("{}: {}", report.bodies[subject].name, measure.0),
        x_label: match stations.first().map(|s| s.series) {
            Some(Series::Angle(..)) => "angle between the columns and the z axis",
            Some(Series::Aspect) => "cells along z for each along x",
            _ => "cells along each axis",
        },
        x_ticks: stations.iter().map(|s| (place(*s), tick(*s))).collect(),
        lines: shown(report, subject).iter().map(line).collect(),
    }
}

/// Of a station on the horizontal scale.
fn place(station: super::Station) -> f64 {
    let cells = station.cells;
    match station.series {
        Series::Grid => f64::from(cells.x).log2(),
        Series::Angle(..) => station.angle_deg(),
        Series::Aspect => (f64::from(cells.z) / f64::from(cells.x)).log2(),
    }
}

fn tick(station: super::Station) -> String {
    match station.series {
        Series::Grid => station.cells.x.to_string(),
        Series::Angle(..) => format!("{:.0}°", station.angle_deg()),
        Series::Aspect => station.name(),
    }
}

/// Time over hybrid's cut-off, a line a body.
pub(super) fn sweep(report: &Report) -> Plot {
    let x = |cells2: f32| f64::from(if cells2 > 0.0 { cells2.log2() } else { -1.0 });
    let mut x_ticks: Vec<(f64, String)> = vec![(-1.0, "0".to_owned())];
    x_ticks.extend((0..=14).step_by(2).map(|k| (f64::from(k), (1_u32 << k).to_string())));
    let of_body = |subject: usize| {
        let points = report.sweep.1.iter().filter(|p| p.subject == subject);
        let mut points: Vec<_> = points.filter_map(|p| Some((x(p.cutoff_cells2?), p.ms.median))).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    let lines = report.bodies.iter().enumerate().map(|(subject, body)| Line {
        name: body.name.clone(),
        color: COLORS[subject % COLORS.len()],
        dashed: false,
        points: of_body(subject),
    });
    Plot {
        title: format!("hybrid at {}³: time, ms, over its cut-off", report.sweep.0),
        x_label: "cut-off, projected cells²",
        x_ticks,
        lines: lines.collect(),
    }
}
