//! What changed since the last frame, and so which stages must run again.

use crate::compose::DebugView;
use crate::grid::Grid;
use crate::march::Channel;
use crate::scene::description::{Deformer, EffectSettings, Scene, VoxelizerSettings};
use crate::scene::geometry::Geometry;
use crate::scene::material::Material;
use crate::scene::world::{Pose, World};
use crate::surroundings::Surroundings;
use glam::UVec2;
use std::sync::Arc;

/// Everything that the stages of one frame depend on. Geometry and pictures are shared, not copied.
#[derive(Debug, Clone)]
pub struct Inputs {
    /// What the scene names.
    pub world: World,
    /// The pose.
    pub pose: Pose,
    /// Each model's deformers.
    pub deformers: Vec<Vec<Deformer>>,
    /// Each part's material.
    pub materials: Vec<Material>,
    /// The grids, without regions.
    pub grids: Vec<Grid>,
    /// Voxelizer and its options.
    pub voxelizer: VoxelizerSettings,
    /// Effect.
    pub effect: EffectSettings,
    /// Camera, lights, planes, background.
    pub surroundings: Surroundings,
    /// Resolution of the march.
    pub size: UVec2,
    /// Resolution of the picture.
    pub picture_size: UVec2,
    /// Float channel.
    pub channel: Channel,
    /// Debug view.
    pub view: DebugView,
}

/// Which stages must run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stale {
    /// Geometry and pictures must be uploaded.
    pub world: bool,
    /// Materials must be written.
    pub materials: bool,
    /// Triangles must be animated.
    pub animate: bool,
    /// Grids that must be voxelized and resolved, by number.
    pub grids: Vec<bool>,
    /// The lights' grids must be walked.
    pub light: bool,
    /// Rays must be marched.
    pub march: bool,
    /// The picture must be composed.
    pub compose: bool,
}

impl Inputs {
    /// What must run again, given the inputs of the last frame that was recorded whole.
    #[must_use]
    pub fn stale_since(&self, last: Option<&Self>) -> Stale {
        let Some(last) = last else {
            return Stale {
                world: true,
                materials: true,
                animate: true,
                grids: vec![true; self.grids.len()],
                light: true,
                march: true,
                compose: true,
            };
        };
        let world = !self.same_world(last);
        let materials = world || self.materials != last.materials;
        let animate = world || self.moved(last);
        // Records carry the part and whether it is opaque; all else of a material is looked up when it is met.
        let marks =
            |i: &Self| i.materials.iter().map(|m| (m.opaque, m.thin_wall, m.operand, m.turned)).collect::<Vec<_>>();
        let all_grids = animate || self.voxelizer != last.voxelizer || marks(self) != marks(last);
        let grids: Vec<bool> =
            (0..self.grids.len()).map(|g| all_grids || self.grids.get(g) != last.grids.get(g)).collect();
        let mut stale = Stale {
            world,
            materials,
            animate,
            light: materials
                || self.effect.shadow != last.effect.shadow
                || self.surroundings.lights != last.surroundings.lights
                || self.surroundings.planes != last.surroundings.planes,
            march: materials
                || self.surroundings != last.surroundings
                || self.size != last.size
                || self.channel != last.channel
                || EffectSettings { exposure: 0.0, ..self.effect } != EffectSettings { exposure: 0.0, ..last.effect },
            compose: self.view != last.view
                || self.picture_size != last.picture_size
                || self.effect.exposure.to_bits() != last.effect.exposure.to_bits(),
            grids,
        };
        stale.follow();
        stale
    }

    fn same_world(&self, last: &Self) -> bool {
        let same = |a: &Self, b: &Self| {
            a.world.models.len() == b.world.models.len()
                && a.world.models.iter().zip(&b.world.models).all(|(a, b)| Arc::ptr_eq(a, b) || same_surface(a, b))
        };
        let same_environment = match (&self.world.environment, &last.world.environment) {
            (None, None) => true,
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            _ => false,
        };
        same(self, last) && same_environment && self.world.bodies == last.world.bodies
    }

    fn moved(&self, last: &Self) -> bool {
        let swings = self.deformers.iter().flatten().any(|d| match d {
            Deformer::Twist { hz, .. } | Deformer::Wave { hz, .. } => *hz != 0.0,
        });
        let remade = |(a, b): (&Arc<Geometry>, &Arc<Geometry>)| !Arc::ptr_eq(a, b);
        self.world.models.iter().zip(&last.world.models).any(remade)
            || self.deformers != last.deformers
            || (swings && self.pose.time_secs.to_bits() != last.pose.time_secs.to_bits())
            || self.pose.matrices != last.pose.matrices
            || self.pose.world_from_model != last.pose.world_from_model
            || self.pose.morph_weights != last.pose.morph_weights
    }
}

/// Two times of one moving surface: only its triangles differ.
fn same_surface(a: &Geometry, b: &Geometry) -> bool {
    matches!((&a.made_from, &b.made_from), (Some(a), Some(b)) if a.surface == b.surface)
}

impl Stale {
    /// Marks grids whose region in the volume is new, and all that reads them.
    pub fn grids_anew(&mut self, anew: &[bool]) {
        for (grid, anew) in self.grids.iter_mut().zip(anew) {
            *grid |= *anew;
        }
        self.follow();
    }

    /// True if some grid must be voxelized.
    #[must_use]
    pub fn any_grid(&self) -> bool {
        self.grids.contains(&true)
    }

    /// A stage runs when one before it did.
    pub fn follow(&mut self) {
        self.light |= self.any_grid();
        self.march |= self.light || self.animate;
        self.compose |= self.march;
    }
}

/// Each model's deformers.
#[must_use]
pub fn deformers(scene: &Scene) -> Vec<Vec<Deformer>> {
    scene.models.iter().map(|m| m.deformers.clone()).collect()
}
