//! What the volume holds: ranks, winners, records, and room for them.

use crate::gpu;
use glam::{DVec3, UVec3, Vec2, Vec3};
use murrine::animate::{Animate, Triangles};
use murrine::gpu::{Recorder, Timing, buffer};
use murrine::grid::Grid;
use murrine::resolve::Resolve;
use murrine::scene::description::{Model, Scene, Shape, Source, VoxelizerSettings};
use murrine::scene::{World, pose::pose_vertices};
use murrine::volume::{Record, Volume};
use murrine::voxelize::{self, Input, Voxelizer};

/// A scene of shapes, animated, and the stages up to the records.
pub(crate) struct Bench {
    pub(crate) triangles: Triangles,
    pub(crate) positions: Vec<(Vec3, Vec3)>,
    pub(crate) indices: Vec<[u32; 3]>,
    pub(crate) volume: Volume,
    pub(crate) voxelizer: Box<dyn Voxelizer>,
    pub(crate) resolve: Resolve,
}

impl Bench {
    pub(crate) fn of(shapes: &[Shape]) -> Self {
        let models = shapes.iter().map(|s| Model { source: Source::Shape(*s), ..Model::default() }).collect();
        let scene = Scene { models, ..Scene::default() };
        Self::of_scene(&scene)
    }

    pub(crate) fn of_scene(scene: &Scene) -> Self {
        let world = World::load(scene, None).unwrap();
        let pose = world.pose(scene, 0.0);
        let mut animate = Animate::new(gpu()).unwrap();
        let triangles = animate.upload(gpu(), &world).unwrap();
        animate.write_materials(gpu(), &triangles, &world.materials(scene));
        let mut rec = Recorder::new(gpu(), Timing::Off);
        animate.record(&mut rec, &triangles, &world, scene, &pose);
        rec.finish().unwrap();
        Self {
            positions: pose_vertices(&world, scene, &pose),
            indices: bytemuck::cast_slice(
                &buffer::read::<u32>(gpu(), &triangles.indices, 0, 3 * triangles.triangle_count as usize).unwrap(),
            )
            .to_vec(),
            triangles,
            volume: Volume::new(gpu()).unwrap(),
            voxelizer: (voxelize::method("triangle-parallel").unwrap().new)(gpu()).unwrap(),
            resolve: Resolve::new(gpu()).unwrap(),
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

/// A sphere's bounds with a margin of a cell, in cubes.
fn around_unit_ball(cells: u32) -> Grid {
    let size = 2.0 / f64::from(cells - 2);
    Grid::world_aligned(DVec3::splat(-1.0 - size), size, UVec3::splat(cells))
}

#[test]
fn ranks_count_the_voxels_before_each_word() {
    for cells in [UVec3::splat(128), UVec3::new(33, 17, 70), UVec3::new(16, 16, 512)] {
        let mut bench = Bench::of(&[Shape::Icosphere { radius: 1.0, subdivisions: 4 }]);
        let grid = Grid::world_aligned(DVec3::splat(-1.1), 2.2 / 33.0, cells);
        bench.render(&[grid]);
        assert!(bench.volume.settle(gpu()).unwrap());
        let words = bench.words(&bench.volume.occupancy, 0);
        let ranks = bench.words(&bench.volume.ranks, 0);
        let mut sum = 0;
        for (word, rank) in words.iter().zip(&ranks) {
            assert_eq!(*rank, sum);
            sum += word.count_ones();
        }
        assert!(sum > 1000, "{sum} voxels");
        assert_eq!(bench.volume.counts()[0].occupied, sum);
    }
}

#[test]
fn every_record_of_a_ball_lies_on_it_and_points_outward() {
    let mut bench = Bench::of(&[Shape::Icosphere { radius: 1.0, subdivisions: 5 }]);
    let grid = around_unit_ball(64);
    bench.render(&[grid]);
    assert!(bench.volume.settle(gpu()).unwrap());
    assert_eq!(bench.volume.counts()[0].orphans, 0);
    let cells = bench.cells(0);
    let records = bench.records(0);
    assert_eq!(records.len(), cells.len());
    for (record, cell) in records.iter().zip(&cells) {
        let normal = unit_of(record.normal);
        let point = grid.world_from_grid.transform_point3(cell.as_vec3() + point_of(record.point));
        // The icosphere's flat faces lie at most 0.1% below the ball; points are stored to 1/1023 cell.
        assert!((point.length() - 1.0).abs() < 2e-3, "{cell}: {point}");
        assert!(normal.dot(point.normalize()) > 0.999, "{cell}: {normal}");
    }
}
