//! `murrine bench voxelize`: every method on meshes from one triangle to hundreds of thousands, beside the CPU's f64 test;
//! and the scan that numbers voxels beside a copy of the same words.

use super::findings::Finding;
use super::report::Spread;
use super::{BenchError, WARM_UP};
use crate::gpu::{ComputePass, Gpu, GpuError, Recorder, Timing};
use crate::grid::Grid;
use crate::marking::{Compiled, Marking};
use crate::resolve::Resolve;
use crate::scene::description::{Separability, VoxelizerSettings};
use crate::voxelize::{METHODS, Method, Promise, marked_voxels};
use glam::{DVec3, UVec3, Vec3};
use serde::Serialize;
use std::collections::VecDeque;
use std::fmt::Write as _;
use std::time::Instant;

/// Triangles of each mesh.
const COUNTS: [usize; 4] = [1, 200, 70_000, 871_000];
/// Cells along each axis.
const GRIDS: [u32; 2] = [128, 256];
/// Cells along each axis of the grids whose voxels are numbered.
const SCAN_GRIDS: [u32; 2] = [256, 512];
/// A method that would take longer for one round is left out, milliseconds.
const CAP_MS: f64 = 20_000.0;
/// A method that takes longer for a round has no more than [`FEW`], milliseconds.
const LONG_MS: f64 = 1_000.0;
/// See [`LONG_MS`].
const FEW: u32 = 2;
/// Cores of the yardstick.
const CORES: usize = 2;
/// What is told of the yardstick.
const YARDSTICK: &str = "f64 on two cores";
/// Hybrid is to be as many times as fast as the yardstick, on this mesh and grid.
const TIMES: (f64, usize, u32) = (3.0, 70_000, 256);
/// How much slower than the fastest exact method hybrid may be: a share, or milliseconds.
const SHARE: f64 = 0.15;
const SLACK_MS: f64 = 0.5;
/// How much longer than the copy a scan may take.
const SCAN_TIMES: f64 = 2.0;

/// A line of the table.
#[derive(Debug, Clone, Serialize)]
pub struct Line {
    /// Triangles of the mesh.
    pub triangles: usize,
    /// Cells along each axis.
    pub cells: u32,
    /// The method.
    pub method: &'static str,
    /// True for methods on the device that promise every voxel.
    pub exact: bool,
    /// Milliseconds; nothing where it was left out.
    pub ms: Option<Spread>,
}

/// Numbering voxels beside copying words.
#[derive(Debug, Clone, Serialize)]
pub struct Scan {
    /// Cells along each axis.
    pub cells: u32,
    /// Milliseconds of the prefix sum.
    pub scan_ms: Spread,
    /// Milliseconds of the copy.
    pub copy_ms: Spread,
}

/// Everything measured.
#[derive(Debug, Clone, Serialize)]
pub struct Voxelizing {
    /// The adapter's name.
    pub adapter: String,
    /// Its driver.
    pub driver: String,
    /// Meshes × grids × methods.
    pub lines: Vec<Line>,
    /// The scan.
    pub scans: Vec<Scan>,
    /// What they say.
    pub findings: Vec<Finding>,
}

