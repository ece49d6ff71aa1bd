//! What the benchmark times: bodies of our own shapes, so that it runs anywhere.

use crate::scene::description::{
    Cells, Deformer, Fill, Light, MaterialOverride, Model, Refraction, Scene, Shadow, Shape, Source,
};
use crate::scene::geometry::Geometry;
use crate::scene::{SceneError, World};
use glam::{UVec2, Vec3};
use std::sync::Arc;

/// One thing to time.
#[derive(Debug, Clone)]
pub struct Case {
    /// Its name in the table.
    pub name: String,
    /// Cases of one group take turns.
    pub group: &'static str,
    /// What is rendered.
    pub scene: Scene,
    /// Resolution of the march and the picture.
    pub size: UVec2,
    /// The stages whose sum is held against the target.
    pub counts: &'static [&'static str],
    /// Of each model one triangle alone is rendered.
    pub one_triangle: bool,
    /// The project's target for that sum.
    pub target_ms: Option<f64>,
}

impl Case {
    /// What its scene names, loaded.
    ///
    /// # Errors
    /// When a model can't be read.
    pub fn world(&self) -> Result<World, SceneError> {
        let mut world = World::load(&self.scene, None)?;
        if self.one_triangle {
            world.models.iter_mut().for_each(keep_one_triangle);
        }
        Ok(world)
    }

    /// True if marking alone is held against others.
    #[must_use]
    pub fn is_marking(&self) -> bool {
        self.counts == MARK
    }
}

/// Leaves a model the first of its triangles that has an area.
fn keep_one_triangle(model: &mut Arc<Geometry>) {
    let mut one = Geometry::clone(model);
    let corners = |t: &[u32; 3]| t.map(|i| one.vertices[i as usize].position);
    let area = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).length();
    one.triangles = one.triangles.iter().filter(|t| area(corners(t)) > 0.0).take(1).copied().collect();
    one.parts.iter_mut().for_each(|part| part.triangles = 0..1);
    *model = Arc::new(one);
}

/// A grid with records and interior.
const GRID: &[&str] = &["voxelize", "resolve", "fill"];
/// A whole frame.
const FRAME: &[&str] = &["scene", "animate", "voxelize", "resolve", "fill", "light", "march", "compose"];
/// Marking alone.
const MARK: &[&str] = &["voxelize"];

/// All cases.
#[must_use]
pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (cells, target_ms) in [(128, 20.0), (256, 50.0)] {
        let mut scene = scene(vec![wavy()], cells);
        scene.lights.clear();
        scene.voxelizer.fill = Fill::Eager;
        scene.effect.refraction = Refraction::None;
        cases.push(Case {
            name: format!("one grid {cells}³, 70k triangles"),
            group: "one grid",
            scene,
            size: UVec2::ONE,
            counts: GRID,
            one_triangle: false,
            target_ms: Some(target_ms),
        });
    }
    // Half of what a path tracer takes to rebuild and trace a ball that deforms; the wavy body has no such peer.
    for (name, body, target_ms) in [("smooth", smooth(), Some(70.0)), ("wavy", wavy(), None)] {
        cases.push(Case {
            name: format!("deforming frame 256², {name}"),
            group: "whole frame",
            scene: with_ground(scene(vec![body], 128)),
            size: UVec2::splat(256),
            counts: FRAME,
            one_triangle: false,
            target_ms,
        });
    }
    for (name, body) in [("smooth", smooth()), ("wavy", wavy())] {
        for events in [2, 4, 8] {
            let mut scene = with_ground(scene(vec![body.clone()], 128));
            scene.effect.max_events = events;
            cases.push(Case {
                name: format!("{name} 512², {events} events"),
                group: "512²",
                scene,
                size: UVec2::splat(512),
                counts: FRAME,
                one_triangle: false,
                target_ms: None,
            });
        }
    }
    for (name, models) in [
        ("one scene-sized triangle", vec![sheet()]),
        ("204 large triangles", boxes()),
        ("70k small triangles", vec![wavy()]),
    ] {
        for method in ["triangle-parallel", "fragment-parallel", "hybrid"] {
            let mut scene = scene(models.clone(), 128);
            scene.lights.clear();
            scene.effect.shadow = Shadow::None;
            scene.voxelizer.method = method.to_owned();
            cases.push(Case {
                name: format!("{name}, {method}"),
                group: name,
                scene,
                size: UVec2::ONE,
                counts: MARK,
                one_triangle: name == "one scene-sized triangle",
                target_ms: None,
            });
        }
    }
    cases
}

/// A scene of the user's, as it is, at 512².
#[must_use]
pub fn of_scene(name: String, scene: Scene) -> Case {
    Case {
        name,
        group: "given scenes",
        scene,
        size: UVec2::splat(512),
        counts: FRAME,
        one_triangle: false,
        target_ms: None,
    }
}

fn scene(models: Vec<Model>, cells: u32) -> Scene {
    let mut scene = Scene { models, lights: vec![Light::default()], ..Scene::default() };
    scene.grid.cells = Cells::Longest(cells);
    scene.light_grid.cells = Cells::Longest(cells.min(128));
    scene
}

fn with_ground(mut scene: Scene) -> Scene {
    scene.models.push(Model {
        name: "ground".to_owned(),
        source: Source::Shape(Shape::Plane { size: 80.0 }),
        translate: Vec3::new(0.0, -1.2, 0.0),
        materials: vec![MaterialOverride { opaque: Some(true), ..MaterialOverride::default() }],
        ..Model::default()
    });
    scene
}

fn body(name: &str, shape: Shape, deformers: Vec<Deformer>) -> Model {
    let material = MaterialOverride { ior: Some(1.5), sigma: Some(Vec3::new(0.2, 0.5, 0.9)), ..Default::default() };
    Model {
        name: name.to_owned(),
        source: Source::Shape(shape),
        deformers,
        materials: vec![material],
        ..Model::default()
    }
}

/// 70,224 triangles that breathe a little: the surface stays a smooth ball.
fn smooth() -> Model {
    let wave = Deformer::Wave { axis: 1, along: 0, amplitude: 0.05, wavelength: 4.0, hz: 0.7 };
    body("smooth", Shape::Sphere { radius: 1.0, rings: 133 }, vec![wave])
}

/// 70,224 triangles in running waves.
fn wavy() -> Model {
    let along = |axis, along| Deformer::Wave { axis, along, amplitude: 0.08, wavelength: 0.6, hz: 0.9 };
    body("wavy", Shape::Sphere { radius: 1.0, rings: 133 }, vec![along(1, 0), along(0, 2)])
}

/// A box without thickness, whose triangles are as large as the scene.
fn sheet() -> Model {
    let mut model = body(
        "sheet",
        Shape::Box { min: Vec3::new(-1.0, -1.0, 0.0), max: Vec3::new(1.0, 1.0, 0.0) },
        vec![Deformer::Twist { axis: 2, deg_per_unit: 1.0, hz: 0.3 }],
    );
    model.rotate_deg = Vec3::new(20.0, 30.0, 10.0);
    model
}

/// 17 boxes of twelve large triangles each.
fn boxes() -> Vec<Model> {
    (0..17u8)
        .map(|i| {
            let size = 1.0 - f32::from(i) * 0.05;
            let mut model = body(
                &format!("box {i}"),
                Shape::Box { min: Vec3::splat(-size), max: Vec3::splat(size) },
                vec![Deformer::Twist { axis: 1, deg_per_unit: 1.0, hz: 0.3 }],
            );
            model.rotate_deg = Vec3::new(f32::from(i) * 11.0, f32::from(i) * 7.0, 0.0);
            model
        })
        .collect()
}
