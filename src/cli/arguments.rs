//! What the command line takes. Scene keys are set by their own flags or by `--set`; both end as assignments.

use crate::gpu::AdapterChoice;
use crate::headless;
use crate::march::Channel;
use crate::scene::description::{CELLS, Conservative, Hit, Refraction};
use crate::scene::words::{Words, nearest};
use clap::{Args, Parser, Subcommand};
use glam::{DVec3, UVec2, UVec3};
use std::path::PathBuf;

/// Moving glass, made of voxels every frame. Opens a window on a scene (.toml) or a model (.glb, .gltf, .npz).
#[derive(Debug, Parser)]
#[command(version, args_conflicts_with_subcommands = true)]
pub(super) struct Arguments {
    /// The scene or model to open in the window; our best scene if there is none
    pub(super) path: Option<PathBuf>,
    /// Change the scene: path=value, such as effect.max_events=4 or model.0.material.0.ior=1.3
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(super) sets: Vec<String>,
    /// For tests: close the window after so many paintings
    #[arg(long, hide = true)]
    pub(super) quit_after: Option<u64>,
    #[command(flatten)]
    pub(super) adapter: Adapter,
    #[command(subcommand)]
    pub(super) command: Option<Command>,
}

#[derive(Debug, Args)]
pub(super) struct Adapter {
    /// Part of an adapter's name, or `software`; the fastest one if left out
    #[arg(long, value_name = "NAME", global = true)]
    pub(super) adapter: Option<String>,
}

impl Adapter {
    pub(super) fn choice(&self) -> AdapterChoice {
        match self.adapter.as_deref() {
            None => AdapterChoice::Fastest,
            Some("software") => AdapterChoice::Software,
            Some(name) => AdapterChoice::Named(name.to_owned()),
        }
    }
}

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Render one picture or float channel to a file
    Render(Render),
    /// Voxelize a model into a world-axis-aligned array
    Voxelize(Voxelize),
    /// List voxelizers, effects, channels, shapes and the words of every choice
    List(List),
    /// Read scenes and models and say what is wrong with them
    Check {
        /// Scenes or models
        #[arg(required = true)]
        scenes: Vec<PathBuf>,
    },
    /// Say what this machine's adapter and driver are, and what will and won't work
    Doctor,
    /// Time the stages: milliseconds as medians with their spread, and the volume's memory
    Bench(Bench),
    /// Measure every voxelizer on models: one page of plots and tables, and one CSV
    Lab(Lab),
    /// Golden frames: pictures that must be made again as they are in screenshots/
    Golden(Golden),
}

#[derive(Debug, Args)]
pub(super) struct Bench {
    /// Scenes or models to time beside our own cases; or `storage`: dense volumes and lists beside our records; or
    /// `voxelize`: every voxelizer on 1 to 871,000 triangles beside the CPU's own test
    pub(super) scenes: Vec<PathBuf>,
    /// Write JSON instead of a table
    #[arg(long)]
    pub(super) json: bool,
    /// Time `hybrid` by cut-off instead (Rauwendaal & Bailey, Figs. 13 and 14): on our bodies, or the scenes given
    #[arg(long)]
    pub(super) cutoffs: bool,
    /// Timed iterations of each case
    #[arg(long, value_name = "N", default_value_t = 15, value_parser = clap::value_parser!(u32).range(3..=1000))]
    pub(super) iterations: u32,
    /// Only the cases whose name contains this text
    #[arg(long, value_name = "TEXT")]
    pub(super) only: Option<String>,
}

#[derive(Debug, Args)]
pub(super) struct Lab {
    /// Models or scenes; or our own shapes, such as shape:torus or shape:icosphere,subdivisions=5
    #[arg(required = true, value_name = "MODEL")]
    pub(super) models: Vec<String>,
    /// The folder for report.html and report.csv; made if its parent is there
    #[arg(short, long, value_name = "FOLDER")]
    pub(super) output: PathBuf,
    /// Cells along each axis, 16 to 512
    #[arg(long, value_name = "N,...", value_delimiter = ',', default_value = "32,64,128,256",
        value_parser = clap::value_parser!(u32).range(16..=512))]
    pub(super) grids: Vec<u32>,
    /// Which methods; `murrine list voxelizers`
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', default_value = "all", value_parser = voxelizer_or_all)]
    pub(super) voxelizers: Vec<String>,
    /// Measure from so many directions, too
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(0..=64))]
    pub(super) angles: u32,
    /// Measure in grids of these proportions, too; `none` for no others than cubes
    #[arg(long, value_name = "X:Y:Z,...", value_delimiter = ',', default_value = "4:4:1,2:2:1,1:1:2,1:1:4",
        value_parser = aspect)]
    pub(super) aspects: Vec<UVec3>,
    /// What would take longer than this is left out, and so is told
    #[arg(long, value_name = "SECS", default_value_t = 20.0, value_parser = cap)]
    pub(super) cap: f64,
    /// Seconds into the animation
    #[arg(long, value_name = "SECS", value_parser = time, default_value_t = 0.0, allow_negative_numbers = true)]
    pub(super) time: f64,
}

