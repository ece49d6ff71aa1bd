//! `murrine bench storage`: what dense volumes and our records cost, and what each makes of a refracted picture.
//!
//! Source: CL §2.1 and §5 and DO Table 2 compare storages by memory and time; RB §3.5 weighs the list against its locks.
//! A ball of glass is voxelized, stored in each way and marched by the paper's marcher; the way out of each ray is held
//! against Snell's law in closed form. All ways take turns within one run.

use super::{BenchError, Spread, findings::mib};
use crate::animate::Animate;
use crate::dense::{self, Dense, DenseVolume, Storage};
use crate::gpu::{Gpu, GpuError, Recorder, Timing, buffer};
use crate::resolve::Resolve;
use crate::scene::description::{
    Background, Camera, Cells, MaterialOverride, Model, Scene, Shadow, Shape, Source, VoxelizerSettings,
};
use crate::scene::{Pose, World};
use crate::surroundings::{SurroundingsBuffers, surroundings};
use crate::volume::Volume;
use crate::voxel_cameras::VoxelCameras;
use crate::voxel_list::{ListedVoxel, LockedList, VoxelList};
use crate::voxelize::{self, Voxelizer};
use glam::{DVec3, UVec2, Vec3};
use serde::Serialize;
use std::fmt::Write as _;

/// The ball's index.
const IOR: f64 = 1.5;
/// How far off the eye stands, radii.
const EYE: f64 = 5.0;
const FOV_DEG: f64 = 30.0;
/// Rays that pass the ball's middle further away than this, radii, are left out.
const IMPACT: f64 = 0.95;
/// Rounds before the timed ones: pipelines warm up, and the volume grows until it fits.
const WARM_UP: u32 = 3;

/// One storage at one grid.
#[derive(Debug, Clone, Serialize)]
pub struct StorageRow {
    /// Cells along each axis.
    pub cells: u32,
    /// Its name.
    pub storage: &'static str,
    /// What it takes.
    pub bytes: u64,
    /// Milliseconds to fill it once the voxels are resolved; 0 for the records, which are what is resolved.
    pub fill: Spread,
    /// Milliseconds to march.
    pub march: Spread,
    /// Median error of the direction in which rays leave, degrees.
    pub median_deg: f64,
    /// The error that 95 of 100 rays stay below, degrees.
    pub p95_deg: f64,
}

/// Both ways to a voxel list at one grid.
#[derive(Debug, Clone, Serialize)]
pub struct ListRow {
    /// Cells along each axis.
    pub cells: u32,
    /// Voxels in the list, the same either way.
    pub voxels: usize,
    /// Milliseconds to mark, rank and list cells.
    pub by_rank: Spread,
    /// Milliseconds to mark and list cells alone behind locks.
    pub by_lock: Spread,
    /// Milliseconds more for the attributes of the voxels, once they are resolved.
    pub attributes: Spread,
}

/// All of it.
#[derive(Debug, Clone, Serialize)]
pub struct StorageReport {
    /// The adapter's name.
    pub adapter: String,
    /// Storages, grid by grid.
    pub rows: Vec<StorageRow>,
    /// Lists, grid by grid.
    pub lists: Vec<ListRow>,
}

/// A voxelized ball, ready to be stored and marched.
struct Ball {
    volume: Volume,
    triangles: crate::animate::Triangles,
    surroundings: SurroundingsBuffers,
    voxelizer: Box<dyn Voxelizer>,
    settings: VoxelizerSettings,
    resolve: Resolve,
    cos_angle_threshold: f32,
    max_events: u32,
}

