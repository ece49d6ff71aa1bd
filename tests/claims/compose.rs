//! The picture: what the tone map keeps, that enlarging invents nothing, that debug views show what is there.

use crate::gpu;
use crate::stages::Stages;
use glam::{DVec3, UVec2, UVec3, Vec3, Vec4};
use murrine::compose::{self, Compose, DebugView};
use murrine::gpu::{Recorder, Timing, buffer};
use murrine::grid::Grid;
use murrine::march::{Channel, March, Radiance};
use murrine::scene::World;
use murrine::scene::description::{Camera, EffectSettings, Scene, Shape};
use murrine::surroundings::{SurroundingsBuffers, surroundings};
use std::sync::OnceLock;

fn texture(size: UVec2, texels: &[Vec4]) -> wgpu::Texture {
    let extent = wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 };
    let texture = gpu().device.create_texture(&wgpu::TextureDescriptor {
        label: Some("given"),
        size: extent,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(16 * size.x), rows_per_image: None };
    gpu().queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(texels), layout, extent);
    texture
}

/// A bench with a ball in a grid of 64³, seen from in front.
fn ball() -> Stages {
    let mut bench = Stages::of(&[Shape::Icosphere { radius: 1.0, subdivisions: 4 }]);
    bench.render(&[Grid::world_aligned(DVec3::splat(-1.6), 0.05, UVec3::splat(64))]);
    assert!(bench.volume.settle(gpu()).unwrap());
    bench
}

/// Only what the march's pictures are made by.
fn march() -> &'static March {
    static MARCH: OnceLock<March> = OnceLock::new();
    MARCH.get_or_init(|| March::new(gpu()).unwrap())
}

struct Shown {
    bench: Stages,
    view: DebugView,
    channel: Channel,
    exposure: f32,
    compose: Compose,
}

impl Shown {
    fn new(view: DebugView, channel: Channel) -> Self {
        Self { bench: ball(), view, channel, exposure: 1.0, compose: Compose::new(gpu()).unwrap() }
    }

    /// The picture of `texels`, as radiance and as channel alike; 0 … 1.
    fn picture(&mut self, small: UVec2, texels: &[Vec4], size: UVec2) -> Vec<Vec3> {
        let camera = Camera { eye: Vec3::new(0.0, 0.0, 8.0), ..Camera::default() };
        let scene = Scene { camera, ..Scene::default() };
        let world = World::default();
        let data = surroundings(&scene, &world, &[], (size.x as f32 / size.y as f32, size.y), &[], None);
        let buffers = SurroundingsBuffers::new(gpu(), &world).unwrap();
        buffers.write(gpu(), &data);
        let mut radiance: Radiance = march().target(gpu(), small);
        radiance.radiance = texture(small, texels);
        radiance.channel = texture(small, texels);
        let target = self.compose.target(gpu(), size);
        let input = compose::Input {
            radiance: &radiance,
            channel: self.channel,
            volume: &self.bench.volume,
            materials: &self.bench.triangles.materials,
            surroundings: &buffers,
            effect: &EffectSettings { exposure: self.exposure, ..EffectSettings::default() },
            view: self.view,
            classes: None,
            filled: false,
            truth: None,
        };
        let mut rec = Recorder::new(gpu(), Timing::Off);
        self.compose.record(&mut rec, &input, &target);
        rec.finish().unwrap();
        let bytes: Vec<[u8; 4]> = buffer::read_texture(gpu(), &target).unwrap();
        bytes.into_iter().map(|[r, g, b, _]| Vec3::new(f32::from(r), f32::from(g), f32::from(b)) / 255.0).collect()
    }
}

fn linear(encoded: Vec3) -> Vec3 {
    encoded.map(|x| if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) })
}

/// The mean of a picture of one colour, by which the dither cancels out; linear.
fn shown(shown: &mut Shown, radiance: Vec3) -> Vec3 {
    let size = UVec2::splat(8);
    let pixels = shown.picture(size, &[radiance.extend(1.0); 64], size);
    linear(pixels.iter().sum::<Vec3>() / 64.0)
}

