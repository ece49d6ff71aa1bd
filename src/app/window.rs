//! The window with its device, its surface and the renderer: made together, and made again when the device is lost.

use super::painter::Painter;
use super::pictures::Pictures;
use super::shell::{Event, Proxy};
use super::{AppError, theme};
use crate::gpu::shader::ShaderLibrary;
use crate::gpu::{AdapterChoice, Gpu};
use std::path::Path;
use std::sync::Arc;
use winit::window::Window;

/// An open window.
pub(super) struct Opened {
    pub(super) window: Arc<Window>,
    pub(super) gpu: Gpu,
    pub(super) painter: Painter,
    pub(super) pictures: Pictures,
    pub(super) egui: egui_winit::State,
    /// Name, kind and driver of the adapter.
    pub(super) adapter: String,
    /// Why the shaders of the folder are not used, if they are not.
    pub(super) shader_fault: Option<String>,
    instance: wgpu::Instance,
}

impl Opened {
    /// Opens an adapter that can show pictures in `window`, and compiles the frame's stages.
    pub(super) fn new(
        window: Arc<Window>,
        choice: &AdapterChoice,
        shaders: Option<&Path>,
        proxy: &Proxy,
    ) -> Result<Self, AppError> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::PRIMARY;
        let instance = wgpu::Instance::new(descriptor);
        let surface = instance
            .create_surface(Arc::clone(&window))
            .map_err(|e| AppError::System(format!("a surface to paint on: {e}")))?;
        let mut gpu = Gpu::open_for_surface(&instance, choice, &surface)?;
        let complaints = proxy.clone();
        gpu.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            complaints.send(Event::Complaint(error.to_string()));
        }));
        let painter = Painter::new(&gpu, surface)?;
        let done = |proxy: &Proxy| {
            let proxy = proxy.clone();
            move |result| proxy.send(Event::FrameDone(result))
        };
        if let Some(folder) = shaders {
            gpu.shaders = ShaderLibrary::Folder(folder.to_owned());
        }
        let mut shader_fault = None;
        let pictures = match Pictures::new(&gpu, done(proxy)) {
            Err(fault) if shaders.is_some() => {
                shader_fault = Some(format!("{fault}; the shaders built in are used"));
                gpu.shaders = ShaderLibrary::Embedded;
                Pictures::new(&gpu, done(proxy))?
            }
            other => other?,
        };
        let ctx = egui::Context::default();
        theme::apply(&ctx);
        let side = usize::try_from(gpu.device.limits().max_texture_dimension_2d).ok();
        #[expect(clippy::cast_possible_truncation, reason = "a factor near 1")]
        let scale = window.scale_factor() as f32;
        let egui = egui_winit::State::new(ctx, egui::ViewportId::ROOT, &window, Some(scale), None, side);
        let info = &gpu.info;
        let adapter = format!("{} · {:?} · {} {}", info.name, info.backend, info.driver, info.driver_info);
        Ok(Self { window, gpu, painter, pictures, egui, adapter, shader_fault, instance })
    }

    /// Makes the surface anew.
    pub(super) fn replace_surface(&mut self) -> Result<(), AppError> {
        let surface = self
            .instance
            .create_surface(Arc::clone(&self.window))
            .map_err(|e| AppError::System(format!("a surface to paint on: {e}")))?;
        self.painter.replace_surface(surface);
        Ok(())
    }

    /// Size of the window's inside, pixels.
    pub(super) fn size(&self) -> glam::UVec2 {
        let size = self.window.inner_size();
        glam::UVec2::new(size.width, size.height)
    }
}
