//! What is open and what is done to it: the scene, its models, time, view, edits and notices.
//!
//! Knows neither window nor device, so that all of it can be tested without.

use super::history::History;
use super::laboratory::{Held, Key, Laboratory};
use super::loader::{Answer, Loaded, Reason};
use super::notices::{Notices, Severity, Topic};
use super::orbit;
use super::timeline::Timeline;
use super::view::View;
use crate::scene::description::{Background, Source};
use crate::scene::framing::bounds_of_bodies;
use crate::scene::{Scene, SceneError, World, file};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Everything that the panels show and change.
#[derive(Debug, Default)]
pub struct Session {
    /// The scene as it is shown.
    pub scene: Scene,
    /// What it names, loaded.
    pub world: World,
    /// Its file; `None` for the built-in scene.
    pub path: Option<PathBuf>,
    /// The scene as its file has it.
    pub as_read: Scene,
    /// Time.
    pub timeline: Timeline,
    /// What is shown of it.
    pub view: View,
    /// What voxels are held against.
    pub laboratory: Laboratory,
    /// What the user should know.
    pub notices: Notices,
    /// Edits.
    pub history: History,
    /// True once a scene has been shown.
    pub is_open: bool,
    /// Counts the worlds that were put in place, so that a change is known without comparing them.
    pub world_number: u64,
}

impl Session {
    /// Now, where time changes the picture.
    #[must_use]
    pub fn time_secs(&self) -> f64 {
        if self.timeline.moves() { self.timeline.time_secs } else { 0.0 }
    }

    /// What the voxels that are shown came to, where that is known and asked for.
    #[must_use]
    pub fn held(&self) -> Option<&Held> {
        let held = self.laboratory.held.as_ref().filter(|_| self.laboratory.holds)?;
        (held.key == Key::of(self, self.time_secs())).then_some(held)
    }

    /// Name for titles and pictures: the file's, without its ending.
    #[must_use]
    pub fn name(&self) -> String {
        let stem = self.path.as_deref().and_then(Path::file_stem);
        stem.map_or_else(|| "murrine".to_owned(), |s| s.to_string_lossy().into_owned())
    }

    /// True when the scene differs from its file in more than the camera.
    #[must_use]
    pub fn is_edited(&self) -> bool {
        !super::history::is_same_edit(&self.scene, &self.as_read)
    }

    /// Takes in what a job brought. A failure keeps the last good state and tells.
    pub fn receive(&mut self, answer: Answer) {
        let Answer { reason, path, result, .. } = answer;
        let result = result.and_then(|loaded| match (reason, loaded.world.picture_lost_since(&self.world)) {
            // A picture that is being written, say: what is shown stays.
            (Reason::Changed | Reason::Reload, Some(lost)) => Err(lost.clone()),
            _ => Ok(loaded),
        });
        match result {
            Err(error) => self.notices.tell(Topic::Scene, Severity::Error, error.to_string()),
            Ok(loaded) => {
                self.notices.clear(Topic::Scene);
                let warnings: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
                self.notices.set(Topic::SceneWarnings, Severity::Warning, warnings);
                match reason {
                    Reason::Open => self.open(path, loaded),
                    Reason::Reload | Reason::Changed => self.reload(loaded, reason),
                    Reason::Background => {
                        self.scene.background = loaded.scene.background;
                        self.put_world(self.world.surrounded_as(&loaded.world));
                    }
                }
            }
        }
    }

    fn open(&mut self, path: Option<PathBuf>, loaded: Loaded) {
        let Loaded { scene, world, .. } = loaded;
        self.history = History::new(&scene, &world);
        self.timeline = Timeline { time_secs: 0.0, playing: true, duration_secs: world.duration_secs(&scene) };
        self.notices.clear(Topic::Frame);
        self.path = path;
        self.as_read = scene.clone();
        self.scene = scene;
        self.put_world(world);
        self.is_open = true;
    }

