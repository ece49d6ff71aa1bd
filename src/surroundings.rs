//! What rays meet outside the volume: camera, lights, planes, background. One uniform and one texture.
//!
//! Shader side: `shaders/lib/surroundings.inc.wgsl` (the data), `shaders/lib/shading.inc.wgsl` (what it looks like).

mod irradiance;

use crate::gpu::{Gpu, GpuError};
use crate::scene::description::{Background, Camera, Light, LightKind, Shadow};
use crate::scene::material::Material;
use crate::scene::world::EnvironmentMap;
use crate::scene::{Scene, World};
use glam::{Mat4, UVec4, Vec3, Vec4};
use irradiance::Irradiance;
use std::ops::Range;

pub use crate::scene::description::{MAX_LIGHTS, MAX_PLANES};

/// The most layers of light on planes; lights past them cast hard shadows there.
pub const MAX_PLANE_LAYERS: u32 = 16;

crate::gpu_struct! {
    /// A light as shaders see it.
    pub struct LightData {
        /// Position; directional: unused.
        pub position: Vec3,
        /// 0 directional, 1 point, 2 spot.
        pub kind: u32,
        /// The way it travels or points, unit.
        pub direction: Vec3,
        /// Spot: cosine of the half angle.
        pub cos_outer: f32,
        /// Colour times intensity.
        pub radiance: Vec3,
        /// Spot: cosine where it starts to fade.
        pub cos_inner: f32,
        /// First of its grids, or `u32::MAX` for none.
        pub first_grid: u32,
        /// How many grids it has (0, 1 or 6).
        pub grid_count: u32,
        /// Layer of the planes' light that holds its first grid on plane 0, then plane by plane, grid by grid; or
        /// `u32::MAX` for none. See [`crate::plane_light`].
        pub first_layer: u32,
        /// Half the angle under which it is seen, radians.
        pub angular_radius: f32,
    }
}

crate::gpu_struct! {
    /// An analytic square at local y = 0, met exactly.
    pub struct PlaneData {
        /// `local_from_world`, local unit = half side.
        pub local_from_world: Mat4,
        /// World normal, unit.
        pub normal: Vec3,
        /// Index of its part.
        pub part: u32,
        /// Second colour of the checkerboard.
        pub checker_color: Vec3,
        /// Squares along half a side; 0 is plain.
        pub checker_squares: f32,
    }
}

crate::gpu_struct! {
    /// Everything around the volume, `Surroundings` in `lib/surroundings.inc.wgsl`.
    pub struct Surroundings {
        /// Camera position.
        pub eye: Vec3,
        /// tan(fov/2).
        pub tan_half_fov: f32,
        /// Camera axes, unit.
        pub right: Vec3,
        /// Width over height.
        pub aspect: f32,
        /// Camera axes, unit.
        pub up: Vec3,
        /// 0 colour, 1 sky, 2 checker, 3 environment.
        pub background_kind: u32,
        /// Camera axes, unit: the way it looks.
        pub forward: Vec3,
        /// Sky: power of the height. Checker: side of a square.
        pub background_parameter: f32,
        /// Colour; sky: horizon; checker: one colour. w: unused.
        pub background_a: Vec4,
        /// Sky: zenith; checker: the other colour.
        pub background_b: Vec4,
        /// Sky: below the horizon. Checker: a point of its plane. Environment: x = turn in radians, y = intensity.
        pub background_c: Vec4,
        /// Checker: the plane's normal, towards the camera.
        pub background_d: Vec4,
        /// x: lights, y: planes, z: index of the scene grid or MAX, w: how light is shadowed (0 none, 1 linear,
        /// 2 Beer–Lambert).
        pub counts: UVec4,
        /// Lights.
        pub lights: [LightData; MAX_LIGHTS],
        /// Planes.
        pub planes: [PlaneData; MAX_PLANES],
        /// What the background sheds on a surface, spherical harmonics of its normal; see [`irradiance`]. w: unused.
        pub irradiance: [Vec4; 9],
        /// Radians that a pixel covers in the middle of the picture.
        pub pixel_angle: f32,
        /// Padding.
        pub _pad: [u32; 3],
    }
}

