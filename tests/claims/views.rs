//! Debug views of whole frames show what the frame's own data say, pixel by pixel.

use crate::gpu;
use glam::{DVec3, UVec2, UVec3, Vec3};
use murrine::compose::DebugView;
use murrine::frame::{Frame, Request};
use murrine::gpu::{Timing, buffer};
use murrine::grid::Grid;
use murrine::march::Channel;
use murrine::scene::World;
use murrine::scene::description::Fill;
use murrine::scene::description::{
    Camera, Cells, GridSettings, Light, LightKind, MaterialOverride, Model, Projection, Scene, Shape, Source,
};
use murrine::volume::Record;
use murrine::voxelize::marked_voxels;

const SIZE: UVec2 = UVec2::new(112, 96);
const SIGMA: Vec3 = Vec3::new(0.3, 0.9, 1.8);
const SUN: Vec3 = Vec3::new(0.36, -0.8, 0.48);

/// A ball of glass that bends nothing, under a sun, in a grid that is no cube.
fn scene() -> Scene {
    let material = MaterialOverride { ior: Some(1.0), sigma: Some(SIGMA), ..MaterialOverride::default() };
    let source = Source::Shape(Shape::Icosphere { radius: 1.0, subdivisions: 5 });
    let grid = |cells| GridSettings { cells, ..GridSettings::default() };
    Scene {
        models: vec![Model { source, materials: vec![material], ..Model::default() }],
        lights: vec![Light { kind: LightKind::Directional { direction: SUN }, ..Light::default() }],
        camera: Camera { eye: Vec3::new(1.5, 1.0, 5.0), ..Camera::default() },
        grid: grid(Cells::Each(UVec3::new(33, 47, 70))),
        light_grid: grid(Cells::Longest(96)),
        ..Scene::default()
    }
}

/// A frame, its picture and its channel.
struct Shown {
    frame: Frame,
    picture: Vec<Vec3>,
    channel: Vec<[f32; 4]>,
}

fn show(scene: &Scene, view: DebugView, channel: Channel) -> Shown {
    let world = World::load(scene, None).unwrap();
    let mut frame = Frame::new(gpu()).unwrap();
    let request = Request {
        scene,
        world: &world,
        time_secs: 0.0,
        size: SIZE,
        picture_size: SIZE,
        channel,
        view,
        timing: Timing::Off,
    };
    for _ in 0..4 {
        frame.render(gpu(), &request).unwrap();
        if frame.settle(gpu()).unwrap() {
            break;
        }
    }
    let rgba: Vec<[u8; 4]> = buffer::read_texture(gpu(), frame.picture()).unwrap();
    let picture = rgba.into_iter().map(|[r, g, b, _]| Vec3::new(r.into(), g.into(), b.into()) / 255.0).collect();
    let channel = buffer::read_texture(gpu(), &frame.radiance().channel).unwrap();
    Shown { frame, picture, channel }
}

impl Shown {
    fn words(&self, grid: usize) -> (Grid, Vec<u32>) {
        let g = self.frame.volume().grids[grid];
        let volume = self.frame.volume();
        (g, buffer::read(gpu(), &volume.occupancy, u64::from(g.word_base), g.word_count() as usize).unwrap())
    }

    fn records(&self, grid: usize) -> Vec<Record> {
        let (volume, g) = (self.frame.volume(), self.frame.volume().grids[grid]);
        let count = volume.counts()[grid].occupied as usize;
        buffer::read(gpu(), &volume.records, u64::from(g.record_base), count).unwrap()
    }
}

fn light_of(color: Vec3) -> f32 {
    let linear = color.map(|x| if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) });
    linear.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

fn is_near(color: Vec3, other: Vec3) -> bool {
    (color - other).abs().max_element() < 0.012
}

const NOTHING: Vec3 = Vec3::new(0.09, 0.09, 0.11);