#[derive(Debug, Args)]
pub(super) struct Golden {
    #[command(subcommand)]
    pub(super) work: GoldenWork,
    /// The folder of the golden frames
    #[arg(long, default_value = "screenshots", global = true)]
    pub(super) folder: PathBuf,
}

#[derive(Debug, Subcommand)]
pub(super) enum GoldenWork {
    /// Render each and compare; exit code 1 when one differs or is missing
    Run {
        /// Which; all if left out
        names: Vec<String>,
    },
    /// Render each and keep it, on lavapipe only
    Update {
        /// Which; all if left out
        names: Vec<String>,
    },
    /// List them, and what each was made with
    List,
}

/// Flags that change the scene.
#[derive(Debug, Args)]
pub(super) struct SceneFlags {
    /// Cells of the view's grid: along the longest axis, or XxYxZ
    #[arg(long, value_name = "N|XxYxZ")]
    pub(super) grid: Option<String>,
    /// The voxelizer; `murrine list voxelizers`
    #[arg(long, value_name = "NAME", value_parser = voxelizer)]
    pub(super) voxelizer: Option<String>,
    /// How rays bend; `murrine list refraction`
    #[arg(long, value_name = "NAME", value_parser = word::<Refraction>)]
    pub(super) refraction: Option<String>,
    /// How a ray meets the volume: surfel or voxel
    #[arg(long, value_name = "NAME", value_parser = word::<Hit>)]
    pub(super) hit: Option<String>,
    /// Change the scene: path=value, such as effect.max_events=4; repeatable, later ones win
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(super) sets: Vec<String>,
}

impl SceneFlags {
    /// The flags as assignments in scene text.
    pub(super) fn assignments(&self) -> Vec<String> {
        let grid = self.grid.as_ref().map(|grid| match grid.contains(['x', 'X']) {
            true => format!("grid.cells=[{}]", grid.replace(['x', 'X'], ", ")),
            false => format!("grid.cells={grid}"),
        });
        let quoted = |key: &str, value: &Option<String>| value.as_ref().map(|value| format!("{key}=\"{value}\""));
        let flags = [
            grid,
            quoted("voxelizer.method", &self.voxelizer),
            quoted("effect.refraction", &self.refraction),
            quoted("effect.hit", &self.hit),
        ];
        flags.into_iter().flatten().chain(self.sets.iter().cloned()).collect()
    }
}

#[derive(Debug, Args)]
pub(super) struct Render {
    /// A scene (.toml) or a model (.glb, .gltf, .npz)
    pub(super) scene: PathBuf,
    /// The file to write: .png (8-bit sRGB), .exr or .npy (linear floats)
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: PathBuf,
    /// Pixels
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "768x512")]
    pub(super) size: UVec2,
    /// Seconds into the animation
    #[arg(long, value_name = "SECS", value_parser = time, default_value_t = 0.0, allow_negative_numbers = true)]
    pub(super) time: f64,
    /// What to write; `murrine list channels`
    #[arg(long, value_name = "NAME", value_parser = channel, default_value = "beauty")]
    pub(super) channel: Channel,
    /// Say what was chosen on the way
    #[arg(short, long)]
    pub(super) verbose: bool,
    /// Four rays a pixel: smooth outlines and calm glass
    #[arg(long)]
    pub(super) antialias: bool,
    #[command(flatten)]
    pub(super) scene_flags: SceneFlags,
}

#[derive(Debug, Args)]
pub(super) struct Voxelize {
    /// A model (.glb, .gltf, .npz) or a scene (.toml)
    pub(super) model: PathBuf,
    /// The file to write: .npy (a u8 array [z][y][x]), .npz (all of it, to be shown again), .vti, .nrrd, .vox or .ply
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: PathBuf,
    /// Cells along each axis: N for a cube, or XxYxZ; 1 to 1024
    #[arg(long, value_name = "N|XxYxZ", value_parser = cells)]
    pub(super) grid: UVec3,
    /// Lower corner of cell (0, 0, 0), world; fitted to the model if left out
    #[arg(long, value_name = "X,Y,Z", value_parser = point, requires = "cell", allow_hyphen_values = true)]
    pub(super) origin: Option<DVec3>,
    /// Side of a cell, world units
    #[arg(long, value_name = "SIDE", value_parser = side, requires = "origin")]
    pub(super) cell: Option<f64>,
    /// The voxelizer; `murrine list voxelizers`
    #[arg(long, value_name = "NAME", value_parser = voxelizer)]
    pub(super) voxelizer: Option<String>,
    /// 26: every cell that a surface touches; 6: thin
    #[arg(long, value_name = "26|6", value_parser = ["26", "6"])]
    pub(super) separability: Option<String>,
    /// Which columns a triangle reaches, for rasterizing methods; `murrine list conservative`
    #[arg(long, value_name = "NAME", value_parser = word::<Conservative>)]
    pub(super) conservative: Option<String>,
    /// Mark every slice that a triangle's plane reaches over a column, for rasterizing methods
    #[arg(long)]
    pub(super) conservative_depth: bool,
    /// The cells whose centre is inside too; .npy, .nrrd and .vox hold them instead of the surface
    #[arg(long)]
    pub(super) solid: bool,
    /// Seconds into the animation
    #[arg(long, value_name = "SECS", value_parser = time, default_value_t = 0.0, allow_negative_numbers = true)]
    pub(super) time: f64,
    /// Change the scene: path=value
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(super) sets: Vec<String>,
}

