//! Marks a grid of any size slab by slab, and reads each back.

use crate::animate::{Animate, Triangles};
use crate::csg::Csg;
use crate::fill::FillInterior;
use crate::gpu::{Gpu, GpuError, Recorder, Timing, buffer};
use crate::grid::{Grid, Slab};
use crate::resolve::Resolve;
use crate::scene::description::{CELLS, Fill, VoxelizerSettings};
use crate::scene::{Scene, World};
use crate::volume::Volume;
use crate::voxelize::{self, Method, Voxelizer};
use glam::{DVec3, UVec3};
use std::collections::VecDeque;

/// Bytes of a slab's words, where the adapter binds more: what the host holds too, and what is done between two looks
/// at Ctrl+C. 512³ is half of it.
const SLAB_BYTES: u64 = 32 << 20;

/// The slabs of a grid, marked one after the other as they are asked for.
#[derive(Debug)]
pub struct VoxelSlabs<'g> {
    gpu: &'g Gpu,
    settings: VoxelizerSettings,
    solid: bool,
    triangles: Triangles,
    fill: FillInterior,
    method: &'static Method,
    voxelizer: Box<dyn Voxelizer>,
    volume: Volume,
    left: VecDeque<Slab>,
    warm: bool,
    ms: f64,
    bodies: Option<Bodies>,
}

/// For models that are made of others.
#[derive(Debug)]
struct Bodies {
    world: World,
    csg: Option<Csg>,
    resolve: Resolve,
}

/// A slab's voxels.
#[derive(Debug, Clone, PartialEq)]
pub struct MarkedSlab {
    /// Where it lies.
    pub slab: Slab,
    /// Words of [`Slab::grid`].
    pub words: Vec<u32>,
}

impl MarkedSlab {
    /// The kept slices one by one: a byte a cell, 1 where it is marked, \[y\]\[x\].
    pub fn into_slices(self) -> impl Iterator<Item = Vec<u8>> {
        self.slab.cell_bytes(self.words)
    }
}

impl<'g> VoxelSlabs<'g> {
    /// Prepares to mark the voxels of `grid`, an orthographic one, that the scene's surfaces meet at a time, or with
    /// `solid` those whose centre is inside.
    ///
    /// # Errors
    /// When the adapter can't hold even a thin slab, refuses a buffer, or is lost.
    pub fn new(
        gpu: &'g Gpu,
        scene: &Scene,
        world: &World,
        time_secs: f64,
        grid: Grid,
        solid: bool,
    ) -> Result<Self, GpuError> {
        let slabs = cut(gpu, &grid, SLAB_BYTES)?;
        let world = &world.at(scene, time_secs, None);
        let mut animate = Animate::new(gpu)?;
        let triangles = animate.upload(gpu, world)?;
        animate.write_materials(gpu, &triangles, &world.materials(scene));
        let mut rec = Recorder::new(gpu, Timing::Off);
        animate.record(&mut rec, &triangles, world, scene, &world.pose(scene, time_secs));
        rec.finish()?;
        let mut slabs = Self::of_triangles(gpu, triangles, &scene.voxelizer, slabs, solid)?;
        if !world.bodies.operands.is_empty() {
            slabs.bodies = Some(Bodies { world: world.clone(), csg: None, resolve: Resolve::new(gpu)? });
        }
        Ok(slabs)
    }

    /// As [`VoxelSlabs::new`] for triangles that stand on the device already, and slabs cut by [`Grid::slabs`].
    ///
    /// # Errors
    /// When the device refuses a buffer, or is lost, or the method can't fill slabs.
    pub fn of_triangles(
        gpu: &'g Gpu,
        triangles: Triangles,
        settings: &VoxelizerSettings,
        slabs: Vec<Slab>,
        solid: bool,
    ) -> Result<Self, GpuError> {
        let method = voxelize::method(&settings.method)?;
        if solid && slabs.len() > 1 && voxelize::scans_whole_columns(method) {
            return Err(GpuError::Setting(format!(
                "`{}` fills by scanning whole columns, and this grid is worked in slabs; choose another voxelizer or fewer cells",
                method.name
            )));
        }
        Ok(Self {
            gpu,
            settings: VoxelizerSettings { fill: if solid { Fill::Eager } else { settings.fill }, ..settings.clone() },
            solid,
            triangles,
            fill: FillInterior::new(gpu)?,
            method,
            voxelizer: (method.new)(gpu)?,
            volume: Volume::new(gpu)?,
            left: slabs.into(),
            warm: false,
            ms: 0.0,
            bodies: None,
        })
    }