#[test]
fn channels_of_numbers_are_brighter_where_their_number_is_larger() {
    let mut scene = scene();
    scene.models[0].materials[0].ior = Some(1.5);
    for (channel, max, least) in
        [(Channel::Thickness, 2.0, 50), (Channel::Events, 8.0, 2), (Channel::Questionable, 1.0, 2)]
    {
        // Rays that may bend once do not come out: both kinds of ray are there.
        scene.effect.max_events = if channel == Channel::Questionable { 1 } else { 8 };
        scene.effect.fill_questionable = false;
        let shown = show(&scene, DebugView::Channel { max }, channel);
        let mut pairs: Vec<_> = shown.channel.iter().map(|c| c[0]).zip(shown.picture.iter().copied()).collect();
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut values = 1;
        for pair in pairs.windows(2) {
            let ((low, dim), (high, bright)) = (pair[0], pair[1]);
            values += u32::from(high > low);
            assert!(light_of(bright) > light_of(dim) - 0.01, "{channel:?}: {low} {dim}, {high} {bright}");
            assert!(high > low || bright == dim, "{channel:?}: one number, two colours");
        }
        assert!(values >= least, "{channel:?}: {values} values");
        let (first, last) = (pairs[0].1, pairs.last().unwrap().1);
        assert!(light_of(last) > light_of(first) + 0.05, "{channel:?}: {first} to {last}");
    }
}

#[test]
fn the_view_of_normals_is_their_numbers_as_a_colour() {
    let shown = show(&scene(), DebugView::Channel { max: 1.0 }, Channel::Normal);
    let mut seen = 0;
    for (value, color) in shown.channel.iter().zip(&shown.picture) {
        if value[0].is_nan() {
            assert!(is_near(*color, NOTHING), "{color}");
        } else {
            seen += 1;
            let n = Vec3::new(value[0], value[1], value[2]);
            assert!(is_near(*color, 0.5 + 0.5 * n), "{n} is shown as {color}");
        }
    }
    assert!(seen > 1000 && seen < shown.picture.len() - 1000, "{seen} pixels see the ball");
}

/// The pixel that shows a point of a slice, in cells across; the slice fits the picture.
fn pixel_of(at: (f64, f64), across: (u32, u32)) -> Option<usize> {
    let size = SIZE.as_dvec2();
    let pixels = (size.x / f64::from(across.0)).min(size.y / f64::from(across.1));
    let x = (at.0 - 0.5 * f64::from(across.0)) * pixels + 0.5 * size.x;
    let y = (at.1 - 0.5 * f64::from(across.1)) * pixels + 0.5 * size.y;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the picture")]
    let pixel = (y as usize) * SIZE.x as usize + x as usize;
    (x >= 0.0 && y >= 0.0 && x < size.x && y < size.y).then_some(pixel)
}

#[test]
fn a_slice_shows_its_cells_where_they_are_in_grids_of_every_shape() {
    for projection in [Projection::Orthographic, Projection::Perspective] {
        for axis in [0, 1, 2_u32] {
            let mut scene = scene();
            scene.grid.projection = projection;
            let shown = show(&scene, DebugView::Slice { axis, position: 0.52 }, Channel::Beauty);
            let (grid, words) = shown.words(0);
            let bytes = grid.cell_bytes(&words);
            let cells = grid.cells;
            let (u, v) = [(2, 1), (0, 2), (0, 1)][axis as usize];
            let (mut marked, mut others) = (0, 0);
            for y in 0..cells[v] {
                for x in 0..cells[u] {
                    let mut cell = UVec3::ZERO;
                    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a cell")]
                    let slice = (0.52 * cells[axis as usize] as f32) as u32;
                    cell[axis as usize] = slice;
                    (cell[u], cell[v]) = (x, y);
                    let Some(pixel) = pixel_of((f64::from(x) + 0.5, f64::from(y) + 0.5), (cells[u], cells[v])) else {
                        continue;
                    };
                    let color = shown.picture[pixel];
                    let plain = [Vec3::new(0.13, 0.13, 0.15), Vec3::new(0.20, 0.33, 0.45)];
                    let is_plain = plain.iter().any(|p| is_near(color, *p));
                    let byte = bytes[((cell.z * cells.y + cell.y) * cells.x + cell.x) as usize];
                    assert_eq!(byte == 0, is_plain, "{projection:?}, axis {axis}, {cell}: {color}");
                    if byte == 0 { others += 1 } else { marked += 1 }
                }
            }
            assert!(marked > 40 && others > 400, "{projection:?}, axis {axis}: {marked} marked, {others} not");
        }
    }
}

