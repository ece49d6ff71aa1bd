//! The laboratory in the window: another method beside the scene's own, with a wipe between them, and both held against
//! the truth of this very frame, which a thread of its own works out once things have come to rest.

use super::session::Session;
use crate::animate::Triangles;
use crate::gpu::{Gpu, GpuError};
use crate::grid::Grid;
use crate::marking::{Faults, Marking};
use crate::scene::Scene;
use crate::scene::description::VoxelizerSettings;
use crate::voxelize::method;

/// Timed rounds of each method; the first, which compiles, is not among them.
const ROUNDS: usize = 3;

/// What is compared, and what came of it.
#[derive(Debug)]
pub struct Laboratory {
    /// The method at the right of the wipe, if there is one.
    pub beside: Option<String>,
    /// Where the wipe stands, 0 to 1 across the picture.
    pub wipe: f32,
    /// Voxels are held against the truth.
    pub holds: bool,
    /// The last answer.
    pub held: Option<Held>,
    /// What the thread works on.
    pub asked: Option<Key>,
}

impl Default for Laboratory {
    fn default() -> Self {
        Self { beside: None, wipe: 0.5, holds: false, held: None, asked: None }
    }
}

/// All that voxels depend on.
#[derive(Debug, Clone, PartialEq)]
pub struct Key {
    scene: Scene,
    world_number: u64,
    time_bits: u64,
    beside: Option<String>,
}

impl Key {
    /// Of what is shown now.
    #[must_use]
    pub fn of(session: &Session, time_secs: f64) -> Self {
        let (scene, beside) = (session.scene.clone(), session.laboratory.beside.clone());
        Self { scene, world_number: session.world_number, time_bits: time_secs.to_bits(), beside }
    }
}

/// A method's figures.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Its name.
    pub method: String,
    /// Milliseconds of marking the view's grid.
    pub ms: f64,
    /// Against the truth.
    pub faults: Faults,
}

/// What a frame's voxels came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Held {
    /// Of which frame.
    pub key: Key,
    /// The true words of the view's grid.
    pub truth: Vec<u32>,
    /// The scene's own method, then that beside it.
    pub lines: Vec<Line>,
}

impl Laboratory {
    /// The answer, where it is about what is shown.
    #[must_use]
    pub fn held_of(&self, key: &Key) -> Option<&Held> {
        self.held.as_ref().filter(|held| held.key == *key)
    }

    /// The settings of the method at the right: the scene's, as far as that method takes them.
    #[must_use]
    pub fn settings_beside(&self, of_scene: &VoxelizerSettings) -> Option<VoxelizerSettings> {
        let name = self.beside.clone()?;
        let mut settings = VoxelizerSettings { method: name, ..of_scene.clone() };
        if method(&settings.method).is_ok_and(|m| !m.conservative.contains(&settings.conservative)) {
            settings.conservative = Default::default();
        }
        Some(settings)
    }
}

/// What a thread is to work out.
#[derive(Debug)]
pub(super) struct Job {
    pub(super) key: Key,
    pub(super) gpu: Gpu,
    /// Those of the frame, that stay as they are.
    pub(super) triangles: Triangles,
    pub(super) grid: Grid,
    pub(super) settings: Vec<VoxelizerSettings>,
}

impl Job {
    /// Marks the grid by each method, times it and counts its faults. Waits for the device: never on the window's thread.
    pub(super) fn run(self) -> Result<Held, GpuError> {
        let Self { key, gpu, triangles, grid, settings } = self;
        let mut marking = Marking::of(&gpu, triangles)?;
        marking.put(&gpu, grid)?;
        let of_scene = settings.first().map_or_else(Default::default, |s| s.separability);
        let truth = marking.truth(of_scene);
        let mut lines = Vec::new();
        for settings in settings {
            let mut compiled = marking.compile(&gpu, method(&settings.method)?)?;
            marking.mark(&gpu, &mut compiled, &settings)?;
            let mut ms =
                (0..ROUNDS).map(|_| marking.mark(&gpu, &mut compiled, &settings)).collect::<Result<Vec<f64>, _>>()?;
            ms.sort_by(f64::total_cmp);
            let faults = marking.faults(&gpu, &truth)?;
            lines.push(Line { method: settings.method, ms: ms[ROUNDS / 2], faults });
        }
        Ok(Held { key, truth: truth.words, lines })
    }
}
