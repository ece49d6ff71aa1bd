//! Undo and redo of scene edits, as whole snapshots: a drag is one edit, camera moves are none.

use crate::scene::{Scene, World};

/// The most edits that can be taken back.
const DEPTH: usize = 200;

/// A scene and what it names. Geometry is shared, so that a snapshot costs little.
#[derive(Debug, Clone, Default)]
pub struct Snapshot {
    /// The scene.
    pub scene: Scene,
    /// The models.
    pub world: World,
}

/// The edits made and those taken back.
#[derive(Debug, Default)]
pub struct History {
    past: Vec<Snapshot>,
    future: Vec<Snapshot>,
    settled: Snapshot,
}

impl History {
    /// Starts with a scene and no edits.
    #[must_use]
    pub fn new(scene: &Scene, world: &World) -> Self {
        Self { settled: Snapshot { scene: scene.clone(), world: world.clone() }, ..Self::default() }
    }

    /// Takes note of the scene as it is now. While `dragging`, an edit is not finished.
    pub fn observe(&mut self, scene: &Scene, world: &World, dragging: bool) {
        if dragging || is_same_edit(scene, &self.settled.scene) {
            return;
        }
        let now = Snapshot { scene: scene.clone(), world: world.clone() };
        self.past.push(std::mem::replace(&mut self.settled, now));
        self.future.clear();
        if self.past.len() > DEPTH {
            self.past.remove(0);
        }
    }

    /// Takes the last edit back; false when there is none.
    pub fn undo(&mut self, scene: &mut Scene, world: &mut World) -> bool {
        self.observe(scene, world, false);
        let Some(before) = self.past.pop() else { return false };
        self.future.push(std::mem::replace(&mut self.settled, before));
        self.restore(scene, world);
        true
    }

    /// Makes the edit again that was taken back last; false when there is none.
    pub fn redo(&mut self, scene: &mut Scene, world: &mut World) -> bool {
        self.observe(scene, world, false);
        let Some(after) = self.future.pop() else { return false };
        self.past.push(std::mem::replace(&mut self.settled, after));
        self.restore(scene, world);
        true
    }

    /// True when there is an edit to take back.
    #[must_use]
    pub fn can_undo(&self) -> bool {
        !self.past.is_empty()
    }

    /// True when there is an edit to make again.
    #[must_use]
    pub fn can_redo(&self) -> bool {
        !self.future.is_empty()
    }

    fn restore(&self, scene: &mut Scene, world: &mut World) {
        let camera = scene.camera;
        *scene = self.settled.scene.clone();
        *world = self.settled.world.clone();
        (scene.camera.eye, scene.camera.target, scene.camera.up) = (camera.eye, camera.target, camera.up);
    }
}

/// True when two scenes differ in nothing but where the camera stands.
#[must_use]
pub fn is_same_edit(a: &Scene, b: &Scene) -> bool {
    // Field by field, so that a new one can't be forgotten.
    let Scene { camera, grid, light_grid, voxelizer, effect, background, lights, models, folder, frame_camera: _ } = a;
    camera.fov_deg.to_bits() == b.camera.fov_deg.to_bits()
        && *grid == b.grid
        && *light_grid == b.light_grid
        && *voxelizer == b.voxelizer
        && *effect == b.effect
        && *background == b.background
        && *lights == b.lights
        && *models == b.models
        && *folder == b.folder
}