/// Surroundings on the device.
#[derive(Debug)]
pub struct SurroundingsBuffers {
    /// One [`Surroundings`], uniform.
    pub data: wgpu::Buffer,
    /// The environment, equirectangular, `texture_2d<f32>`, filterable; one black texel without one.
    pub environment: wgpu::TextureView,
    /// Linear, wraps around.
    pub sampler: wgpu::Sampler,
    /// What the environment sheds, before it is turned and scaled.
    environment_irradiance: Irradiance,
}

impl SurroundingsBuffers {
    /// Uploads the environment, halved until it fits the device's largest texture.
    ///
    /// # Errors
    /// When it would not fit the device's memory limits.
    pub fn new(gpu: &Gpu, world: &World) -> Result<Self, GpuError> {
        let black = EnvironmentMap { width: 1, height: 1, rgb: vec![[0.0; 3]] };
        let map = world.environment.as_deref().filter(|map| is_whole(map)).unwrap_or(&black);
        let largest = gpu.device.limits().max_texture_dimension_2d;
        let mut fitted = None;
        while fitted.as_ref().unwrap_or(map).width.max(fitted.as_ref().unwrap_or(map).height) > largest {
            fitted = Some(halved(fitted.as_ref().unwrap_or(map)));
        }
        let environment = upload(gpu, fitted.as_ref().unwrap_or(map))?;
        Ok(Self {
            data: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("surroundings"),
                size: size_of::<Surroundings>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            environment: environment.create_view(&wgpu::TextureViewDescriptor::default()),
            sampler: gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("environment"),
                address_mode_u: wgpu::AddressMode::Repeat,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }),
            environment_irradiance: Irradiance::of_map(map),
        })
    }

    /// Writes the uniform; called when it changed. An environment's irradiance, which was worked out when it was
    /// uploaded, is filled in here.
    pub fn write(&self, gpu: &Gpu, surroundings: &Surroundings) {
        let mut data = *surroundings;
        if data.background_kind == BACKGROUND_ENVIRONMENT {
            let [turn, intensity, ..] = data.background_c.to_array();
            data.irradiance = self.environment_irradiance.turned(turn).coefficients(intensity);
        }
        gpu.queue.write_buffer(&self.data, 0, bytemuck::bytes_of(&data));
    }
}

const BACKGROUND_COLOR: u32 = 0;
const BACKGROUND_SKY: u32 = 1;
const BACKGROUND_CHECKER: u32 = 2;
const BACKGROUND_ENVIRONMENT: u32 = 3;

/// Works out the uniform. `aspect` is the picture's width over its height, `rows` how many rows of rays are marched.
/// `light_grids[i]` are the grid numbers of light `i`; `scene_grid` that of the opaque parts. Lights and planes past
/// [`MAX_LIGHTS`] and [`MAX_PLANES`] are left out.
#[must_use]
pub fn surroundings(
    scene: &Scene,
    world: &World,
    materials: &[Material],
    (aspect, rows): (f32, u32),
    light_grids: &[Range<u32>],
    scene_grid: Option<u32>,
) -> Surroundings {
    let mut data: Surroundings = bytemuck::Zeroable::zeroed();
    let (right, up, forward) = camera_axes(&scene.camera);
    data.eye = scene.camera.eye;
    data.right = right;
    data.up = up;
    data.forward = forward;
    data.tan_half_fov = (scene.camera.fov_deg.to_radians() * 0.5).tan();
    data.aspect = aspect;
    data.pixel_angle = 2.0 * data.tan_half_fov / rows.max(1) as f32;
    set_background(&mut data, &scene.background, &scene.camera);

    let lights = scene.lights.len().min(MAX_LIGHTS);
    for (i, light) in scene.lights.iter().take(lights).enumerate() {
        data.lights[i] = light_data(light, light_grids.get(i).cloned().unwrap_or(0..0));
    }
    let mut planes = 0;
    for (part, (named, material)) in world.parts.iter().zip(materials).enumerate() {
        let half = world.models[named.model as usize].parts[named.part as usize].plane_half;
        if let Some(half) = half.filter(|_| planes < MAX_PLANES) {
            let world_from_model = scene.models[named.model as usize].placement();
            let part = u32::try_from(part).unwrap_or(u32::MAX);
            data.planes[planes] = plane_data(world_from_model, half, part, material);
            planes += 1;
        }
    }
    give_out_layers(&mut data.lights, u32::try_from(planes).unwrap_or(0));
    let shadow = match scene.effect.shadow {
        Shadow::None => 0,
        Shadow::Linear => 1,
        Shadow::BeerLambert => 2,
    };
    let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    data.counts = UVec4::new(count(lights), count(planes), scene_grid.unwrap_or(u32::MAX), shadow);
    data
}

