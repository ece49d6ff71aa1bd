//! Golden frames: pictures that the program must make again, kept in `screenshots/`.
//!
//! `goldens.toml` lists them; beside each `name.png` stands `name.toml`, which says what it was made with. Each entry
//! names a *control*: an assignment that turns its own effect off. A golden that its control leaves as it is shows
//! nothing, so it is not blessed.

use crate::compose::DebugView;
use crate::frame::Frame;
use crate::gpu::{Gpu, GpuError};
use crate::headless::{self, Still};
use crate::image::{self, ImageError, Picture};
use crate::march::Channel;
use crate::scene::SceneError;
use glam::UVec2;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// By how much a component may be off without being counted.
pub const TOLERANCE: u8 = 2;
/// The share of pixels that may be off by more.
pub const ALLOWED_SHARE: f64 = 0.001;

/// The file that lists the goldens.
const LIST: &str = "goldens.toml";

/// What can go wrong with golden frames.
#[derive(Debug, thiserror::Error)]
pub enum GoldenError {
    /// The list or a sidecar can't be used.
    #[error("{}: {what}", .path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// What is wrong, and what to do.
        what: String,
    },
    /// A name that no golden has.
    #[error("there is no golden `{name}`; choose {known}")]
    Unknown {
        /// As given.
        name: String,
        /// Those there are.
        known: String,
    },
    /// Goldens are made on lavapipe, whose pictures everyone can make again.
    #[error("golden frames are made on lavapipe, not on `{0}`; add --adapter software")]
    NotLavapipe(String),
    /// The control changes nothing.
    #[error("golden `{name}`: its control `{control}` changes nothing, so it shows nothing; choose another control")]
    Blind {
        /// Which.
        name: String,
        /// Its control.
        control: String,
    },
    /// From the scene.
    #[error("{0}")]
    Scene(#[from] SceneError),
    /// From the device.
    #[error("{0}")]
    Gpu(#[from] GpuError),
    /// From a picture's file.
    #[error("{0}")]
    Image(#[from] ImageError),
}

/// A golden frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Golden {
    /// Its files are `name.png` and `name.toml`.
    pub name: String,
    /// What it shows, for the README.
    pub about: String,
    /// What it is made of.
    pub settings: Settings,
    /// The assignment that turns its own effect off.
    pub control: String,
}

/// What a golden is made of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// The scene, relative to the folder that holds `screenshots/`.
    pub scene: PathBuf,
    /// Pixels.
    pub size: [u32; 2],
    /// Seconds.
    #[serde(default)]
    pub time_secs: f64,
    /// Assignments to the scene's text.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sets: Vec<String>,
}

/// What a golden was made with, kept beside it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sidecar {
    /// The adapter's name.
    pub adapter: String,
    /// The driver's name and its version: for lavapipe, Mesa's.
    pub driver: String,
    /// This program's version.
    pub murrine: String,
    /// What it is made of.
    pub settings: Settings,
}

/// The goldens of a `screenshots/` folder.
#[derive(Debug)]
pub struct Goldens {
    folder: PathBuf,
    /// All entries, in the order of the list.
    pub entries: Vec<Golden>,
}

/// How two pictures differ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// The share of pixels that are off by more than [`TOLERANCE`].
    pub share: f64,
    /// The largest difference of a component.
    pub largest: u8,
}

impl Difference {
    /// True where the pictures pass for the same.
    #[must_use]
    pub fn passes(&self) -> bool {
        self.share <= ALLOWED_SHARE
    }
}

/// Compares two pictures; those of different sizes differ in every pixel.
#[must_use]
pub fn compare(a: &Picture, b: &Picture) -> Difference {
    if (a.width, a.height) != (b.width, b.height) || a.rgb8.is_empty() {
        return Difference { share: 1.0, largest: 255 };
    }
    let off = |(a, b): (&[u8; 3], &[u8; 3])| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
    let (mut over, mut largest) = (0_usize, 0);
    for off in a.rgb8.iter().zip(&b.rgb8).map(off) {
        over += usize::from(off > TOLERANCE);
        largest = largest.max(off);
    }
    #[expect(clippy::cast_precision_loss, reason = "pictures have fewer than 2^52 pixels")]
    let share = over as f64 / a.rgb8.len() as f64;
    Difference { share, largest }
}

