//! The stages up to the records and the fill, run one by one.

use crate::gpu;
use glam::{DVec3, UVec3, Vec3};
use murrine::animate::{Animate, Triangles};
use murrine::fill::FillInterior;
use murrine::gpu::{Recorder, Timing, buffer};
use murrine::grid::Grid;
use murrine::resolve::Resolve;
use murrine::scene::description::{Model, Scene, Shape, Source, VoxelizerSettings};
use murrine::scene::{World, pose::pose_vertices};
use murrine::volume::{Record, Volume};
use murrine::voxelize::{self, Input, Voxelizer};

/// A scene of shapes, animated, and the stages up to the records.
pub(crate) struct Stages {
    pub(crate) triangles: Triangles,
    pub(crate) positions: Vec<(Vec3, Vec3)>,
    pub(crate) indices: Vec<[u32; 3]>,
    pub(crate) volume: Volume,
    pub(crate) voxelizer: Box<dyn Voxelizer>,
    pub(crate) resolve: Resolve,
    pub(crate) fill: FillInterior,
}

impl Stages {
    pub(crate) fn of(shapes: &[Shape]) -> Self {
        let models = shapes.iter().map(|s| Model { source: Source::Shape(*s), ..Model::default() }).collect();
        let scene = Scene { models, ..Scene::default() };
        Self::of_scene(&scene)
    }

    pub(crate) fn of_scene(scene: &Scene) -> Self {
        Self::of_world(scene, &World::load(scene, None).unwrap())
    }

    pub(crate) fn of_world(scene: &Scene, world: &World) -> Self {
        let pose = world.pose(scene, 0.0);
        let mut animate = Animate::new(gpu()).unwrap();
        let triangles = animate.upload(gpu(), world).unwrap();
        animate.write_materials(gpu(), &triangles, &world.materials(scene));
        let mut rec = Recorder::new(gpu(), Timing::Off);
        animate.record(&mut rec, &triangles, world, scene, &pose);
        rec.finish().unwrap();
        Self {
            positions: pose_vertices(world, scene, &pose),
            indices: bytemuck::cast_slice(
                &buffer::read::<u32>(gpu(), &triangles.indices, 0, 3 * triangles.triangle_count as usize).unwrap(),
            )
            .to_vec(),
            triangles,
            volume: Volume::new(gpu()).unwrap(),
            voxelizer: (voxelize::method("triangle-parallel").unwrap().new)(gpu()).unwrap(),
            resolve: Resolve::new(gpu()).unwrap(),
            fill: FillInterior::new(gpu()).unwrap(),
        }
    }

    /// One frame of every grid, up to the records.
    pub(crate) fn render(&mut self, grids: &[Grid]) {
        self.volume.fit(gpu(), grids).unwrap();
        let mut rec = Recorder::new(gpu(), Timing::Off);
        for grid in 0..grids.len() {
            self.volume.clear(&mut rec, grid);
            let settings = &VoxelizerSettings::default();
            let input = Input { volume: &self.volume, grid, triangles: &self.triangles, settings };
            self.voxelizer.record(&mut rec, &input).unwrap();
            self.resolve.record(&mut rec, &self.volume, grid, &self.triangles);
        }
        rec.finish().unwrap();
    }

    /// The eager fill of one grid, its words read back.
    pub(crate) fn filled(&mut self, grid: Grid, repair: bool) -> Vec<u32> {
        self.volume.fit(gpu(), &[grid]).unwrap();
        let mut rec = Recorder::new(gpu(), Timing::Off);
        self.volume.clear(&mut rec, 0);
        self.fill.record(&mut rec, &self.volume, 0, &self.triangles, repair);
        rec.finish().unwrap();
        self.volume.settle(gpu()).unwrap();
        self.words(&self.volume.interior, 0)
    }

    /// The corners of every triangle as the host's reference poses them.
    pub(crate) fn corners(&self) -> Vec<[DVec3; 3]> {
        self.indices.iter().map(|t| t.map(|v| self.positions[v as usize].0.as_dvec3())).collect()
    }

    pub(crate) fn words(&self, of: &wgpu::Buffer, grid: usize) -> Vec<u32> {
        let g = self.volume.grids[grid];
        buffer::read(gpu(), of, u64::from(g.word_base), g.word_count() as usize).unwrap()
    }

    /// The marked cells in the order of their ranks.
    pub(crate) fn cells(&self, grid: usize) -> Vec<UVec3> {
        let g = self.volume.grids[grid];
        let mut cells = Vec::new();
        for (i, mut word) in (0..).zip(self.words(&self.volume.occupancy, grid)) {
            let column = i / g.words_per_column;
            while word != 0 {
                let z = i % g.words_per_column * 32 + word.trailing_zeros();
                cells.push(UVec3::new(column % g.cells.x, column / g.cells.x, z));
                word &= word - 1;
            }
        }
        cells
    }

    pub(crate) fn records(&self, grid: usize) -> Vec<Record> {
        let g = self.volume.grids[grid];
        let count = self.volume.counts()[grid].occupied.min(g.record_capacity);
        buffer::read(gpu(), &self.volume.records, u64::from(g.record_base), count as usize).unwrap()
    }
}