/// Right, up and forward, unit, also where the camera looks along its own up or stands in its target.
fn camera_axes(camera: &Camera) -> (Vec3, Vec3, Vec3) {
    let forward = (camera.target - camera.eye).try_normalize().unwrap_or(Vec3::NEG_Z);
    let right = forward.cross(camera.up).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
    (right, right.cross(forward), forward)
}

fn set_background(data: &mut Surroundings, background: &Background, camera: &Camera) {
    let irradiance = match background {
        Background::Color { color } => {
            data.background_kind = BACKGROUND_COLOR;
            data.background_a = color.extend(0.0);
            Irradiance::of(|_| *color)
        }
        Background::Sky { horizon, zenith, ground, exponent, intensity } => {
            data.background_kind = BACKGROUND_SKY;
            data.background_a = (*horizon * *intensity).extend(0.0);
            data.background_b = (*zenith * *intensity).extend(0.0);
            data.background_c = (*ground * *intensity).extend(0.0);
            data.background_parameter = *exponent;
            Irradiance::of(|direction| {
                let sky = horizon.lerp(*zenith, direction.y.max(0.0).powf(*exponent));
                *intensity * if direction.y < 0.0 { *ground } else { sky }
            })
        }
        Background::Checker { a, b, square, distance } => {
            let (_, _, forward) = camera_axes(camera);
            data.background_kind = BACKGROUND_CHECKER;
            data.background_a = a.extend(0.0);
            data.background_b = b.extend(0.0);
            data.background_parameter = square.max(1e-6);
            data.background_c = (camera.target + forward * *distance).extend(0.0);
            data.background_d = (-forward).extend(0.0);
            Irradiance::of(|_| (*a + *b) * 0.5)
        }
        Background::Environment { rotate_deg, intensity, .. } => {
            data.background_kind = BACKGROUND_ENVIRONMENT;
            data.background_c = Vec4::new(rotate_deg.to_radians(), *intensity, 0.0, 0.0);
            return; // `SurroundingsBuffers::write` knows the picture's
        }
    };
    data.irradiance = irradiance.coefficients(1.0);
}

fn light_data(light: &Light, grids: Range<u32>) -> LightData {
    let mut data: LightData = bytemuck::Zeroable::zeroed();
    data.radiance = light.color * light.intensity;
    data.angular_radius = light.angular_radius_deg.to_radians();
    data.first_layer = u32::MAX;
    data.grid_count = grids.end.saturating_sub(grids.start);
    data.first_grid = if data.grid_count == 0 { u32::MAX } else { grids.start };
    match light.kind {
        LightKind::Directional { direction } => data.direction = direction.normalize_or(Vec3::NEG_Y),
        LightKind::Point { position } => {
            data.kind = 1;
            data.position = position;
        }
        LightKind::Spot { position, direction, angle_deg, blend } => {
            data.kind = 2;
            data.position = position;
            data.direction = direction.normalize_or(Vec3::NEG_Y);
            data.cos_outer = angle_deg.to_radians().cos();
            data.cos_inner = (angle_deg.to_radians() * (1.0 - blend.clamp(0.0, 1.0))).cos();
        }
    }
    data
}

/// A layer for each grid and each plane, as far as they reach.
fn give_out_layers(lights: &mut [LightData], planes: u32) {
    let mut next = 0;
    for light in lights {
        let layers = light.grid_count * planes;
        if layers > 0 && next + layers <= MAX_PLANE_LAYERS {
            light.first_layer = next;
            next += layers;
        }
    }
}

fn plane_data(world_from_model: Mat4, half: f32, part: u32, material: &Material) -> PlaneData {
    let world_from_local = world_from_model * Mat4::from_scale(Vec3::splat(half.max(1e-6)));
    let half_side_world = world_from_local.transform_vector3(Vec3::X).length();
    PlaneData {
        local_from_world: world_from_local.inverse(),
        normal: world_from_local.transform_vector3(Vec3::Y).normalize_or(Vec3::Y),
        part,
        checker_color: material.checker_color,
        checker_squares: if material.checker_square > 0.0 { half_side_world / material.checker_square } else { 0.0 },
    }
}

