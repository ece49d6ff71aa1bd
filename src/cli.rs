//! The command line. Data goes to stdout, all else to stderr; the exit code is 0 when all is well, 1 when pictures
//! differ or a check failed, 2 when something could not be done, 130 when Ctrl+C ended it.

mod arguments;
mod doctor;
mod golden;
mod interrupt;
mod lab;
mod list;
mod output;
mod render;
mod voxels;

use crate::app;
use crate::bench::{self, BenchError};
use crate::golden::GoldenError;
use crate::gpu::{Gpu, GpuError};
use crate::headless;
use crate::image::ImageError;
use crate::scene::{SceneError, Warning};
use arguments::{Arguments, Command};
use clap::Parser as _;
use output::{Output, tell};
use std::path::PathBuf;
use std::process::ExitCode;

/// What a command came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Outcome {
    Good,
    /// Pictures differ or a check failed.
    Bad,
    /// The user stopped it; what there was is kept.
    Stopped,
}

/// Why a command could not do its work.
#[derive(Debug, thiserror::Error)]
enum Failure {
    #[error("{0}")]
    Scene(#[from] SceneError),
    #[error("{0}")]
    Gpu(#[from] GpuError),
    #[error("{0}")]
    Image(#[from] ImageError),
    #[error("{0}")]
    Golden(#[from] GoldenError),
    #[error("{0}")]
    Bench(#[from] BenchError),
    #[error("{0}")]
    App(#[from] app::AppError),
    #[error("{0}")]
    Other(String),
    /// Whoever read our output has gone: no fault of anyone.
    #[error("the reader of the output has gone")]
    PipeClosed,
}

/// Runs the program with the process's arguments.
#[must_use]
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            // Help and version are no errors; a closed pipe is not one either.
            let code = if error.use_stderr() { 2 } else { 0 };
            let _ = error.print();
            return ExitCode::from(code);
        }
    };
    match run(arguments) {
        Ok(Outcome::Good) | Err(Failure::PipeClosed) => ExitCode::SUCCESS,
        Ok(Outcome::Bad) => ExitCode::from(1),
        // As shells tell of a program that Ctrl+C ended.
        Ok(Outcome::Stopped) => ExitCode::from(130),
        Err(failure) => {
            tell(format_args!("error: {failure}"));
            ExitCode::from(2)
        }
    }
}

fn run(arguments: Arguments) -> Result<Outcome, Failure> {
    let mut out = Output::default();
    let adapter = &arguments.adapter;
    match arguments.command {
        None => window(arguments),
        Some(Command::Render(options)) => render::run(&options, adapter),
        Some(Command::Voxelize(options)) => voxels::run(&options, adapter, &mut out),
        Some(Command::List(options)) => list::run(&options, &mut out),
        Some(Command::Check { scenes }) => check(&scenes, &mut out),
        Some(Command::Doctor) => doctor::run(adapter, &mut out),
        Some(Command::Bench(options)) => time(&options, adapter, &mut out),
        Some(Command::Lab(options)) => lab::run(&options, adapter, &mut out),
        Some(Command::Golden(options)) => golden::run(&options, adapter, &mut out),
    }
}

/// Opens the window; what it logs goes to stderr, as much as `MURRINE_LOG` says (error, warn, info, debug).
fn window(arguments: Arguments) -> Result<Outcome, Failure> {
    let level = std::env::var("MURRINE_LOG").ok().and_then(|l| l.parse().ok()).unwrap_or(tracing::Level::WARN);
    tracing_subscriber::fmt().with_writer(std::io::stderr).with_max_level(level).init();
    let Arguments { path: scene, sets, quit_after, adapter, .. } = arguments;
    app::run(app::Options { scene, sets, adapter: adapter.choice(), shaders: None, quit_after })?;
    Ok(Outcome::Good)
}

/// Reads and loads each scene; all are tried.
fn check(scenes: &[PathBuf], out: &mut Output) -> Result<Outcome, Failure> {
    let mut outcome = Outcome::Good;
    for path in scenes {
        match headless::open(path, &[]) {
            Ok((scene, _, warnings)) => {
                tell_warnings(&warnings);
                out.line(format_args!("{}: ok, {} models", path.display(), scene.models.len()))?;
            }
            Err(error) => {
                outcome = Outcome::Bad;
                out.line(format_args!("{error}"))?;
            }
        }
    }
    Ok(outcome)
}

/// Grids and picture of `bench storage`.
const STORAGE_CELLS: [u32; 3] = [64, 128, 256];
const STORAGE_PIXELS: u32 = 256;

/// Times our own cases, and the given scenes after them; or the ways to store a volume.
fn time(options: &arguments::Bench, adapter: &arguments::Adapter, out: &mut Output) -> Result<Outcome, Failure> {
    if options.cutoffs {
        return time_cutoffs(options, adapter, out);
    }
    let json = |text: serde_json::Result<String>| text.map_err(|e| Failure::Other(e.to_string()));
    if options.scenes.as_slice() == [PathBuf::from("storage")] {
        let progress = |group: &str| tell(format_args!("timing: {group}"));
        let gpu = open_gpu(adapter)?;
        let report = bench::storage(&gpu, &STORAGE_CELLS, STORAGE_PIXELS, options.iterations, progress)?;
        let text = if options.json { json(serde_json::to_string_pretty(&report))? } else { report.table() };
        out.line(format_args!("{}", text.trim_end()))?;
        return Ok(Outcome::Good);
    }
    if options.scenes.as_slice() == [PathBuf::from("voxelize")] {
        let progress = |what: &str| tell(format_args!("timing: {what}"));
        let report = bench::voxelizing(&open_gpu(adapter)?, options.iterations, progress)?;
        let text = if options.json { json(serde_json::to_string_pretty(&report))? } else { report.table() };
        out.line(format_args!("{}", text.trim_end()))?;
        return Ok(Outcome::Good);
    }
    let mut more = Vec::new();
    for path in &options.scenes {
        let (scene, _, warnings) = headless::open(path, &[])?;
        tell_warnings(&warnings);
        more.push(bench::of_scene(path.display().to_string(), scene));
    }
    let what = bench::Options { iterations: options.iterations, filter: options.only.clone(), more };
    let report = bench::run(&open_gpu(adapter)?, &what, |group| tell(format_args!("timing: {group}")))?;
    let text = if options.json { json(serde_json::to_string_pretty(&report))? } else { report.table() };
    out.line(format_args!("{}", text.trim_end()))?;
    Ok(Outcome::Good)
}

fn time_cutoffs(
    options: &arguments::Bench,
    adapter: &arguments::Adapter,
    out: &mut Output,
) -> Result<Outcome, Failure> {
    let gpu = open_gpu(adapter)?;
    let mut sweeps = Vec::new();
    for path in &options.scenes {
        let (scene, world, warnings) = headless::open(path, &[])?;
        tell_warnings(&warnings);
        sweeps.push(bench::sweep(&gpu, &path.display().to_string(), &scene, &world, options.iterations)?);
    }
    let wanted = |case: &bench::Case| options.only.as_ref().is_none_or(|only| case.name.contains(only.as_str()));
    let ours = bench::cases().into_iter().filter(|case| case.scene.voxelizer.method == "hybrid" && case.is_marking());
    for case in ours.filter(|case| options.scenes.is_empty() && wanted(case)) {
        tell(format_args!("timing: {}", case.name));
        let world = case.world()?;
        sweeps.push(bench::sweep(&gpu, case.group, &case.scene, &world, options.iterations)?);
    }
    let json = || serde_json::to_string_pretty(&sweeps).map_err(|e| Failure::Other(e.to_string()));
    let text = if options.json { json()? } else { bench::cutoffs_table(&sweeps) };
    out.line(format_args!("{}", text.trim_end()))?;
    Ok(Outcome::Good)
}

fn tell_warnings(warnings: &[Warning]) {
    for warning in warnings {
        tell(format_args!("warning: {warning}"));
    }
}

/// Opens the adapter that the command line names.
fn open_gpu(adapter: &arguments::Adapter) -> Result<Gpu, Failure> {
    Ok(Gpu::open(&adapter.choice())?)
}
