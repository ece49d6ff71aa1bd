//! The laboratory: every voxelizer on the same bodies and grids, held against the truth: time, voxels found, missing,
//! spurious, memory; over grids, viewing angles and aspect ratios; and the sweep of hybrid's cut-off.
//!
//! Source: [`papers::TRIPIANA_2009`], chapter 3, whose figures are the plots here; CL §4 for angles and aspects; RB Figs.
//! 13 and 14 for the sweep. Differs: what only touches a voxel to within ±1e-6 of the grid's size is no fault, and is
//! counted apart; an interior that a method makes is held against our parity fill, where TR left such methods out.
//!
//! [`papers::TRIPIANA_2009`]: crate::papers::TRIPIANA_2009

mod csv;
mod page;
mod plot;
mod stations;
mod svg;

pub use csv::csv;
pub use page::page;
pub use stations::{Series, Station};

use crate::bench::Spread;
use crate::gpu::{Gpu, GpuError};
use crate::marking::{Faults, Marking};
use crate::scene::description::{Conservative, Separability, VoxelizerSettings};
use crate::scene::words::Words as _;
use crate::scene::{Scene, World};
use crate::voxelize::{ExactVoxels, METHODS, Method};
use glam::UVec3;
use std::time::Instant;

/// Timed rounds of a way, at most; the first, which compiles, is not among them.
const ROUNDS: usize = 5;

/// A body to measure on.
#[derive(Debug)]
pub struct Subject {
    /// Its name in the report.
    pub name: String,
    /// The scene that shows it.
    pub scene: Scene,
    /// What that names, loaded.
    pub world: World,
}

/// What is to be measured.
#[derive(Debug)]
pub struct Plan {
    /// On what.
    pub subjects: Vec<Subject>,
    /// Cells along each axis.
    pub grids: Vec<u32>,
    /// Which methods.
    pub methods: Vec<&'static Method>,
    /// Viewing angles, beside the z axis.
    pub angles: u32,
    /// Shapes of the grid, beside cubes: cells along x, y, z in proportion.
    pub aspects: Vec<UVec3>,
    /// What would take longer than this, seconds, is left out.
    pub cap_secs: f64,
    /// Seconds into the animation.
    pub time_secs: f64,
}

/// A method with its options: a line of the report.
#[derive(Debug, Clone, Copy)]
pub struct Way {
    /// The method.
    pub method: &'static Method,
    /// Which columns a triangle reaches.
    pub conservative: Conservative,
    /// Slices too.
    pub in_depth: bool,
}

/// What was found out about a way in a grid.
#[derive(Debug, Clone)]
pub enum Outcome {
    /// It was measured.
    Measured(Figures),
    /// It was left out: why.
    LeftOut(String),
}

/// The measures of TR's chapter 3.
#[derive(Debug, Clone, Copy)]
pub struct Figures {
    /// Milliseconds.
    pub ms: Spread,
    /// Timed rounds.
    pub rounds: usize,
    /// Of the surface's voxels against the truth.
    pub faults: Faults,
    /// Of the interior, where the method makes one, against our parity fill.
    pub solid: Option<Faults>,
    /// Bytes of words and of what the method holds, where the device tells.
    pub bytes: Option<u64>,
}

/// A line of the report.
#[derive(Debug, Clone)]
pub struct Row {
    /// Index of its body.
    pub subject: usize,
    /// Where it was measured.
    pub station: Station,
    /// How the voxels were marked.
    pub way: Way,
    /// What came of it.
    pub outcome: Outcome,
}

/// A point of the cut-off's sweep (RB Figs. 13–14).
#[derive(Debug, Clone, Copy)]
pub struct SweepPoint {
    /// Index of the body.
    pub subject: usize,
    /// Triangles of more projected cells² than this go to fragments; `None`: what suits the device.
    pub cutoff_cells2: Option<f32>,
    /// Milliseconds.
    pub ms: Spread,
}

/// A body as the report names it.
#[derive(Debug, Clone)]
pub struct Body {
    /// Name.
    pub name: String,
    /// Number of triangles.
    pub triangles: usize,
}

/// Everything that was measured.
#[derive(Debug, Clone, Default)]
pub struct Report {
    /// The adapter's name.
    pub adapter: String,
    /// Its driver.
    pub driver: String,
    /// The command line that measures it again.
    pub command: String,
    /// The bodies.
    pub bodies: Vec<Body>,
    /// Every way at every station.
    pub rows: Vec<Row>,
    /// The sweep of the cut-off, and the cells along each axis of its grid.
    pub sweep: (u32, Vec<SweepPoint>),
    /// How many steps were done, of how many.
    pub steps: (usize, usize),
}

/// Where a run stands.
#[derive(Debug, Clone, Copy)]
pub struct Progress<'a> {
    /// Steps done.
    pub done: usize,
    /// Of how many.
    pub of: usize,
    /// The body that comes next,
    pub body: &'a str,
    /// the grid,
    pub station: &'a str,
    /// and the way.
    pub way: &'a str,
}

