//! `murrine lab`.

use super::arguments::{Adapter, Lab};
use super::{Failure, Outcome, Output, interrupt, open_gpu, tell, tell_warnings};
use crate::headless;
use crate::image;
use crate::lab::{self, Plan, Progress, Subject};
use crate::scene::{World, file};
use glam::UVec3;
use std::io::{IsTerminal as _, Write as _};
use std::path::Path;
use std::sync::atomic::Ordering;

/// What a model's name begins with that is one of our own shapes.
const SHAPE: &str = "shape:";
/// Width of the bar, characters.
const BAR: usize = 28;

pub(super) fn run(options: &Lab, adapter: &Adapter, out: &mut Output) -> Result<Outcome, Failure> {
    let (html, csv) = (options.output.join("report.html"), options.output.join("report.csv"));
    let subjects = options.models.iter().map(|name| subject(name)).collect::<Result<_, _>>()?;
    let plan = Plan {
        subjects,
        grids: options.grids.clone(),
        methods: lab::methods(&options.voxelizers)?,
        angles: options.angles,
        aspects: options.aspects.iter().copied().filter(|aspect| *aspect != UVec3::ONE).collect(),
        cap_secs: options.cap,
        time_secs: options.time,
    };
    let gpu = open_gpu(adapter)?;
    make_folder(&options.output)?;
    // Before anything is measured: can files stand there?
    tempfile::tempfile_in(&options.output)
        .map_err(|e| Failure::Other(format!("{}: can't write there: {e}; choose another", options.output.display())))?;
    let stop = interrupt::flag()?;
    let mut bar = Bar { drawn: false, told: String::new() };
    let (mut report, result) = lab::run(&gpu, &plan, |progress| bar.show(progress), || stop.load(Ordering::Relaxed));
    bar.clear();
    report.command = command(options, adapter);
    image::atomically(&csv, |file| file.write_all(lab::csv(&report).as_bytes()))?;
    image::atomically(&html, |file| file.write_all(lab::page(&report).as_bytes()))?;
    out.line(format_args!("{}", html.display()))?;
    out.line(format_args!("{}", csv.display()))?;
    result?;
    let (done, of) = report.steps;
    if done < of {
        tell(format_args!("stopped after {done} of {of} steps; the report holds what there was"));
        return Ok(Outcome::Stopped);
    }
    Ok(Outcome::Good)
}

/// Opens a file, or makes one of our shapes.
fn subject(name: &str) -> Result<Subject, Failure> {
    if let Some(shape) = name.strip_prefix(SHAPE) {
        let text = shape_text(shape);
        let (scene, _) = file::parse(&text, Path::new(name), &headless::methods())?;
        let world = World::load(&scene, None)?;
        return Ok(Subject { name: shape.to_owned(), scene, world });
    }
    let path = Path::new(name);
    let (scene, world, warnings) = headless::open(path, &[])?;
    tell_warnings(&warnings);
    if world.models.iter().all(|model| model.triangles.is_empty()) {
        return Err(Failure::Other(format!("{name}: it has no triangles to voxelize")));
    }
    let stem = path.file_stem().map_or_else(|| name.to_owned(), |stem| stem.to_string_lossy().into_owned());
    Ok(Subject { name: stem, scene, world })
}

/// `torus,segments=60` as a scene file says it.
fn shape_text(shape: &str) -> String {
    let mut parts = shape.split(',');
    let kind = parts.next().unwrap_or_default();
    let keys: String = parts.map(|part| format!("{part}\n")).collect();
    format!("[[model]]\nshape = \"{kind}\"\n{keys}")
}

fn make_folder(path: &Path) -> Result<(), Failure> {
    if path.is_dir() {
        return Ok(());
    }
    std::fs::create_dir(path)
        .map_err(|e| Failure::Other(format!("{}: can't make this folder: {e}; choose another", path.display())))
}

/// The command line that measures this again.
fn command(options: &Lab, adapter: &Adapter) -> String {
    let list = |items: &[String]| items.join(",");
    let grids: Vec<String> = options.grids.iter().map(ToString::to_string).collect();
    let aspects: Vec<String> = options
        .aspects
        .iter()
        .map(|a| if *a == UVec3::ONE { "none".to_owned() } else { format!("{}:{}:{}", a.x, a.y, a.z) })
        .collect();
    let mut text = format!(
        "murrine lab {} --grids {} --voxelizers {} --angles {} --aspects {} --cap {} --time {} -o {}",
        options.models.iter().map(|model| quoted(model)).collect::<Vec<_>>().join(" "),
        list(&grids),
        list(&options.voxelizers),
        options.angles,
        list(&aspects),
        options.cap,
        options.time,
        quoted(&options.output.display().to_string())
    );
    if let Some(adapter) = &adapter.adapter {
        text.push_str(&format!(" --adapter {}", quoted(adapter)));
    }
    text
}

/// As a shell takes it.
fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "./_-:=,".contains(c);
    if text.chars().all(plain) { text.to_owned() } else { format!("'{}'", text.replace('\'', "'\\''")) }
}

/// On a terminal, one line that is drawn over; else a line for each grid, so that a log stays short.
struct Bar {
    drawn: bool,
    told: String,
}

impl Bar {
    fn show(&mut self, progress: Progress<'_>) {
        let Progress { done, of, body, station, way } = progress;
        if std::io::stderr().is_terminal() {
            let full = (done * BAR).checked_div(of).unwrap_or(0);
            let text =
                format!("\r\x1b[2K{}{} {done}/{of} {body} {station} {way}", "█".repeat(full), "░".repeat(BAR - full));
            // Where nobody sees it, nothing is lost.
            let _ = std::io::stderr().write_all(text.as_bytes());
            self.drawn = true;
        } else {
            let line = format!("{body} {station}");
            if line != self.told {
                tell(format_args!("{done}/{of} {line}"));
                self.told = line;
            }
        }
    }

    fn clear(&self) {
        if self.drawn {
            let _ = std::io::stderr().write_all(b"\r\x1b[2K");
        }
    }
}
