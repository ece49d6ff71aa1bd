//! Stage 6: the first surface by rasterizing, then rays through the view's grid.
//!
//! Source: [`papers::CHANG_LAI_2011`](crate::papers::CHANG_LAI_2011), §3.2, §3.3 and Fig. 3. Passes, in order:
//!
//! | pass          | does                                                             | writes               |
//! | first_surface | rasterizes every triangle                                        | triangle a pixel     |
//! | march         | ours: follows each ray from crossing to crossing                 | [`Targets`]' path    |
//! | march_voxel   | or the paper's, whole: fixed steps, a voxel's normal             | the same             |
//! | march_two_surface | or the paper's short way: entry, and an estimated exit       | the same             |
//! | shade         | what each path ends on, what the first surface mirrors           | radiance, channel    |
//! | repair        | fills questionable pixels from their neighbours                  | the same             |
//! | ground_light  | the channel of that name                                         | channel              |
//!
//! | paper         | here                       | meaning                                            |
//! | P_i, T_i      | `Ray.origin`, `.direction` | where the ray was bent last, and its way from there |
//! | N_v(P), T_v(P) | `Surface.normal`, `PartMaterial.ior` | normal and refraction index at P         |
//! | σ(d_i)        | `Ray.sigma`                | absorption per world unit; Eq. 5 lacks its minus   |

mod first_surface;

use crate::animate::{Triangles, Vertex};
use crate::gpu::pass::Variants;
use crate::gpu::{ComputePass, Gpu, GpuError, GpuStruct, Recorder, buffer};
use crate::grid::{Grid, PERSPECTIVE};
use crate::scene::description::{EffectSettings, Hit, Refraction};
use crate::scene::geometry::RestVertex;
use crate::scene::material::{PartMaterial, flags};
use crate::surroundings::{LightData, PlaneData, Surroundings, SurroundingsBuffers};
use crate::volume::{Record, Volume};
use first_surface::FirstSurface;
use glam::{DVec3, UVec2, Vec3};
use std::ops::Range;

/// What the float channel of a frame holds; see the design's "Float channels".
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Channel {
    /// The picture itself.
    #[default]
    Beauty,
    /// Length of the transmitted path inside glass, world units.
    Thickness,
    /// Absorption alone down to the first opaque surface or the background, RGB.
    Transmittance,
    /// World normal of the first surface; NaN where there is none.
    Normal,
    /// Refractions and internal reflections along the path.
    Events,
    /// 1 where the ray is questionable.
    Questionable,
    /// World, unit; NaN where the ray left no glass.
    ExitDirection,
    /// World; NaN where the ray left no glass.
    ExitPosition,
    /// Fraction of light 0 that absorption lets through to the first opaque surface met by the unrefracted ray, RGB.
    GroundLight,
}

impl Channel {
    /// Every channel with its name on the command line, and its number of components.
    pub const ALL: &'static [(Channel, &'static str, usize)] = &[
        (Channel::Beauty, "beauty", 3),
        (Channel::Thickness, "thickness", 1),
        (Channel::Transmittance, "transmittance", 3),
        (Channel::Normal, "normal", 3),
        (Channel::Events, "events", 1),
        (Channel::Questionable, "questionable", 1),
        (Channel::ExitDirection, "exit-direction", 3),
        (Channel::ExitPosition, "exit-position", 3),
        (Channel::GroundLight, "ground-light", 3),
    ];
}

crate::gpu_struct! {
    /// What every pass of this stage is told.
    pub struct MarchSettings {
        /// Pixels.
        pub size: UVec2,
        /// The rows to march: the first, and the one behind the last.
        pub rows: UVec2,
        /// The most refractions and internal reflections of a path.
        pub max_events: u32,
        /// 1 where media absorb.
        pub absorb: u32,
        /// 1 where surfaces mirror.
        pub reflect: u32,
        /// A [`Channel`] by number.
        pub channel: u32,
        /// `hit = "voxel"`: a smaller angle between normals is the same surface again.
        pub cos_angle_threshold: f32,
        /// A quiet NaN: WGSL has no way to write one.
        pub nan: f32,
        /// 1 where the first surface is rasterized: pixels without one have no path.
        pub rasterized: u32,
        /// Padding.
        pub _pad: u32,
    }
}

/// What the march writes: two pictures of the internal resolution.
#[derive(Debug)]
pub struct Radiance {
    /// Linear radiance RGB; w is 1 for a good ray, 0 for a questionable one. `rgba32float`.
    pub radiance: wgpu::Texture,
    /// The chosen channel. `rgba32float`.
    pub channel: wgpu::Texture,
    /// Internal resolution.
    pub size: UVec2,
    /// What the passes hand to each other.
    targets: Targets,
}