/// Where two pictures of one size differ: grey by how much, eight times enlarged; red where it counts.
#[must_use]
pub fn difference_picture(a: &Picture, b: &Picture) -> Picture {
    let pixel = |(a, b): (&[u8; 3], &[u8; 3])| {
        let off = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
        if off > TOLERANCE { [255, off.saturating_mul(8) / 2, 60] } else { [off.saturating_mul(8); 3] }
    };
    Picture { width: a.width, height: a.height, rgb8: a.rgb8.iter().zip(&b.rgb8).map(pixel).collect() }
}

/// What came of one golden.
#[derive(Debug, Clone, PartialEq)]
pub enum Verdict {
    /// It was made again.
    Same(Difference),
    /// It was not; the text says what to look at.
    Different(Difference, String),
    /// There is none, or it was made from other settings; the text says how to make it.
    Missing(String),
}

impl Goldens {
    /// Reads the list of a `screenshots/` folder.
    ///
    /// # Errors
    /// When it is missing or wrong.
    pub fn open(folder: &Path) -> Result<Self, GoldenError> {
        let path = folder.join(LIST);
        let error = |what: String| GoldenError::File { path: path.clone(), what };
        let text = std::fs::read_to_string(&path).map_err(|e| error(format!("can't read it: {e}")))?;
        let list: List = toml::from_str(&text).map_err(|e| error(format!("{}; mend it", e.to_string().trim())))?;
        let entries: Vec<Golden> = list.golden.into_iter().map(Golden::from).collect();
        for (i, golden) in entries.iter().enumerate() {
            let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
            if golden.name.is_empty() || !golden.name.chars().all(plain) || golden.name == "goldens" {
                return Err(error(format!("`{}` is no name for a golden; use a-z, 0-9 and -", golden.name)));
            }
            if entries[..i].iter().any(|earlier| earlier.name == golden.name) {
                return Err(error(format!("two goldens are called `{}`; rename one", golden.name)));
            }
            if golden.settings.size.iter().any(|side| !(1..=4096).contains(side)) {
                return Err(error(format!("`{}` has a side outside 1 to 4096 pixels", golden.name)));
            }
        }
        Ok(Self { folder: folder.to_owned(), entries })
    }

    /// The entries of these names; all where there is no name.
    ///
    /// # Errors
    /// When a name is unknown.
    pub fn named(&self, names: &[String]) -> Result<Vec<&Golden>, GoldenError> {
        if names.is_empty() {
            return Ok(self.entries.iter().collect());
        }
        let find = |name: &String| {
            self.entries.iter().find(|golden| golden.name == *name).ok_or_else(|| GoldenError::Unknown {
                name: name.clone(),
                known: self.entries.iter().map(|golden| golden.name.as_str()).collect::<Vec<_>>().join(", "),
            })
        };
        names.iter().map(find).collect()
    }

    /// Where a golden's picture stands.
    #[must_use]
    pub fn picture_path(&self, golden: &Golden) -> PathBuf {
        self.folder.join(format!("{}.png", golden.name))
    }

    /// Where the note beside it stands.
    #[must_use]
    pub fn sidecar_path(&self, golden: &Golden) -> PathBuf {
        self.folder.join(format!("{}.toml", golden.name))
    }

    /// Renders a golden's frame, with further assignments.
    ///
    /// # Errors
    /// What is wrong with its scene or the device.
    pub fn render(
        &self,
        gpu: &Gpu,
        frame: &mut Frame,
        golden: &Golden,
        further: &[String],
    ) -> Result<Picture, GoldenError> {
        let Settings { scene, size, time_secs, sets } = &golden.settings;
        let path = self.folder.parent().unwrap_or(Path::new("")).join(scene);
        let sets: Vec<String> = sets.iter().chain(further).cloned().collect();
        let (scene, world, _) = headless::open(&path, &sets)?;
        let still = Still {
            scene: &scene,
            world: &world,
            time_secs: *time_secs,
            size: UVec2::from_array(*size),
            antialias: false,
            channel: Channel::Beauty,
            view: DebugView::None,
        };
        headless::render(gpu, frame, &still)?;
        Ok(headless::picture(gpu, frame)?)
    }

