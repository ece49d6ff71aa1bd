//! One mesh on the device, marked by any method into any grid, timed, and held to the truth: what the laboratory and the
//! benchmark of voxelizers measure with. Waits for the device: never part of a frame.

use crate::animate::{Animate, Triangles, Vertex};
use crate::fill::FillInterior;
use crate::gpu::{Gpu, GpuError, Recorder, Timing, buffer};
use crate::grid::Grid;
use crate::scene::description::{Fill, Separability, VoxelizerSettings};
use crate::scene::material::PartMaterial;
use crate::scene::{Scene, World};
use crate::volume::Volume;
use crate::voxelize::{self, ExactVoxels, Method, Voxelizer, exact_voxels, world_triangles};
use glam::Vec3;

/// A mesh and the grid that it is marked into.
#[derive(Debug)]
pub struct Marking {
    /// World space, as the device has them.
    pub world_triangles: Vec<[Vec3; 3]>,
    triangles: Triangles,
    volume: Volume,
    fill: FillInterior,
}

/// A method that is compiled, and the device's memory before it was.
#[derive(Debug)]
pub struct Compiled {
    method: &'static Method,
    voxelizer: Box<dyn Voxelizer>,
    bytes_before: Option<u64>,
}

/// Voxels of a method held against the true ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Faults {
    /// Voxels marked.
    pub found: u64,
    /// True ones that are not marked, ties left out.
    pub missing: u64,
    /// Marked ones that are not true, ties left out.
    pub spurious: u64,
    /// Those that differ but are true or not by less than [`voxelize::TIE_BAND`].
    pub ties: u64,
}

impl Faults {
    /// Of two sets of words.
    #[must_use]
    pub fn of(words: &[u32], truth: &ExactVoxels) -> Self {
        let mut faults = Self::default();
        for ((&got, &want), &tie) in words.iter().zip(&truth.words).zip(&truth.ties) {
            let count = |bits: u32| u64::from(bits.count_ones());
            faults.found += count(got);
            faults.missing += count(want & !got & !tie);
            faults.spurious += count(got & !want & !tie);
            faults.ties += count((got ^ want) & tie);
        }
        faults
    }
}

impl Marking {
    /// The surfaces of a scene at a time.
    ///
    /// # Errors
    /// When the device refuses a buffer, or is lost.
    pub fn of_scene(gpu: &Gpu, scene: &Scene, world: &World, time_secs: f64) -> Result<Self, GpuError> {
        let mut animate = Animate::new(gpu)?;
        let triangles = animate.upload(gpu, world)?;
        animate.write_materials(gpu, &triangles, &world.materials(scene));
        let mut rec = Recorder::new(gpu, Timing::Submit);
        rec.stage("animate")?;
        animate.record(&mut rec, &triangles, world, scene, &world.pose(scene, time_secs));
        rec.finish()?;
        Self::of(gpu, triangles)
    }