#[derive(Debug, Args)]
pub(super) struct List {
    /// One of the lists; all if left out
    pub(super) what: Option<String>,
    /// The voxelizers as the table of docs/gallery.md
    #[arg(long, conflicts_with = "what")]
    pub(super) markdown: bool,
}

/// The most pixels of a picture along an axis, and in all.
const MOST_PIXELS: (u32, u64) = (8192, 8192 * 4320);

fn size(text: &str) -> Result<UVec2, String> {
    let (w, h) = text.split_once(['x', 'X']).ok_or("write WIDTHxHEIGHT, such as 768x512")?;
    let side = |text: &str| match text.trim().parse::<u32>() {
        Ok(side) if (1..=MOST_PIXELS.0).contains(&side) => Ok(side),
        _ => Err(format!("`{text}` is no width or height; write 1 to {}", MOST_PIXELS.0)),
    };
    let size = UVec2::new(side(w)?, side(h)?);
    if u64::from(size.x) * u64::from(size.y) > MOST_PIXELS.1 {
        return Err(format!("{size} is more than {} pixels in all; choose a smaller picture", MOST_PIXELS.1));
    }
    Ok(size)
}

fn time(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(secs) if (0.0..=1e6).contains(&secs) => Ok(secs),
        _ => Err("write seconds from 0 to 1000000".to_owned()),
    }
}

fn cells(text: &str) -> Result<UVec3, String> {
    let parts: Vec<&str> = text.split(['x', 'X']).collect();
    let count = |text: &str| match text.trim().parse::<u32>() {
        Ok(count) if (1..=*CELLS.end()).contains(&count) => Ok(count),
        _ => Err(format!("`{text}` cells; write 1 to {}", CELLS.end())),
    };
    match parts.as_slice() {
        [all] => Ok(UVec3::splat(count(all)?)),
        [x, y, z] => Ok(UVec3::new(count(x)?, count(y)?, count(z)?)),
        _ => Err("write N or XxYxZ, such as 128 or 128x64x256".to_owned()),
    }
}

fn point(text: &str) -> Result<DVec3, String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    match numbers.as_slice() {
        [x, y, z] if text.matches(',').count() == 2 && numbers.iter().all(|n| n.abs() <= 1e6) => {
            Ok(DVec3::new(*x, *y, *z))
        }
        [_, _, _] => Err("write three numbers, X,Y,Z, each within ±1000000".to_owned()),
        _ => Err("write three numbers, X,Y,Z".to_owned()),
    }
}

fn side(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(side) if (1e-9..=1e6).contains(&side) => Ok(side),
        _ => Err("write a length above 0, at most 1000000".to_owned()),
    }
}

fn channel(text: &str) -> Result<Channel, String> {
    let names = || Channel::ALL.iter().map(|(_, name, _)| *name);
    let found = Channel::ALL.iter().find(|(_, name, _)| *name == text);
    found.map(|(channel, ..)| *channel).ok_or_else(|| choose(text, &names().collect::<Vec<_>>()))
}

fn voxelizer(text: &str) -> Result<String, String> {
    let names = headless::methods();
    if names.contains(&text) { Ok(text.to_owned()) } else { Err(choose(text, &names)) }
}

fn voxelizer_or_all(text: &str) -> Result<String, String> {
    if text == "all" { Ok(text.to_owned()) } else { voxelizer(text).map_err(|e| format!("{e}; or all")) }
}

/// Proportions of a grid; ones for `none`, which are those of a cube.
fn aspect(text: &str) -> Result<UVec3, String> {
    if text == "none" {
        return Ok(UVec3::ONE);
    }
    let numbers: Vec<u32> = text.split(':').filter_map(|n| n.trim().parse().ok()).collect();
    match numbers.as_slice() {
        [x, y, z] if text.matches(':').count() == 2 && numbers.iter().all(|n| (1..=16).contains(n)) => {
            Ok(UVec3::new(*x, *y, *z))
        }
        _ => Err("write X:Y:Z, each 1 to 16, such as 1:1:4; or none".to_owned()),
    }
}

fn cap(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(secs) if (1e-3..=86_400.0).contains(&secs) => Ok(secs),
        _ => Err("write seconds from 0.001 to 86400".to_owned()),
    }
}

fn word<T: Words>(text: &str) -> Result<String, String> {
    let words = T::words();
    if words.contains(&text) { Ok(text.to_owned()) } else { Err(choose(text, &words)) }
}

/// The remedy for a name that is none of the choices.
pub(super) fn choose(given: &str, names: &[&str]) -> String {
    match nearest(given, names.iter().copied()) {
        Some(near) => format!("did you mean `{near}`? Choose {}", names.join(", ")),
        None => format!("choose {}", names.join(", ")),
    }
}
