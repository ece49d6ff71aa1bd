//! Stage 7: tone map, debug views, the picture.

use crate::gpu::{ComputePass, Gpu, GpuError, GpuStruct, Recorder, buffer};
use crate::grid::Grid;
use crate::march::{Channel, Radiance};
use crate::scene::description::EffectSettings;
use crate::scene::material::PartMaterial;
use crate::surroundings::{LightData, PlaneData, Surroundings, SurroundingsBuffers};
use crate::volume::{Record, Volume};
use glam::UVec2;

/// What is shown instead of the picture.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum DebugView {
    /// The picture.
    #[default]
    None,
    /// The view grid's voxels as cubes, coloured by their record's normal.
    Cubes,
    /// The same, coloured by the way that their triangle was marked: amber by a thread, blue by fragments. Of a method that
    /// makes no difference, as [`DebugView::Cubes`].
    Classes,
    /// One slice of the view's grid: occupancy and interior.
    Slice {
        /// 0 = x, 1 = y, 2 = z of the grid.
        axis: u32,
        /// 0 to 1 along it.
        position: f32,
    },
    /// The chosen float channel in false colours (0 … `max`); directions as colours.
    Channel {
        /// The value shown brightest.
        max: f32,
    },
    /// One slice of light 0's grid: the light that is left.
    LightVolume {
        /// 0 to 1 along the light.
        position: f32,
    },
}

crate::gpu_struct! {
    /// What the passes are told.
    pub struct ComposeSettings {
        /// Scales the radiance.
        pub exposure: f32,
        /// The value of a channel that is shown brightest.
        pub max: f32,
        /// Of the slice, 0 to 1.
        pub position: f32,
        /// Of the slice: 0 = x, 1 = y, 2 = z.
        pub axis: u32,
        /// Of a channel: 0 a number, 1 a colour, 2 a direction, 3 a position.
        pub kind: u32,
        /// 1 where `truth` holds the view grid's true voxels.
        pub compares: u32,
        /// 1 where `interior` holds the view grid's solid.
        pub filled: u32,
        /// Padding.
        pub _pad: u32,
    }
}

/// The passes.
#[derive(Debug)]
pub struct Compose {
    main: ComputePass,
    encode: ComputePass,
    enlarge: ComputePass,
    channel: ComputePass,
    cubes: ComputePass,
    classes: ComputePass,
    slice: ComputePass,
    light: ComputePass,
    linear_sampler: wgpu::Sampler,
    /// The picture at the march's resolution, where it must be enlarged.
    encoded: Option<wgpu::Texture>,
}

/// What is composed.
#[derive(Debug, Clone, Copy)]
pub struct Input<'a> {
    /// From the march.
    pub radiance: &'a Radiance,
    /// What the channel beside the radiance holds.
    pub channel: Channel,
    /// For the debug views.
    pub volume: &'a Volume,
    /// Parts' materials, for the light volume's view.
    pub materials: &'a wgpu::Buffer,
    /// For the debug views' camera.
    pub surroundings: &'a SurroundingsBuffers,
    /// Exposure.
    pub effect: &'a EffectSettings,
    /// What to show.
    pub view: DebugView,
    /// A bit a triangle, for [`DebugView::Classes`]: which are large.
    pub classes: Option<&'a wgpu::Buffer>,
    /// The volume's interior words are this frame's.
    pub filled: bool,
    /// The true words of the view's grid, which cubes and slices are held against.
    pub truth: Option<&'a wgpu::Buffer>,
}

