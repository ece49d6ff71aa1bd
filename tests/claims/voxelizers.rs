//! What the voxelizers promise: every exact method marks the voxels that `cpu-exact` marks, and `cpu-exact` marks those
//! that a triangle cut to a voxel's box leaves something in.

mod effects;
mod hybrid;
mod ramp;
mod rasterized;
mod shapes;
mod slabs;
mod three_axis;
mod truth;

use crate::gpu;
use crate::support::left_out;
use glam::{DMat3, DMat4, DVec3, UVec3, Vec3};
use murrine::animate::{Triangles, Vertex};
use murrine::gpu::{Gpu, GpuError, Recorder, Timing, buffer};
use murrine::grid::{Grid, PERSPECTIVE};
use murrine::scene::description::{
    Blending, Bounds, Camera, Cells, ColumnLoop, GridSettings, Light, LightKind, Projection, Separability, Shape,
    VoxelizerSettings,
};
use murrine::scene::gltf;
use murrine::scene::material::{PartMaterial, flags};
use murrine::scene::shapes::shape;
use murrine::volume::Volume;
use murrine::voxelize::{self, ExactVoxels, Input, Promise, Voxelizer, exact_voxels};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;

/// A triangle in world space.
type Triangle = [Vec3; 3];

fn vertex(position: Vec3) -> Vertex {
    Vertex { position, normal: Vec3::Z, ..bytemuck::Zeroable::zeroed() }
}

/// Triangles in world space, as `animate` would leave them.
fn upload(triangles: &[Triangle]) -> Triangles {
    upload_to(gpu(), triangles)
}

fn upload_to(gpu: &Gpu, triangles: &[Triangle]) -> Triangles {
    let vertices: Vec<Vertex> = triangles
        .iter()
        .flatten()
        .map(|&position| Vertex { position, part: 0, normal: Vec3::Z, mirrored: 0 })
        .collect();
    let count = u32::try_from(triangles.len()).unwrap();
    let indices: Vec<[u32; 3]> = (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let material: PartMaterial = bytemuck::Zeroable::zeroed();
    Triangles::still(gpu, &vertices, &indices, &[material]).unwrap()
}

thread_local! {
    /// Compiled voxelizers of this test.
    static MADE: RefCell<BTreeMap<String, Box<dyn Voxelizer>>> = const { RefCell::new(BTreeMap::new()) };
}

/// The words of `grid` as a method marks them.
fn words(grid: Grid, triangles: &Triangles, settings: &VoxelizerSettings) -> Vec<u32> {
    try_words(grid, triangles, settings).unwrap()
}

/// As [`words`], where the method may refuse.
fn try_words(grid: Grid, triangles: &Triangles, settings: &VoxelizerSettings) -> Result<Vec<u32>, GpuError> {
    let mut volume = Volume::new(gpu()).unwrap();
    let count = (grid.word_base + grid.word_count()) as usize;
    volume.occupancy = buffer::storage(gpu(), "occupancy", 4 * count as u64).unwrap();
    volume.interior = buffer::storage(gpu(), "interior", 4 * count as u64).unwrap();
    gpu().queue.write_buffer(&volume.grid_data, 0, bytemuck::bytes_of(&grid));
    volume.grids = vec![grid];
    let mut rec = Recorder::new(gpu(), Timing::Off);
    MADE.with_borrow_mut(|made| {
        let new = || (voxelize::method(&settings.method).unwrap().new)(gpu()).unwrap();
        let voxelizer = made.entry(settings.method.clone()).or_insert_with(new);
        voxelizer.record(&mut rec, &Input { volume: &volume, grid: 0, triangles, settings })
    })?;
    rec.finish()?;
    buffer::read(gpu(), &volume.occupancy, 0, count)
}

/// Voxels that differ from the truth, ties left out.
#[derive(Debug, PartialEq, Eq, Clone, Copy)]
struct Faults {
    missing: u32,
    spurious: u32,
}

fn faults(words: &[u32], truth: &ExactVoxels) -> Faults {
    let mut faults = Faults { missing: 0, spurious: 0 };
    for ((&got, &want), &tie) in words.iter().zip(&truth.words).zip(&truth.ties) {
        faults.missing += (want & !got & !tie).count_ones();
        faults.spurious += (got & !want & !tie).count_ones();
    }
    faults
}

fn count(words: &[u32]) -> u32 {
    words.iter().map(|w| w.count_ones()).sum()
}

const BOTH: [Separability; 2] = [Separability::TwentySix, Separability::Six];

/// The method that the others are held to.
const TRUTH: &str = "cpu-exact";

fn exact_methods() -> impl Iterator<Item = &'static str> {
    voxelize::METHODS.iter().filter(|m| m.promise == Promise::Exact).map(|m| m.name)
}

