//! All that a scene names, loaded; and its pose at a time.

use super::description::{Bounds, Scene};
use super::geometry::{Geometry, Texture};
use super::material::Material;
use super::{SceneError, Warning};
use glam::Mat4;
use std::sync::Arc;

/// Everything a scene names, loaded. Cheap to clone: geometry is shared.
#[derive(Debug, Clone, Default)]
pub struct World {
    /// One for each model of the scene, in order.
    pub models: Vec<Arc<Geometry>>,
    /// Parts of all models in order: the part numbers that vertices carry.
    pub parts: Vec<WorldPart>,
    /// The environment picture, if the background names one: width, height, linear RGB.
    pub environment: Option<Arc<EnvironmentMap>>,
    /// What was odd.
    pub warnings: Vec<Warning>,
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

/// An equirectangular environment.
#[derive(Debug, Clone)]
pub struct EnvironmentMap {
    /// Texels.
    pub width: u32,
    /// Texels.
    pub height: u32,
    /// Linear RGB, row by row from the zenith.
    pub rgb: Vec<[f32; 3]>,
}

/// The state of everything that moves, at one time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Pose {
    /// `model_from_rest` of every matrix of every model, models in order: what influences index, plus the model's first.
    /// Deformers act in model space, after these and before `world_from_model`.
    pub matrices: Vec<Mat4>,
    /// Placement of every model, models in order.
    pub world_from_model: Vec<Mat4>,
    /// Morph weights of every part with targets, parts in order, targets in order.
    pub morph_weights: Vec<f32>,
    /// Conservative world bounds of each part at this pose (deformers included).
    pub part_bounds: Vec<Bounds>,
    /// Seconds.
    pub time_secs: f64,
}

impl World {
    /// Loads every model and picture that the scene names. Models whose source did not change since `previous` are
    /// taken from it.
    ///
    /// # Errors
    /// The first file that can't be used, with the reason.
    pub fn load(scene: &Scene, previous: Option<&World>) -> Result<Self, SceneError> {
        let _ = (scene, previous);
        Err(SceneError::new("scene", "loading is being built"))
    }

    /// The pose at `time_secs`, a pure function of scene and time.
    #[must_use]
    pub fn pose(&self, scene: &Scene, time_secs: f64) -> Pose {
        let _ = scene;
        Pose { time_secs, ..Pose::default() }
    }

    /// The materials of all parts with the scene's overrides and variants applied, parts in order.
    #[must_use]
    pub fn materials(&self, scene: &Scene) -> Vec<Material> {
        let _ = scene;
        Vec::new()
    }

    /// Textures of all models in order; [`Material::base_color_texture`] counts these.
    #[must_use]
    pub fn textures(&self) -> Vec<&Texture> {
        self.models.iter().flat_map(|m| &m.textures).collect()
    }

    /// Seconds after which every clip repeats: the longest chosen clip, or 0 where nothing moves.
    #[must_use]
    pub fn duration_secs(&self, scene: &Scene) -> f64 {
        let _ = scene;
        0.0
    }
}
