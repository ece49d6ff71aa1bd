//! Paints the user interface on the window's surface.
//!
//! The surface's format is a plain one (not `…Srgb`): the picture and egui both hold sRGB-encoded values, which go to the
//! screen as they are, so that the window shows what the PNG holds.

use crate::gpu::{Gpu, GpuError};
use glam::UVec2;
use winit::window::Window;

/// A surface with what draws on it.
pub struct Painter {
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    configured: bool,
    renderer: egui_wgpu::Renderer,
    picture: Option<(egui::TextureId, wgpu::Texture)>,
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
        Ok(Self { surface, config, configured: false, renderer, picture: None })
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

    /// The texture by which egui knows the picture.
    pub fn picture_id(&mut self, gpu: &Gpu, picture: &wgpu::Texture) -> egui::TextureId {
        let filter = wgpu::FilterMode::Linear;
        let view = || picture.create_view(&wgpu::TextureViewDescriptor::default());
        match &mut self.picture {
            Some((id, known)) => {
                if known != picture {
                    let (device, renderer) = (&gpu.device, &mut self.renderer);
                    renderer.update_egui_texture_from_wgpu_texture(device, &view(), filter, *id);
                    *known = picture.clone();
                }
                *id
            }
            None => {
                let id = self.renderer.register_native_texture(&gpu.device, &view(), filter);
                self.picture = Some((id, picture.clone()));
                id
            }
        }
    }

    /// Paints what egui made and shows it.
    pub fn paint(&mut self, gpu: &Gpu, window: &Window, ctx: &egui::Context, output: PaintInput) -> Painted {
        let PaintInput { shapes, mut textures, pixels_per_point } = output;
        let free = std::mem::take(&mut textures.free);
        #[expect(clippy::iter_over_hash_type, reason = "each texture is written on its own")]
        for (id, deltas) in textures.set.drain() {
            for delta in deltas {
                self.renderer.update_texture(&gpu.device, &gpu.queue, id, &delta);
            }
        }
        let painted = self.paint_shapes(gpu, window, ctx, shapes, pixels_per_point);
        #[expect(clippy::iter_over_hash_type, reason = "each texture is freed on its own")]
        for id in &free {
            self.renderer.free_texture(id);
        }
        painted
    }

    fn paint_shapes(
        &mut self,
        gpu: &Gpu,
        window: &Window,
        ctx: &egui::Context,
        shapes: Vec<egui::epaint::ClippedShape>,
        pixels_per_point: f32,
    ) -> Painted {
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
            wgpu::CurrentSurfaceTexture::Timeout => return Painted::Again,
            wgpu::CurrentSurfaceTexture::Occluded => return Painted::Nowhere,
            wgpu::CurrentSurfaceTexture::Outdated | wgpu::CurrentSurfaceTexture::Validation => {
                self.configured = false;
                return Painted::Again;
            }
            wgpu::CurrentSurfaceTexture::Lost => return Painted::Lost,
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
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Store,
                    },
                    depth_slice: None,
                })],
                ..Default::default()
            })
            .forget_lifetime();
        self.renderer.render(&mut pass, &jobs, &screen);
        drop(pass);
        gpu.queue.submit(extra.into_iter().chain([encoder.finish()]));
        window.pre_present_notify();
        gpu.queue.present(target);
        Painted::Shown
    }
}

/// What egui wants painted.
#[derive(Debug)]
pub struct PaintInput {
    /// Shapes.
    pub shapes: Vec<egui::epaint::ClippedShape>,
    /// Textures to write before and free after.
    pub textures: egui::TexturesDelta,
    /// Physical pixels a point.
    pub pixels_per_point: f32,
}
