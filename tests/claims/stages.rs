//! The stages up to the records and the fill, run one by one.
#![expect(clippy::cast_possible_truncation, reason = "small whole numbers")]

use crate::gpu;
use glam::{DVec3, UVec3, Vec2, Vec3};
use murrine::animate::{Animate, Triangles, Vertex};
use murrine::fill::FillInterior;
use murrine::gpu::{Recorder, Timing, buffer};
use murrine::grid::Grid;
use murrine::resolve::Resolve;
use murrine::scene::description::{Fill, Model, Scene, Shape, Source, VoxelizerSettings};
use murrine::scene::material::PartMaterial;
use murrine::scene::{World, pose::pose_vertices};
use murrine::volume::{Record, Volume};
use murrine::voxelize::{self, Input, Voxelizer};

/// The point that a record keeps, in its cell: 0 … 1 within it.
pub(crate) fn point_of(bits: u32) -> Vec3 {
    UVec3::new(bits & 1023, (bits >> 10) & 1023, (bits >> 20) & 1023).as_vec3() / 1023.0 * 2.0 - 0.5
}

/// A unit vector from its octahedral code.
pub(crate) fn unit_of(bits: u32) -> Vec3 {
    let fraction = |bits: u32| f32::from(bits as u16 as i16) / 32767.0;
    let p = Vec2::new(fraction(bits), fraction(bits >> 16));
    let z = 1.0 - p.x.abs() - p.y.abs();
    let folded = (Vec2::ONE - Vec2::new(p.y, p.x).abs()) * p.map(|v| if v >= 0.0 { 1.0 } else { -1.0 });
    (if z >= 0.0 { p } else { folded }).extend(z).normalize()
}

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
        Self::with(triangles, pose_vertices(world, scene, &pose))
    }

    /// Triangles that stand where they are.
    pub(crate) fn standing(corners: &[[Vec3; 3]]) -> Self {
        let normal = |t: &[Vec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]).normalize_or_zero();
        let vertex = |position, normal| Vertex { position, part: 0, normal, mirrored: 0 };
        let vertices: Vec<_> = corners.iter().flat_map(|t| t.map(|p| vertex(p, normal(t)))).collect();
        let indices: Vec<_> = (0..u32_of(corners.len())).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let material: PartMaterial = bytemuck::Zeroable::zeroed();
        let triangles = Triangles::still(gpu(), &vertices, &indices, &[material]).unwrap();
        Self::with(triangles, vertices.iter().map(|v| (v.position, v.normal)).collect())
    }

    fn with(triangles: Triangles, positions: Vec<(Vec3, Vec3)>) -> Self {
        Self {
            positions,
            indices: buffer::read(gpu(), &triangles.indices, 0, triangles.triangle_count as usize).unwrap(),
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
        self.volume.count(&mut rec);
        rec.finish().unwrap();
    }

    /// The records of words that the host marked.
    pub(crate) fn resolve_words(&mut self, grid: Grid, words: &[u32]) {
        self.volume.fit(gpu(), &[grid]).unwrap();
        let mut rec = Recorder::new(gpu(), Timing::Off);
        self.volume.clear(&mut rec, 0);
        rec.finish().unwrap();
        let first = u64::from(self.volume.grids[0].word_base) * 4;
        gpu().queue.write_buffer(&self.volume.occupancy, first, bytemuck::cast_slice(words));
        let mut rec = Recorder::new(gpu(), Timing::Off);
        self.resolve.record(&mut rec, &self.volume, 0, &self.triangles);
        rec.finish().unwrap();
        assert!(self.volume.settle(gpu()).unwrap());
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

    /// What a method that writes the interior itself makes of one grid: the interior's words and the surface's.
    pub(crate) fn solid(&mut self, grid: Grid, method: &str) -> [Vec<u32>; 2] {
        self.volume.fit(gpu(), &[grid]).unwrap();
        let settings = VoxelizerSettings { method: method.into(), fill: Fill::Eager, ..Default::default() };
        let mut voxelizer = (voxelize::method(method).unwrap().new)(gpu()).unwrap();
        let mut rec = Recorder::new(gpu(), Timing::Off);
        self.volume.clear(&mut rec, 0);
        let input = Input { volume: &self.volume, grid: 0, triangles: &self.triangles, settings: &settings };
        voxelizer.record(&mut rec, &input).unwrap();
        rec.finish().unwrap();
        [self.words(&self.volume.interior, 0), self.words(&self.volume.occupancy, 0)]
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

    /// Records of further sheets, those that have room.
    pub(crate) fn extras(&self, grid: usize) -> Vec<Record> {
        let g = self.volume.grids[grid];
        let count = self.volume.counts()[grid].extras.min(g.extra_capacity);
        buffer::read(gpu(), &self.volume.records, u64::from(g.extra_base), count as usize).unwrap()
    }

    pub(crate) fn records(&self, grid: usize) -> Vec<Record> {
        let g = self.volume.grids[grid];
        let count = self.volume.counts()[grid].occupied.min(g.record_capacity);
        buffer::read(gpu(), &self.volume.records, u64::from(g.record_base), count as usize).unwrap()
    }
}

fn u32_of(count: usize) -> u32 {
    u32::try_from(count).unwrap()
}