#[test]
fn black_is_black_and_what_a_display_can_show_is_shown_as_it_is() {
    let mut picture = Shown::new(DebugView::None, Channel::Beauty);
    assert_eq!(shown(&mut picture, Vec3::ZERO), Vec3::ZERO);
    for color in [Vec3::splat(0.18), Vec3::new(0.7, 0.2, 0.05), Vec3::new(0.02, 0.3, 0.6), Vec3::splat(1e-3)] {
        let error = (shown(&mut picture, color) - color).abs();
        assert!((error / (color + 0.01)).max_element() < 0.02, "{color}: off by {error}");
    }
    let not_a_number = shown(&mut picture, Vec3::new(f32::NAN, -1.0, f32::INFINITY));
    assert!(not_a_number.is_finite(), "{not_a_number}");
}

#[test]
fn exposure_scales_light_before_the_curve() {
    let mut picture = Shown::new(DebugView::None, Channel::Beauty);
    let color = Vec3::new(0.3, 0.1, 0.02);
    picture.exposure = 2.0;
    assert!((shown(&mut picture, color) - 2.0 * color).abs().max_element() < 0.01);
    picture.exposure = 0.5;
    assert!((shown(&mut picture, color) - 0.5 * color).abs().max_element() < 0.01);
    assert!((shown(&mut picture, color) - color).abs().max_element() > 0.1, "exposure must do something");
}

#[test]
fn more_light_never_looks_darker_and_tinted_light_keeps_its_hue() {
    let mut picture = Shown::new(DebugView::None, Channel::Beauty);
    let amber = Vec3::new(1.0, 0.45, 0.08);
    let steps: Vec<(f32, Vec3)> =
        (0..24).map(|i| 0.05 * 1.4_f32.powi(i)).map(|k| (k, shown(&mut picture, k * amber))).collect();
    for pair in steps.windows(2) {
        let ((before, dim), (now, bright)) = (pair[0], pair[1]);
        assert!((bright - dim).min_element() > -2e-3, "from {before} to {now}: {dim} to {bright}");
    }
    for (k, color) in &steps {
        assert!(color.x >= color.y && color.y >= color.z, "{k}: {color} is not amber");
        if *k < 2.0 {
            let ratio = color.y / color.x;
            assert!((ratio - 0.45).abs() < 0.12, "{k}: green to red is {ratio}");
        }
    }
    let (_, brightest) = steps.last().unwrap();
    assert!(brightest.z > 0.5, "what is far too bright bleaches: {brightest}");
    // A curve for each channel would turn it yellow: this is the claim's control.
    let yellow = |x: f32| 1.0 - (-x).exp();
    assert!(yellow(2.0 * 0.45) / yellow(2.0) - 0.45 > 0.12);
}

#[test]
fn enlarging_keeps_flat_pictures_flat_and_ramps_straight() {
    let mut picture = Shown::new(DebugView::None, Channel::Beauty);
    let small = UVec2::new(16, 12);
    let flat = picture.picture(small, &[Vec4::new(0.2, 0.4, 0.6, 1.0); 192], UVec2::new(48, 36));
    let mean = flat.iter().sum::<Vec3>() / flat.len() as f32;
    assert!((linear(mean) - Vec3::new(0.2, 0.4, 0.6)).abs().max_element() < 4e-3);
    assert!(flat.iter().all(|p| (*p - mean).abs().max_element() < 1.1 / 255.0));

    // Even steps of the encoded picture, from left to right.
    let step = |x: u32| linear(Vec3::splat(0.1 + 0.04 * x as f32)).extend(1.0);
    let texels: Vec<Vec4> = (0..192).map(|i| step(i % 16)).collect();
    let ramp = picture.picture(small, &texels, UVec2::new(64, 48));
    for x in 8_u16..56 {
        let truth = 0.1 + 0.04 * ((f32::from(x) + 0.5) / 4.0 - 0.5);
        let here = ramp[20 * 64 + usize::from(x)].x;
        assert!((here - truth).abs() < 1.6 / 255.0, "column {x}: {here} instead of {truth}");
    }
    let steps = ramp[20 * 64 + 8..20 * 64 + 56].windows(2).filter(|p| p[0].x == p[1].x).count();
    assert!(steps < 10, "the ramp must not be made of steps: {steps} pairs are equal");
}