impl Way {
    /// The plain way of a method and, where it rasterizes, every conservative one, each in depth too.
    #[must_use]
    pub fn all(method: &'static Method) -> Vec<Self> {
        let plain = Self { method, conservative: Conservative::None, in_depth: false };
        let ways = method
            .conservative
            .iter()
            .flat_map(|&conservative| [false, true].map(|in_depth| Self { method, conservative, in_depth }));
        std::iter::once(plain).chain(ways).collect()
    }

    /// True where no option is taken.
    #[must_use]
    pub fn is_plain(&self) -> bool {
        self.conservative == Conservative::None && !self.in_depth
    }

    /// Such as `slicemap, polygon, in depth`.
    #[must_use]
    pub fn name(&self) -> String {
        let mut name = self.method.name.to_owned();
        if self.conservative != Conservative::None {
            name = format!("{name}, {}", self.conservative.word());
        }
        if self.in_depth { format!("{name}, in depth") } else { name }
    }

    fn settings(&self) -> VoxelizerSettings {
        VoxelizerSettings {
            method: self.method.name.to_owned(),
            conservative: self.conservative,
            conservative_depth: self.in_depth,
            ..VoxelizerSettings::default()
        }
    }

    fn is(&self, other: &Self) -> bool {
        self.method.name == other.method.name
            && (self.conservative, self.in_depth) == (other.conservative, other.in_depth)
    }
}

impl Plan {
    /// The grid on which angles, aspects and cut-offs are compared: the finest of at most 128 cells, else the coarsest.
    #[must_use]
    pub fn base_grid(&self) -> u32 {
        let modest = self.grids.iter().copied().filter(|n| *n <= 128).max();
        modest.or(self.grids.iter().copied().min()).unwrap_or(64)
    }

    /// Everywhere that something is measured, coarse grids first.
    fn stations(&self) -> Vec<Station> {
        let mut grids = self.grids.clone();
        grids.sort_unstable();
        grids.dedup();
        let base = self.base_grid();
        let cubes = grids.into_iter().map(|n| Station::new(Series::Grid, UVec3::splat(n)));
        let angles = (1..=self.angles).map(|i| Station::new(Series::Angle(i, self.angles), UVec3::splat(base)));
        let aspects =
            self.aspects.iter().map(|aspect| Station::new(Series::Aspect, stations::stretched(base, *aspect)));
        cubes.chain(angles).chain(aspects).collect()
    }

    fn ways(&self, station: &Station) -> Vec<Way> {
        let ways = self.methods.iter().flat_map(|method| Way::all(method));
        ways.filter(|way| station.series == Series::Grid || way.is_plain()).collect()
    }

    /// The cut-offs of the sweep, cells²: none at all, powers of two, all; then the device's own.
    fn cutoffs(&self) -> Vec<Option<f32>> {
        if !self.methods.iter().any(|m| m.name == "hybrid") {
            return Vec::new();
        }
        let powers = (0..=14).map(|k| Some(f32::from(1_u16 << k)));
        std::iter::once(Some(0.0)).chain(powers).chain([None]).collect()
    }
}

