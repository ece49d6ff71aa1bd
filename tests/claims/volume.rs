//! What the volume holds: ranks, winners, records, and room for them.
//!
//! Distances are measured in half cells of each axis, as winners measure them.
#![expect(clippy::cast_possible_truncation, reason = "small whole numbers")]

mod growth;

use crate::gpu;
use crate::probe;
use crate::stages::{Stages, point_of, unit_of};
use glam::{DMat3, DMat4, DVec2, DVec3, UVec3, Vec3, Vec4};
use murrine::gpu::GpuStruct;
use murrine::grid::Grid;
use murrine::scene::description::{Deformer, Model, Scene, Shape, Source};
use murrine::volume::{Record, Volume};

/// A sphere's bounds with a margin of a cell, in cubes.
fn around_unit_ball(cells: u32) -> Grid {
    let size = 2.0 / f64::from(cells - 2);
    Grid::world_aligned(DVec3::splat(-1.0 - size), size, UVec3::splat(cells))
}

#[test]
fn ranks_count_the_voxels_before_each_word() {
    for cells in [UVec3::splat(128), UVec3::new(33, 17, 70), UVec3::new(16, 16, 512), UVec3::splat(512)] {
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
fn a_world_without_triangles_makes_an_empty_volume() {
    for shapes in [&[][..], &[Shape::Plane { size: 4.0 }]] {
        let mut stages = Stages::of(shapes);
        stages.render(&[around_unit_ball(16)]);
        assert!(stages.volume.settle(gpu()).unwrap());
        assert_eq!(stages.volume.counts()[0].occupied, 0);
        assert!(stages.filled(around_unit_ball(16), true).iter().all(|w| *w == 0));
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

const TRIANGLE: u32 = 0xff_ffff;
const ORPHAN: u32 = 1 << 24;
/// The most that a nearness of 8 bits may be wrong by, in half cells, and f32 with it.
const NEARNESS_STEP: f64 = 2.0 / 254.0 + 1e-3;

fn extra_count(record: &Record) -> u32 {
    record.point >> 30
}

fn extra_first(record: &Record) -> u32 {
    record.medium >> 12
}

/// A triangle in half cells about a cell's centre.
fn about(grid: &Grid, cell: UVec3, corners: [DVec3; 3]) -> [DVec3; 3] {
    let (lo, hi) = (grid.slab(f64::from(cell.z)), grid.slab(f64::from(cell.z) + 1.0));
    let center = DVec3::new(f64::from(cell.x) + 0.5, f64::from(cell.y) + 0.5, 0.5 * (lo + hi));
    corners.map(|p| (grid.grid_point(p) - center) / DVec3::new(0.5, 0.5, 0.5 * (hi - lo)))
}

/// Whether a triangle meets the cell: something of it is left when the cell's six sides have cut it.
fn meets(corners: [DVec3; 3]) -> bool {
    let [a, b, c] = corners;
    if a.min(b).min(c).max_element() > 1.0 || a.max(b).max(c).min_element() < -1.0 {
        return false;
    }
    let mut polygon = corners.to_vec();
    for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0)] {
        let out = |p: DVec3| sign * p[axis] - 1.0;
        let next = polygon.iter().cycle().skip(1);
        polygon = (polygon.iter().zip(next))
            .flat_map(|(p, q)| {
                let cut = (out(*p) > 0.0) != (out(*q) > 0.0);
                let at = *p + (*q - *p) * (out(*p) / (out(*p) - out(*q)));
                [(out(*p) <= 0.0).then_some(*p), cut.then_some(at)].into_iter().flatten()
            })
            .collect();
    }
    !polygon.is_empty()
}

/// From a cell's centre to the closest point of a triangle, in half cells.
fn offset_from(grid: &Grid, cell: UVec3, corners: [DVec3; 3]) -> DVec3 {
    let [a, b, c] = about(grid, cell, corners);
    let on_segment = |a: DVec3, b: DVec3| a + (b - a) * (-a.dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    let normal = (b - a).cross(c - a);
    let within = [(a, b), (b, c), (c, a)].iter().all(|(u, v)| u.cross(*v).dot(normal) >= 0.0);
    let foot = normal * (a.dot(normal) / normal.length_squared());
    let candidates = [on_segment(a, b), on_segment(b, c), on_segment(c, a)];
    let nearest = candidates.into_iter().min_by(|p, q| p.length().total_cmp(&q.length())).unwrap();
    if within { foot } else { nearest }
}

fn spot(cells: UVec3) -> Grid {
    let eye = DVec3::new(1.0, 3.0, 2.0);
    let z = -eye.normalize();
    let x = z.cross(DVec3::Y).normalize();
    let world_from_eye = DMat4::from_translation(eye) * DMat4::from_mat3(DMat3::from_cols(x, z.cross(x), z));
    Grid::perspective(world_from_eye, DVec2::splat(-0.4), DVec2::splat(0.4), 2.4, 5.1, cells)
}

#[test]
fn a_record_is_of_the_nearest_triangle_and_its_plane() {
    let mut stages = Stages::of(&[
        Shape::Icosphere { radius: 1.0, subdivisions: 2 },
        Shape::Box { min: Vec3::new(-0.33, -0.21, -0.44), max: Vec3::new(0.31, 0.27, 0.93) },
    ]);
    let corners = stages.corners();
    for grid in [around_unit_ball(28), spot(UVec3::new(34, 30, 28))] {
        stages.render(&[grid]);
        assert!(stages.volume.settle(gpu()).unwrap());
        assert_eq!(stages.volume.counts()[0].orphans, 0);
        let mut second_nearest_is_further = 0;
        for (cell, record) in stages.cells(0).iter().zip(&stages.records(0)) {
            let winner = (record.triangle & TRIANGLE) as usize;
            let of_winner = offset_from(&grid, *cell, corners[winner]).length();
            let mut distances: Vec<f64> = (corners.iter().filter(|t| meets(about(&grid, *cell, **t))))
                .map(|t| offset_from(&grid, *cell, *t).length())
                .collect();
            distances.sort_by(f64::total_cmp);
            let nearest = distances.first().copied().unwrap_or(f64::INFINITY);
            assert!(of_winner <= nearest + NEARNESS_STEP, "{cell}: {of_winner}, the nearest is {nearest}");
            second_nearest_is_further +=
                u32::from(distances.get(1).is_some_and(|d| *d > nearest + 2.0 * NEARNESS_STEP));

            let [a, b, c] = corners[winner];
            let normal = (b - a).cross(c - a).normalize();
            assert!(unit_of(record.normal).as_dvec3().dot(normal) > 1.0 - 1e-6, "{cell}");
            let in_cell = point_of(record.point).as_dvec3();
            let offset = offset_from(&grid, *cell, corners[winner]);
            assert!((in_cell * 2.0 - 1.0 - offset).abs().max_element() < 4e-3, "{cell}: {in_cell} for {offset}");
            assert_eq!(record.medium & 0xfff, stages_part(winner, &stages), "{cell}");
        }
        // The comparison can tell triangles apart.
        assert!(second_nearest_is_further > 100, "{second_nearest_is_further}");
    }
}

/// The ball's triangles come first.
fn stages_part(triangle: usize, stages: &Stages) -> u32 {
    u32::from(triangle >= stages.indices.len() - 12)
}

#[test]
fn a_wall_of_a_third_of_a_cell_keeps_both_its_faces() {
    let cells = 32;
    let (near, far) = (0.31 / 16.0, 0.61 / 16.0);
    let mut stages = Stages::of(&[Shape::Box { min: Vec3::new(-0.8, -0.8, near), max: Vec3::new(0.8, 0.8, far) }]);
    let grid = Grid::world_aligned(DVec3::splat(-1.0), 1.0 / 16.0, UVec3::splat(cells));
    stages.render(&[grid]);
    assert!(stages.volume.settle(gpu()).unwrap());
    let (records, extras) = (stages.records(0), stages.extras(0));
    let mut walls = 0;
    for (cell, record) in stages.cells(0).iter().zip(&records) {
        let within = |i: u32| (5..27).contains(&i);
        assert_eq!(cell.z, 16);
        if within(cell.x) && within(cell.y) {
            walls += 1;
            assert_eq!(extra_count(record), 1, "{cell}");
            let other = extras[extra_first(record) as usize];
            // The nearer face first: the far one is 0.11 cells from the centre.
            assert!(unit_of(record.normal).z > 0.999 && unit_of(other.normal).z < -0.999, "{cell}");
            assert!((point_of(record.point).z - 0.61).abs() < 3e-3 && (point_of(other.point).z - 0.31).abs() < 3e-3);
        }
    }
    assert_eq!(walls, 22 * 22);
    assert_eq!(extras.len(), records.iter().map(|r| extra_count(r) as usize).sum::<usize>());
    // A lone face has but one sheet.
    let lone =
        Stages::standing(&[[Vec3::new(-0.8, -0.8, near), Vec3::new(0.8, -0.8, near), Vec3::new(0.0, 0.8, near)]]);
    let mut stages = lone;
    stages.render(&[grid]);
    assert!(stages.volume.settle(gpu()).unwrap());
    assert_eq!(stages.volume.counts()[0].extras, 0);
}

fn wavy(amplitude: f32) -> Stages {
    let deformers = vec![
        Deformer::Wave { axis: 0, along: 1, amplitude, wavelength: 0.5, hz: 0.0 },
        Deformer::Wave { axis: 1, along: 2, amplitude, wavelength: 0.4, hz: 0.0 },
    ];
    let source = Source::Shape(Shape::Icosphere { radius: 1.0, subdivisions: 5 });
    Stages::of_scene(&Scene { models: vec![Model { source, deformers, ..Model::default() }], ..Scene::default() })
}

/// All that the volume holds of a grid.
fn contents(stages: &Stages) -> (Vec<u32>, Vec<u32>, Vec<Record>, Vec<Record>) {
    let volume = &stages.volume;
    (stages.words(&volume.occupancy, 0), stages.words(&volume.ranks, 0), stages.records(0), stages.extras(0))
}

#[test]
fn the_same_frame_holds_the_same_bytes_ten_times_over() {
    let grid = Grid::world_aligned(DVec3::splat(-1.3), 2.6 / 128.0, UVec3::splat(128));
    let mut stages = wavy(0.1);
    stages.render(&[grid]);
    assert!(stages.volume.settle(gpu()).unwrap());
    let first = contents(&stages);
    assert!(!first.3.is_empty(), "no further sheets to compare");
    for _ in 0..9 {
        stages.render(&[grid]);
        assert!(contents(&stages) == first);
    }
    let mut other = wavy(0.1001);
    other.render(&[grid]);
    assert!(other.volume.settle(gpu()).unwrap());
    assert!(contents(&other) != first, "another body must give other bytes");
}

/// Many small triangles all over a cube of 16 cells: more voxels and sheets than any estimate.
fn soup() -> Stages {
    let mut state = 1_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let mut point = |scale: f32| Vec3::new(next(), next(), next()) * scale;
    let corners: Vec<_> = (0..4000)
        .map(|_| {
            let center = point(16.0);
            [center, center + point(1.5), center + point(1.5)]
        })
        .collect();
    Stages::standing(&corners)
}

#[test]
fn what_has_no_room_is_dropped_in_order_and_the_next_frame_makes_room() {
    let grid = Grid::world_aligned(DVec3::ZERO, 1.0, UVec3::splat(16));
    let mut stages = soup();
    stages.render(&[grid]);
    assert!(!stages.volume.settle(gpu()).unwrap());
    assert!(!stages.volume.fits());
    let few = contents(&stages);
    let counted = stages.volume.counts()[0];
    let (records, extras) = (few.2.len() as u32, few.3.len() as u32);
    assert!(records < counted.occupied && extras < counted.extras, "{counted:?} in {records}, {extras}");
    let dropped = few.2.iter().filter(|r| extra_count(r) > 0 && extra_first(r) + extra_count(r) > extras).count();
    assert_eq!(dropped, 0, "a record promises sheets that have no room");

    for _ in 0..2 {
        stages.render(&[grid]);
        if stages.volume.settle(gpu()).unwrap() {
            break;
        }
    }
    assert!(stages.volume.fits());
    let all = contents(&stages);
    assert_eq!(all.2.len() as u32, counted.occupied);
    assert!(few.0 == all.0 && few.1 == all.1, "occupancy and ranks need no room");
    let same_but_sheets = |a: &Record, b: &Record| {
        (a.triangle, a.normal, a.point & 0x3fff_ffff) == (b.triangle, b.normal, b.point & 0x3fff_ffff)
    };
    assert!(few.2.iter().zip(&all.2).all(|(a, b)| same_but_sheets(a, b)));
    assert!(few.3.iter().zip(&all.3).all(|(a, b)| a == b), "sheets are dropped from the end");
}

#[test]
fn room_grows_a_frame_late_without_waiting_and_then_stays() {
    let grid = Grid::world_aligned(DVec3::ZERO, 1.0, UVec3::splat(16));
    let mut stages = soup();
    stages.render(&[grid]);
    let estimated = stages.volume.grids[0].record_capacity;
    // The device is given time, as a frame shown would; nothing is asked of it.
    gpu().device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    assert_eq!(stages.volume.fit(gpu(), &[grid]).unwrap(), [true]);
    let grown = stages.volume.grids[0].record_capacity;
    assert!(grown > estimated);
    stages.render(&[grid]);
    gpu().device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    assert_eq!(stages.volume.fit(gpu(), &[grid]).unwrap(), [false], "all fits: the grid stands");
    assert!(stages.volume.fits());
    assert_eq!(stages.volume.counts()[0].occupied, stages.cells(0).len() as u32);
}

#[test]
fn grids_share_the_buffers_and_keep_out_of_each_others_regions() {
    let grids = [around_unit_ball(40), spot(UVec3::new(44, 36, 40)), around_unit_ball(24)];
    let mut together = Stages::of(&[Shape::Icosphere { radius: 1.0, subdivisions: 3 }]);
    together.render(&grids);
    assert!(together.volume.settle(gpu()).unwrap());
    for (number, grid) in grids.iter().enumerate() {
        let mut alone = Stages::of(&[Shape::Icosphere { radius: 1.0, subdivisions: 3 }]);
        alone.render(&[*grid]);
        assert!(alone.volume.settle(gpu()).unwrap());
        let words = |s: &Stages, g| (s.words(&s.volume.occupancy, g), s.words(&s.volume.ranks, g));
        assert!(words(&together, number) == words(&alone, 0));
        assert!(together.records(number) == alone.records(0));
        assert!(together.extras(number) == alone.extras(0));
    }
}

#[test]
fn a_grid_that_does_not_fit_the_device_is_refused_with_a_remedy_and_the_old_one_stands() {
    let mut volume = Volume::new(gpu()).unwrap();
    let small = around_unit_ball(16);
    volume.fit(gpu(), &[small]).unwrap();
    let huge = Grid::world_aligned(DVec3::ZERO, 1.0, UVec3::splat(512));
    volume.fit(gpu(), &[huge]).unwrap();
    let error = volume.fit(gpu(), &[huge; 16]).unwrap_err().to_string();
    assert!(error.contains("choose a smaller grid"), "{error}");
    assert_eq!(volume.grids.len(), 1);
    assert!(volume.occupancy.size() >= 512 * 512 * 16 * 4);
}

#[test]
fn voxels_that_no_triangle_claims_take_their_neighbours_normal() {
    let mut stages = Stages::of(&[Shape::Icosphere { radius: 1.0, subdivisions: 4 }]);
    let grid = around_unit_ball(48);
    stages.render(&[grid]);
    assert!(stages.volume.settle(gpu()).unwrap());
    // Half a cell further out than any method marks: the column's next cell outward, on the side of larger z.
    let cells = stages.cells(0);
    let mut words = stages.words(&stages.volume.occupancy, 0);
    let marked = |words: &[u32], c: UVec3| words[grid.word_of(c.to_array())] >> (c.z & 31) & 1 == 1;
    let mut added = Vec::new();
    for cell in cells {
        let beyond = cell + UVec3::Z;
        if beyond.z < 48 && !marked(&words, beyond) && cell.z > 30 {
            words[grid.word_of(beyond.to_array())] |= 1 << (beyond.z & 31);
            added.push(beyond);
        }
    }
    stages.resolve_words(grid, &words);
    let counted = stages.volume.counts()[0].orphans as usize;
    assert!(counted > added.len() / 2 && counted <= added.len(), "{counted} of {}", added.len());
    let mut orphans = 0;
    for (cell, record) in stages.cells(0).iter().zip(&stages.records(0)) {
        if record.triangle & ORPHAN != 0 {
            orphans += 1;
            assert!(added.contains(cell), "{cell} was marked by a triangle");
            let outward = grid.world_point(cell.as_dvec3() + 0.5).normalize();
            assert!(unit_of(record.normal).as_dvec3().dot(outward) > 0.98, "{cell}");
        }
    }
    assert_eq!(orphans, counted);
}

#[test]
fn packing_and_unpacking_on_the_device_go_round() {
    let pass = probe::compile(
        "#include \"lib/record.inc.wgsl\"
        @group(0) @binding(0) var<storage, read> questions: array<vec4f>;
        @group(0) @binding(1) var<storage, read_write> answers: array<array<vec4f, 2>>;
        @compute @workgroup_size(1) fn main(@builtin(global_invocation_id) id: vec3u) {
            let q = questions[id.x].xyz;
            answers[id.x][0] = vec4f(unpack_point_in_cell(pack_point_in_cell(q)), bitcast<f32>(pack_point_in_cell(q)));
            answers[id.x][1] = vec4f(unpack_unit(pack_unit(normalize(q))), bitcast<f32>(pack_unit(normalize(q))));
        }",
        &[Record::LAYOUT],
    );
    let steps = || [-0.5, -0.01, 0.3, 0.73, 1.5].into_iter();
    let questions: Vec<Vec4> = steps()
        .flat_map(|x| steps().flat_map(move |y| steps().map(move |z| Vec4::new(x, y, z, 0.0))))
        .chain([Vec4::X, Vec4::Y, Vec4::Z, -Vec4::X, -Vec4::Y, -Vec4::Z])
        .collect();
    let answers: Vec<[Vec4; 2]> = probe::ask(&pass, &[], &questions);
    for (asked, [point, unit]) in questions.iter().zip(&answers) {
        let asked = asked.truncate();
        // The host's own unpacking, which the other claims go by, agrees.
        assert!(point_of(point.w.to_bits()).distance(point.truncate()) < 1e-6);
        assert!(unit_of(unit.w.to_bits()).distance(unit.truncate()) < 1e-5);
        let near = asked.clamp(Vec3::splat(-0.5), Vec3::splat(1.5));
        assert!((point.truncate() - near).abs().max_element() <= 1.0 / 1023.0 + 1e-6, "{asked}: {point}");
        assert!(unit.truncate().distance(asked.normalize()) < 1e-4, "{asked}: {unit}");
    }
    assert_eq!(answers.len(), 131);
    let distinct = |of: fn(&[Vec4; 2]) -> u32| answers.iter().map(of).collect::<std::collections::BTreeSet<_>>().len();
    assert!(distinct(|a| a[0].w.to_bits()) > 125 && distinct(|a| a[1].w.to_bits()) > 100);
}

#[test]
fn the_memory_shown_is_that_of_the_buffers_and_small_for_256() {
    let mut stages = Stages::of(&[Shape::Sphere { radius: 1.0, rings: 132 }]);
    let mut bytes = [0_u64; 2];
    for (bytes, cells) in bytes.iter_mut().zip([128, 256]) {
        stages.volume = Volume::new(gpu()).unwrap();
        let grid = around_unit_ball(cells);
        for _ in 0..3 {
            stages.render(&[grid]);
            if stages.volume.settle(gpu()).unwrap() {
                break;
            }
        }
        let memory = stages.volume.memory();
        *bytes = memory.iter().map(|(_, bytes)| bytes).sum();
        assert_eq!(stages.volume.records.size(), memory.iter().find(|(name, _)| *name == "records").unwrap().1);
    }
    let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    assert!(mib(bytes[1]) <= 32.0, "{:.1} MiB at 256³", mib(bytes[1]));
    let growth = bytes[1] as f64 / bytes[0] as f64;
    assert!((3.0..5.5).contains(&growth), "{growth} times from 128³ to 256³");
}
