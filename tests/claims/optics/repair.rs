//! Questionable pixels are filled from good ones around them (CL §2.3, Fig. 3): known pictures with bad pixels planted.

use crate::gpu;
use crate::support::{glass, render_with, scene_of};
use glam::{UVec2, Vec3, Vec4};
use murrine::frame::Frame;
use murrine::gpu::{ComputePass, GpuStruct, Recorder, Timing, buffer};
use murrine::march::{Channel, MarchSettings};
use murrine::scene::World;
use murrine::scene::description::{Background, Scene, Shape};

const SIZE: UVec2 = UVec2::new(48, 40);

/// A picture before the repair: radiance and part of each pixel's first surface, 0 for none.
struct Planted {
    radiance: Vec<Vec4>,
    value: Vec<Vec4>,
    part: Vec<f32>,
}

impl Planted {
    /// `radiance` and `part` of a pixel's column and row; the channel holds twice the radiance.
    fn new(radiance: impl Fn(f32, f32) -> Vec3, part: impl Fn(u32, u32) -> u32) -> Self {
        let pixels = || (0..SIZE.y).flat_map(|y| (0..SIZE.x).map(move |x| (x, y)));
        let light = |(x, y): (u32, u32)| radiance(x as f32, y as f32);
        Self {
            radiance: pixels().map(|p| light(p).extend(1.0)).collect(),
            value: pixels().map(|p| (2.0 * light(p)).extend(1.0)).collect(),
            part: pixels().map(|(x, y)| part(x, y) as f32).collect(),
        }
    }

    /// The radiance and the channel after the repair, with the pixels of `bad` spoilt and listed.
    fn repaired(&self, bad: &[(u32, u32)], channel: Channel) -> [Vec<Vec4>; 2] {
        let (mut radiance, mut value) = (self.radiance.clone(), self.value.clone());
        for (x, y) in bad {
            radiance[at(*x, *y)] = Vec4::new(900.0, 900.0, 900.0, 0.0);
            value[at(*x, *y)] = Vec4::splat(900.0);
        }
        let first: Vec<Vec4> = self.part.iter().map(|part| Vec4::new(0.0, 0.0, 0.0, -part)).collect();
        let seen: Vec<u32> = self.part.iter().map(|part| u32::from(*part > 0.0)).collect();
        let listed: Vec<u32> = bad.iter().map(|(x, y)| x | y << 16).collect();
        let count = u32::try_from(bad.len()).unwrap();
        let list = buffer::storage_with(gpu(), "list", &[&[1, 1, 1, count][..], &listed].concat()).unwrap();
        let number = Channel::ALL.iter().position(|(c, ..)| *c == channel).unwrap();
        let settings = MarchSettings {
            size: SIZE,
            channel: u32::try_from(number).unwrap(),
            rasterized: 1,
            ..bytemuck::Zeroable::zeroed()
        };
        let settings = buffer::uniform(gpu(), "settings", &settings);
        let [radiance, value, first] = [radiance, value, first].map(|texels| floats(&texels));
        let [found, found_value] = [&self.radiance; 2].map(|texels| floats(texels));
        let seen = texture(wgpu::TextureFormat::R32Uint, bytemuck::cast_slice(&seen), 4);
        let bound = [
            ("settings", settings.as_entire_binding()),
            ("questionable", list.as_entire_binding()),
            ("first_triangle", view(&seen)),
            ("path_first", view(&first)),
            ("seen_radiance", view(&radiance)),
            ("seen_channel", view(&value)),
            ("found_radiance", view(&found)),
            ("found_channel", view(&found_value)),
        ];
        let layouts = [MarchSettings::LAYOUT];
        let mut rec = Recorder::new(gpu(), Timing::Off);
        let gather = ComputePass::new(gpu(), "repair.wgsl", "gather", &layouts).unwrap();
        gather.dispatch(&mut rec.encoder, &gather.bind_used(gpu(), &bound), [count, 1, 1]);
        let place = ComputePass::new(gpu(), "repair.wgsl", "place", &layouts).unwrap();
        let found = [
            ("filled_radiance", view(&found)),
            ("filled_channel", view(&found_value)),
            ("radiance", view(&radiance)),
            ("channel", view(&value)),
        ];
        let group = place.bind_used(gpu(), &[&bound[..2], &found].concat());
        place.dispatch(&mut rec.encoder, &group, [count, 1, 1]);
        rec.finish().unwrap();
        [radiance, value].map(|t| buffer::read_texture(gpu(), &t.0).unwrap())
    }
}

fn at(x: u32, y: u32) -> usize {
    (y * SIZE.x + x) as usize
}

struct Texture(wgpu::Texture, wgpu::TextureView);