/// The first marked cell on a pixel's ray, by small steps.
fn first_cell(grid: &Grid, words: &[u32], eye: DVec3, direction: DVec3) -> Option<UVec3> {
    (0..12_000).find_map(|step| {
        let p = grid.grid_point(eye + direction * (3.5 + f64::from(step) * 3e-4));
        let p = DVec3::new(p.x, p.y, grid.slice_of(p.z));
        let inside = p.cmpge(DVec3::ZERO).all() && p.cmplt(grid.cells.as_dvec3()).all();
        let cell = inside.then(|| p.as_uvec3())?;
        (words[grid.word_of(cell.to_array())] >> (cell.z & 31) & 1 == 1).then_some(cell)
    })
}

#[test]
fn cubes_are_the_first_marked_cells_in_the_colour_of_their_records() {
    for projection in [Projection::Orthographic, Projection::Perspective] {
        let mut scene = scene();
        scene.grid.projection = projection;
        let shown = show(&scene, DebugView::Cubes, Channel::Beauty);
        let (grid, words) = shown.words(0);
        let records = shown.records(0);
        let eye = scene.camera.eye.as_dvec3();
        let forward = -eye.normalize();
        let right = forward.cross(DVec3::Y).normalize();
        let up = right.cross(forward);
        let tan = 15_f64.to_radians().tan();
        let (mut right_ones, mut all, mut solid) = (0, 0, 0);
        for y in (1..SIZE.y).step_by(3) {
            for x in (1..SIZE.x).step_by(3) {
                let at = (UVec2::new(x, y).as_dvec2() + 0.5) / SIZE.as_dvec2() * 2.0 - 1.0;
                let aspect = f64::from(SIZE.x) / f64::from(SIZE.y);
                let direction = (forward + right * at.x * tan * aspect - up * at.y * tan).normalize();
                let color = shown.picture[(y * SIZE.x + x) as usize];
                all += 1;
                right_ones += match first_cell(&grid, &words, eye, direction) {
                    None => u32::from(is_near(color, Vec3::new(0.13, 0.13, 0.15))),
                    Some(cell) => {
                        solid += 1;
                        let word = grid.word_of(cell.to_array());
                        let before: u32 = words[..word].iter().map(|w| w.count_ones()).sum();
                        let rank = before + (words[word] & ((1 << (cell.z & 31)) - 1)).count_ones();
                        let base = 0.5 + 0.5 * crate::stages::unit_of(records[rank as usize].normal);
                        // Faces are shaded and edges drawn: the colour is the record's, dimmed.
                        let dimmed = color.dot(base) / base.length_squared();
                        u32::from((0.38..0.97).contains(&dimmed) && is_near(color, dimmed * base))
                    }
                };
            }
        }
        assert!(solid > 300 && solid < all - 300, "{solid} of {all} see a cube");
        assert!(right_ones * 100 >= all * 98, "{projection:?}: {right_ones} of {all} pixels are right");
    }
}

