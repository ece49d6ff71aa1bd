//! All that a scene names, loaded.

use super::csg::Bodies;
use super::description::{Background, Bounds, Deformer, Model, Scene, Source};
pub use super::environment::EnvironmentMap;
use super::geometry::{Geometry, Texture};
use super::material::Material;
pub use super::pose::Pose;
use super::shapes::Mesh;
use super::surface::{MadeFrom, Surface};
use super::{SceneError, Warning, environment, gltf, shapes, voxels};
use glam::Mat4;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

/// Everything a scene names, loaded. Cheap to clone: geometry is shared.
#[derive(Debug, Clone, Default)]
pub struct World {
    /// One for each model of the scene, in order.
    pub models: Vec<Arc<Geometry>>,
    /// Parts of all models in order: the part numbers that vertices carry.
    pub parts: Vec<WorldPart>,
    /// Models that are made of other ones.
    pub bodies: Bodies,
    /// The environment picture, if the background names one.
    pub environment: Option<Arc<EnvironmentMap>>,
    /// What was odd.
    pub warnings: Vec<Warning>,
    /// What each model was made from, models in order.
    pub origins: Vec<Origin>,
    /// The environment's file as it was read.
    pub environment_stamp: Option<FileStamp>,
}

/// A part of the world: the number that vertices and records carry is its index.
#[derive(Debug, Clone)]
pub struct WorldPart {
    /// Index of its model.
    pub model: u32,
    /// Index within the model.
    pub part: u32,
    /// `model/part`.
    pub name: String,
}

/// What a model was made from: it is made again only when this changes.
#[derive(Debug, Clone, PartialEq)]
pub struct Origin {
    /// As the scene says it.
    pub source: Source,
    /// Every file that was read, for watching.
    pub files: Vec<FileStamp>,
    /// What was odd.
    pub warnings: Vec<Warning>,
    /// Those of the warnings that tell of a picture that can't be read.
    pub lost_pictures: Vec<Warning>,
}

impl Origin {
    fn of(source: &Source) -> Self {
        Self { source: source.clone(), files: Vec::new(), warnings: Vec::new(), lost_pictures: Vec::new() }
    }
}

/// A file as it was when it was read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileStamp {
    /// Where it is.
    pub path: PathBuf,
    /// Bytes.
    pub len: u64,
    /// When it last changed, where the system knows.
    pub modified: Option<SystemTime>,
}

impl FileStamp {
    /// The file as it is now; `None` when it can't be asked.
    #[must_use]
    pub fn now(path: PathBuf) -> Option<Self> {
        let meta = std::fs::metadata(&path).ok()?;
        Some(Self { path, len: meta.len(), modified: meta.modified().ok() })
    }

    fn holds(&self) -> bool {
        Self::now(self.path.clone()).as_ref() == Some(self)
    }
}

impl World {
    /// Loads every model and picture that the scene names. Models whose source did not change since `previous` are
    /// taken from it.
    ///
    /// # Errors
    /// The first file that can't be used, with the reason.
    pub fn load(scene: &Scene, previous: Option<&World>) -> Result<Self, SceneError> {
        let mut world = Self::default();
        for model in &scene.models {
            let known = previous.and_then(|p| p.find(&model.source, &scene.folder));
            let known = known.or_else(|| world.find(&model.source, &scene.folder));
            let (geometry, origin) = match known {
                Some(known) => known,
                None => make(model, &scene.folder)?,
            };
            check_names(model, &geometry)?;
            world.warnings.extend(origin.warnings.iter().cloned());
            world.add(&model.name, geometry, origin);
        }
        world.bodies = Bodies::of(scene, &world.models)?;
        if let Background::Environment { file, .. } = &scene.background {
            world.load_environment(&scene.folder.join(file), previous)?;
        }
        Ok(world)
    }