fn settings_of(method: &str) -> VoxelizerSettings {
    VoxelizerSettings { method: method.to_owned(), ..Default::default() }
}

/// Every exact method on the device with every setting that may change its way but not its voxels.
fn exact_ways(separability: Separability) -> Vec<(String, VoxelizerSettings)> {
    let mut ways = Vec::new();
    let two_ended =
        VoxelizerSettings { separability, column_loop: ColumnLoop::TwoEnded, ..settings_of("exact-columns") };
    ways.push(("exact-columns, two-ended".to_owned(), two_ended));
    for method in exact_methods().filter(|m| *m != TRUTH) {
        let cutoffs = if method == "hybrid" { &[None, Some(0.0), Some(4.0), Some(100.0)][..] } else { &[None] };
        for &cutoff_cells2 in cutoffs {
            let method = method.to_owned();
            let name = cutoff_cells2.map_or_else(|| method.clone(), |cells2| format!("{method}, {cells2} cells²"));
            ways.push((name, VoxelizerSettings { method, separability, cutoff_cells2, ..Default::default() }));
        }
    }
    ways
}

/// Those, and the methods that look along several axes.
fn all_ways() -> Vec<(String, VoxelizerSettings)> {
    let three_axis = |three_axis_blending: Blending| {
        let settings = VoxelizerSettings { three_axis_blending, ..settings_of("three-axis") };
        (format!("three-axis, {three_axis_blending:?}"), settings)
    };
    let mut ways = exact_ways(Separability::TwentySix);
    ways.extend([Blending::Or, Blending::Additive].map(three_axis));
    ways
}

/// Fails unless every exact method equals the truth in every voxel that is no tie.
fn assert_all_exact(what: &str, grid: Grid, triangles: &[Triangle]) {
    let uploaded = upload(triangles);
    for separability in BOTH {
        let truth = exact_voxels(&grid, triangles, separability);
        let (marked, ties) = (count(&truth.words), count(&truth.ties));
        for (name, settings) in exact_ways(separability) {
            let faults = faults(&words(grid, &uploaded, &settings), &truth);
            assert_eq!(
                faults,
                Faults { missing: 0, spurious: 0 },
                "{name}, {what}, {}, {separability:?}: of {marked} voxels, {ties} ties",
                grid.cells
            );
        }
    }
}

fn mesh(of: &Shape) -> Vec<Triangle> {
    let geometry = shape(of);
    let at = |i: u32| geometry.vertices[i as usize].position;
    geometry.triangles.iter().map(|t| t.map(at)).collect()
}

fn sphere() -> Vec<Triangle> {
    mesh(&Shape::Sphere { radius: 0.9, rings: 40 })
}

fn torus() -> Vec<Triangle> {
    torus_of(60)
}

fn torus_of(segments: u32) -> Vec<Triangle> {
    mesh(&Shape::Torus { radius: 0.7, tube: 0.23, segments })
}

/// Even numbers in 0 … 1 from a seed.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        // SplitMix64.
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1 << 24) as f32
    }

    fn point(&mut self, half: f32) -> Vec3 {
        Vec3::new(self.next() - 0.5, self.next() - 0.5, self.next() - 0.5) * (2.0 * half)
    }
}

/// Triangles of all sizes, from a hundredth of the grid to all of it.
fn soup(n: usize) -> Vec<Triangle> {
    let mut random = Random(7);
    (0..n)
        .map(|_| {
            let size = 0.01_f32.powf(random.next());
            let at = random.point(1.0);
            [0; 3].map(|_| at + random.point(size))
        })
        .collect()
}

/// Triangles that are hardly any: thin ones, segments, points, in all directions and along the axes.
fn needles() -> Vec<Triangle> {
    let mut random = Random(11);
    let mut needles = Vec::new();
    for i in 0..400 {
        let a = random.point(0.9);
        let length = 0.01_f32.powf(random.next());
        let b = a + random.point(length);
        let b = if i % 5 == 0 { Vec3::new(a.x, a.y, b.z) } else { b };
        let width = 10_f32.powf(-1.0 - 6.0 * random.next());
        let off = random.point(width);
        needles.push(match i % 4 {
            0 => [a, b, b + off],
            1 => [a, b, a.lerp(b, random.next()) + off],
            2 => [a, b, b],
            _ => [a, a, a + off * 0.1],
        });
    }
    needles
}

