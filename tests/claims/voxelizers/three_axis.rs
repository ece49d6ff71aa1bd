//! What `three-axis` finds, what its published blending loses, and what its scan fill makes a solid of.

use super::{
    Random, Triangle, count, faults, from_within, in_perspective, mesh, settings_of, soup, sphere, torus, turned,
    upload, words,
};
use crate::gpu;
use glam::{DVec3, UVec3, Vec3};
use murrine::gpu::{Recorder, Timing, buffer};
use murrine::grid::Grid;
use murrine::scene::description::{Blending, Fill, Separability, Shape, VoxelizerSettings};
use murrine::volume::Volume;
use murrine::voxelize::{self, Input, Sheets, exact_voxels};

fn settings(three_axis_blending: Blending) -> VoxelizerSettings {
    VoxelizerSettings { three_axis_blending, ..settings_of("three-axis") }
}

/// What the method leaves of a grid.
struct Marked {
    occupancy: Vec<u32>,
    interior: Vec<u32>,
    sheets: Vec<u32>,
}

fn mark(grid: Grid, triangles: &[Triangle]) -> Marked {
    let mut volume = Volume::new(gpu()).unwrap();
    volume.fit(gpu(), &[grid]).unwrap();
    let settings = VoxelizerSettings { fill: Fill::Eager, ..settings(Blending::Or) };
    let mut voxelizer = (voxelize::method("three-axis").unwrap().new)(gpu()).unwrap();
    let mut rec = Recorder::new(gpu(), Timing::Off);
    volume.clear(&mut rec, 0);
    let input = Input { volume: &volume, grid: 0, triangles: &upload(triangles), settings: &settings };
    voxelizer.record(&mut rec, &input).unwrap();
    rec.finish().unwrap();
    let of_grid = |words| buffer::read(gpu(), words, 0, grid.word_count() as usize).unwrap();
    let sheets = voxelizer.sheets().unwrap();
    let last = Sheets::sheet(grid.cells, 2);
    let texels = last.first + last.size.element_product() * last.patches;
    Marked {
        occupancy: of_grid(&volume.occupancy),
        interior: of_grid(&volume.interior),
        sheets: buffer::read(gpu(), &sheets.words, 0, texels as usize).unwrap(),
    }
}

#[test]
fn three_axes_miss_less_than_one_and_add_nothing() {
    let cells = UVec3::new(100, 64, 80);
    for grid in [turned(cells), in_perspective(cells), from_within(cells)] {
        // A steep wall is what a single axis misses most of.
        let wall = [DVec3::new(2.0, 1.0, 0.0), DVec3::new(70.0, 3.0, 60.0), DVec3::new(60.0, 2.0, 2.0)];
        let wall = vec![wall.map(|p| grid.world_point(p).as_vec3())];
        for (body, at_most) in [(sphere(), 1.0), (torus(), 1.0), (soup(300), 1.0), (wall, 0.8)] {
            let truth = exact_voxels(&grid, &body, Separability::TwentySix);
            let uploaded = upload(&body);
            let of = |settings: &VoxelizerSettings| faults(&words(grid, &uploaded, settings), &truth);
            let (three, one) = (of(&settings(Blending::Or)), of(&settings_of("slicemap")));
            assert_eq!(three.spurious, 0);
            let share = f64::from(three.missing) / f64::from(one.missing);
            assert!(share <= at_most && three.missing > 0, "{three:?}, slicemap {one:?}");
        }
    }
}