    /// Milliseconds that marking (and filling) has taken so far, compiling left out.
    #[must_use]
    pub fn ms(&self) -> f64 {
        self.ms
    }

    fn mark(&mut self) -> Result<f64, GpuError> {
        let mut rec = Recorder::new(self.gpu, Timing::Submit);
        rec.stage("voxelize")?;
        self.volume.clear(&mut rec, 0);
        let Self { volume, triangles, settings, .. } = self;
        self.voxelizer.record(&mut rec, &voxelize::Input { volume, grid: 0, triangles, settings })?;
        if self.solid && (!self.method.interior || self.bodies.is_some()) {
            rec.stage("fill")?;
            self.fill.record(&mut rec, volume, 0, triangles, true);
        }
        if let Some(Bodies { csg: Some(csg), resolve, .. }) = &self.bodies {
            rec.stage("csg")?;
            if self.solid {
                csg.record_interior(&mut rec, volume, 0, triangles);
            } else {
                csg.record_unmark(&mut rec, resolve, volume, 0, triangles);
            }
        }
        Ok(rec.finish()?.iter().map(|(_, ms)| ms).sum())
    }

    /// Words alone, but where hidden parts of bodies are told from seen ones by their records.
    fn make_room(&mut self, slab: &Slab) -> Result<(), GpuError> {
        let Some(bodies) = &mut self.bodies else {
            return self.volume.fit_words(self.gpu, &slab.grid, self.solid || self.method.interior);
        };
        self.volume.fit(self.gpu, &[slab.grid])?;
        bodies.csg = Csg::for_world(bodies.csg.take(), self.gpu, &bodies.world, &self.volume)?;
        Ok(())
    }

    fn marked(&mut self, slab: Slab) -> Result<MarkedSlab, GpuError> {
        self.make_room(&slab)?;
        if !self.warm {
            // Compiles.
            self.mark()?;
            self.warm = true;
        }
        self.ms += self.mark()?;
        while self.bodies.is_some() && !self.volume.settle(self.gpu)? {
            self.make_room(&slab)?;
            self.ms += self.mark()?;
        }
        let words = if self.solid { &self.volume.interior } else { &self.volume.occupancy };
        let words = buffer::read(self.gpu, words, 0, slab.grid.word_count() as usize)?;
        Ok(MarkedSlab { slab, words })
    }
}

impl Iterator for VoxelSlabs<'_> {
    type Item = Result<MarkedSlab, GpuError>;

    fn next(&mut self) -> Option<Self::Item> {
        let slab = self.left.pop_front()?;
        let marked = self.marked(slab);
        if marked.is_err() {
            self.left.clear();
        }
        Some(marked)
    }
}

/// The slabs of `grid` that the adapter binds whole.
fn cut(gpu: &Gpu, grid: &Grid, most_bytes: u64) -> Result<Vec<Slab>, GpuError> {
    let allowed = buffer::largest(gpu).min(most_bytes);
    grid.slabs(allowed).ok_or_else(|| {
        let [nx, ny, _] = grid.cells.to_array();
        let (what, needed) = (format!("a slab of {nx}x{ny} columns"), 4 * u64::from(nx) * u64::from(ny));
        GpuError::Limit { what, needed, allowed, remedy: "choose fewer cells along x and y" }
    })
}

/// Cells along the axes of the largest cube that can be marked in slabs.
#[must_use]
pub fn largest_cube(gpu: &Gpu) -> u32 {
    let cube = |cells: u32| Grid::world_aligned(DVec3::ZERO, 1.0, UVec3::splat(cells));
    CELLS.rev().find(|cells| cut(gpu, &cube(*cells), SLAB_BYTES).is_ok()).unwrap_or(0)
}