/// Triangles much larger than the grid, that cross it or pass it by.
fn huge() -> Vec<Triangle> {
    let mut random = Random(13);
    (0..12).map(|_| [0; 3].map(|_| random.point(6.0))).collect()
}

/// A grid of cubes about the origin that contains −1 … 1, turned by a rotation that favours no axis.
fn turned(cells: UVec3) -> Grid {
    let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.37, 0.71, -0.23);
    let cell_size = 2.0 * 1.8 / f64::from(cells.min_element());
    let world_from_grid = DMat4::from_mat3(turn)
        * DMat4::from_scale(DVec3::splat(cell_size))
        * DMat4::from_translation(cells.as_dvec3() * -0.5 + 0.137);
    Grid::orthographic(world_from_grid, cell_size, cells)
}

/// A perspective grid about the same box, seen from a corner.
fn in_perspective(cells: UVec3) -> Grid {
    let settings =
        GridSettings { cells: Cells::Each(cells), projection: Projection::Perspective, ..GridSettings::default() };
    let camera = Camera { eye: Vec3::new(2.5, 1.9, 2.2), target: Vec3::ZERO, ..Camera::default() };
    let (grid, warning) = Grid::for_camera(&settings, &camera, &Bounds { min: DVec3::NEG_ONE, max: DVec3::ONE });
    assert_eq!((grid.projection, warning), (PERSPECTIVE, None));
    grid
}

/// The first of six grids of a point light amid the body: triangles reach beside and behind it.
fn from_within(cells: UVec3) -> Grid {
    let settings = GridSettings { cells: Cells::Each(cells), ..GridSettings::default() };
    let light = Light { kind: LightKind::Point { position: Vec3::new(0.1, 0.05, -0.03) }, ..Light::default() };
    Grid::for_light(&settings, &light, &Bounds { min: DVec3::NEG_ONE, max: DVec3::ONE })[0]
}

#[test]
fn a_needle_marks_its_column_and_a_triangle_its_cells_and_those_it_touches() {
    let grid = Grid::world_aligned(DVec3::ZERO, 1.0, UVec3::splat(64));
    let corner = Vec3::splat(10.5);
    let triangles = [
        [Vec3::new(1.5, 1.5, 1.5), Vec3::new(1.5, 1.5, 40.5), Vec3::new(1.6, 1.5, 1.5)],
        [corner, corner + 10.0 * Vec3::X, corner + 10.0 * Vec3::Y],
    ];
    for (name, settings) in exact_ways(Separability::TwentySix) {
        let words = words(grid, &upload(&triangles), &settings);
        // The long side passes through ten corners of cells that it otherwise misses.
        assert_eq!(count(&words), 40 + 11 * 12 / 2 + 10, "{name}");
    }
}

#[test]
fn exact_methods_equal_the_truth_on_closed_bodies() {
    for cells in [UVec3::splat(64), UVec3::new(100, 37, 211)] {
        assert_all_exact("sphere", turned(cells), &sphere());
        assert_all_exact("torus", turned(cells), &torus());
    }
}

#[test]
fn the_truth_as_a_method_is_the_truth() {
    let mut grid = in_perspective(UVec3::new(40, 30, 50));
    let triangles = torus();
    for separability in BOTH {
        let truth = exact_voxels(&grid, &triangles, separability);
        grid.word_base = 7;
        let settings = VoxelizerSettings { method: TRUTH.into(), separability, ..Default::default() };
        assert_eq!(words(grid, &upload(&triangles), &settings)[7..], truth.words);
    }
}

/// A scanned model within −1 … 1, if it is there.
fn scanned(file: &str) -> Option<Vec<Triangle>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/models/static").join(file);
    if !path.exists() {
        left_out(file, &format!("{} is not there", path.display()));
        return None;
    }
    let geometry = gltf::read(&path).unwrap().geometry;
    let mut bounds = Bounds::EMPTY;
    geometry.vertices.iter().for_each(|v| bounds.add(v.position.as_dvec3()));
    let scale = 1.7 / (bounds.max - bounds.min).length();
    let at = |i: u32| ((geometry.vertices[i as usize].position.as_dvec3() - bounds.center()) * scale).as_vec3();
    let triangles: Vec<Triangle> = geometry.triangles.iter().map(|t| t.map(at)).collect();
    assert!(triangles.len() > 60_000);
    Some(triangles)
}

