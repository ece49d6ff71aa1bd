//! What the volume holds: ranks, winners, records, and room for them.

use crate::gpu;
use crate::stages::Stages;
use glam::{DVec3, UVec3, Vec2, Vec3};
use murrine::grid::Grid;
use murrine::scene::description::Shape;

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
        let mut bench = Stages::of(&[Shape::Icosphere { radius: 1.0, subdivisions: 4 }]);
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
    let mut bench = Stages::of(&[Shape::Icosphere { radius: 1.0, subdivisions: 5 }]);
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