/// Compares the storages, and the lists, for a ball at each grid, by pictures of `pixels`².
///
/// # Errors
/// When the device is lost or refuses a buffer or a texture.
pub fn storage(
    gpu: &Gpu,
    grids: &[u32],
    pixels: u32,
    iterations: u32,
    mut progress: impl FnMut(&str),
) -> Result<StorageReport, BenchError> {
    let mut report = StorageReport { adapter: gpu.info.name.clone(), rows: Vec::new(), lists: Vec::new() };
    let passes = Dense::new(gpu)?;
    for &cells in grids {
        progress(&format!("{cells}³"));
        let mut ball = Ball::new(gpu, cells, pixels)?;
        report.rows.extend(ball.compare(gpu, &passes, cells, pixels, iterations)?);
        report.lists.push(ball.lists(gpu, cells, iterations)?);
    }
    Ok(report)
}

impl Ball {
    fn new(gpu: &Gpu, cells: u32, pixels: u32) -> Result<Self, BenchError> {
        let scene = scene(cells);
        let world = World::load(&scene, None)?;
        let (pose, materials) = (world.pose(&scene, 0.0), world.materials(&scene));
        let mut animate = Animate::new(gpu)?;
        let triangles = animate.upload(gpu, &world)?;
        animate.write_materials(gpu, &triangles, &materials);
        animate_once(gpu, &animate, &triangles, &world, &scene, &pose)?;
        let cameras = VoxelCameras::fit(&scene, &world, &materials, &pose);
        let around = SurroundingsBuffers::new(gpu, &world)?;
        around.write(gpu, &surroundings(&scene, &world, &materials, (1.0, pixels), &[], None));
        let mut ball = Self {
            volume: Volume::new(gpu)?,
            triangles,
            surroundings: around,
            voxelizer: (voxelize::method(&scene.voxelizer.method)?.new)(gpu)?,
            settings: scene.voxelizer.clone(),
            resolve: Resolve::new(gpu)?,
            cos_angle_threshold: scene.effect.angle_threshold_deg.to_radians().cos(),
            max_events: scene.effect.max_events,
        };
        for _ in 0..WARM_UP {
            ball.volume.fit(gpu, &cameras.grids)?;
            let mut rec = Recorder::new(gpu, Timing::Off);
            ball.mark(&mut rec)?;
            ball.resolve.record(&mut rec, &ball.volume, 0, &ball.triangles);
            rec.finish()?;
            if ball.volume.settle(gpu)? {
                return Ok(ball);
            }
        }
        Err(GpuError::Lost("the volume was still too small; choose a smaller grid".to_owned()).into())
    }

    fn mark(&mut self, rec: &mut Recorder<'_>) -> Result<(), GpuError> {
        self.volume.clear(rec, 0);
        let Self { volume, triangles, settings, .. } = self;
        self.voxelizer.record(rec, &voxelize::Input { volume, grid: 0, triangles, settings })
    }