fn is_whole(map: &EnvironmentMap) -> bool {
    map.width > 0 && map.height > 0 && map.rgb.len() == map.width as usize * map.height as usize
}

/// Each texel the mean of up to four.
fn halved(map: &EnvironmentMap) -> EnvironmentMap {
    let (width, height) = (map.width.div_ceil(2), map.height.div_ceil(2));
    let texel =
        |x: u32, y: u32| Vec3::from(map.rgb[(y.min(map.height - 1) * map.width + x.min(map.width - 1)) as usize]);
    let rgb = (0..height).flat_map(|y| (0..width).map(move |x| (2 * x, 2 * y)));
    let mean = |(x, y)| (texel(x, y) + texel(x + 1, y) + texel(x, y + 1) + texel(x + 1, y + 1)) * 0.25;
    EnvironmentMap { width, height, rgb: rgb.map(|at| mean(at).to_array()).collect() }
}

/// Makes the texture, half floats. A texel that is no number is black; what is brighter than a half float can say (a
/// sun) is as bright as one can.
fn upload(gpu: &Gpu, map: &EnvironmentMap) -> Result<wgpu::Texture, GpuError> {
    let texels: Vec<[u16; 4]> =
        map.rgb.iter().map(|rgb| [half(rgb[0]), half(rgb[1]), half(rgb[2]), half(1.0)]).collect();
    let size = wgpu::Extent3d { width: map.width, height: map.height, depth_or_array_layers: 1 };
    let bytes: &[u8] = bytemuck::cast_slice(&texels);
    let allowed = gpu.device.limits().max_buffer_size;
    if bytes.len() as u64 > allowed {
        let (needed, remedy) = (bytes.len() as u64, "choose a smaller environment picture");
        return Err(GpuError::Limit { what: "the environment".to_owned(), needed, allowed, remedy });
    }
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("environment"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(map.width * 8), rows_per_image: None };
    gpu.queue.write_texture(texture.as_image_copy(), bytes, layout, size);
    Ok(texture)
}

/// The half float nearest to `x`, 0 … 65504.
fn half(x: f32) -> u16 {
    const LARGEST: f32 = 65_504.0;
    const SMALLEST_NORMAL: f32 = 6.103_515_6e-5;
    if x.is_nan() || x <= 0.0 {
        return 0;
    }
    let x = x.min(LARGEST);
    if x < SMALLEST_NORMAL {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 … 1024")]
        return (x * 16_777_216.0).round_ties_even() as u16;
    }
    // Rounds the mantissa to 10 bits; a carry runs into the exponent, as it should.
    let bits = (x.to_bits() - (112 << 23) + 0xfff + (x.to_bits() >> 13 & 1)) >> 13;
    u16::try_from(bits).unwrap_or(0x7bff)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_floats_are_the_nearest_ones() {
        let cases = [
            (0.0, 0),
            (1.0, 0x3c00),
            (0.5, 0x3800),
            (65_504.0, 0x7bff),
            (1e9, 0x7bff),
            (f32::NAN, 0),
            (-1.0, 0),
            (6.103_515_6e-5, 0x0400),
            (5.960_464_5e-8, 0x0001),
            (1.000_976_6, 0x3c01),
            (0.333_251_95, 0x3555),
        ];
        for (x, bits) in cases {
            assert_eq!(half(x), bits, "{x}");
        }
    }

    #[test]
    fn camera_axes_stay_unit_and_square_when_the_camera_is_degenerate() {
        let straight_down = Camera { eye: Vec3::Y, target: Vec3::ZERO, up: Vec3::Y, fov_deg: 30.0 };
        let in_its_target = Camera { eye: Vec3::X, target: Vec3::X, up: Vec3::Y, fov_deg: 30.0 };
        for camera in [straight_down, in_its_target, Camera::default()] {
            let (right, up, forward) = camera_axes(&camera);
            let volume = right.cross(up).dot(-forward);
            assert!((volume - 1.0).abs() < 1e-5, "{camera:?}: {right} {up} {forward}");
        }
    }
}