/// Pictures of the internal resolution that the stage's passes hand to each other. The path's four are described in
/// `shaders/lib/path.inc.wgsl`.
#[derive(Debug)]
struct Targets {
    first_triangle: wgpu::TextureView,
    depth: wgpu::TextureView,
    path_place: wgpu::TextureView,
    path_way: wgpu::TextureView,
    path_depth: wgpu::TextureView,
    path_first: wgpu::TextureView,
    radiance: wgpu::TextureView,
    channel: wgpu::TextureView,
    /// Three numbers of workgroups, the count, the pixels; see `shaders/lib/path_store.inc.wgsl`.
    questionable: wgpu::Buffer,
}

/// The passes.
#[derive(Debug)]
pub struct March {
    first_surface: FirstSurface,
    march: Variants<Marching>,
    shade: Variants<Shading>,
    gather: ComputePass,
    place: ComputePass,
    ground_light: ComputePass,
    texture_sampler: wgpu::Sampler,
    /// Pixels that one thread of a march takes.
    pixels_per_thread: u32,
}

/// What a march pass is compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Marching {
    hit: Hit,
    refraction: Refraction,
    /// The view's grid is a perspective one.
    perspective: bool,
    /// The eye is in the view's grid, and so may be in glass.
    eye_inside: bool,
}

/// What a shade pass is compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Shading {
    /// There are opaque parts beside planes.
    opaque_triangles: bool,
    /// A float channel is written.
    writes_channel: bool,
    /// [`Surroundings::background_kind`].
    background: u32,
}

/// What the march works on.
#[derive(Debug, Clone, Copy)]
pub struct Input<'a> {
    /// Grid 0 is the view's; light grids and the scene grid are found through the surroundings.
    pub volume: &'a Volume,
    /// Triangles.
    pub triangles: &'a Triangles,
    /// Around the volume.
    pub surroundings: &'a SurroundingsBuffers,
    /// Where the camera stands, world.
    pub eye: Vec3,
    /// [`Surroundings::background_kind`] of what stands there.
    pub background: u32,
    /// What is left of the lights on planes, [`crate::plane_light::PlaneLight::view`].
    pub plane_light: &'a wgpu::TextureView,
    /// Effect.
    pub effect: &'a EffectSettings,
    /// Which float channel to write.
    pub channel: Channel,
}

/// A part of the march is a multiple of so many rows: `shade` looks at the paths of the rows beside its own.
pub const ROWS: u32 = 8;

/// Words of the list of questionable pixels before its pixels.
const LIST_HEAD: u64 = 4;

/// Host structs that the stage's shaders share.
const LAYOUTS: &[crate::gpu::Layout] = &[
    Vertex::LAYOUT,
    RestVertex::LAYOUT,
    PartMaterial::LAYOUT,
    Grid::LAYOUT,
    Record::LAYOUT,
    Surroundings::LAYOUT,
    LightData::LAYOUT,
    PlaneData::LAYOUT,
    MarchSettings::LAYOUT,
];