#[test]
fn what_three_axes_find_hangs_on_no_axis() {
    // The same body with its axes renamed, in a cube whose planes lie off all vertices.
    let grid = Grid::world_aligned(DVec3::splat(-0.987_654), 2.0 / 60.0, UVec3::splat(64));
    let body = torus();
    let turned: Vec<Triangle> = body.iter().map(|t| t.map(|p| Vec3::new(p.z, p.x, p.y))).collect();
    let [straight, turned] = [body, turned].map(|b| words(grid, &upload(&b), &settings(Blending::Or)));
    let is_set = |words: &[u32], cell: [u32; 3]| words[grid.word_of(cell)] >> (cell[2] & 31) & 1 == 1;
    let mut differ = 0;
    for (x, y, z) in (0..64).flat_map(|x| (0..64).flat_map(move |y| (0..64).map(move |z| (x, y, z)))) {
        differ += u32::from(is_set(&straight, [x, y, z]) != is_set(&turned, [z, x, y]));
    }
    let found = count(&straight);
    // Rasterizers snap corners to 1/256 pixel, other coordinates each time.
    assert!(found > 3000 && differ * 200 < found, "{differ} of {found} differ");
    let sliced = |words: &[Triangle]| count(&super::words(grid, &upload(words), &settings_of("slicemap")));
    let flat: Vec<Triangle> = mesh(&Shape::Box { min: Vec3::new(-0.7, -0.7, -0.01), max: Vec3::new(0.7, 0.7, 0.01) });
    let upright: Vec<Triangle> = flat.iter().map(|t| t.map(|p| Vec3::new(p.z, p.x, p.y))).collect();
    assert!(sliced(&flat) > 5 * sliced(&upright), "one axis of projection is told from three");
}

#[test]
fn blending_by_addition_loses_voxels_where_triangles_meet() {
    let grid = turned(UVec3::splat(96));
    let triangles = soup(500);
    let uploaded = upload(&triangles);
    let [united, added] = [Blending::Or, Blending::Additive].map(|b| words(grid, &uploaded, &settings(b)));
    let lost: u32 = united.iter().zip(&added).map(|(or, add)| (or & !add).count_ones()).sum();
    let strange: u32 = united.iter().zip(&added).map(|(or, add)| (add & !or).count_ones()).sum();
    assert!(lost > 20 && strange > 20, "{lost} lost, {strange} strange");
    // A triangle by itself meets no voxel twice, so nothing carries.
    for triangle in triangles.iter().take(20) {
        let [united, added] =
            [Blending::Or, Blending::Additive].map(|b| words(grid, &upload(&[*triangle]), &settings(b)));
        assert_eq!(united, added);
    }
}

#[test]
fn added_bits_carry_and_end_at_255() {
    let grid = Grid::world_aligned(DVec3::ZERO, 1.0, UVec3::splat(32));
    // A square across the columns at a depth, so many times.
    let at =
        |z: f32, times: usize| vec![[Vec3::new(4.2, 4.2, z), Vec3::new(9.7, 4.2, z), Vec3::new(4.2, 9.7, z)]; times];
    let column = |triangles: &[Triangle], blending| {
        let words = words(grid, &upload(triangles), &settings(blending));
        words[grid.word_of([5, 5, 0])]
    };
    assert_eq!(column(&at(3.5, 2), Blending::Or), 1 << 3);
    assert_eq!(column(&at(3.5, 2), Blending::Additive), 1 << 4);
    assert_eq!(column(&at(3.5, 3), Blending::Additive), 3 << 3);
    // 2⁷ + 2⁷ is more than the component holds; the next component gets nothing.
    assert_eq!(column(&at(15.5, 2), Blending::Additive), 0xff << 8);
    assert_eq!(column(&[at(8.5, 1), at(7.5, 2)].concat(), Blending::Additive), 0xff | 1 << 8);
}

#[test]
fn the_sheets_hold_what_the_worksheet_unites() {
    let cells = UVec3::new(70, 40, 50);
    let grid = turned(cells);
    let marked = mark(grid, &torus());
    let mut united = vec![0; marked.occupancy.len()];
    for axis in 0..3 {
        let sheet = Sheets::sheet(cells, axis);
        let mut bits = 0;
        for texel in 0..sheet.size.element_product() * sheet.patches {
            let word = marked.sheets[(sheet.first + texel) as usize];
            bits += word.count_ones();
            let (u, v) = (texel % sheet.size.x, texel / sheet.size.x % sheet.size.y);
            let slab = texel / sheet.size.element_product();
            for bit in (0..32).filter(|bit| word >> bit & 1 == 1) {
                let mut cell = [0; 3];
                (cell[(axis + 1) % 3], cell[(axis + 2) % 3], cell[axis]) = (u, v, slab * 32 + bit);
                united[grid.word_of(cell)] |= 1 << (cell[2] & 31);
            }
        }
        assert!(bits > 100, "the torus has {bits} voxels along axis {axis}");
    }
    assert!(united == marked.occupancy);
}

