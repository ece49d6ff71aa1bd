//! Reads scenes and loads models on a thread of its own, so that the window answers meanwhile.
//!
//! One job waits at most: a newer one takes its place. Answers carry their job's number, so that a late one is known.

use crate::scene::description::Background;
use crate::scene::{Scene, SceneError, Warning, World};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, PoisonError};

/// Why something is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reason {
    /// It is to be shown instead of what is shown.
    Open,
    /// The user wants it as its files are now.
    Reload,
    /// A file of it changed.
    Changed,
    /// It is to have another background.
    Background,
}

/// What to read.
#[derive(Debug)]
pub struct Job {
    /// Counts up.
    pub number: u64,
    /// Why.
    pub reason: Reason,
    /// A scene or a model; `None` is the built-in scene.
    pub path: Option<PathBuf>,
    /// `path=value` assignments applied to it.
    pub sets: Vec<String>,
    /// The background to load instead of its own.
    pub background: Option<Background>,
    /// What is loaded already.
    pub previous: World,
}

/// A scene that can be shown.
#[derive(Debug)]
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// What it names.
    pub world: World,
    /// What was odd.
    pub warnings: Vec<Warning>,
}

/// What became of a job.
#[derive(Debug)]
pub struct Answer {
    /// Its number.
    pub number: u64,
    /// Why it was read.
    pub reason: Reason,
    /// What was read.
    pub path: Option<PathBuf>,
    /// The scene, or why there is none.
    pub result: Result<Loaded, SceneError>,
}

#[derive(Debug, Default)]
struct Inbox {
    job: Mutex<(Option<Job>, bool)>,
    came: Condvar,
}

/// The thread. It ends when this is dropped.
#[derive(Debug)]
pub struct Loader {
    inbox: Arc<Inbox>,
}

impl Loader {
    /// Starts the thread, which calls `answer` from it after each job.
    ///
    /// # Errors
    /// When the system refuses a thread.
    pub fn start(answer: impl Fn(Answer) + Send + 'static) -> std::io::Result<Self> {
        let inbox = Arc::new(Inbox::default());
        let theirs = Arc::clone(&inbox);
        std::thread::Builder::new().name("loader".to_owned()).spawn(move || {
            while let Some(job) = theirs.next() {
                let Job { number, reason, path, sets, background, previous } = job;
                let result = load(path.as_deref(), &sets, background, &previous);
                answer(Answer { number, reason, path, result });
            }
        })?;
        Ok(Self { inbox })
    }

    /// Hands over a job; one that still waits is dropped.
    pub fn request(&self, job: Job) {
        self.inbox.lock().0 = Some(job);
        self.inbox.came.notify_one();
    }
}

impl Drop for Loader {
    fn drop(&mut self) {
        self.inbox.lock().1 = true;
        self.inbox.came.notify_one();
    }
}

impl Inbox {
    fn lock(&self) -> std::sync::MutexGuard<'_, (Option<Job>, bool)> {
        self.job.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for a job; `None` when there will be none any more.
    fn next(&self) -> Option<Job> {
        let mut guard = self.lock();
        loop {
            match &mut *guard {
                (_, true) => return None,
                (Some(_), _) => return guard.0.take(),
                (None, false) => guard = self.came.wait(guard).unwrap_or_else(PoisonError::into_inner),
            }
        }
    }
}

/// Reads a scene or a model (`None`: the built-in scene), gives it another background if there is one, and loads what it
/// names.
///
/// # Errors
/// The first thing that can't be used, with place and remedy.
pub fn load(
    path: Option<&Path>,
    sets: &[String],
    background: Option<Background>,
    previous: &World,
) -> Result<Loaded, SceneError> {
    let methods: Vec<&str> = crate::voxelize::METHODS.iter().map(|m| m.name).collect();
    let (mut scene, mut warnings) = match path {
        Some(path) => crate::scene::file::read(path, sets, &methods)?,
        None => (super::fallback::scene(), Vec::new()),
    };
    if let Some(background) = background {
        scene.background = background;
    }
    let world = World::load(&scene, Some(previous))?;
    crate::scene::framing::frame(&mut scene, &world);
    warnings.extend(world.warnings.iter().cloned());
    Ok(Loaded { scene, world, warnings })
}