/// The scanned models, where they are; `shapes` holds the same of our own models always.
#[test]
fn exact_methods_equal_the_truth_on_scanned_bodies() {
    for (file, cells) in
        [("bunny_69666_closed.glb", UVec3::splat(128)), ("dragon_100000.glb", UVec3::new(100, 37, 211))]
    {
        if let Some(triangles) = scanned(file) {
            assert_all_exact(file, turned(cells), &triangles);
        }
    }
}

#[test]
fn exact_methods_equal_the_truth_on_a_soup_of_triangles() {
    assert_all_exact("soup", turned(UVec3::splat(64)), &soup(600));
    assert_all_exact("soup", turned(UVec3::new(100, 37, 211)), &soup(300));
}

#[test]
fn exact_methods_equal_the_truth_on_needles_segments_and_points() {
    assert_all_exact("needles", turned(UVec3::splat(128)), &needles());
    assert_all_exact("needles", turned(UVec3::splat(48)), &needles());
    assert_all_exact("needles", Grid::world_aligned(DVec3::splat(-1.0), 2.0 / 64.0, UVec3::splat(64)), &needles());
}

#[test]
fn exact_methods_equal_the_truth_on_triangles_larger_than_the_grid() {
    assert_all_exact("huge", turned(UVec3::splat(64)), &huge());
}

#[test]
fn exact_methods_equal_the_truth_in_perspective() {
    let grid = in_perspective(UVec3::new(64, 50, 90));
    assert_all_exact("torus", grid, &torus());
    assert_all_exact("soup", grid, &soup(300));
    assert_all_exact("needles", grid, &needles());
}

#[test]
fn exact_methods_equal_the_truth_around_a_light_amid_the_body() {
    let grid = from_within(UVec3::new(64, 50, 90));
    assert_all_exact("sphere", grid, &sphere());
    assert_all_exact("soup", grid, &soup(300));
    assert_all_exact("huge", grid, &huge());
}

#[test]
fn a_shifted_body_is_told_from_the_truth() {
    let grid = turned(UVec3::splat(64));
    for separability in BOTH {
        let truth = exact_voxels(&grid, &sphere(), separability);
        let shifted: Vec<Triangle> = sphere().iter().map(|t| t.map(|p| p + Vec3::X * grid.cell_size * 0.01)).collect();
        for (name, settings) in exact_ways(separability) {
            let faults = faults(&words(grid, &upload(&shifted), &settings), &truth);
            assert!(faults.missing > 0 && faults.spurious > 0, "{name}, {separability:?}: {faults:?}");
        }
    }
}

#[test]
fn a_list_of_all_triangles_changes_no_voxel() {
    // 70,224 triangles, all large by this cut-off.
    let triangles = upload(&mesh(&Shape::Sphere { radius: 0.9, rings: 133 }));
    assert!(triangles.triangle_count > 1 << 16);
    let grid = turned(UVec3::splat(64));
    let settings = VoxelizerSettings { method: "triangle-parallel".into(), ..Default::default() };
    let want = words(grid, &triangles, &settings);
    let got = words(grid, &triangles, &VoxelizerSettings { cutoff_cells2: Some(0.0), ..Default::default() });
    assert!(count(&want) > 1000);
    assert_eq!(got, want);
}

#[test]
fn the_same_triangles_mark_the_same_words_every_time() {
    let triangles = upload(&soup(2000));
    let grid = turned(UVec3::new(129, 140, 150));
    for separability in BOTH {
        for (name, settings) in exact_ways(separability) {
            let first = words(grid, &triangles, &settings);
            assert!((0..4).all(|_| words(grid, &triangles, &settings) == first), "{name}");
        }
    }
    let first = sliced(grid, &triangles, 0.1);
    assert!((0..4).all(|_| sliced(grid, &triangles, 0.1) == first));
}

#[test]
fn parts_without_the_grids_flags_are_not_voxelized() {
    let part = |part, at: Vec3| [Vec3::ZERO, Vec3::X, Vec3::Y].map(|p| Vertex { part, ..vertex(p * 10.0 + at) });
    let vertices = [part(0, Vec3::splat(3.5)), part(1, Vec3::new(3.5, 3.5, 20.5))].concat();
    let mut materials: [PartMaterial; 2] = bytemuck::Zeroable::zeroed();
    materials[1].flags = flags::OPAQUE;
    let triangles = Triangles::still(gpu(), &vertices, &[[0, 1, 2], [3, 4, 5]], &materials).unwrap();
    let mut grid = Grid::world_aligned(DVec3::ZERO, 1.0, UVec3::splat(32));
    let slices = |words: &[u32]| words.iter().fold(0, |all, w| all | w);
    for (name, settings) in all_ways() {
        grid.required_flags = 0;
        assert_eq!(slices(&words(grid, &triangles, &settings)), 1 << 3 | 1 << 20, "{name}");
        grid.required_flags = flags::OPAQUE;
        assert_eq!(slices(&words(grid, &triangles, &settings)), 1 << 20, "{name}");
    }
}