    /// Triangles in world space, as they are.
    ///
    /// # Errors
    /// As [`Marking::of_scene`].
    pub fn of_triangles(gpu: &Gpu, world_triangles: &[[Vec3; 3]]) -> Result<Self, GpuError> {
        let vertex = |position: &Vec3| Vertex { position: *position, part: 0, normal: Vec3::Z, mirrored: 0 };
        let vertices: Vec<Vertex> = world_triangles.iter().flatten().map(vertex).collect();
        let indices: Vec<[u32; 3]> = (0..).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).take(world_triangles.len()).collect();
        let material: PartMaterial = bytemuck::Zeroable::zeroed();
        Self::of(gpu, Triangles::still(gpu, &vertices, &indices, &[material])?)
    }

    /// Triangles that the device has already.
    ///
    /// # Errors
    /// As [`Marking::of_scene`].
    pub fn of(gpu: &Gpu, triangles: Triangles) -> Result<Self, GpuError> {
        let world_triangles = world_triangles(gpu, &triangles, 0)?;
        Ok(Self { world_triangles, triangles, volume: Volume::new(gpu)?, fill: FillInterior::new(gpu)? })
    }

    /// Goes on with another grid.
    ///
    /// # Errors
    /// When it does not fit the device's bindings.
    pub fn put(&mut self, gpu: &Gpu, grid: Grid) -> Result<(), GpuError> {
        self.volume.fit(gpu, &[grid])?;
        Ok(())
    }

    /// The grid, and what stands in it.
    #[must_use]
    pub fn volume(&self) -> &Volume {
        &self.volume
    }

    /// Compiles a method.
    ///
    /// # Errors
    /// When its shader is wrong, or the device is lost.
    pub fn compile(&self, gpu: &Gpu, method: &'static Method) -> Result<Compiled, GpuError> {
        let bytes_before = allocated_bytes(gpu)?;
        Ok(Compiled { method, voxelizer: (method.new)(gpu)?, bytes_before })
    }

    /// Marks the grid anew; milliseconds, clearing its words included.
    ///
    /// # Errors
    /// When the device refuses a buffer, or is lost.
    pub fn mark(&self, gpu: &Gpu, compiled: &mut Compiled, settings: &VoxelizerSettings) -> Result<f64, GpuError> {
        let mut rec = Recorder::new(gpu, Timing::Submit);
        rec.stage("voxelize")?;
        self.volume.clear(&mut rec, 0);
        let input = voxelize::Input { volume: &self.volume, grid: 0, triangles: &self.triangles, settings };
        compiled.voxelizer.record(&mut rec, &input)?;
        Ok(rec.finish()?.iter().map(|(_, ms)| ms).sum())
    }

    /// Bytes that a method needs, once it has marked: the words that it writes and what it holds between frames, where
    /// the device tells.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn bytes(&self, gpu: &Gpu, compiled: &Compiled) -> Result<Option<u64>, GpuError> {
        let words = if compiled.method.interior { 2 } else { 1 };
        let words = words * 4 * u64::from(self.volume.grids.first().map_or(0, Grid::word_count));
        let held = allocated_bytes(gpu)?.zip(compiled.bytes_before).map(|(now, before)| now.saturating_sub(before));
        Ok(held.map(|held| words + held))
    }

    /// How the voxels that a method left differ from the true ones.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn faults(&self, gpu: &Gpu, truth: &ExactVoxels) -> Result<Faults, GpuError> {
        Ok(Faults::of(&self.words(gpu, &self.volume.occupancy)?, truth))
    }

    /// How the interior that a method leaves differs from our parity fill's; nothing where it leaves none.
    ///
    /// # Errors
    /// As [`Marking::mark`].
    pub fn solid_faults(
        &self,
        gpu: &Gpu,
        compiled: &mut Compiled,
        settings: &VoxelizerSettings,
    ) -> Result<Option<Faults>, GpuError> {
        if !compiled.method.interior {
            return Ok(None);
        }
        self.mark(gpu, compiled, &VoxelizerSettings { fill: Fill::Eager, ..settings.clone() })?;
        let solid = self.words(gpu, &self.volume.interior)?;
        let mut rec = Recorder::new(gpu, Timing::Off);
        self.fill.record(&mut rec, &self.volume, 0, &self.triangles, true);
        rec.finish()?;
        let words = self.words(gpu, &self.volume.interior)?;
        Ok(Some(Faults::of(&solid, &ExactVoxels { ties: vec![0; words.len()], words })))
    }

    /// The true voxels of the grid.
    #[must_use]
    pub fn truth(&self, separability: Separability) -> ExactVoxels {
        let nothing = || ExactVoxels { words: Vec::new(), ties: Vec::new() };
        let of_grid = |grid| exact_voxels(grid, &self.world_triangles, separability);
        self.volume.grids.first().map_or_else(nothing, of_grid)
    }

    fn words(&self, gpu: &Gpu, of: &wgpu::Buffer) -> Result<Vec<u32>, GpuError> {
        let Some(grid) = self.volume.grids.first() else { return Ok(Vec::new()) };
        buffer::read(gpu, of, grid.word_base.into(), grid.word_count() as usize)
    }
}

/// Bytes that all our buffers and textures take, once what is done with is freed; none where the device does not tell.
fn allocated_bytes(gpu: &Gpu) -> Result<Option<u64>, GpuError> {
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| GpuError::Lost(e.to_string()))?;
    let report = gpu.device.generate_allocator_report();
    // What wgpu keeps for its own uploads is not the method's.
    let ours = |name: &str| !name.contains("wgpu internal");
    Ok(report.map(|r| r.allocations.iter().filter(|a| ours(&a.name)).map(|a| a.size).sum()))
}