fn texture(format: wgpu::TextureFormat, bytes: &[u8], texel: u32) -> Texture {
    let size = wgpu::Extent3d { width: SIZE.x, height: SIZE.y, depth_or_array_layers: 1 };
    let mut usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
    if texel == 16 {
        usage |= wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_SRC;
    }
    let texture = gpu().device.create_texture(&wgpu::TextureDescriptor {
        label: Some("planted"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(texel * SIZE.x), rows_per_image: None };
    gpu().queue.write_texture(texture.as_image_copy(), bytes, layout, size);
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    Texture(texture, view)
}

fn floats(texels: &[Vec4]) -> Texture {
    texture(wgpu::TextureFormat::Rgba32Float, bytemuck::cast_slice(texels), 16)
}

fn view(texture: &Texture) -> wgpu::BindingResource<'_> {
    wgpu::BindingResource::TextureView(&texture.1)
}

fn ramp(x: f32, y: f32) -> Vec3 {
    Vec3::new(0.1 + 0.01 * x, 0.9 - 0.02 * y, 0.5 + 0.004 * (x - y))
}

#[test]
fn bad_pixels_amid_a_ramp_take_the_ramps_light_and_good_ones_keep_theirs() {
    let planted = Planted::new(ramp, |_, _| 1);
    let bad: Vec<_> = (0..24).map(|i| (5 + i % 6 * 7, 5 + i / 6 * 8)).collect();
    let [radiance, value] = planted.repaired(&bad, Channel::Thickness);
    for (i, (got, truth)) in radiance.iter().zip(&planted.radiance).enumerate() {
        let was_bad = bad.iter().any(|(x, y)| at(*x, *y) == i);
        let off = (got.truncate() - truth.truncate()).abs().max_element();
        assert!(off <= if was_bad { 1e-5 } else { 0.0 }, "pixel {i}: {got} instead of {truth}");
        assert_eq!(got.w, if was_bad { 0.0 } else { 1.0 }, "a filled pixel is questionable still");
        let off = (value[i].truncate() - planted.value[i].truncate()).abs().max_element();
        assert!(off <= if was_bad { 1e-5 } else { 0.0 }, "pixel {i}: {}", value[i]);
    }
    // Channels that have no mean keep what the ray said.
    let [_, value] = planted.repaired(&bad, Channel::ExitDirection);
    assert!(bad.iter().all(|(x, y)| value[at(*x, *y)] == Vec4::splat(900.0)));
}

#[test]
fn a_hole_of_many_pixels_is_filled_from_as_far_as_it_must_be_and_no_further() {
    let planted = Planted::new(|_, _| Vec3::new(0.2, 0.4, 0.8), |_, _| 1);
    let square = |half: u32| -> Vec<(u32, u32)> {
        (20 - half..=20 + half).flat_map(|y| (20 - half..=20 + half).map(move |x| (x, y))).collect()
    };
    for half in [2, 4, 7] {
        let bad = square(half);
        let [radiance, _] = planted.repaired(&bad, Channel::Beauty);
        let worst = bad.iter().map(|(x, y)| (radiance[at(*x, *y)] - Vec4::new(0.2, 0.4, 0.8, 0.0)).length());
        assert!(worst.fold(0.0, f32::max) < 1e-5, "a hole of {} pixels across", 2 * half + 1);
    }
    // Nothing good within eight pixels: it stays as it was.
    let [radiance, _] = planted.repaired(&square(9), Channel::Beauty);
    assert_eq!(radiance[at(20, 20)].x, 900.0);
    assert!((radiance[at(11, 20)].x - 0.2).abs() < 1e-5);
}

#[test]
fn filling_smears_nothing_across_outlines() {
    // Two bodies and the background, each of its own colour, that meet along a slanted line and an upright one.
    let part = |x: u32, y: u32| if x > 32 { 0 } else { 1 + u32::from(2 * x > y + 12) };
    let color =
        |part: u32| [Vec3::new(0.9, 0.0, 0.0), Vec3::new(0.0, 0.7, 0.0), Vec3::new(0.0, 0.0, 0.5)][part as usize];
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small whole numbers")]
    let planted = Planted::new(|x, y| color(part(x as u32, y as u32)), part);
    let near_outline = |x: u32, y: u32| {
        let around = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
        around.iter().any(|(u, v)| part(*u, *v) != part(x, y))
    };
    let bad: Vec<_> = (1..SIZE.y - 1)
        .flat_map(|y| (1..SIZE.x - 1).map(move |x| (x, y)))
        .filter(|(x, y)| near_outline(*x, *y) && (x + y) % 3 == 0)
        .collect();
    assert!(bad.len() > 30, "{} pixels along outlines", bad.len());
    let [radiance, _] = planted.repaired(&bad, Channel::Beauty);
    for (x, y) in &bad {
        let (got, truth) = (radiance[at(*x, *y)], color(part(*x, *y)));
        assert!((got.truncate() - truth).abs().max_element() < 1e-6, "({x}, {y}): {got} instead of {truth}");
    }
    // Were all one body, the colours would run into each other.
    let one = Planted { part: vec![1.0; planted.part.len()], ..planted };
    let [radiance, _] = one.repaired(&bad, Channel::Beauty);
    let smeared =
        bad.iter().filter(|(x, y)| (radiance[at(*x, *y)].truncate() - color(part(*x, *y))).abs().max_element() > 0.05);
    assert!(smeared.count() > bad.len() / 2, "the picture has no outlines to smear");
}

#[test]
fn only_questionable_pixels_are_filled_and_none_where_filling_is_off() {
    let ball = glass("ball", Shape::Icosphere { radius: 1.0, subdivisions: 4 }, 1.5, Vec3::new(0.2, 0.4, 0.6));
    let mut scene = Scene { background: Background::default(), ..scene_of(vec![ball]) };
    // Rays that are mirrored within run out of events.
    scene.effect.max_events = 1;
    scene.models[0].rotate_deg.x = 20.0;
    let world = World::load(&scene, None).unwrap();
    let mut frame = Frame::new(gpu()).unwrap();
    let mut picture = |fill| {
        scene.effect.fill_questionable = fill;
        render_with(&mut frame, &scene, &world, UVec2::splat(96), Channel::Questionable)
    };
    let (left, filled) = (picture(false), picture(true));
    let bad = left.channel.iter().filter(|p| p[0] > 0.0).count();
    assert!(bad > 200, "{bad} questionable pixels");
    for (i, (before, after)) in left.radiance.iter().zip(&filled.radiance).enumerate() {
        assert_eq!(before[3], after[3], "filling does not make a ray good");
        assert!(before[3] == 0.0 || before == after, "pixel {i} is good and changed");
    }
    assert_eq!(left.channel, filled.channel);
    assert_eq!(left.radiance, picture(false).radiance);
}