    fn reload(&mut self, loaded: Loaded, reason: Reason) {
        let Loaded { scene, world, .. } = loaded;
        // A file that says what it said before (we may have written it ourselves) leaves edits alone.
        if reason == Reason::Reload || scene != self.as_read {
            // Whoever looks from somewhere else keeps looking from there, unless the file's camera was moved.
            let camera = if scene.camera == self.as_read.camera { self.scene.camera } else { scene.camera };
            self.as_read = scene.clone();
            self.scene = Scene { camera, ..scene };
        }
        // The picture of an environment that the file does not know of (yet).
        let environment_stays = self.scene.background != self.as_read.background;
        let world = if environment_stays { world.surrounded_as(&self.world) } else { world };
        if !is_same_world(&world, &self.world) {
            self.put_world(world);
        }
        self.history.observe(&self.scene, &self.world, false);
        self.settle_time();
    }

    fn put_world(&mut self, world: World) {
        self.world = world;
        self.world_number += 1;
    }

    /// Works out the duration anew, after an edit of clips or deformers.
    pub fn settle_time(&mut self) {
        self.timeline.duration_secs = self.world.duration_secs(&self.scene);
    }

    /// Notes edits once a drag is over.
    pub fn observe_edits(&mut self, dragging: bool) {
        if self.is_open {
            self.history.observe(&self.scene, &self.world, dragging);
        }
    }

    /// Takes the last edit back.
    pub fn undo(&mut self) {
        if self.history.undo(&mut self.scene, &mut self.world) {
            self.world_number += 1;
            self.settle_time();
        }
    }

    /// Makes it again.
    pub fn redo(&mut self) {
        if self.history.redo(&mut self.scene, &mut self.world) {
            self.world_number += 1;
            self.settle_time();
        }
    }

    /// The scene as its file has it, but for the camera's place; can be undone.
    pub fn reset_scene(&mut self) {
        let camera = self.scene.camera;
        self.scene = self.as_read.clone();
        (self.scene.camera.eye, self.scene.camera.target, self.scene.camera.up) =
            (camera.eye, camera.target, camera.up);
        self.settle_time();
    }

    /// The camera as the file has it.
    pub fn reset_camera(&mut self) {
        self.scene.camera = self.as_read.camera;
    }

    /// Brings every model but the planes into a picture of this aspect.
    pub fn frame_all(&mut self, aspect: f32) {
        let bounds = bounds_of_bodies(&self.scene, &self.world);
        orbit::frame(&mut self.scene.camera, &bounds, aspect);
    }

    /// Every file that is shown: a change of one is a reason to read again.
    #[must_use]
    pub fn files(&self) -> Vec<PathBuf> {
        let mut files: Vec<PathBuf> = self.path.clone().into_iter().collect();
        files.extend(self.world.origins.iter().flat_map(|o| o.files.iter().map(|f| f.path.clone())));
        if let Background::Environment { file, .. } = &self.scene.background {
            files.push(self.scene.folder.join(file));
        }
        files
    }

    /// Writes the scene to `path`, whole or not at all, and goes on with that file.
    pub fn save(&mut self, path: &Path) {
        use std::io::Write as _;
        // A link stays a link to the file that is written.
        let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let folder = folder_of(path);
        let is_elsewhere = folder.canonicalize().ok() != folder_of(&self.scene.folder.join("x")).canonicalize().ok();
        let scene = if is_elsewhere { moved_to(&self.scene, folder) } else { self.scene.clone() };
        let written = self.text_of(&scene, &target).map_err(|e| e.to_string()).and_then(|text| {
            crate::image::atomically(&target, |file| file.write_all(text.as_bytes())).map_err(|e| e.to_string())
        });
        match written {
            Ok(()) => {
                self.as_read = self.scene.clone();
                self.path = Some(path.to_owned());
                self.notices.tell(Topic::Files, Severity::Done, format!("saved {}", path.display()));
            }
            Err(e) => self.notices.tell(Topic::Files, Severity::Error, format!("the scene was not saved: {e}")),
        }
    }

    /// The text of a scene file at `path`: the one that is open with its comments, as far as it goes. What could not be
    /// read back is refused.
    fn text_of(&self, scene: &Scene, path: &Path) -> Result<String, SceneError> {
        let methods = crate::headless::methods();
        let open = self.path.as_deref().filter(|open| is_scene(open));
        let text = match open.and_then(|open| file::text_of(open).ok()) {
            Some(text) => file::amended(&text, scene, path, &methods),
            None => file::to_toml(scene),
        };
        file::parse(&text, path, &methods)?;
        Ok(text)
    }