impl Compose {
    /// Compiles the passes.
    ///
    /// # Errors
    /// When a shader is wrong.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let layouts = [
            ComposeSettings::LAYOUT,
            Grid::LAYOUT,
            Record::LAYOUT,
            PartMaterial::LAYOUT,
            Surroundings::LAYOUT,
            LightData::LAYOUT,
            PlaneData::LAYOUT,
        ];
        let pass = |shader, entry| ComputePass::new(gpu, shader, entry, &layouts);
        Ok(Self {
            main: pass("compose.wgsl", "main")?,
            encode: pass("compose.wgsl", "encode")?,
            enlarge: pass("compose.wgsl", "enlarge")?,
            channel: pass("compose_channel.wgsl", "main")?,
            cubes: pass("compose_cubes.wgsl", "main")?,
            classes: pass("compose_cubes.wgsl", "classes")?,
            slice: pass("compose_slice.wgsl", "main")?,
            light: pass("compose_slice.wgsl", "light")?,
            linear_sampler: gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("enlarge"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }),
            encoded: None,
        })
    }

    /// Makes a picture, `rgba8unorm` holding sRGB-encoded values.
    #[must_use]
    pub fn target(&self, gpu: &Gpu, size: UVec2) -> wgpu::Texture {
        gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d { width: size.x.max(1), height: size.y.max(1), depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::STORAGE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    }

    /// Records the stage. `target` may be larger than the radiance, which is then scaled up smoothly.
    pub fn record(&mut self, rec: &mut Recorder<'_>, input: &Input<'_>, target: &wgpu::Texture) {
        let settings = buffer::uniform(rec.gpu, "compose_settings", &settings(input));
        let picture = view_of(target);
        let size = [target.width(), target.height(), 1];
        let same_size = [input.radiance.size.x, input.radiance.size.y] == [size[0], size[1]];
        match input.view {
            DebugView::None if same_size => {
                let radiance = view_of(&input.radiance.radiance);
                let group = self.main.bind(
                    rec.gpu,
                    &[
                        ("compose_settings", settings.as_entire_binding()),
                        ("radiance", wgpu::BindingResource::TextureView(&radiance)),
                        ("picture", wgpu::BindingResource::TextureView(&picture)),
                    ],
                );
                self.main.dispatch(&mut rec.encoder, &group, size);
            }
            DebugView::None => self.enlarged(rec, input, &settings, target),
            DebugView::Channel { .. } => {
                let channel = view_of(&input.radiance.channel);
                let group = self.channel.bind(
                    rec.gpu,
                    &[
                        ("compose_settings", settings.as_entire_binding()),
                        ("channel", wgpu::BindingResource::TextureView(&channel)),
                        ("picture", wgpu::BindingResource::TextureView(&picture)),
                    ],
                );
                self.channel.dispatch(&mut rec.encoder, &group, size);
            }
            DebugView::Cubes | DebugView::Classes => {
                let mut further = vec![("compose_settings", settings.as_entire_binding()), truth(input)];
                match input.classes.filter(|_| input.view == DebugView::Classes) {
                    None => run_on_volume(&self.cubes, rec, input, &further, &picture, size),
                    Some(classes) => {
                        further.push(("large_triangles", classes.as_entire_binding()));
                        run_on_volume(&self.classes, rec, input, &further, &picture, size);
                    }
                }
            }
            DebugView::Slice { .. } => {
                let further = [
                    ("compose_settings", settings.as_entire_binding()),
                    ("interior", input.volume.interior.as_entire_binding()),
                    truth(input),
                ];
                run_on_volume(&self.slice, rec, input, &further, &picture, size);
            }
            DebugView::LightVolume { .. } => {
                let further = [
                    ("compose_settings", settings.as_entire_binding()),
                    ("light_records", input.volume.light_records.as_entire_binding()),
                    ("materials", input.materials.as_entire_binding()),
                ];
                run_on_volume(&self.light, rec, input, &further, &picture, size);
            }
        }
    }

    /// Tone-maps at the march's resolution, then enlarges.
    fn enlarged(&mut self, rec: &mut Recorder<'_>, input: &Input<'_>, settings: &wgpu::Buffer, target: &wgpu::Texture) {
        let size = input.radiance.size;
        let fits = |t: &wgpu::Texture| [t.width(), t.height()] == [size.x, size.y];
        let encoded = match self.encoded.take().filter(fits) {
            Some(texture) => texture,
            None => encoded_texture(rec.gpu, size),
        };
        let (radiance, small, picture) = (view_of(&input.radiance.radiance), view_of(&encoded), view_of(target));
        let group = self.encode.bind(
            rec.gpu,
            &[
                ("compose_settings", settings.as_entire_binding()),
                ("radiance", wgpu::BindingResource::TextureView(&radiance)),
                ("encoded", wgpu::BindingResource::TextureView(&small)),
            ],
        );
        self.encode.dispatch(&mut rec.encoder, &group, [size.x, size.y, 1]);
        let group = self.enlarge.bind(
            rec.gpu,
            &[
                ("small", wgpu::BindingResource::TextureView(&small)),
                ("small_sampler", wgpu::BindingResource::Sampler(&self.linear_sampler)),
                ("picture", wgpu::BindingResource::TextureView(&picture)),
            ],
        );
        self.enlarge.dispatch(&mut rec.encoder, &group, [target.width(), target.height(), 1]);
        self.encoded = Some(encoded);
    }
}

/// The true words; where there are none, something to bind.
fn truth<'a>(input: &Input<'a>) -> (&'static str, wgpu::BindingResource<'a>) {
    ("truth", input.truth.unwrap_or(&input.volume.occupancy).as_entire_binding())
}

/// Runs a view of the volume: what they all read, and `further` resources.
fn run_on_volume(
    pass: &ComputePass,
    rec: &mut Recorder<'_>,
    input: &Input<'_>,
    further: &[(&str, wgpu::BindingResource<'_>)],
    picture: &wgpu::TextureView,
    size: [u32; 3],
) {
    let mut resources = further.to_vec();
    resources.extend([
        ("grids", input.volume.grid_data.as_entire_binding()),
        ("surroundings", input.surroundings.data.as_entire_binding()),
        ("occupancy", input.volume.occupancy.as_entire_binding()),
        ("ranks", input.volume.ranks.as_entire_binding()),
        ("records", input.volume.records.as_entire_binding()),
        ("picture", wgpu::BindingResource::TextureView(picture)),
    ]);
    let group = pass.bind_used(rec.gpu, &resources);
    pass.dispatch(&mut rec.encoder, &group, size);
}

fn settings(input: &Input<'_>) -> ComposeSettings {
    let mut settings: ComposeSettings = bytemuck::Zeroable::zeroed();
    settings.exposure = input.effect.exposure;
    let compares = matches!(input.view, DebugView::Cubes | DebugView::Slice { .. });
    settings.compares = (compares && input.truth.is_some()).into();
    settings.filled = input.filled.into();
    settings.kind = match input.channel {
        Channel::Thickness | Channel::Events | Channel::Questionable => 0,
        Channel::Beauty | Channel::Transmittance | Channel::GroundLight => 1,
        Channel::Normal | Channel::ExitDirection => 2,
        Channel::ExitPosition => 3,
    };
    match input.view {
        DebugView::None | DebugView::Cubes | DebugView::Classes => {}
        DebugView::Channel { max } => settings.max = max,
        DebugView::Slice { axis, position } => {
            settings.axis = axis.min(2);
            settings.position = position;
        }
        DebugView::LightVolume { position } => settings.position = position,
    }
    settings
}

fn view_of(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn encoded_texture(gpu: &Gpu, size: UVec2) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("encoded"),
        size: wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::STORAGE_BINDING,
        view_formats: &[],
    })
}
