//! Paints the picture and the user interface on the window's surface.
//!
//! The picture and the panels' ground are not egui's: its fragment shader samples every texture twice, in two ways, and
//! on a software adapter a windowful of it takes 58 ms of a core's time where a plain one takes 7.
//!
//! The surface's format is a plain one (not `…Srgb`): the picture and egui both hold sRGB-encoded values, which go to the
//! screen as they are, so that the window shows what the PNG holds.

use super::theme;
use crate::gpu::pass::{Bindings, guarded, module_of};
use crate::gpu::{Gpu, GpuError};
use glam::UVec2;
use winit::window::Window;

/// A surface with what draws on it.
pub struct Painter {
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    configured: bool,
    renderer: egui_wgpu::Renderer,
    blit: Blit,
    /// What is at the right of the wipe.
    blit_beside: Blit,
}

/// Draws the picture.
#[derive(Debug)]
struct Blit {
    pipeline: wgpu::RenderPipeline,
    bindings: Bindings,
    sampler: wgpu::Sampler,
    bound: Option<(wgpu::Texture, wgpu::BindGroup)>,
}

/// What became of a painting.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Painted {
    /// It is on the screen.
    Shown,
    /// There is nothing to paint on at present: no size, or covered.
    Nowhere,
    /// The surface had to be made anew; paint again.
    Again,
    /// The surface is gone; make a new one with [`Painter::replace_surface`].
    Lost,
}

impl std::fmt::Debug for Painter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Painter").field("config", &self.config).finish_non_exhaustive()
    }
}

impl Painter {
    /// Prepares to paint on `surface`.
    ///
    /// # Errors
    /// When the adapter can't show anything there.
    pub fn new(gpu: &Gpu, surface: wgpu::Surface<'static>) -> Result<Self, GpuError> {
        let refuse = |reason: &str| GpuError::NoDevice { adapter: gpu.info.name.clone(), reason: reason.to_owned() };
        let mut config = surface
            .get_default_config(&gpu.adapter, 1, 1)
            .ok_or_else(|| refuse("it can't show pictures in this window"))?;
        let formats = surface.get_capabilities(&gpu.adapter).formats;
        let plain =
            |f: &&wgpu::TextureFormat| matches!(f, wgpu::TextureFormat::Bgra8Unorm | wgpu::TextureFormat::Rgba8Unorm);
        if let Some(format) = formats.iter().find(plain) {
            config.format = *format;
        }
        config.present_mode = wgpu::PresentMode::AutoVsync;
        config.desired_maximum_frame_latency = 1;
        // No dithering: the picture's bytes go to the screen unchanged.
        let options = egui_wgpu::RendererOptions { dithering: false, ..Default::default() };
        let renderer = egui_wgpu::Renderer::new(&gpu.device, config.format, options);
        let (blit, blit_beside) = (Blit::new(gpu, config.format)?, Blit::new(gpu, config.format)?);
        Ok(Self { surface, config, configured: false, renderer, blit, blit_beside })
    }

    /// Goes on with another surface of the same window.
    pub fn replace_surface(&mut self, surface: wgpu::Surface<'static>) {
        self.surface = surface;
        self.configured = false;
    }

    /// The window has this size now, pixels; may be nothing.
    pub fn resize(&mut self, size: UVec2) {
        if UVec2::new(self.config.width, self.config.height) != size {
            (self.config.width, self.config.height) = (size.x, size.y);
            self.configured = false;
        }
    }

    /// Paints the picture and what egui made, and shows it.
    pub fn paint(&mut self, gpu: &Gpu, window: &Window, ctx: &egui::Context, mut input: PaintInput<'_>) -> Painted {
        let mut textures = std::mem::take(&mut input.textures);
        let free = std::mem::take(&mut textures.free);
        #[expect(clippy::iter_over_hash_type, reason = "each texture is written on its own")]
        for (id, deltas) in textures.set.drain() {
            for delta in deltas {
                self.renderer.update_texture(&gpu.device, &gpu.queue, id, &delta);
            }
        }
        let painted = self.paint_shapes(gpu, window, ctx, input);
        #[expect(clippy::iter_over_hash_type, reason = "each texture is freed on its own")]
        for id in &free {
            self.renderer.free_texture(id);
        }
        painted
    }

    /// A colour as the surface takes it to clear: encoded as it is, unless the surface encodes by itself.
    fn ground(&self, color: egui::Color32) -> wgpu::Color {
        let [r, g, b, _] = if self.config.format.is_srgb() {
            egui::Rgba::from(color).to_array()
        } else {
            color.to_normalized_gamma_f32()
        };
        wgpu::Color { r: r.into(), g: g.into(), b: b.into(), a: 1.0 }
    }