/// Runs all of it; `progress` is told each mesh and grid.
///
/// # Errors
/// When the device is lost or refuses a buffer.
pub fn voxelizing(gpu: &Gpu, iterations: u32, mut progress: impl FnMut(&str)) -> Result<Voxelizing, BenchError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(CORES).build().map_err(|e| GpuError::Lost(e.to_string()))?;
    let mut lines: Vec<Line> = Vec::new();
    for triangles in COUNTS {
        let mesh = mesh(triangles);
        let mut marking = Marking::of_triangles(gpu, &mesh)?;
        for cells in GRIDS {
            progress(&format!("{triangles} triangles, {cells}³"));
            let grid = grid(cells);
            marking.put(gpu, grid)?;
            let mut runs = Vec::new();
            for method in METHODS {
                let fits = expected_ms(&lines, method, triangles, cells).is_none_or(|ms| ms <= CAP_MS);
                runs.push(fits.then(|| Run::new(gpu, &marking, method)).transpose()?);
            }
            let mut yardstick = Vec::new();
            for iteration in 0..iterations {
                for run in runs.iter_mut().flatten().filter(|run| iteration < FEW || run.first_ms < LONG_MS) {
                    run.ms.push(marking.mark(gpu, &mut run.compiled, &run.settings)?);
                }
                let started = Instant::now();
                pool.install(|| marked_voxels(&grid, &mesh, Separability::TwentySix));
                yardstick.push(started.elapsed().as_secs_f64() * 1e3);
            }
            let line =
                |method, exact, ms: Option<&[f64]>| Line { triangles, cells, method, exact, ms: ms.map(Spread::of) };
            for (method, run) in METHODS.iter().zip(&runs) {
                let exact = method.promise == Promise::Exact && method.shader.is_some();
                lines.push(line(method.name, exact, run.as_ref().map(|run| run.ms.as_slice())));
            }
            lines.push(line(YARDSTICK, false, Some(&yardstick)));
        }
    }
    let mut scans = Vec::new();
    for cells in SCAN_GRIDS {
        progress(&format!("scan, {cells}³"));
        scans.push(scan(gpu, cells, iterations)?);
    }
    let findings = findings(&lines, &scans);
    let driver = format!("{} {}", gpu.info.driver, gpu.info.driver_info);
    Ok(Voxelizing { adapter: gpu.info.name.clone(), driver, lines, scans, findings })
}

/// A method that takes its turns.
struct Run {
    compiled: Compiled,
    settings: VoxelizerSettings,
    /// Of the round after that which compiles.
    first_ms: f64,
    ms: Vec<f64>,
}

impl Run {
    fn new(gpu: &Gpu, marking: &Marking, method: &'static Method) -> Result<Self, GpuError> {
        let mut compiled = marking.compile(gpu, method)?;
        let settings = VoxelizerSettings { method: method.name.to_owned(), ..VoxelizerSettings::default() };
        let mut first_ms = marking.mark(gpu, &mut compiled, &settings)?;
        for _ in 1..WARM_UP {
            if first_ms < LONG_MS {
                first_ms = marking.mark(gpu, &mut compiled, &settings)?;
            }
        }
        Ok(Self { compiled, settings, first_ms, ms: Vec::new() })
    }
}

/// What a method is to take by what it took on fewer triangles in this grid, or in the coarser grid on as many.
fn expected_ms(lines: &[Line], method: &Method, triangles: usize, cells: u32) -> Option<f64> {
    let of = |t: usize, c: u32| lines.iter().find(|l| (l.triangles, l.cells, l.method) == (t, c, method.name));
    let fewer = COUNTS.iter().rev().find(|n| **n < triangles).copied();
    let by_triangles = fewer.and_then(|n| Some((of(n, cells)?.ms, triangles as f64 / n as f64)));
    let by_cells = of(triangles, GRIDS[0]).map(|line| (line.ms, f64::from(cells) / f64::from(GRIDS[0])));
    let known = [by_triangles.filter(|_| triangles > COUNTS[2]), by_cells];
    known.into_iter().flatten().map(|(ms, times)| ms.map_or(f64::INFINITY, |ms| ms.median * times)).reduce(f64::max)
}

