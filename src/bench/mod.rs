//! `murrine bench`: milliseconds a stage and bytes, as medians with their spread.
//!
//! Every iteration advances the time, so that nothing can be kept from the one before; each stage is submitted on its
//! own and waited for, which is true on every adapter. Methods that are compared take turns within one run.

mod cases;
mod cutoffs;
mod findings;
mod report;
mod storage;
mod voxelize;

pub use cases::{Case, cases, of_scene};
pub use cutoffs::{CutoffTime, Sweep, cutoffs, sweep, table as cutoffs_table};
pub use findings::{Finding, findings};
pub use report::{Report, Row, Spread};
pub use storage::{ListRow, StorageReport, StorageRow, storage};
pub use voxelize::{Line, Scan, Voxelizing, voxelizing};

use crate::frame::{Frame, Request};
use crate::gpu::{Gpu, GpuError, Timing};
use crate::march::Channel;
use crate::scene::description::Cells;
use crate::scene::{SceneError, World};
use std::time::Instant;

/// What can stop a benchmark.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// The device.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A model.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

/// How long and what.
#[derive(Debug, Clone)]
pub struct Options {
    /// Timed iterations a case, at least 3.
    pub iterations: u32,
    /// Only cases whose name contains this.
    pub filter: Option<String>,
    /// Timed after our own cases.
    pub more: Vec<Case>,
}

impl Default for Options {
    fn default() -> Self {
        Self { iterations: 15, filter: None, more: Vec::new() }
    }
}

/// Seconds by which each iteration advances the time: no multiple of any period in the cases.
const STEP_SECS: f64 = 0.037;
/// Iterations before the timed ones: pipelines warm up and the volume grows until it fits.
const WARM_UP: u32 = 4;

struct Running {
    case: Case,
    world: World,
    frame: Frame,
    samples: Vec<Vec<(&'static str, f64)>>,
    walls: Vec<f64>,
}

/// Runs all cases. Cases of one group are interleaved, iteration by iteration. `progress` is told each group's name.
///
/// # Errors
/// When the device is lost or refuses a buffer.
pub fn run(gpu: &Gpu, options: &Options, mut progress: impl FnMut(&str)) -> Result<Report, BenchError> {
    let wanted = |case: &Case| options.filter.as_ref().is_none_or(|f| case.name.contains(f.as_str()));
    let mut rows = Vec::new();
    let mut cases: Vec<Case> = cases().into_iter().chain(options.more.iter().cloned()).filter(wanted).collect();
    while let Some(group) = cases.first().map(|c| c.group) {
        let (now, later) = cases.into_iter().partition(|c| c.group == group);
        cases = later;
        progress(group);
        rows.extend(run_group(gpu, options, now)?);
    }
    let findings = findings(&rows);
    Ok(Report { adapter: gpu.info.name.clone(), driver: gpu.info.driver_info.clone(), rows, findings })
}

fn run_group(gpu: &Gpu, options: &Options, cases: Vec<Case>) -> Result<Vec<Row>, BenchError> {
    let mut all = Vec::new();
    for case in cases {
        let world = case.world()?;
        all.push(Running { world, case, frame: Frame::new(gpu)?, samples: Vec::new(), walls: Vec::new() });
    }
    let iterations = options.iterations.max(3);
    for iteration in 0..WARM_UP + iterations {
        for running in &mut all {
            let request = Request {
                scene: &running.case.scene,
                world: &running.world,
                time_secs: f64::from(iteration) * STEP_SECS,
                size: running.case.size,
                picture_size: running.case.size,
                channel: Channel::Beauty,
                view: crate::compose::DebugView::None,
                timing: Timing::Submit,
            };
            let started = Instant::now();
            let times = running.frame.render(gpu, &request)?;
            let wall = started.elapsed().as_secs_f64() * 1e3;
            if iteration < WARM_UP {
                running.frame.settle(gpu)?;
            } else {
                running.samples.push(times);
                running.walls.push(wall);
            }
        }
    }
    Ok(all.iter().map(row).collect())
}

fn row(running: &Running) -> Row {
    let names: Vec<&'static str> = running.samples.first().map_or_else(Vec::new, |s| s.iter().map(|t| t.0).collect());
    let of = |name: &str| -> Vec<f64> {
        running.samples.iter().filter_map(|s| s.iter().find(|t| t.0 == name).map(|t| t.1)).collect()
    };
    let sums: Vec<f64> = running.samples.iter().map(|s| s.iter().map(|t| t.1).sum()).collect();
    let volume = running.frame.volume();
    Row {
        name: running.case.name.clone(),
        group: running.case.group,
        method: running.case.scene.voxelizer.method.clone(),
        cells: match running.case.scene.grid.cells {
            Cells::Longest(cells) => cells,
            Cells::Each(cells) => cells.max_element(),
        },
        target_ms: running.case.target_ms,
        stages: names.iter().map(|n| ((*n).to_owned(), Spread::of(&of(n)))).collect(),
        counted: Spread::of(
            &running
                .samples
                .iter()
                .map(|s| s.iter().filter(|t| running.case.counts.contains(&t.0)).map(|t| t.1).sum())
                .collect::<Vec<f64>>(),
        ),
        counts: running.case.counts,
        sum: Spread::of(&sums),
        wall: Spread::of(&running.walls),
        memory: volume.memory(),
        records: volume.counts().iter().map(|c| u64::from(c.occupied) + u64::from(c.extras)).sum(),
    }
}
