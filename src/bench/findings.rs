//! What the figures say, held against the project's targets.

use super::report::Row;
use serde::Serialize;

/// The stages' sum and the wall clock agree to this share.
const CLOCK_SHARE: f64 = 0.10;
/// Hybrid may be slower than the better of its halves by this share, or by this many milliseconds.
const HYBRID_SHARE: f64 = 0.15;
const HYBRID_MS: f64 = 0.5;
/// The most that a volume of 256³ around 70k triangles may take.
const MOST_MIB: f64 = 32.0;

/// A statement about the figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// What was found.
    pub text: String,
    /// Whether that meets the project's target.
    pub met: bool,
}

/// All statements that the rows allow.
#[must_use]
pub fn findings(rows: &[Row]) -> Vec<Finding> {
    let mut all = targets(rows);
    all.extend(clock(rows));
    all.extend(hybrid(rows));
    all.extend(growth(rows));
    all
}

fn targets(rows: &[Row]) -> Vec<Finding> {
    let of_row = |row: &Row| {
        let target = row.target_ms?;
        let ms = row.counted.median;
        let text = format!("{}: {ms:.1} ms of at most {target:.0}", row.name);
        Some(Finding { text, met: ms <= target })
    };
    rows.iter().filter_map(of_row).collect()
}

fn clock(rows: &[Row]) -> Option<Finding> {
    let share = |row: &Row| (row.sum.median / row.wall.median.max(1e-9) - 1.0).abs();
    let worst = rows.iter().map(|row| (share(row), &row.name)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    let text = format!("stages and the wall clock differ by at most {:.1}% ({})", worst.0 * 100.0, worst.1);
    Some(Finding { text, met: worst.0 <= CLOCK_SHARE })
}

/// One statement for each group in which hybrid took turns with its halves.
fn hybrid(rows: &[Row]) -> Vec<Finding> {
    let of_hybrid = |row: &Row| {
        let other = |method: &str| {
            let found = rows.iter().find(|other| other.group == row.group && other.method == method)?;
            Some(found.counted.median)
        };
        if row.method != "hybrid" {
            return None;
        }
        let better = other("triangle-parallel")?.min(other("fragment-parallel")?);
        let ms = row.counted.median;
        let text = format!("{}: {ms:.2} ms, the better of its halves {better:.2}", row.name);
        Some(Finding { text, met: ms <= better * (1.0 + HYBRID_SHARE) || ms <= better + HYBRID_MS })
    };
    rows.iter().filter_map(of_hybrid).collect()
}

/// Memory at 256³ and the growth of records from 128³.
fn growth(rows: &[Row]) -> Vec<Finding> {
    let grid = |cells: u32| rows.iter().find(|row| row.group == "one grid" && row.cells == cells);
    let mut all = Vec::new();
    if let Some(fine) = grid(256) {
        let mib = mib(fine.memory.iter().map(|(_, bytes)| bytes).sum());
        let text = format!("{}: {mib:.1} MiB of at most {MOST_MIB:.0}", fine.name);
        all.push(Finding { text, met: mib <= MOST_MIB });
        if let Some(coarse) = grid(128).filter(|coarse| coarse.records > 0) {
            let times = fine.records as f64 / coarse.records as f64;
            let text = format!(
                "records grow from {} at 128³ to {} at 256³: {times:.2} times (a surface: 4)",
                coarse.records, fine.records
            );
            all.push(Finding { text, met: (3.5..=4.5).contains(&times) });
        }
    }
    all
}

/// Bytes in MiB.
#[must_use]
pub(super) fn mib(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 20)
}

#[cfg(test)]
mod tests {
    use super::super::report::Spread;
    use super::*;

    fn row(group: &'static str, method: &str, ms: f64) -> Row {
        let spread = Spread::of(&[ms]);
        Row {
            name: format!("{group}, {method}"),
            group,
            method: method.to_owned(),
            cells: 128,
            target_ms: Some(10.0),
            stages: Vec::new(),
            counts: &[],
            counted: spread,
            sum: spread,
            wall: spread,
            memory: vec![("records", 40 << 20)],
            records: 1000,
        }
    }

    fn met(rows: &[Row], what: &str) -> Vec<bool> {
        findings(rows).iter().filter(|f| f.text.contains(what)).map(|f| f.met).collect()
    }

    #[test]
    fn hybrid_is_held_against_the_better_of_its_halves() {
        let rows = |hybrid: f64| {
            let halves = [row("a", "triangle-parallel", 4.0), row("a", "fragment-parallel", 9.0)];
            [&halves[..], &[row("a", "hybrid", hybrid)]].concat()
        };
        assert_eq!(met(&rows(4.55), "halves"), [true]);
        assert_eq!(met(&rows(4.65), "halves"), [false]);
        assert_eq!(met(&rows(4.65)[1..], "halves"), [false; 0], "a half is missing");
    }

    #[test]
    fn targets_the_clock_memory_and_growth_can_be_missed() {
        let mut rows = vec![row("one grid", "hybrid", 9.0), row("one grid", "hybrid", 11.0)];
        rows[1].cells = 256;
        rows[1].records = 4_000;
        assert_eq!(met(&rows, "of at most 10"), [true, false]);
        assert_eq!(met(&rows, "wall clock"), [true]);
        assert_eq!(met(&rows, "MiB"), [false]);
        assert_eq!(met(&rows, "records grow"), [true]);
        rows[1].records = 8_000;
        rows[1].memory = vec![("records", 20 << 20)];
        rows[0].wall = Spread::of(&[12.0]);
        assert_eq!(met(&rows, "wall clock"), [false]);
        assert_eq!(met(&rows, "MiB"), [true]);
        assert_eq!(met(&rows, "records grow"), [false]);
    }
}