    fn paint_shapes(&mut self, gpu: &Gpu, window: &Window, ctx: &egui::Context, input: PaintInput<'_>) -> Painted {
        let PaintInput { shapes, pixels_per_point, picture, beside, place, .. } = input;
        if self.config.width == 0 || self.config.height == 0 {
            return Painted::Nowhere;
        }
        if !self.configured {
            self.surface.configure(&gpu.device, &self.config);
            self.configured = true;
        }
        let target = match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(target) => target,
            wgpu::CurrentSurfaceTexture::Suboptimal(target) => {
                self.configured = false; // from the next frame on
                target
            }
            none => {
                let (painted, configured) = without_texture(&none);
                self.configured = configured;
                return painted;
            }
        };
        let jobs = ctx.tessellate(shapes, pixels_per_point);
        let size_in_pixels = [target.texture.width(), target.texture.height()];
        let screen = egui_wgpu::ScreenDescriptor { size_in_pixels, pixels_per_point };
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("window") });
        let extra = self.renderer.update_buffers(&gpu.device, &gpu.queue, &mut encoder, &jobs, &screen);
        let view = target.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut pass = encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("window"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(self.ground(theme::PANEL)),
                        store: wgpu::StoreOp::Store,
                    },
                    depth_slice: None,
                })],
                ..Default::default()
            })
            .forget_lifetime();
        if let Some(picture) = picture {
            self.blit.draw(gpu, &mut pass, picture, place, place.left(), size_in_pixels);
        }
        if let Some((picture, wipe)) = beside {
            let from = place.left() + wipe * place.width();
            self.blit_beside.draw(gpu, &mut pass, picture, place, from, size_in_pixels);
        }
        self.renderer.render(&mut pass, &jobs, &screen);
        drop(pass);
        gpu.queue.submit(extra.into_iter().chain([encoder.finish()]));
        window.pre_present_notify();
        gpu.queue.present(target);
        Painted::Shown
    }
}

/// What becomes of a painting to which the surface gives no texture, and whether the surface is still fit to use.
#[must_use]
pub fn without_texture(status: &wgpu::CurrentSurfaceTexture) -> (Painted, bool) {
    match status {
        wgpu::CurrentSurfaceTexture::Timeout => (Painted::Again, true),
        wgpu::CurrentSurfaceTexture::Occluded => (Painted::Nowhere, true),
        wgpu::CurrentSurfaceTexture::Lost => (Painted::Lost, false),
        _ => (Painted::Again, false),
    }
}

impl Blit {
    fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Result<Self, GpuError> {
        let shader = gpu.shaders.load("painter.wgsl")?;
        let bindings = Bindings::of(&shader, "painter", &["corner", "texel"])?;
        let pipeline = guarded(gpu, "painter.wgsl", || {
            let module = module_of(gpu, &shader);
            gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("painter"),
                layout: None,
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("corner"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: None,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("texel"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(format.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        })?;
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("painter"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        Ok(Self { pipeline, bindings, sampler, bound: None })
    }

    fn draw(
        &mut self,
        gpu: &Gpu,
        pass: &mut wgpu::RenderPass<'_>,
        picture: &wgpu::Texture,
        place: egui::Rect,
        from: f32,
        target: [u32; 2],
    ) {
        let group = match &self.bound {
            Some((bound, group)) if bound == picture => group.clone(),
            _ => {
                let view = picture.create_view(&wgpu::TextureViewDescriptor::default());
                let resources = [
                    ("picture", wgpu::BindingResource::TextureView(&view)),
                    ("linear_clamp", wgpu::BindingResource::Sampler(&self.sampler)),
                ];
                self.bindings.group(gpu, &self.pipeline.get_bind_group_layout(0), &resources)
            }
        };
        #[expect(clippy::cast_precision_loss, reason = "sizes of windows are small")]
        let window = egui::Rect::from_min_max(egui::Pos2::ZERO, egui::pos2(target[0] as f32, target[1] as f32));
        let place = place.intersect(window);
        if place.is_positive() {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.set_viewport(place.min.x, place.min.y, place.width(), place.height(), 0.0, 1.0);
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the window")]
            let from = from.clamp(0.0, window.max.x) as u32;
            pass.set_scissor_rect(from, 0, target[0] - from, target[1]);
            pass.draw(0..3, 0..1);
            pass.set_scissor_rect(0, 0, target[0], target[1]);
        }
        self.bound = Some((picture.clone(), group));
    }
}

/// What is to be painted.
#[derive(Debug)]
pub struct PaintInput<'a> {
    /// egui's shapes.
    pub shapes: Vec<egui::epaint::ClippedShape>,
    /// egui's textures to write before and free after.
    pub textures: egui::TexturesDelta,
    /// Physical pixels a point.
    pub pixels_per_point: f32,
    /// The picture, if there is one.
    pub picture: Option<&'a wgpu::Texture>,
    /// The picture at the right of a wipe, and where that stands: 0 to 1 across the place.
    pub beside: Option<(&'a wgpu::Texture, f32)>,
    /// Its place, pixels.
    pub place: egui::Rect,
}