    /// The scene's background with this picture around it.
    #[must_use]
    pub fn surrounded_by(&self, file: &Path) -> Background {
        let file = relative(file, &self.scene.folder).unwrap_or_else(|| file.to_owned());
        match self.scene.background {
            Background::Environment { rotate_deg, intensity, .. } => {
                Background::Environment { file, rotate_deg, intensity }
            }
            _ => Background::Environment { file, rotate_deg: 0.0, intensity: 1.0 },
        }
    }

    /// Writes unsaved edits beside the scene, or where temporary files go, because the program has to end; where they are.
    pub fn rescue(&mut self) -> Option<PathBuf> {
        let name = format!("{}-rescued.toml", self.name());
        let beside = folder_of(&self.save_path()).join(&name);
        [beside, std::env::temp_dir().join(&name)].into_iter().find(|path| {
            let edited = self.is_open && self.is_edited();
            edited && {
                self.save(path);
                !self.is_edited()
            }
        })
    }

    /// Where Ctrl+S writes: the scene's own file; beside a model that was opened alone; else the current folder.
    #[must_use]
    pub fn save_path(&self) -> PathBuf {
        match &self.path {
            Some(path) if is_scene(path) => path.clone(),
            Some(model) => model.with_extension("toml"),
            None => PathBuf::from("murrine.toml"),
        }
    }
}

/// True when both hold the very same geometry and pictures.
fn is_same_world(a: &World, b: &World) -> bool {
    let models = a.models.len() == b.models.len() && a.models.iter().zip(&b.models).all(|(x, y)| Arc::ptr_eq(x, y));
    let environments = match (&a.environment, &b.environment) {
        (Some(x), Some(y)) => Arc::ptr_eq(x, y),
        (None, None) => true,
        _ => false,
    };
    models && environments
}

/// True for a scene file's name.
#[must_use]
pub fn is_scene(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"))
}

/// True for a file's name that can be opened.
#[must_use]
pub fn can_open(path: &Path) -> bool {
    let is_model = |e: &std::ffi::OsStr| ["glb", "gltf", "npz"].iter().any(|known| e.eq_ignore_ascii_case(known));
    is_scene(path) || path.extension().is_some_and(is_model)
}

/// True for the name of a picture that can light a scene.
#[must_use]
pub fn is_environment(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("hdr") || e.eq_ignore_ascii_case("exr"))
}

/// The file `by` places after this one among those of its kind in its folder, round and round.
#[must_use]
pub fn neighbour(path: &Path, by: i32) -> Option<PathBuf> {
    let entries = std::fs::read_dir(folder_of(path)).ok()?;
    let of_kind = |p: &PathBuf| can_open(p) && is_scene(p) == is_scene(path);
    let mut names: Vec<_> = entries
        .flatten()
        .map(|e| e.path())
        .filter(of_kind)
        .filter_map(|p| p.file_name().map(ToOwned::to_owned))
        .collect();
    names.sort();
    let here = names.iter().position(|n| Some(n.as_os_str()) == path.file_name());
    let count = i32::try_from(names.len()).ok().filter(|c| *c > 0)?;
    let at = here.map_or(0, |h| (i32::try_from(h).unwrap_or(0) + by).rem_euclid(count));
    let name = names.get(usize::try_from(at).ok()?)?;
    Some(path.with_file_name(name))
}

/// The scene with its files named from another folder, where they are to be named relatively.
fn moved_to(scene: &Scene, folder: &Path) -> Scene {
    let mut moved = scene.clone();
    let from = |file: &Path| relative(&scene.folder.join(file), folder).unwrap_or_else(|| file.to_owned());
    for model in &mut moved.models {
        if let Source::File(file) = &mut model.source {
            *file = from(file);
        }
    }
    if let Background::Environment { file, .. } = &mut moved.background {
        *file = from(file);
    }
    moved.folder = folder.to_owned();
    moved
}

/// A file's way from a folder, where both are there.
fn relative(file: &Path, folder: &Path) -> Option<PathBuf> {
    let (file, folder) = (file.canonicalize().ok()?, folder_of(&folder.join("x")).canonicalize().ok()?);
    let shared = file.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    let up = folder.components().skip(shared).map(|_| std::path::Component::ParentDir);
    Some(up.chain(file.components().skip(shared)).collect())
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}