fn scan(gpu: &Gpu, cells: u32, iterations: u32) -> Result<Scan, BenchError> {
    let mut marking = Marking::of_triangles(gpu, &mesh(COUNTS[2]))?;
    marking.put(gpu, grid(cells))?;
    let method = crate::voxelize::method("triangle-parallel")?;
    marking.mark(gpu, &mut marking.compile(gpu, method)?, &VoxelizerSettings::default())?;
    let resolve = Resolve::new(gpu)?;
    let copy = ComputePass::new(gpu, "copy.wgsl", "main", &[])?;
    let volume = marking.volume();
    let words = volume.grids.first().map_or(0, Grid::word_count);
    let group = copy
        .bind(gpu, &[("source", volume.occupancy.as_entire_binding()), ("copied", volume.ranks.as_entire_binding())]);
    let (mut scan_ms, mut copy_ms) = (Vec::new(), Vec::new());
    for iteration in 0..WARM_UP + iterations {
        let mut rec = Recorder::new(gpu, Timing::Submit);
        rec.stage("scan")?;
        resolve.record_scan(&mut rec, volume, 0);
        rec.stage("copy")?;
        copy.dispatch(&mut rec.encoder, &group, [words, 1, 1]);
        let times = rec.finish()?;
        if iteration >= WARM_UP {
            scan_ms.extend(times.iter().filter(|t| t.0 == "scan").map(|t| t.1));
            copy_ms.extend(times.iter().filter(|t| t.0 == "copy").map(|t| t.1));
        }
    }
    Ok(Scan { cells, scan_ms: Spread::of(&scan_ms), copy_ms: Spread::of(&copy_ms) })
}

fn grid(cells: u32) -> Grid {
    Grid::world_aligned(DVec3::splat(-1.0), 2.0 / f64::from(cells), UVec3::splat(cells))
}

/// One triangle across the grid, or a bumpy ball of so many: an icosahedron whose triangles are halved across their
/// longest side, the oldest first.
fn mesh(count: usize) -> Vec<[Vec3; 3]> {
    if count == 1 {
        return vec![[Vec3::new(-0.9, -0.8, -0.9), Vec3::new(0.9, -0.5, 0.1), Vec3::new(-0.2, 0.9, 0.8)]];
    }
    let shape =
        crate::scene::shapes::shape(&crate::scene::description::Shape::Icosphere { radius: 1.0, subdivisions: 0 });
    let at = |i: u32| shape.vertices[i as usize].position;
    let mut triangles: VecDeque<[Vec3; 3]> = shape.triangles.iter().map(|t| t.map(at)).collect();
    while triangles.len() < count {
        let Some(t) = triangles.pop_front() else { break };
        let length = |i: usize| t[i].distance_squared(t[(i + 1) % 3]);
        let i = (0..3).max_by(|&i, &j| length(i).total_cmp(&length(j))).unwrap_or(0);
        let [a, b, c] = [t[i], t[(i + 1) % 3], t[(i + 2) % 3]];
        let middle = (a + b).normalize();
        triangles.extend([[a, middle, c], [middle, b, c]]);
    }
    let bump = |p: Vec3| p * (0.85 + 0.1 * (7.0 * p.x).sin() * (6.0 * p.y).sin() * (5.0 * p.z).cos());
    triangles.into_iter().map(|t| t.map(bump)).collect()
}

fn findings(lines: &[Line], scans: &[Scan]) -> Vec<Finding> {
    let mut found = Vec::new();
    let ms = |triangles: usize, cells: u32, method: &str| {
        let line = lines.iter().find(|l| (l.triangles, l.cells, l.method) == (triangles, cells, method))?;
        Some(line.ms?.median)
    };
    let (times, triangles, cells) = TIMES;
    if let (Some(hybrid), Some(yardstick)) = (ms(triangles, cells, "hybrid"), ms(triangles, cells, YARDSTICK)) {
        let ratio = yardstick / hybrid;
        let text = format!(
            "hybrid, {triangles} triangles, {cells}³: {ratio:.1} times as fast as {YARDSTICK} (at least {times:.0})"
        );
        found.push(Finding { text, met: ratio >= times });
    }
    for line in lines.iter().filter(|line| line.method == "hybrid") {
        let (triangles, cells) = (line.triangles, line.cells);
        let others = lines.iter().filter(|l| l.exact && (l.triangles, l.cells) == (triangles, cells));
        let fastest = others.filter_map(|l| Some((l.ms?.median, l.method))).min_by(|a, b| a.0.total_cmp(&b.0));
        if let (Some(hybrid), Some((best, name))) = (line.ms.map(|ms| ms.median), fastest) {
            let text =
                format!("hybrid, {triangles} triangles, {cells}³: {hybrid:.2} ms; fastest exact: {name}, {best:.2}");
            found.push(Finding { text, met: hybrid <= best * (1.0 + SHARE) || hybrid <= best + SLACK_MS });
        }
    }
    for Scan { cells, scan_ms, copy_ms } in scans {
        let ratio = scan_ms.median / copy_ms.median;
        let text =
            format!("numbering voxels, {cells}³: {ratio:.2} times a copy of the words (at most {SCAN_TIMES:.0})");
        found.push(Finding { text, met: ratio <= SCAN_TIMES });
    }
    found
}

