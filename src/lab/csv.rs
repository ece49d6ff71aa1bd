//! The report as one table of comma-separated values: a line a way at a station, then a line a point of the sweep.

use super::{Outcome, Report, Row, Series};
use crate::scene::words::Words as _;
use crate::voxelize::Promise;
use std::fmt::Write as _;

const HEAD: &str = "model,triangles,series,angle_deg,cells_x,cells_y,cells_z,method,promise,conservative,in_depth,\
    cutoff_cells2,ms_min,ms_median,ms_max,rounds,found,missing,spurious,differing_ties,solid_found,solid_missing,solid_spurious,bytes,left_out\n";

/// The whole table.
#[must_use]
pub fn csv(report: &Report) -> String {
    let mut text = HEAD.to_owned();
    for row in &report.rows {
        text.push_str(&line(report, row));
    }
    for point in &report.sweep.1 {
        let (body, n, ms) = (&report.bodies[point.subject], report.sweep.0, point.ms);
        let cutoff = point.cutoff_cells2.map_or("auto".to_owned(), |cells2| cells2.to_string());
        let (name, triangles) = (field(&body.name), body.triangles);
        // Writing to a string can't fail.
        let _ = write!(text, "{name},{triangles},cutoff,0,{n},{n},{n},hybrid,exact,none,false,{cutoff},");
        let _ = writeln!(text, "{:.4},{:.4},{:.4},,,,,,,,,,", ms.min, ms.median, ms.max);
    }
    text
}

fn line(report: &Report, row: &Row) -> String {
    let (body, way, cells) = (&report.bodies[row.subject], &row.way, row.station.cells);
    let series = match row.station.series {
        Series::Grid => "grid",
        Series::Angle(..) => "angle",
        Series::Aspect => "aspect",
    };
    let promise = match way.method.promise {
        Promise::Exact => "exact",
        Promise::Approximate => "approximate",
    };
    let outcome = match &row.outcome {
        Outcome::Measured(f) => {
            let bytes = f.bytes.map_or(String::new(), |bytes| bytes.to_string());
            let of = f.faults;
            let solid = f.solid.map_or(",,".to_owned(), |s| format!("{},{},{}", s.found, s.missing, s.spurious));
            format!(
                "{:.4},{:.4},{:.4},{},{},{},{},{},{solid},{bytes},",
                f.ms.min, f.ms.median, f.ms.max, f.rounds, of.found, of.missing, of.spurious, of.ties
            )
        }
        Outcome::LeftOut(why) => format!(",,,,,,,,,,,,{}", field(why)),
    };
    format!(
        "{},{},{series},{:.1},{},{},{},{},{promise},{},{},,{outcome}\n",
        field(&body.name),
        body.triangles,
        row.station.angle_deg(),
        cells.x,
        cells.y,
        cells.z,
        way.method.name,
        way.conservative.word(),
        way.in_depth
    )
}

/// A value that may hold commas or quotes.
fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}