    fn load_environment(&mut self, path: &Path, previous: Option<&World>) -> Result<(), SceneError> {
        let stamp = FileStamp::now(path.to_path_buf());
        let known = previous.filter(|p| stamp.is_some() && p.environment_stamp == stamp);
        self.environment = match known.and_then(|p| p.environment.clone()) {
            Some(known) => Some(known),
            None => Some(Arc::new(environment::read(path)?)),
        };
        self.environment_stamp = stamp;
        Ok(())
    }

    /// This world with the environment picture of another one.
    #[must_use]
    pub fn surrounded_as(&self, other: &Self) -> Self {
        Self {
            environment: other.environment.clone(),
            environment_stamp: other.environment_stamp.clone(),
            ..self.clone()
        }
    }

    /// This world at a time: surfaces whose expressions hold `t` are made anew, but for those that `previous` has as
    /// they are then. A model that the scene no longer has stays as it is.
    #[must_use]
    pub fn at(&self, scene: &Scene, time_secs: f64, previous: Option<&Self>) -> Self {
        let mut world = self.clone();
        for (i, geometry) in world.models.iter_mut().enumerate() {
            let Some(MadeFrom { surface, .. }) = &geometry.made_from else { continue };
            let speed = scene.models.get(i).map_or(1.0, |m| f64::from(m.speed));
            let wanted = MadeFrom { surface: Arc::clone(surface), time_secs: time_secs * speed };
            let known = previous.and_then(|p| p.models.get(i)).filter(|g| g.made_from.as_ref() == Some(&wanted));
            if let Some(known) = known {
                *geometry = Arc::clone(known);
            } else if geometry.made_from.as_ref() != Some(&wanted) {
                *geometry = Arc::new(made(&wanted.surface, wanted.time_secs));
            }
        }
        world
    }

    /// What is odd about surfaces at this world's time.
    pub fn warnings_now<'a>(&'a self, scene: &'a Scene) -> impl Iterator<Item = String> + 'a {
        let moving = self.models.iter().zip(&scene.models).filter(|(geometry, _)| geometry.made_from.is_some());
        moving.filter_map(|(g, model)| g.warning.as_ref().map(|what| format!("model `{}`: {what}", model.name)))
    }

    /// Every file that was read: what to watch for changes.
    #[must_use]
    pub fn files(&self) -> Vec<PathBuf> {
        let stamps = self.origins.iter().flat_map(|o| &o.files).chain(&self.environment_stamp);
        let mut files: Vec<PathBuf> = stamps.map(|s| s.path.clone()).collect();
        files.sort();
        files.dedup();
        files
    }

    /// A world of geometry made elsewhere, one for each model of the scene.
    #[must_use]
    pub fn from_geometry(scene: &Scene, models: Vec<Arc<Geometry>>) -> Self {
        let mut world = Self::default();
        for (model, geometry) in scene.models.iter().zip(models) {
            let origin = Origin::of(&model.source);
            world.add(&model.name, geometry, origin);
        }
        world
    }

    /// The model of a source in a folder, if it stands as it was read.
    fn find(&self, source: &Source, folder: &Path) -> Option<(Arc<Geometry>, Origin)> {
        let same = |o: &Origin| match source {
            Source::File(file) => o.files.first().is_some_and(|f| f.path == folder.join(file)),
            Source::Shape(_) | Source::Surface(_) | Source::Csg(_) => true,
        };
        let unchanged = |o: &Origin| o.source == *source && same(o) && o.files.iter().all(FileStamp::holds);
        let i = self.origins.iter().position(unchanged)?;
        Some((Arc::clone(&self.models[i]), self.origins[i].clone()))
    }

    /// A picture that can't be read, of a model that had it in `before`.
    #[must_use]
    pub fn picture_lost_since(&self, before: &World) -> Option<&Warning> {
        let same = |a: &Origin, b: &Origin| {
            let [a, b] = [a, b].map(|o| o.files.first().map(|f| &f.path));
            a.is_some() && a == b
        };
        self.origins.iter().find_map(|origin| {
            let known = before.origins.iter().find(|o| same(o, origin))?;
            origin.lost_pictures.iter().find(|w| !known.lost_pictures.contains(w))
        })
    }