impl Voxelizing {
    /// As an aligned table: a line a method, a column a mesh and grid.
    #[must_use]
    pub fn table(&self) -> String {
        let mut text =
            format!("{} · {}\nmilliseconds a grid, medians\n\n{:20}", self.adapter, self.driver, "triangles");
        let columns = || COUNTS.iter().flat_map(|t| GRIDS.map(|c| (*t, c)));
        for (triangles, _) in columns() {
            // Writing to a string can't fail.
            let _ = write!(text, "{triangles:>10}");
        }
        let _ = write!(text, "\n{:20}", "cells");
        for (_, cells) in columns() {
            let _ = write!(text, "{:>10}", format!("{cells}³"));
        }
        text.push('\n');
        for method in METHODS.iter().map(|m| m.name).chain([YARDSTICK]) {
            let _ = write!(text, "{method:20}");
            for (triangles, cells) in columns() {
                let line = self.lines.iter().find(|l| (l.triangles, l.cells, l.method) == (triangles, cells, method));
                let ms = line.and_then(|line| line.ms).map_or("–".to_owned(), |ms| format!("{:.2}", ms.median));
                let _ = write!(text, "{ms:>10}");
            }
            text.push('\n');
        }
        for Scan { cells, scan_ms, copy_ms } in &self.scans {
            let _ = writeln!(text, "\nscan {cells}³ {:.2}, copy {:.2}", scan_ms.median, copy_ms.median);
        }
        let _ = writeln!(text, "\n–: would take more than {:.0} s a round\n\nfindings", CAP_MS / 1e3);
        for finding in &self.findings {
            let _ = writeln!(text, "  {:6} {}", if finding.met { "met" } else { "MISSED" }, finding.text);
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(triangles: usize, method: &'static str, exact: bool, ms: f64) -> Line {
        Line { triangles, cells: 256, method, exact, ms: Some(Spread::of(&[ms])) }
    }

    #[test]
    fn meshes_have_the_triangles_that_they_are_named_by_and_fit_the_grid() {
        for count in &COUNTS[..3] {
            let mesh = mesh(*count);
            assert_eq!(mesh.len(), *count);
            assert!(mesh.iter().flatten().all(|p| p.abs().max_element() < 1.0));
        }
    }

    #[test]
    fn findings_are_met_and_missed() {
        let met = |hybrid: f64, yardstick: f64, other: f64| -> Vec<bool> {
            let lines = [
                line(70_000, "hybrid", true, hybrid),
                line(70_000, "triangle-parallel", true, other),
                line(70_000, "slices", false, 0.1),
                line(70_000, YARDSTICK, false, yardstick),
            ];
            findings(&lines, &[]).iter().map(|f| f.met).collect()
        };
        assert_eq!(met(10.0, 31.0, 9.0), [true, true]);
        assert_eq!(met(10.0, 29.0, 8.0), [false, false]);
        let scan = |ms: f64| Scan { cells: 256, scan_ms: Spread::of(&[ms]), copy_ms: Spread::of(&[1.0]) };
        assert_eq!(findings(&[], &[scan(1.9), scan(2.1)]).iter().map(|f| f.met).collect::<Vec<_>>(), [true, false]);
    }
}