#[test]
fn vertices_that_are_no_numbers_mark_nothing() {
    let corner = Vec3::splat(3.5);
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY].map(|x| [corner, corner + Vec3::X, Vec3::new(x, 4.0, 4.0)]);
    let grid = Grid::world_aligned(DVec3::ZERO, 1.0, UVec3::splat(32));
    for (name, settings) in all_ways() {
        assert_eq!(count(&words(grid, &upload(&odd), &settings)), 0, "{name}");
    }
}

#[test]
fn a_grid_marks_its_own_region_alone() {
    let mut grid = Grid::world_aligned(DVec3::splat(-1.0), 2.0 / 32.0, UVec3::splat(32));
    let triangles = upload(&sphere());
    for (name, settings) in all_ways() {
        grid.word_base = 0;
        let alone = words(grid, &triangles, &settings);
        grid.word_base = 100;
        let region = words(grid, &triangles, &settings);
        assert!(region[..100].iter().all(|w| *w == 0) && region[100..] == alone, "{name}");
    }
}

fn sliced(grid: Grid, triangles: &Triangles, slice_overlap: f32) -> Vec<u32> {
    let settings = VoxelizerSettings { method: "slice-amplified".into(), slice_overlap, ..Default::default() };
    words(grid, triangles, &settings)
}

#[test]
fn sliced_voxels_are_those_whose_middle_line_meets_the_surface() {
    for grid in [turned(UVec3::new(100, 64, 80)), in_perspective(UVec3::new(64, 50, 90))] {
        let triangles = sphere();
        let truth = exact_voxels(&grid, &triangles, Separability::TwentySix);
        let words = sliced(grid, &upload(&triangles), 0.0);
        let found = faults(&words, &truth);
        // A closed body's middle lines meet it twice a column of its outline: 2π of the 6π + corners that it touches.
        let share = f64::from(count(&words)) / f64::from(count(&truth.words));
        assert!((0.2..0.35).contains(&share), "{} of {}", count(&words), count(&truth.words));
        assert!(found.spurious * 200 < count(&words), "{} spurious of {}", found.spurious, count(&words));
    }
}

#[test]
fn overlapping_slices_mark_more_and_lose_nothing() {
    let grid = turned(UVec3::new(100, 64, 80));
    // Rasterizers move the corners that clipping makes to 1/256 pixel, so a middle line that just grazes a loose edge may
    // be lost; on a closed body the neighbour has it.
    for (body, tolerated) in [(sphere(), 0), (torus(), 0), (soup(400), 1)] {
        let triangles = upload(&body);
        let mut before = sliced(grid, &triangles, 0.0);
        for overlap in [0.1, 0.25, 0.5, 1.0] {
            let words = sliced(grid, &triangles, overlap);
            let lost: u32 = before.iter().zip(&words).map(|(b, w)| (b & !w).count_ones()).sum();
            assert!(lost * 250 <= count(&before) * tolerated, "{lost} of {} at {overlap}", count(&before));
            assert!(count(&words) > count(&before));
            before = words;
        }
    }
}

#[test]
fn a_full_list_of_copies_loses_no_voxel() {
    // 600 triangles that each span most slices want over 130,000 copies of a list of 65,536.
    let mut random = Random(17);
    let spans: Vec<Triangle> = (0..600)
        .map(|_| {
            let at = random.point(0.8);
            [at.with_z(-0.9), at.with_z(0.9) + Vec3::X * 0.06, at.with_z(0.0) + Vec3::Y * 0.06]
        })
        .collect();
    let grid = Grid::world_aligned(DVec3::splat(-1.0), 2.0 / 256.0, UVec3::splat(256));
    let all = sliced(grid, &upload(&spans), 0.0);
    let mut parts = vec![0; all.len()];
    for part in spans.chunks(200) {
        for (sum, word) in parts.iter_mut().zip(sliced(grid, &upload(part), 0.0)) {
            *sum |= word;
        }
    }
    assert!(count(&parts) > 10_000);
    assert!(all == parts, "{} voxels, not {}", count(&all), count(&parts));
}