    fn add(&mut self, name: &str, geometry: Arc<Geometry>, origin: Origin) {
        let model = number(self.models.len());
        for (i, part) in geometry.parts.iter().enumerate() {
            self.parts.push(WorldPart { model, part: number(i), name: format!("{name}/{}", part.name) });
        }
        self.models.push(geometry);
        self.origins.push(origin);
    }

    /// The materials of all parts with the scene's overrides and variants applied, parts in order.
    ///
    /// Planes are opaque whatever the overrides say.
    #[must_use]
    pub fn materials(&self, scene: &Scene) -> Vec<Material> {
        let mut materials = Vec::with_capacity(self.parts.len());
        let mut first_texture = 0;
        let absent = Model::default();
        for (i, geometry) in self.models.iter().enumerate() {
            let model = scene.models.get(i).unwrap_or(&absent);
            let variant = model.variant.as_ref().and_then(|name| geometry.variants.iter().position(|v| v == name));
            for part in &geometry.parts {
                let of_variant = part.variant_materials.iter().find(|(v, _)| Some(*v) == variant);
                let mut material = of_variant.map_or(&part.material, |(_, m)| m).clone();
                for texture in [&mut material.base_color_texture, &mut material.emissive_texture] {
                    *texture = texture.map(|t| t + first_texture);
                }
                material = material.overridden(&part.name, &model.materials);
                material.opaque |= part.plane_half.is_some();
                materials.push(material);
            }
            first_texture += number(geometry.textures.len());
        }
        self.mark_operands(scene, &mut materials);
        materials
    }

    /// A body's medium is that of its first operand, but for what the scene says of the body; its operands are opaque or
    /// clear as it is.
    fn mark_operands(&self, scene: &Scene, materials: &mut [Material]) {
        let first_part = |model: usize| self.parts.iter().position(|p| p.model as usize == model);
        for (number, operand) in (1..).zip(&self.bodies.operands) {
            let Some(body) = first_part(operand.body) else { continue };
            let is_first = self.bodies.operands.iter().find(|o| o.body == operand.body) == Some(operand);
            if let Some(own) = first_part(operand.model).filter(|_| is_first) {
                let overrides = scene.models.get(operand.body).map_or(&[][..], |m| &m.materials);
                materials[body] =
                    materials[own].clone().overridden(&self.models[operand.body].parts[0].name, overrides);
            }
            let of_body = (materials[body].opaque, materials[body].thin_wall);
            for (part, material) in self.parts.iter().zip(materials.iter_mut()) {
                if part.model as usize == operand.model {
                    (material.opaque, material.thin_wall) = of_body;
                    (material.operand, material.turned) = (number, operand.turned);
                }
            }
        }
    }

    /// Textures of all models in order; [`Material::base_color_texture`] counts these.
    #[must_use]
    pub fn textures(&self) -> Vec<&Texture> {
        self.models.iter().flat_map(|m| &m.textures).collect()
    }

    /// The longest chosen clip or deformer's swing at its model's speed, or 0 where nothing moves: what a time line
    /// should span.
    #[must_use]
    pub fn duration_secs(&self, scene: &Scene) -> f64 {
        let mut longest: f64 = 0.0;
        for (geometry, model) in self.models.iter().zip(&scene.models) {
            let speed = f64::from(model.speed.abs());
            if let Some(clip) = geometry.clip(model).filter(|_| speed > 0.0) {
                longest = longest.max(f64::from(clip.duration_secs) / speed);
            }
            for deformer in &model.deformers {
                let (Deformer::Twist { hz, .. } | Deformer::Wave { hz, .. }) = deformer;
                if *hz != 0.0 {
                    longest = longest.max(1.0 / f64::from(hz.abs()));
                }
            }
            if geometry.made_from.is_some() && speed > 0.0 {
                // What its period is, the expressions don't say; most hold sin(t).
                longest = longest.max(std::f64::consts::TAU / speed);
            }
        }
        longest
    }
}