impl March {
    /// Compiles the passes.
    ///
    /// # Errors
    /// When a shader is wrong.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        // A software device runs eight threads in step; a hardware one wants many threads rather than long ones.
        let pixels_per_thread = if gpu.is_software() { 16 } else { 1 };
        let pass =
            |shader, constants: &[(&str, f64)]| ComputePass::with_constants(gpu, shader, "main", LAYOUTS, constants);
        Ok(Self {
            pixels_per_thread,
            first_surface: FirstSurface::new(gpu)?,
            march: Variants::new(),
            shade: Variants::new(),
            gather: ComputePass::new(gpu, "repair.wgsl", "gather", LAYOUTS)?,
            place: ComputePass::new(gpu, "repair.wgsl", "place", LAYOUTS)?,
            ground_light: pass("ground_light.wgsl", &[])?,
            texture_sampler: gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("textures"),
                address_mode_u: wgpu::AddressMode::Repeat,
                address_mode_v: wgpu::AddressMode::Repeat,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                ..Default::default()
            }),
        })
    }

    /// Makes the pictures that [`March::record`] writes.
    #[must_use]
    pub fn target(&self, gpu: &Gpu, size: UVec2) -> Radiance {
        use wgpu::TextureFormat::{Depth32Float, R32Uint, Rgba32Float, Rgba32Uint};
        let make = |label, format, usage| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: size.x.max(1), height: size.y.max(1), depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let drawn = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let stored = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
        let radiance = make("radiance", Rgba32Float, stored | wgpu::TextureUsages::COPY_SRC);
        let channel = make("channel", Rgba32Float, stored | wgpu::TextureUsages::COPY_SRC);
        let targets = Targets {
            first_triangle: view(&make("first_triangle", R32Uint, drawn)),
            depth: view(&make("depth", Depth32Float, wgpu::TextureUsages::RENDER_ATTACHMENT)),
            path_place: view(&make("path_place", Rgba32Float, stored)),
            path_way: view(&make("path_way", Rgba32Float, stored)),
            path_depth: view(&make("path_depth", Rgba32Uint, stored)),
            path_first: view(&make("path_first", Rgba32Float, stored)),
            radiance: view(&radiance),
            channel: view(&channel),
            questionable: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("questionable"),
                size: 4 * (u64::from(size.x.max(1)) * u64::from(size.y.max(1)) + LIST_HEAD),
                usage: buffer::STORAGE | wgpu::BufferUsages::INDIRECT,
                mapped_at_creation: false,
            }),
        };
        Radiance { radiance, channel, size, targets }
    }

    /// Records the march of some rows: the first surface with the first of them, the repair of questionable rays with
    /// the last. Rows may be marched in any number of parts, from the top, each a multiple of [`ROWS`] but the last.
    ///
    /// # Errors
    /// When a shader that was not needed before is wrong.
    pub fn record(
        &mut self,
        rec: &mut Recorder<'_>,
        input: &Input<'_>,
        target: &Radiance,
        rows: Range<u32>,
    ) -> Result<(), GpuError> {
        let Input { volume, triangles, surroundings, effect, .. } = *input;
        let gpu = rec.gpu;
        let to = &target.targets;
        let rows_len = rows.end.saturating_sub(rows.start);
        let shading = Shading {
            opaque_triangles: volume.grids.iter().any(|g| g.required_flags & flags::OPAQUE != 0),
            writes_channel: input.channel != Channel::Beauty,
            background: input.background,
        };
        let perspective = volume.grids.first().is_some_and(|g| g.projection == PERSPECTIVE);
        let eye_inside = volume.grids.first().is_some_and(|g| {
            let p = g.grid_point(input.eye.as_dvec3());
            p.cmpgt(DVec3::ZERO).all() && p.cmplt(g.cells.as_dvec3()).all()
        });
        let marching = Marching { hit: effect.hit, refraction: effect.refraction, perspective, eye_inside };
        let settings = buffer::uniform(gpu, "march_settings", &settings(effect, input.channel, target.size, &rows));
        let view = wgpu::BindingResource::TextureView;
        let resources = [
            ("vertices", triangles.vertices.as_entire_binding()),
            ("indices", triangles.indices.as_entire_binding()),
            ("rest_vertices", triangles.rest_vertices.as_entire_binding()),
            ("neighbors", triangles.neighbors.as_entire_binding()),
            ("materials", triangles.materials.as_entire_binding()),
            ("textures", view(&triangles.textures)),
            ("plane_light", view(input.plane_light)),
            ("texture_sampler", wgpu::BindingResource::Sampler(&self.texture_sampler)),
            ("occupancy", volume.occupancy.as_entire_binding()),
            ("ranks", volume.ranks.as_entire_binding()),
            ("records", volume.records.as_entire_binding()),
            ("light_records", volume.light_records.as_entire_binding()),
            ("grids", volume.grid_data.as_entire_binding()),
            ("surroundings", surroundings.data.as_entire_binding()),
            ("environment", view(&surroundings.environment)),
            ("environment_sampler", wgpu::BindingResource::Sampler(&surroundings.sampler)),
            ("settings", settings.as_entire_binding()),
            ("first_triangle", view(&to.first_triangle)),
            ("path_place", view(&to.path_place)),
            ("path_way", view(&to.path_way)),
            ("path_depth", view(&to.path_depth)),
            ("path_first", view(&to.path_first)),
            ("questionable", to.questionable.as_entire_binding()),
        ];
        if rows.start == 0 {
            self.first_surface.record(rec, triangles, surroundings, &to.first_triangle, &to.depth);
            rec.encoder.clear_buffer(&to.questionable, 0, Some(4 * LIST_HEAD));
        }

        let march = self.march.pass(marching, |&key| marching_pass(gpu, key, self.pixels_per_thread))?;
        let takes_columns = effect.hit == Hit::Surfel && effect.refraction != Refraction::TwoSurface;
        let threads_down = rows_len.div_ceil(if takes_columns { self.pixels_per_thread } else { 1 });
        let group = march.bind_used(gpu, &resources);
        march.dispatch(&mut rec.encoder, &group, [target.size.x, threads_down, 1]);

        let pictures = [("radiance", view(&to.radiance)), ("channel", view(&to.channel))];
        let shade = self.shade.pass(shading, |&key| shading_pass(gpu, key))?;
        let group = shade.bind_used(gpu, &[&resources[..], &pictures].concat());
        shade.dispatch(&mut rec.encoder, &group, [target.size.x, rows_len, 1]);

        if rows.end < target.size.y {
            return Ok(());
        }
        if effect.fill_questionable {
            let seen = [
                ("seen_radiance", view(&to.radiance)),
                ("seen_channel", view(&to.channel)),
                ("found_radiance", view(&to.path_place)),
                ("found_channel", view(&to.path_way)),
            ];
            let group = self.gather.bind_used(gpu, &[&resources[..], &seen].concat());
            self.gather.dispatch_indirect(&mut rec.encoder, &group, &to.questionable, 0);
            let found = [("filled_radiance", view(&to.path_place)), ("filled_channel", view(&to.path_way))];
            let group = self.place.bind_used(gpu, &[&resources[..], &found, &pictures].concat());
            self.place.dispatch_indirect(&mut rec.encoder, &group, &to.questionable, 0);
        }
        if input.channel == Channel::GroundLight {
            let group = self.ground_light.bind_used(gpu, &[&resources[..], &pictures].concat());
            self.ground_light.dispatch(&mut rec.encoder, &group, [target.size.x, target.size.y, 1]);
        }
        Ok(())
    }
}