/// Measures all of it. `progress` is told each step; once `stop` says so, or the device is lost, what there is comes back.
pub fn run(
    gpu: &Gpu,
    plan: &Plan,
    progress: impl FnMut(Progress<'_>),
    stop: impl Fn() -> bool,
) -> (Report, Result<(), GpuError>) {
    let ways = plan.stations().iter().map(|station| plan.ways(station).len()).sum::<usize>();
    let mut report = Report {
        adapter: gpu.info.name.clone(),
        driver: format!("{} {}", gpu.info.driver, gpu.info.driver_info),
        sweep: (plan.base_grid(), Vec::new()),
        steps: (0, plan.subjects.len() * (plan.cutoffs().len() + ways)),
        ..Report::default()
    };
    let result = fill_in(gpu, plan, &mut report, progress, stop);
    (report, result)
}

fn fill_in(
    gpu: &Gpu,
    plan: &Plan,
    report: &mut Report,
    mut progress: impl FnMut(Progress<'_>),
    stop: impl Fn() -> bool,
) -> Result<(), GpuError> {
    let stations = plan.stations();
    let of = report.steps.1;
    for (subject, body) in plan.subjects.iter().enumerate() {
        let mut marking = Marking::of_scene(gpu, &body.scene, &body.world, plan.time_secs)?;
        let triangles = marking.world_triangles.len();
        report.bodies.push(Body { name: body.name.clone(), triangles });
        for station in &stations {
            let put = marking.put(gpu, station.grid(&marking.world_triangles));
            let mut truth = None;
            for way in plan.ways(station) {
                if stop() {
                    return Ok(());
                }
                let (station_name, way_name) = (station.name(), way.name());
                progress(Progress {
                    done: report.steps.0,
                    of,
                    body: &body.name,
                    station: &station_name,
                    way: &way_name,
                });
                let expected = expected_secs(&report.rows, subject, station, &way);
                let outcome = match &put {
                    Err(refusal) => Outcome::LeftOut(refusal.to_string()),
                    Ok(()) if let Err(why) = &expected => Outcome::LeftOut(why.clone()),
                    Ok(())
                        if let Ok(secs) = expected
                            && secs > plan.cap_secs =>
                    {
                        Outcome::LeftOut(capped(secs, plan.cap_secs))
                    }
                    Ok(()) => {
                        let truth = truth.get_or_insert_with(|| marking.truth(Separability::TwentySix));
                        measured(gpu, &marking, &way, truth, plan.cap_secs)?
                    }
                };
                report.rows.push(Row { subject, station: *station, way, outcome });
                report.steps.0 += 1;
            }
        }
        marking.put(gpu, Station::new(Series::Grid, UVec3::splat(plan.base_grid())).grid(&marking.world_triangles))?;
        for cutoff_cells2 in plan.cutoffs() {
            if stop() {
                return Ok(());
            }
            progress(Progress { done: report.steps.0, of, body: &body.name, station: "cut-off", way: "hybrid" });
            let settings = VoxelizerSettings { method: "hybrid".to_owned(), cutoff_cells2, ..Default::default() };
            let mut compiled = marking.compile(gpu, crate::voxelize::method("hybrid")?)?;
            marking.mark(gpu, &mut compiled, &settings)?;
            let ms = rounds(plan.cap_secs, || marking.mark(gpu, &mut compiled, &settings))?;
            report.sweep.1.push(SweepPoint { subject, cutoff_cells2, ms: Spread::of(&ms) });
            report.steps.0 += 1;
        }
    }
    Ok(())
}

/// A way that the device or the method refuses is left out; a lost device ends all.
fn measured(gpu: &Gpu, marking: &Marking, way: &Way, truth: &ExactVoxels, cap_secs: f64) -> Result<Outcome, GpuError> {
    let measure = || -> Result<Figures, GpuError> {
        let settings = way.settings();
        let mut compiled = marking.compile(gpu, way.method)?;
        marking.mark(gpu, &mut compiled, &settings)?;
        let bytes = marking.bytes(gpu, &compiled)?;
        let ms = rounds(cap_secs, || marking.mark(gpu, &mut compiled, &settings))?;
        let faults = marking.faults(gpu, truth)?;
        let solid = if way.is_plain() { marking.solid_faults(gpu, &mut compiled, &settings)? } else { None };
        Ok(Figures { ms: Spread::of(&ms), rounds: ms.len(), faults, solid, bytes })
    };
    match measure() {
        Ok(figures) => Ok(Outcome::Measured(figures)),
        Err(lost @ GpuError::Lost(_)) => Err(lost),
        Err(refusal) => Ok(Outcome::LeftOut(refusal.to_string())),
    }
}

/// Milliseconds of up to [`ROUNDS`] rounds, fewer once they have taken `cap_secs` together.
fn rounds(cap_secs: f64, mut round: impl FnMut() -> Result<f64, GpuError>) -> Result<Vec<f64>, GpuError> {
    let started = Instant::now();
    let mut ms = Vec::new();
    while ms.is_empty() || (ms.len() < ROUNDS && started.elapsed().as_secs_f64() < cap_secs) {
        ms.push(round()?);
    }
    Ok(ms)
}

fn capped(expected_secs: f64, cap_secs: f64) -> String {
    format!("would take about {expected_secs:.0} s, more than the cap of {cap_secs:.0} s; raise --cap")
}

/// What a way will take in a finer grid than those measured: as its time grew so far, at least as the number of slices
/// does; or why it was left out in a coarser one.
fn expected_secs(rows: &[Row], subject: usize, station: &Station, way: &Way) -> Result<f64, String> {
    if station.series != Series::Grid {
        return Ok(0.0);
    }
    let of_way = |row: &&Row| row.subject == subject && row.station.series == Series::Grid && row.way.is(way);
    let mut points: Vec<(f64, f64)> = Vec::new();
    for row in rows.iter().filter(of_way) {
        match &row.outcome {
            Outcome::Measured(figures) => points.push((f64::from(row.station.cells.x), figures.ms.median / 1e3)),
            Outcome::LeftOut(why) => return Err(why.clone()),
        }
    }
    let Some(&(cells, secs)) = points.last() else { return Ok(0.0) };
    let before = points.len().checked_sub(2).map(|i| points[i]);
    let power = before.map_or(1.0, |(fewer, less)| (secs / less).ln() / (cells / fewer).ln()).clamp(1.0, 3.0);
    Ok(secs * (f64::from(station.cells.x) / cells).powf(power))
}

/// The methods of these names; `all` names all.
///
/// # Errors
/// When there is none of a name.
pub fn methods(names: &[String]) -> Result<Vec<&'static Method>, GpuError> {
    if names.iter().any(|name| name == "all") {
        return Ok(METHODS.iter().collect());
    }
    names.iter().map(|name| crate::voxelize::method(name)).collect()
}