#[test]
fn a_channel_in_false_colours_is_brighter_for_more_and_dark_for_nothing() {
    let mut picture = Shown::new(DebugView::Channel { max: 2.0 }, Channel::Thickness);
    let size = UVec2::new(4, 1);
    let texels = [0.0, 1.0, 2.0, f32::NAN].map(|x| Vec4::new(x, x, x, 0.0));
    let colors = picture.picture(size, &texels, size);
    let light = |c: Vec3| linear(c).dot(Vec3::new(0.2126, 0.7152, 0.0722));
    assert!(light(colors[0]) < light(colors[1]) && light(colors[1]) < light(colors[2]), "{colors:?}");
    assert!(light(colors[3]) < 0.02 && colors[3].max_element() - colors[3].min_element() < 0.1, "{}", colors[3]);

    let mut directions = Shown::new(DebugView::Channel { max: 1.0 }, Channel::Normal);
    let colors = directions.picture(size, &[Vec4::X, -Vec4::X, Vec4::Y, Vec4::Z], size);
    assert!(colors[0].x > 0.99 && colors[1].x < 0.01 && colors[2].y > 0.99 && colors[3].z > 0.99, "{colors:?}");
}

#[test]
fn a_slice_shows_just_the_voxels_that_are_marked() {
    let size = UVec2::splat(64);
    let blank = [Vec4::ZERO; 64 * 64];
    for (axis, slice) in [(2, 32), (0, 19), (1, 49)] {
        let position = (slice as f32 + 0.3) / 64.0;
        let mut view = Shown::new(DebugView::Slice { axis, position }, Channel::Beauty);
        let picture = view.picture(size, &blank, size);
        let mut marked = vec![false; 64 * 64];
        for cell in view.bench.cells(0) {
            if cell[axis as usize] == slice {
                let (x, y) = [(cell.z, cell.y), (cell.x, cell.z), (cell.x, cell.y)][axis as usize];
                marked[(y * 64 + x) as usize] = true;
            }
        }
        assert!(marked.iter().filter(|m| **m).count() > 50);
        let air = Vec3::new(0.13, 0.13, 0.15);
        let interior = Vec3::new(0.20, 0.33, 0.45);
        let is = |color: Vec3, other: Vec3| (color - other).abs().max_element() < 0.01;
        for (pixel, marked) in picture.iter().zip(&marked) {
            assert!(*marked != (is(*pixel, air) || is(*pixel, interior)), "axis {axis}: {pixel}");
        }
        let inside = picture.iter().filter(|p| is(**p, interior)).count();
        assert!(inside > 150, "axis {axis}: {inside} cells are shown as interior");
        assert!(is(picture[0], air), "a corner is air");
    }
}

#[test]
fn cubes_cover_the_balls_outline_and_show_its_normals() {
    let size = UVec2::splat(128);
    let mut view = Shown::new(DebugView::Cubes, Channel::Beauty);
    let picture = view.picture(size, &vec![Vec4::ZERO; 128 * 128], size);
    let empty = |p: &Vec3| (*p - Vec3::new(0.13, 0.13, 0.15)).abs().max_element() < 0.01;
    let covered = picture.iter().filter(|p| !empty(p)).count() as f64 / picture.len() as f64;
    // A ball of radius 1 to 1.09 (cells of 0.05) from 8 away in a field of 30°.
    let share = |radius: f64| {
        let half = (radius / 8.0).asin().tan() / 15_f64.to_radians().tan();
        std::f64::consts::PI * half * half / 4.0
    };
    assert!(covered > share(1.0) && covered < share(1.09), "{covered} not in {}…{}", share(1.0), share(1.09));
    // In the middle the normal looks at the camera: blue; at the right, red; above, green.
    let at = |x: usize, y: usize| picture[y * 128 + x];
    assert!(at(64, 64).z > 0.7 && at(64, 64).x < 0.6, "{}", at(64, 64));
    assert!(at(90, 64).x > at(38, 64).x + 0.2, "{} {}", at(90, 64), at(38, 64));
    assert!(at(64, 38).y > at(64, 90).y + 0.2, "{} {}", at(64, 38), at(64, 90));
}
