//! A benchmark's figures as a table or JSON.

use super::findings::{Finding, mib};
use serde::Serialize;
use std::fmt::Write as _;

/// Minimum, median and maximum.
#[derive(Debug, Clone, Copy, Serialize, PartialEq)]
pub struct Spread {
    /// Least.
    pub min: f64,
    /// Middle.
    pub median: f64,
    /// Greatest.
    pub max: f64,
}

impl Spread {
    /// Of the samples; zeros for none.
    #[must_use]
    pub fn of(samples: &[f64]) -> Self {
        let mut sorted = samples.to_vec();
        sorted.sort_by(f64::total_cmp);
        match sorted.as_slice() {
            [] => Self { min: 0.0, median: 0.0, max: 0.0 },
            all => Self { min: all[0], median: all[all.len() / 2], max: all[all.len() - 1] },
        }
    }
}

/// One case.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// Its name.
    pub name: String,
    /// Its group.
    pub group: &'static str,
    /// Its voxelizer.
    pub method: String,
    /// Cells along the longest axis of its view grid.
    pub cells: u32,
    /// The project's target for `counted`.
    pub target_ms: Option<f64>,
    /// Milliseconds a stage.
    pub stages: Vec<(String, Spread)>,
    /// The stages in `counted`.
    pub counts: &'static [&'static str],
    /// Milliseconds of those stages.
    pub counted: Spread,
    /// Milliseconds of all stages.
    pub sum: Spread,
    /// Milliseconds by the wall clock.
    pub wall: Spread,
    /// Bytes of each of the volume's buffers, all grids.
    pub memory: Vec<(&'static str, u64)>,
    /// Records of all grids, further sheets included.
    pub records: u64,
}

/// All cases.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// The adapter's name.
    pub adapter: String,
    /// Its driver.
    pub driver: String,
    /// A row a case.
    pub rows: Vec<Row>,
    /// What the rows say.
    pub findings: Vec<Finding>,
}

impl Report {
    /// As an aligned table.
    #[must_use]
    pub fn table(&self) -> String {
        let mut text = format!("{} · {}\nmilliseconds: median (min–max)\n", self.adapter, self.driver);
        let mut group = "";
        for row in &self.rows {
            if row.group != group {
                group = row.group;
                text.push('\n');
                text.push_str(group);
                text.push('\n');
            }
            let Spread { min, median, max } = row.counted;
            let mib_in_all = mib(row.memory.iter().map(|(_, bytes)| bytes).sum());
            // Writing to a string can't fail.
            let _ = writeln!(text, "  {:42} {median:8.2} ({min:.2}–{max:.2})  {mib_in_all:6.1} MiB", row.name);
            let stages: Vec<String> = row.stages.iter().map(|(n, s)| format!("{n} {:.2}", s.median)).collect();
            let share = row.sum.median / row.wall.median.max(1e-9) * 100.0;
            let _ = writeln!(text, "      {}; stages are {share:.0}% of the wall clock", stages.join(", "));
            if row.group == "one grid" {
                let memory: Vec<String> = row.memory.iter().map(|(n, b)| format!("{n} {:.2}", mib(*b))).collect();
                let _ = writeln!(text, "      {} records; MiB: {}", row.records, memory.join(", "));
            }
        }
        text.push_str("\nfindings\n");
        for finding in &self.findings {
            let _ = writeln!(text, "  {:6} {}", if finding.met { "met" } else { "MISSED" }, finding.text);
        }
        text
    }
}