    fn compare(
        &self,
        gpu: &Gpu,
        passes: &Dense,
        cells: u32,
        pixels: u32,
        iterations: u32,
    ) -> Result<Vec<StorageRow>, BenchError> {
        let size = UVec2::splat(pixels);
        let exits = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("exits"),
            size: wgpu::Extent3d { width: pixels, height: pixels, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Float,
            usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = exits.create_view(&wgpu::TextureViewDescriptor::default());
        let input = dense::Input {
            volume: &self.volume,
            triangles: &self.triangles,
            surroundings: &self.surroundings,
            size,
            cos_angle_threshold: self.cos_angle_threshold,
            max_events: self.max_events,
        };
        let grid_cells = self.volume.grids[0].cells;
        let mut times = [const { (Vec::new(), Vec::new()) }; Storage::ALL.len()];
        let mut rows = Vec::new();
        for iteration in 0..1 + iterations {
            for (storage, (fill, march)) in Storage::ALL.into_iter().zip(&mut times) {
                // One texture at a time: the largest takes most of a small device's memory.
                let volume = DenseVolume::new(gpu, storage, grid_cells)?;
                let mut rec = Recorder::new(gpu, Timing::Submit);
                rec.stage("fill")?;
                passes.record_fill(&mut rec, &self.volume, &volume);
                rec.stage("march")?;
                passes.record_march(&mut rec, &input, &volume, &view);
                let stages = rec.finish()?;
                let ms = |name: &str| stages.iter().find(|(stage, _)| *stage == name).map_or(0.0, |(_, ms)| *ms);
                if iteration == 0 {
                    let (median_deg, p95_deg) = errors(&buffer::read_texture(gpu, &exits)?, pixels);
                    let bytes = if storage == Storage::Records { self.record_bytes() } else { volume.bytes };
                    let (fill, march) = (Spread::of(&[]), Spread::of(&[]));
                    rows.push(StorageRow { cells, storage: storage.name(), bytes, fill, march, median_deg, p95_deg });
                } else {
                    fill.push(if storage == Storage::Records { 0.0 } else { ms("fill") });
                    march.push(ms("march"));
                }
            }
        }
        for (row, (fill, march)) in rows.iter_mut().zip(&times) {
            (row.fill, row.march) = (Spread::of(fill), Spread::of(march));
        }
        Ok(rows)
    }

    /// What the march reads: occupancy, ranks and records, as many as there are.
    fn record_bytes(&self) -> u64 {
        let counts = self.volume.counts().first().map_or(0, |c| u64::from(c.occupied) + u64::from(c.extras));
        let words = self.volume.grids.first().map_or(0, |g| u64::from(g.word_count()));
        words * 8 + counts * size_of::<crate::volume::Record>() as u64
    }

    fn lists(&mut self, gpu: &Gpu, cells: u32, iterations: u32) -> Result<ListRow, BenchError> {
        let occupied = self.volume.counts().first().map_or(0, |c| c.occupied);
        let list = VoxelList::new(gpu)?;
        let locks = LockedList::new(gpu, occupied)?;
        let listed = buffer::storage(gpu, "voxel_list", u64::from(occupied) * size_of::<ListedVoxel>() as u64)?;
        let (mut by_rank, mut by_lock, mut attributes) = (Vec::new(), Vec::new(), Vec::new());
        for iteration in 0..1 + iterations {
            let mut rec = Recorder::new(gpu, Timing::Submit);
            rec.stage("lock")?;
            self.volume.clear(&mut rec, 0);
            locks.record(&mut rec, &self.volume, 0, &self.triangles);
            rec.stage("mark")?;
            self.mark(&mut rec)?;
            self.resolve.record_rank(&mut rec, &self.volume, 0);
            rec.stage("resolve")?;
            self.resolve.record_winners(&mut rec, &self.volume, 0, &self.triangles);
            self.resolve.record_records(&mut rec, &self.volume, 0, &self.triangles);
            rec.stage("list")?;
            list.record(&mut rec, &self.volume, 0, &self.triangles, &listed);
            let stages = rec.finish()?;
            let ms = |name: &str| stages.iter().find(|(stage, _)| *stage == name).map_or(0.0, |(_, ms)| *ms);
            if iteration > 0 {
                by_lock.push(ms("lock"));
                by_rank.push(ms("mark"));
                attributes.push(ms("list"));
            }
        }
        let [by_rank, by_lock, attributes] = [by_rank, by_lock, attributes].map(|ms| Spread::of(&ms));
        Ok(ListRow { cells, voxels: locks.read(gpu)?.len(), by_rank, by_lock, attributes })
    }
}

fn animate_once(
    gpu: &Gpu,
    animate: &Animate,
    triangles: &crate::animate::Triangles,
    world: &World,
    scene: &Scene,
    pose: &Pose,
) -> Result<(), GpuError> {
    let mut rec = Recorder::new(gpu, Timing::Off);
    animate.record(&mut rec, triangles, world, scene, pose);
    rec.finish().map(|_| ())
}

/// A smooth ball of glass of 70,224 triangles, as a whole in the picture.
fn scene(cells: u32) -> Scene {
    #[expect(clippy::cast_possible_truncation, reason = "small plain numbers")]
    let (ior, eye, fov_deg) = (IOR as f32, EYE as f32, FOV_DEG as f32);
    let mut scene = Scene {
        models: vec![Model {
            name: "ball".to_owned(),
            source: Source::Shape(Shape::Sphere { radius: 1.0, rings: 133 }),
            materials: vec![MaterialOverride { ior: Some(ior), ..MaterialOverride::default() }],
            ..Model::default()
        }],
        background: Background::Color { color: Vec3::ZERO },
        camera: Camera { eye: Vec3::new(0.0, 0.0, eye), fov_deg, ..Camera::default() },
        ..Scene::default()
    };
    scene.effect.shadow = Shadow::None;
    scene.grid.cells = Cells::Longest(cells);
    scene
}

/// Median and 95th percentile of the angle between the rays' ways out and Snell's, degrees; a ray that never left is as
/// far off as can be.
fn errors(exits: &[[f32; 4]], pixels: u32) -> (f64, f64) {
    let tan = (FOV_DEG.to_radians() * 0.5).tan();
    let mut errors = Vec::new();
    for (i, exit) in (0..).zip(exits) {
        let at = |pixel: u32| (f64::from(pixel) + 0.5) / f64::from(pixels) * 2.0 - 1.0;
        let direction = DVec3::new(at(i % pixels) * tan, -at(i / pixels) * tan, -1.0).normalize();
        if let Some(truth) = through_ball(DVec3::new(0.0, 0.0, EYE), direction) {
            let found = Vec3::new(exit[0], exit[1], exit[2]).as_dvec3();
            let angle = found.cross(truth).length().atan2(found.dot(truth)).to_degrees();
            errors.push(if exit[3] == 1.0 { angle } else { 180.0 });
        }
    }
    errors.sort_by(f64::total_cmp);
    let at = |share: usize| errors.get(errors.len() * share / 100).copied().unwrap_or(f64::NAN);
    (at(50), at(95))
}

/// The way on which a ray leaves the unit ball; `None` where it passes too near the rim.
fn through_ball(eye: DVec3, direction: DVec3) -> Option<DVec3> {
    let along = eye.dot(direction);
    let off2 = eye.length_squared() - along * along;
    if off2 > IMPACT * IMPACT {
        return None;
    }
    let refract = |d: DVec3, n: DVec3, eta: f64| {
        let c = -d.dot(n);
        eta * d + (eta * c - (1.0 - eta * eta * (1.0 - c * c)).sqrt()) * n
    };
    let entry = eye - (along + (1.0 - off2).sqrt()) * direction;
    let inside = refract(direction, entry, 1.0 / IOR);
    let exit = entry - 2.0 * entry.dot(inside) * inside;
    Some(refract(inside, -exit, IOR))
}

impl StorageReport {
    /// As an aligned table.
    #[must_use]
    pub fn table(&self) -> String {
        let mut text = format!("{}\nmilliseconds: median (min–max)\n\n", self.adapter);
        // Writing to a string can't fail.
        let _ = writeln!(
            text,
            "{:6} {:26} {:>9} {:>22} {:>22} {:>9} {:>8}",
            "cells", "storage", "MiB", "fill ms", "march ms", "median °", "p95 °"
        );
        let spread = |s: &Spread| format!("{:.2} ({:.2}–{:.2})", s.median, s.min, s.max);
        for row in &self.rows {
            let StorageRow { cells, storage, median_deg, p95_deg, .. } = row;
            let (bytes, fill, march) = (mib(row.bytes), spread(&row.fill), spread(&row.march));
            let _ = writeln!(
                text,
                "{:6} {storage:26} {bytes:9.2} {fill:>22} {march:>22} {median_deg:9.3} {p95_deg:8.2}",
                format!("{cells}³")
            );
        }
        text.push_str("\nvoxel list, marking included\n");
        for row in &self.lists {
            let ListRow { cells, voxels, .. } = row;
            let [by_rank, by_lock, attributes] = [&row.by_rank, &row.by_lock, &row.attributes].map(spread);
            let _ = writeln!(
                text,
                "{:6} {voxels:8} voxels  by rank {by_rank}  by locks {by_lock}  attributes {attributes}",
                format!("{cells}³")
            );
        }
        text
    }
}
