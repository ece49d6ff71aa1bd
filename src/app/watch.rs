//! Watches the files that are shown, and the shaders' folder, for changes.
//!
//! Folders are watched rather than files: editors write a new file and rename it over the old one.

use notify_debouncer_full::notify::{Error, EventKind, RecommendedWatcher, RecursiveMode};
use notify_debouncer_full::{DebounceEventResult, Debouncer, RecommendedCache, new_debouncer};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Changes that come within this time are told together.
const SETTLE: Duration = Duration::from_millis(120);

/// What changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// The scene, or a file that it names.
    Scene,
    /// A shader.
    Shader,
}

#[derive(Debug, Default)]
struct Interest {
    files: BTreeSet<PathBuf>,
    shaders: Option<PathBuf>,
}

/// The watcher. It ends when this is dropped.
#[derive(Debug)]
pub struct Watcher {
    debouncer: Debouncer<RecommendedWatcher, RecommendedCache>,
    interest: Arc<Mutex<Interest>>,
    folders: BTreeSet<PathBuf>,
}

impl Watcher {
    /// Starts to watch; `changed` is called from the watcher's thread.
    ///
    /// # Errors
    /// What the system says when it can't watch.
    pub fn start(changed: impl Fn(Change) + Send + 'static) -> Result<Self, String> {
        let interest = Arc::new(Mutex::new(Interest::default()));
        let theirs = Arc::clone(&interest);
        let handler = move |result: DebounceEventResult| {
            // What could not be read of one change will show at the next; F5 reads in any case.
            let Ok(events) = result else { return };
            let interest = theirs.lock().unwrap_or_else(PoisonError::into_inner);
            let touched = events.iter().filter(|e| !matches!(e.kind, EventKind::Access(_))).flat_map(|e| &e.paths);
            let (mut scene, mut shader) = (false, false);
            for path in touched {
                scene |= interest.files.contains(path);
                shader |= interest.shaders.as_ref().is_some_and(|s| path.starts_with(s) && is_shader(path));
            }
            drop(interest);
            if scene {
                changed(Change::Scene);
            }
            if shader {
                changed(Change::Shader);
            }
        };
        let debouncer = new_debouncer(SETTLE, None, handler).map_err(|e| told(&e))?;
        Ok(Self { debouncer, interest, folders: BTreeSet::new() })
    }

    /// Watches these files instead of those before.
    ///
    /// # Errors
    /// What the system says of a folder that it can't watch; the others are watched.
    pub fn watch_files(&mut self, files: impl IntoIterator<Item = PathBuf>) -> Result<(), String> {
        let files: BTreeSet<PathBuf> = files.into_iter().filter_map(|f| absolute(&f)).collect();
        let folders: BTreeSet<PathBuf> = files.iter().filter_map(|f| f.parent().map(Path::to_owned)).collect();
        self.lock().files = files;
        let mut failed = Vec::new();
        for gone in self.folders.difference(&folders) {
            // A folder that is gone can't be left.
            let _ = self.debouncer.unwatch(gone);
        }
        for new in folders.difference(&self.folders) {
            if let Err(e) = self.debouncer.watch(new, RecursiveMode::NonRecursive) {
                failed.push(told(&e));
            }
        }
        self.folders = folders;
        if failed.is_empty() { Ok(()) } else { Err(failed.join("; ")) }
    }

    /// Watches a folder of shaders.
    ///
    /// # Errors
    /// What the system says when it can't.
    pub fn watch_shaders(&mut self, folder: &Path) -> Result<(), String> {
        let Ok(folder) = folder.canonicalize() else { return Ok(()) };
        self.debouncer.watch(&folder, RecursiveMode::Recursive).map_err(|e| told(&e))?;
        self.lock().shaders = Some(folder);
        Ok(())
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Interest> {
        self.interest.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn told(error: &Error) -> String {
    format!("files can't be watched: {error}; F5 reads them again")
}

fn is_shader(path: &Path) -> bool {
    path.extension().is_some_and(|e| e == "wgsl")
}

/// The path as the watcher will tell it: its folder resolved, its own name kept, whether or not it is there now.
fn absolute(file: &Path) -> Option<PathBuf> {
    let folder = match file.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    Some(folder.canonicalize().ok()?.join(file.file_name()?))
}