#[test]
fn the_light_volumes_view_is_what_absorption_leaves_at_each_depth() {
    let mut seen = Vec::new();
    for position in [0.0, 0.5, 1.0] {
        let shown = show(&scene(), DebugView::LightVolume { position }, Channel::Beauty);
        let (grid, _) = shown.words(1);
        let mut off = 0.0_f32;
        let mut dark = 0;
        for y in 0..grid.cells.y {
            for x in 0..grid.cells.x {
                let across = (f64::from(x) + 0.5, f64::from(y) + 0.5);
                let Some(pixel) = pixel_of(across, (grid.cells.x, grid.cells.y)) else { continue };
                let depth = (f64::from(position) * f64::from(grid.cells.z)).min(f64::from(grid.cells.z) - 0.5);
                let p = grid.world_point(DVec3::new(across.0, across.1, grid.slab(depth)));
                let along = SUN.as_dvec3().normalize();
                let middle = p.dot(along);
                let beside = (p - middle * along).length();
                if (beside - 1.0).abs() < 0.1 {
                    continue;
                }
                let half = (1.0 - beside * beside).max(0.0).sqrt();
                let length = (middle.clamp(-half, half) + half).max(0.0);
                let left = (SIGMA.as_dvec3() * -length).exp().as_vec3();
                let encoded =
                    left.map(|x| if x <= 0.003_130_8 { x * 12.92 } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 });
                dark += u32::from(left.min_element() < 0.8);
                off = off.max((shown.picture[pixel] - encoded).abs().max_element());
            }
        }
        assert!(off < 0.1, "at {position} of the way the view is off by {off}");
        seen.push(dark);
    }
    assert!(seen[0] == 0 && seen[1] > 500 && seen[2] >= seen[1], "cells in the shadow: {seen:?}");
}

const MISSING: Vec3 = Vec3::new(0.93, 0.20, 0.16);
const SPURIOUS: Vec3 = Vec3::new(0.22, 0.47, 1.0);

/// The slice across z that is shown, of the 70 of the grid, and the position that shows it.
const SLICE: u32 = 31;
const POSITION: f32 = 31.5 / 70.0;

fn pixel_at(index: usize) -> UVec2 {
    let index = u32::try_from(index).unwrap();
    UVec2::new(index % SIZE.x, index / SIZE.x)
}

/// The cell of a slice across z that a pixel shows.
fn cell_of(grid: &Grid, pixel: UVec2, slice: u32) -> Option<[u32; 3]> {
    let cells = grid.cells.truncate().as_vec2();
    let pixels = (SIZE.as_vec2() / cells).min_element();
    let at = (pixel.as_vec2() + 0.5 - 0.5 * SIZE.as_vec2()) / pixels + 0.5 * cells;
    let inside = at.cmpge(glam::Vec2::ZERO).all() && at.cmplt(cells).all();
    let cell = at.max(glam::Vec2::ZERO).as_uvec2();
    inside.then_some([cell.x, cell.y, slice])
}

#[test]
fn a_slice_of_an_eager_fill_shows_the_interiors_own_words() {
    let mut scene = scene();
    scene.voxelizer.fill = Fill::Eager;
    let shown = show(&scene, DebugView::Slice { axis: 2, position: POSITION }, Channel::Beauty);
    let (grid, occupied) = shown.words(0);
    let volume = shown.frame.volume();
    let mut interior: Vec<u32> =
        buffer::read(gpu(), &volume.interior, u64::from(grid.word_base), grid.word_count() as usize).unwrap();
    let slice = SLICE;
    let is_interior = |color: Vec3| is_near(color, Vec3::new(0.20, 0.33, 0.45));
    let agrees = |interior: &[u32]| {
        let mut seen = [0, 0];
        for (i, color) in shown.picture.iter().enumerate() {
            let pixel = pixel_at(i);
            let Some(cell) = cell_of(&grid, pixel, slice) else { continue };
            let bit = |words: &[u32]| words[grid.word_of(cell)] >> (slice & 31) & 1 == 1;
            let solid = bit(interior) && !bit(&occupied);
            seen[usize::from(solid)] += 1;
            if solid != is_interior(*color) {
                return None;
            }
        }
        Some(seen)
    };
    let seen = agrees(&interior).expect("a pixel disagrees with the interior words");
    assert!(seen[0] > 300 && seen[1] > 300, "{seen:?}");
    interior[grid.word_of([grid.cells.x / 2, grid.cells.y / 2, slice])] ^= 1 << (slice & 31);
    assert_eq!(agrees(&interior), None, "one voxel more or less is seen");
}