/// A surface's geometry at a time; one that moves remembers what it was made from.
fn made(surface: &Arc<Surface>, time_secs: f64) -> Geometry {
    let mut geometry = surface.geometry(time_secs);
    geometry.made_from = surface.moves().then(|| MadeFrom { surface: Arc::clone(surface), time_secs });
    geometry
}

/// Makes a model's geometry from its source.
fn make(model: &Model, folder: &Path) -> Result<(Arc<Geometry>, Origin), SceneError> {
    let mut origin = Origin::of(&model.source);
    let geometry = match &model.source {
        Source::Shape(shape) => shapes::shape(shape),
        // What it is made of has the triangles.
        Source::Csg(_) => Mesh::default().into_geometry("csg", None),
        Source::Surface(surface) => {
            let geometry = made(surface, 0.0);
            // One that moves has its warnings frame by frame.
            let odd = geometry.warning.clone().filter(|_| !surface.moves());
            origin.warnings.extend(odd.map(|what| Warning::new(format!("model `{}`", model.name), what)));
            geometry
        }
        Source::File(file) => {
            let path = folder.join(file);
            // Stamped before it is read: a change meanwhile is seen later.
            origin.files.extend(FileStamp::now(path.clone()));
            let loaded = if voxels::is_saved(file) { voxels::read(&path)? } else { gltf::read(&path)? };
            origin.files.extend(loaded.files.into_iter().filter_map(FileStamp::now));
            origin.warnings = loaded.warnings;
            origin.lost_pictures = loaded.lost_pictures;
            loaded.geometry
        }
    };
    let geometry = Arc::new(geometry);
    if !stands(&geometry) {
        let what = "its parts lie further out than 1e12; scale the model down";
        return Err(SceneError::new(format!("model `{}`", model.name), what));
    }
    Ok((geometry, origin))
}

/// Whether the model's first pose is somewhere that single precision can tell apart.
fn stands(geometry: &Arc<Geometry>) -> bool {
    let scene = Scene { models: vec![Model::default()], ..Scene::default() };
    let pose = World::from_geometry(&scene, vec![Arc::clone(geometry)]).pose(&scene, 0.0);
    let near = |b: &Bounds| b.min.abs().max_element() <= 1e12 && b.max.abs().max_element() <= 1e12;
    pose.part_bounds.iter().all(|b| b.is_empty() || near(b)) && pose.matrices.iter().all(Mat4::is_finite)
}

/// The names in a scene's model must be the file's own.
fn check_names(model: &Model, geometry: &Geometry) -> Result<(), SceneError> {
    let unknown = |kind: &str, name: &str, known: Vec<&str>| {
        let remedy = if known.is_empty() { "it has none".to_owned() } else { format!("choose {}", list(&known)) };
        SceneError::new(format!("model `{}`", model.name), format!("no {kind} `{name}`; {remedy}"))
    };
    if let Some(name) = &model.animation
        && geometry.clip(model).is_none()
    {
        let known = geometry.clips.iter().map(|c| c.name.as_str()).collect();
        return Err(unknown("animation", name, known));
    }
    if let Some(name) = model.variant.as_ref().filter(|name| !geometry.variants.contains(name)) {
        return Err(unknown("variant", name, geometry.variants.iter().map(String::as_str).collect()));
    }
    for o in &model.materials {
        if !geometry.parts.iter().any(|p| o.names(&p.name)) {
            let known = std::iter::once("*").chain(geometry.parts.iter().map(|p| p.name.as_str())).collect();
            return Err(unknown("part", &o.part, known));
        }
    }
    Ok(())
}

/// The first few names of a list.
fn list(names: &[&str]) -> String {
    const SHOWN: usize = 12;
    let shown = names[..names.len().min(SHOWN)].join(", ");
    if names.len() > SHOWN { format!("{shown}, … ({} in all)", names.len()) } else { shown }
}

#[expect(clippy::cast_possible_truncation, reason = "readers refuse models of more than 2³² of anything")]
fn number(n: usize) -> u32 {
    n as u32
}