fn marching_pass(gpu: &Gpu, key: Marching, pixels_per_thread: u32) -> Result<ComputePass, GpuError> {
    let bends = match key.refraction {
        Refraction::None => 0.0,
        Refraction::Single => 1.0,
        Refraction::TwoSurface | Refraction::MultipleSurface => 2.0,
    };
    let by_voxel = key.hit == Hit::Voxel;
    let (shader, constants): (_, &[_]) = match (key.refraction, key.hit) {
        (Refraction::TwoSurface, _) => {
            ("march_two_surface.wgsl", &[("first_is_voxel", f64::from(u32::from(by_voxel)))])
        }
        (_, Hit::Surfel) => (
            "march.wgsl",
            &[
                ("pixels_per_thread", f64::from(pixels_per_thread)),
                ("eye_inside", f64::from(u32::from(key.eye_inside))),
            ],
        ),
        (_, Hit::Voxel) => ("march_voxel.wgsl", &[]),
    };
    let shared = [("bends", bends), ("perspective_rays", f64::from(u32::from(key.perspective)))];
    ComputePass::with_constants(gpu, shader, "main", LAYOUTS, &[constants, &shared].concat())
}

fn shading_pass(gpu: &Gpu, key: Shading) -> Result<ComputePass, GpuError> {
    let constants = [
        ("opaque_triangles", f64::from(u32::from(key.opaque_triangles))),
        ("writes_channel", f64::from(u32::from(key.writes_channel))),
        ("background", f64::from(key.background)),
        // The scene grid is an orthographic one.
        ("perspective_rays", 0.0),
    ];
    ComputePass::with_constants(gpu, "shade.wgsl", "main", LAYOUTS, &constants)
}

/// Takes the next rows to march, about `most`, off the top of those that are left.
pub fn take_rows(left: &mut Range<u32>, most: u32) -> Range<u32> {
    let most = (most / ROWS).max(1) * ROWS;
    let next = left.start.saturating_add(most).min(left.end);
    let taken = left.start..next;
    left.start = next;
    taken
}

fn settings(effect: &EffectSettings, channel: Channel, size: UVec2, rows: &Range<u32>) -> MarchSettings {
    let channel = Channel::ALL.iter().position(|(c, ..)| *c == channel).unwrap_or(0);
    MarchSettings {
        size,
        rows: UVec2::new(rows.start, rows.end),
        max_events: effect.max_events.clamp(1, 32),
        absorb: u32::from(effect.transmittance),
        reflect: u32::from(effect.reflection),
        channel: u32::try_from(channel).unwrap_or(0),
        cos_angle_threshold: effect.angle_threshold_deg.to_radians().cos(),
        nan: f32::NAN,
        rasterized: u32::from(effect.hit == Hit::Surfel),
        _pad: 0,
    }
}
