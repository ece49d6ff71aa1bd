//! The window: shows a scene, plays it, lets everything about it be changed.
//!
//! [`session`] is what is open and what is done to it; [`panels`] show and change it; [`pictures`] keeps one frame in
//! flight at a [`resolution`] that holds the frame time, and the sharp one in [`parts`]; [`painter`] puts it on the screen; [`shell`] is the event loop
//! that holds them together. [`actions`] is the one table of what the window can be told to do.

pub mod actions;
pub mod fallback;
pub mod history;
pub mod laboratory;
pub mod loader;
pub mod notices;
pub mod orbit;
pub mod painter;
pub mod panels;
pub mod parts;
pub mod pictures;
pub mod resolution;
pub mod screenshot;
pub mod session;
pub mod shell;
pub mod theme;
pub mod timeline;
pub mod view;
pub mod watch;
mod window;

use crate::gpu::{AdapterChoice, GpuError};
use std::path::{Path, PathBuf};

/// Our best scene, where the program is run from its own folder.
const BEST_SCENE: &str = "scenes/fish.toml";

/// What the window opens with.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// A scene or a model; `None`: our best scene.
    pub scene: Option<PathBuf>,
    /// `path=value` assignments applied to that scene.
    pub sets: Vec<String>,
    /// The adapter.
    pub adapter: AdapterChoice,
    /// A folder of shaders to use, and to compile again when they change, instead of those built in; `None`: `shaders`
    /// in the current folder, if it is ours.
    pub shaders: Option<PathBuf>,
    /// For tests: ends after so many paintings.
    pub quit_after: Option<u64>,
}

/// Why the window did not open, or had to close.
#[derive(Debug, thiserror::Error)]
pub enum AppError {
    /// There is no display.
    #[error("no window can be opened: {0}; set DISPLAY or WAYLAND_DISPLAY, or use `murrine render`, which needs none")]
    NoDisplay(String),
    /// The graphics device.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The system.
    #[error("the system refused {0}")]
    System(String),
    /// Another of these, after which the unsaved edits were written.
    #[error("{error}; the unsaved edits are in {}", path.display())]
    Rescued {
        /// What happened.
        error: Box<AppError>,
        /// Where the edits are.
        path: PathBuf,
    },
}

/// Opens the window and returns when it is closed.
///
/// # Errors
/// When there is no display or no usable adapter.
pub fn run(mut options: Options) -> Result<(), AppError> {
    if options.scene.is_none() && Path::new(BEST_SCENE).is_file() {
        options.scene = Some(PathBuf::from(BEST_SCENE));
    }
    if options.shaders.is_none() {
        let ours = Path::new("shaders");
        options.shaders = ours.join("lib/grid.inc.wgsl").is_file().then(|| ours.to_owned());
    }
    shell::run(options)
}