/// Cells whose middle lies deeper within a body than `depth` and that are not solid, and those farther outside that are.
fn solid_faults(grid: &Grid, interior: &[u32], depth: f64, inside: impl Fn(DVec3) -> f64) -> (u32, u32) {
    let (mut missing, mut spurious) = (0, 0);
    let UVec3 { x, y, z } = grid.cells;
    for cell in (0..x).flat_map(|x| (0..y).flat_map(move |y| (0..z).map(move |z| [x, y, z]))) {
        let middle = inside(grid.world_point(UVec3::from_array(cell).as_dvec3() + 0.5));
        let is_solid = interior[grid.word_of(cell)] >> (cell[2] & 31) & 1 == 1;
        missing += u32::from(!is_solid && middle > depth);
        spurious += u32::from(is_solid && middle < -depth);
    }
    (missing, spurious)
}

#[test]
fn scan_fill_makes_a_closed_body_solid_but_for_streaks() {
    let grid = turned(UVec3::new(100, 64, 80));
    let cell = f64::from(grid.cell_size);
    let ball = |p: DVec3| 0.9 - p.length();
    let marked = mark(grid, &sphere());
    // Where triangles change their axis a line may meet the surface twice on its way in: its flag is wrong from there on.
    let (missing, spurious) = solid_faults(&grid, &marked.interior, cell, ball);
    assert!(
        spurious == 0 && missing > 0 && missing * 20 < count(&marked.interior),
        "{missing} missing, {spurious} spurious"
    );
    let is_part = marked.occupancy.iter().zip(&marked.interior).all(|(surface, solid)| surface & !solid == 0);
    assert!(is_part && count(&marked.interior) > 4 * count(&marked.occupancy));
    // A ball that is told to be smaller is not that ball.
    let (_, spurious) = solid_faults(&grid, &marked.interior, cell, |p| ball(p) - 4.0 * cell);
    assert!(spurious > 1000);

    // Lines that graze the hole turn their flag for nothing, too.
    let ring = |p: DVec3| 0.23 - DVec3::new((p.x * p.x + p.z * p.z).sqrt() - 0.7, p.y, 0.0).length();
    let marked = mark(grid, &torus());
    let (missing, spurious) = solid_faults(&grid, &marked.interior, cell, ring);
    assert!((missing + spurious) * 20 < count(&marked.interior), "{missing} missing, {spurious} spurious");

    // Half a ball: along most lines the flag is never turned back.
    let half: Vec<Triangle> = sphere().into_iter().filter(|t| t.iter().all(|p| p.x < 0.0)).collect();
    let (missing, spurious) = solid_faults(&grid, &mark(grid, &half).interior, cell, ball);
    assert!(missing > 1000 || spurious > 1000, "{missing} missing, {spurious} spurious");
}

#[test]
fn sheets_take_the_same_bits_every_time() {
    let mut random = Random(5);
    let triangles: Vec<Triangle> = (0..3000)
        .map(|_| {
            let at = random.point(0.8);
            [0; 3].map(|_| at + random.point(0.2))
        })
        .collect();
    let grid = turned(UVec3::new(129, 140, 150));
    let uploaded = upload(&triangles);
    for blending in [Blending::Or, Blending::Additive] {
        let first = words(grid, &uploaded, &settings(blending));
        assert!((0..4).all(|_| words(grid, &uploaded, &settings(blending)) == first));
    }
}
