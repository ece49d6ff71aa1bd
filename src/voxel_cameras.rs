//! Which grids a frame has, and what each must enclose.

use crate::grid::{Grid, MAX_GRIDS};
use crate::scene::description::{Align, Bounds, Cells, GridSettings, LightKind, Projection, Scene, Shadow};
use crate::scene::material::{Material, flags};
use crate::scene::world::{Pose, World, WorldPart};
use std::ops::Range;

/// The grids of a frame: the view's first, then the scene's if there are opaque parts, then those of the lights.
#[derive(Debug, Clone, Default)]
pub struct VoxelCameras {
    /// All grids, without regions.
    pub grids: Vec<Grid>,
    /// Number of the coarse world-aligned grid of opaque parts, for rays that leave the view's grid.
    pub scene_grid: Option<u32>,
    /// The grids of each light, by number; empty for a light that casts no shadow.
    pub light_grids: Vec<Range<u32>>,
    /// What could not be as the scene asked.
    pub warnings: Vec<String>,
}

/// Resolution of the scene grid's longest axis: opaque parts seen through glass, away from it.
const SCENE_GRID_CELLS: u32 = 96;

impl VoxelCameras {
    /// Fits every grid to the parts' bounds at this pose.
    #[must_use]
    pub fn fit(scene: &Scene, world: &World, materials: &[Material], pose: &Pose) -> Self {
        let mut cameras = Self::default();
        // Analytic planes are met exactly: a ground of 80 units inside the bounds would ruin the cells.
        let plane = |part: &WorldPart| world.models[part.model as usize].parts[part.part as usize].plane_half.is_some();
        let mut voxelized: Vec<(bool, Bounds)> = (world.parts.iter().zip(materials).zip(&pose.part_bounds))
            .filter(|((part, material), bounds)| !plane(part) && material.operand == 0 && !bounds.is_empty())
            .map(|((_, material), bounds)| (material.opaque, *bounds))
            .collect();
        voxelized.extend(bodies(world, materials, pose));
        let bounds = glass_and_near(&voxelized);
        let seen = scene.grid.region.map_or(bounds, |region| region.bounds());
        let (view, warning) = Grid::for_camera(&scene.grid, &scene.camera, &seen);
        cameras.grids.push(view);
        cameras.warnings.extend(warning);

        let opaque = union(&voxelized, true);
        if !opaque.is_empty() {
            let settings = GridSettings {
                cells: Cells::Longest(SCENE_GRID_CELLS),
                align: Align::World,
                projection: Projection::Orthographic,
                region: None,
            };
            let (mut grid, _) = Grid::for_camera(&settings, &scene.camera, &opaque);
            grid.required_flags = flags::OPAQUE;
            cameras.scene_grid = Some(1);
            cameras.grids.push(grid);
        }
        for light in &scene.lights {
            let first = cameras.grids.len();
            if light.casts_shadow && scene.effect.shadow != Shadow::None && !bounds.is_empty() {
                let lit = Grid::for_light(&scene.light_grid, light, &bounds);
                if first + lit.len() <= MAX_GRIDS {
                    cameras.grids.extend(lit);
                } else {
                    let kind = match light.kind {
                        LightKind::Directional { .. } => "directional",
                        LightKind::Point { .. } => "point",
                        LightKind::Spot { .. } => "spot",
                    };
                    let warning = format!("a {kind} light casts no shadow: all {MAX_GRIDS} grids are taken");
                    cameras.warnings.push(warning);
                }
            }
            let number = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
            cameras.light_grids.push(number(first)..number(cameras.grids.len()));
        }
        cameras
    }
}

/// Whether bodies that are made of other models are opaque, and their bounds. Opaque ones count as clear too: they are
/// met in the view's grid alone, so it must hold them.
fn bodies(world: &World, materials: &[Material], pose: &Pose) -> Vec<(bool, Bounds)> {
    let of_model = |model: usize| {
        let parts = world.parts.iter().zip(&pose.part_bounds).filter(|(part, _)| part.model as usize == model);
        parts.fold(Bounds::EMPTY, |sum, (_, b)| sum.union(*b))
    };
    let bounds = world.bodies.bounds(|operand| of_model(world.bodies.operands[operand].model));
    let opaque = world.bodies.models().map(|model| {
        let part = world.parts.iter().position(|part| part.model as usize == model);
        part.is_some_and(|part| materials[part].opaque)
    });
    let clear_and_opaque =
        |(opaque, bounds): (bool, Bounds)| std::iter::once((false, bounds)).chain(opaque.then_some((true, bounds)));
    opaque.zip(bounds).filter(|(_, bounds)| !bounds.is_empty()).flat_map(clear_and_opaque).collect()
}

/// Bounds of the transmissive parts and of the opaque ones near them; of all parts if none transmits.
fn glass_and_near(parts: &[(bool, Bounds)]) -> Bounds {
    let glass = union(parts, false);
    if glass.is_empty() {
        return union(parts, true);
    }
    // Near: reaching into the glass's box grown by half its radius, and not so large that it would coarsen the cells.
    let margin = glam::DVec3::splat(glass.radius() * 0.5);
    let (min, max) = (glass.min - margin, glass.max + margin);
    let near = parts.iter().filter(|(opaque, b)| *opaque && b.min.cmple(max).all() && b.max.cmpge(min).all());
    near.map(|(_, b)| glass.union(*b)).filter(|both| both.radius() <= glass.radius() * 2.0).fold(glass, Bounds::union)
}

fn union(parts: &[(bool, Bounds)], opaque: bool) -> Bounds {
    parts.iter().filter(|(o, _)| *o == opaque).fold(Bounds::EMPTY, |sum, (_, b)| sum.union(*b))
}