    /// Renders a golden's frame and compares. Where they differ, the picture and the difference are written into
    /// `failures`.
    ///
    /// # Errors
    /// When it can't be rendered, or its files can't be read or written.
    pub fn check(
        &self,
        gpu: &Gpu,
        frame: &mut Frame,
        golden: &Golden,
        failures: &Path,
    ) -> Result<Verdict, GoldenError> {
        let remedy = format!("make it with: murrine golden update {}", golden.name);
        let path = self.picture_path(golden);
        if !path.is_file() {
            return Ok(Verdict::Missing(format!("{} is missing; {remedy}", path.display())));
        }
        if self.sidecar(golden).map(|sidecar| sidecar.settings).as_ref() != Some(&golden.settings) {
            let sidecar = self.sidecar_path(golden);
            return Ok(Verdict::Missing(format!("{} does not say the list's settings; {remedy}", sidecar.display())));
        }
        let wanted = image::read_png(&path)?;
        let actual = self.render(gpu, frame, golden, &[])?;
        let difference = compare(&wanted, &actual);
        if difference.passes() {
            return Ok(Verdict::Same(difference));
        }
        make_folder(failures)?;
        let file = |what: &str| failures.join(format!("{}.{what}.png", golden.name));
        image::write_png(&file("actual"), &actual)?;
        image::write_png(&file("difference"), &difference_picture(&wanted, &actual))?;
        Ok(Verdict::Different(difference, format!("look at {} and beside it", file("difference").display())))
    }

    /// What a golden was made with, where its sidecar can be read.
    #[must_use]
    pub fn sidecar(&self, golden: &Golden) -> Option<Sidecar> {
        toml::from_str(&std::fs::read_to_string(self.sidecar_path(golden)).ok()?).ok()
    }

    /// Makes a golden anew: on lavapipe only, and only where its control changes the picture.
    ///
    /// # Errors
    /// When it may not be blessed, can't be rendered or can't be written.
    pub fn bless(&self, gpu: &Gpu, frame: &mut Frame, golden: &Golden) -> Result<(), GoldenError> {
        if !is_lavapipe(&gpu.info) {
            return Err(GoldenError::NotLavapipe(gpu.info.name.clone()));
        }
        let picture = self.render(gpu, frame, golden, &[])?;
        if !self.control_shows(gpu, frame, golden, &picture)? {
            return Err(GoldenError::Blind { name: golden.name.clone(), control: golden.control.clone() });
        }
        let sidecar = Sidecar {
            adapter: gpu.info.name.clone(),
            driver: format!("{} {}", gpu.info.driver, gpu.info.driver_info),
            murrine: env!("CARGO_PKG_VERSION").to_owned(),
            settings: golden.settings.clone(),
        };
        let path = self.sidecar_path(golden);
        let text =
            toml::to_string(&sidecar).map_err(|e| GoldenError::File { path: path.clone(), what: e.to_string() })?;
        let text = format!("# What {}.png was made with; `murrine golden update` writes this.\n{text}", golden.name);
        image::write_png(&self.picture_path(golden), &picture)?;
        image::atomically(&path, |to| std::io::Write::write_all(to, text.as_bytes()))?;
        Ok(())
    }

    /// True where turning the golden's own effect off makes another picture of `picture`.
    ///
    /// # Errors
    /// When it can't be rendered.
    pub fn control_shows(
        &self,
        gpu: &Gpu,
        frame: &mut Frame,
        golden: &Golden,
        picture: &Picture,
    ) -> Result<bool, GoldenError> {
        let off = self.render(gpu, frame, golden, std::slice::from_ref(&golden.control))?;
        Ok(!compare(picture, &off).passes())
    }
}

/// The file that lists the goldens.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    golden: Vec<Entry>,
}

/// An entry of the list, as it is written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: String,
    about: String,
    scene: PathBuf,
    size: [u32; 2],
    #[serde(default)]
    time_secs: f64,
    #[serde(default)]
    sets: Vec<String>,
    control: String,
}

impl From<Entry> for Golden {
    fn from(entry: Entry) -> Self {
        let Entry { name, about, scene, size, time_secs, sets, control } = entry;
        Self { name, about, settings: Settings { scene, size, time_secs, sets }, control }
    }
}

/// True for Mesa's software adapter.
#[must_use]
pub fn is_lavapipe(info: &wgpu::AdapterInfo) -> bool {
    info.device_type == wgpu::DeviceType::Cpu && (info.driver.contains("llvmpipe") || info.name.contains("llvmpipe"))
}

fn make_folder(folder: &Path) -> Result<(), GoldenError> {
    let error = |e: std::io::Error| GoldenError::File { path: folder.to_owned(), what: format!("can't make it: {e}") };
    std::fs::create_dir_all(folder).map_err(error)
}