#[test]
fn voxels_held_against_the_truth_are_red_where_missing_and_blue_where_spurious() {
    let scene = scene();
    let world = World::load(&scene, None).unwrap();
    let view = DebugView::Slice { axis: 2, position: POSITION };
    let mut frame = Frame::new(gpu()).unwrap();
    let render = |frame: &mut Frame, view| {
        let (size, channel, timing) = (SIZE, Channel::Beauty, Timing::Off);
        let request =
            Request { scene: &scene, world: &world, time_secs: 0.0, size, picture_size: size, channel, view, timing };
        frame.render(gpu(), &request).unwrap();
        frame.settle(gpu()).unwrap();
        frame.render(gpu(), &request).unwrap();
        let rgba: Vec<[u8; 4]> = buffer::read_texture(gpu(), frame.picture()).unwrap();
        rgba.into_iter().map(|[r, g, b, _]| Vec3::new(r.into(), g.into(), b.into()) / 255.0).collect::<Vec<_>>()
    };
    render(&mut frame, view);
    let grid = frame.volume().grids[0];
    let triangles = murrine::voxelize::world_triangles(gpu(), frame.triangles().unwrap(), 0).unwrap();
    let truth = marked_voxels(&grid, &triangles, scene.voxelizer.separability);
    let slice = SLICE;
    // One true voxel is said to be none, one that is none to be true.
    let bit = |words: &[u32], [x, y]: [u32; 2]| words[grid.word_of([x, y, slice])] >> (slice & 31) & 1 == 1;
    let row = grid.cells.y / 2;
    let spurious = (0..grid.cells.x).map(|x| [x, row]).find(|c| bit(&truth, *c)).unwrap();
    let missing = [grid.cells.x / 2, row];
    assert!(!bit(&truth, missing));
    let mut told = truth.clone();
    for [x, y] in [spurious, missing] {
        told[grid.word_of([x, y, slice])] ^= 1 << (slice & 31);
    }
    let count = |frame: &mut Frame, truth: Option<&[u32]>, view| {
        frame.hold_against(truth.map(|words| buffer::storage_with(gpu(), "truth", words).unwrap()));
        let picture = render(frame, view);
        for (i, color) in picture.iter().enumerate() {
            let pixel = pixel_at(i);
            let cell = cell_of(&grid, pixel, slice).map(|[x, y, _]| [x, y]);
            if matches!(view, DebugView::Slice { .. }) {
                assert!(!is_near(*color, MISSING) || cell == Some(missing), "{pixel}");
                assert!(!is_near(*color, SPURIOUS) || cell == Some(spurious), "{pixel}");
            }
        }
        [MISSING, SPURIOUS].map(|what| picture.iter().filter(|c| is_near(**c, what)).count())
    };
    let [red, blue] = count(&mut frame, Some(&told), view);
    assert!(red > 0 && blue > 0, "{red} red, {blue} blue");
    assert_eq!(count(&mut frame, Some(&truth), view), [0, 0], "an exact method has no faults");
    assert_eq!(count(&mut frame, None, view), [0, 0], "nothing to hold it against");
    // As cubes: with nothing true, all is spurious; with all true, the grid is a block of missing ones.
    let blueish = |picture: &[Vec3]| picture.iter().filter(|c| c.z > 1.4 * c.x && c.z > 0.25).count();
    frame.hold_against(Some(buffer::storage_with(gpu(), "truth", &vec![0_u32; truth.len()]).unwrap()));
    assert!(blueish(&render(&mut frame, DebugView::Cubes)) > 500);
    let reddish = |picture: &[Vec3]| picture.iter().filter(|c| c.x > 2.0 * c.y && c.x > 0.25).count();
    frame.hold_against(Some(buffer::storage_with(gpu(), "truth", &vec![u32::MAX; truth.len()]).unwrap()));
    assert!(reddish(&render(&mut frame, DebugView::Cubes)) > 500);
}
