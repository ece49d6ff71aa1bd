//! What is to be shown: the scene file, the models it names, and their state at a time.
//!
//! [`description`] is the scene as its file says it, in [`words`]; [`file`](mod@file) reads, edits and writes such files;
//! [`gltf`], [`shapes`], [`surface`] and saved [`voxels`] make [`geometry`]; [`clips`] and [`deform`] move it; [`world`] holds all that a scene names,
//! loaded; [`pose`] is its state at a time and [`bounds`] how far it then reaches; [`framing`] fits a scene to bodies of
//! unknown size; [`material`] is what light sees of a part, [`environment`] a picture around it all.

pub mod bounds;
pub mod clips;
pub mod csg;
pub mod deform;
pub mod description;
pub mod environment;
pub mod expression;
pub mod file;
pub mod framing;
pub mod geometry;
pub mod gltf;
pub mod implicit;
pub mod material;
pub mod parametric;
pub mod pose;
pub mod shapes;
pub mod surface;
pub mod voxels;
pub mod words;
pub mod world;

pub use description::Scene;
pub use pose::Pose;
pub use world::World;

/// What can be wrong with a scene or a model. The text starts with the place and ends with a remedy.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {what}")]
pub struct SceneError {
    /// `file` or `file:line:column`.
    pub place: String,
    /// What is wrong and what to do.
    pub what: String,
}

impl SceneError {
    /// An error at a place.
    #[must_use]
    pub fn new(place: impl Into<String>, what: impl Into<String>) -> Self {
        Self { place: place.into(), what: what.into() }
    }
}

/// Something odd that does not stop the picture; shown once.
pub type Warning = SceneError;
