//! Rasterizing into occupancy words: pipelines whose fragments mark, over a target that nothing is written to.

use super::variant::Variant;
use crate::gpu::pass::{Bindings, guarded, module_of};
use crate::gpu::{Gpu, GpuError, Layout, Recorder, layout};
use glam::UVec2;

/// A shader's vertex and fragment entry points, compiled.
#[derive(Debug)]
pub(super) struct Raster {
    label: &'static str,
    bindings: Bindings,
    pipeline: wgpu::RenderPipeline,
    target: Option<(UVec2, wgpu::TextureView)>,
}

/// What to draw.
#[derive(Debug, Clone, Copy)]
pub(super) enum Draw<'a> {
    /// So many vertices, so many instances.
    Counted { vertices: u32, instances: u32 },
    /// As many, numbered from `slice · instances`.
    Slice { vertices: u32, instances: u32, slice: u32 },
    /// As the device counted: four `u32` at the buffer's start.
    Indirect(&'a wgpu::Buffer),
}

impl Raster {
    /// Compiles `vertex` and `fragment` of `shader`.
    pub(super) fn new(
        gpu: &Gpu,
        shader: &'static str,
        [vertex, fragment]: [&str; 2],
        layouts: &[Layout],
        constants: &[(&str, f64)],
    ) -> Result<Self, GpuError> {
        Self::with(gpu, shader, [vertex, fragment], layouts, constants, wgpu::PrimitiveState::default())
    }

    /// As [`Raster::new`], for a shader that draws footprints (`lib/conservative.inc.wgsl`); `constants` are its others.
    ///
    /// # Errors
    /// Also when the adapter itself is to be conservative and can't.
    pub(super) fn of_footprints(
        gpu: &Gpu,
        shader: &'static str,
        entries: [&str; 2],
        layouts: &[Layout],
        variant: Variant,
        constants: &[(&str, f64)],
    ) -> Result<Self, GpuError> {
        let conservative = variant.by_hardware();
        if conservative && !gpu.device.features().contains(wgpu::Features::CONSERVATIVE_RASTERIZATION) {
            return Err(GpuError::Setting(format!(
                "the adapter `{}` has no conservative rasterization; write conservative = \"polygon\", \"box\" or \"dilated\"",
                gpu.info.name
            )));
        }
        let constants: Vec<_> = variant.footprint_constants().iter().chain(constants).copied().collect();
        let primitive = wgpu::PrimitiveState { conservative, ..Default::default() };
        Self::with(gpu, shader, entries, layouts, &constants, primitive)
    }

    fn with(
        gpu: &Gpu,
        shader: &'static str,
        [vertex, fragment]: [&str; 2],
        layouts: &[Layout],
        constants: &[(&str, f64)],
        primitive: wgpu::PrimitiveState,
    ) -> Result<Self, GpuError> {
        let source = gpu.shaders.load(shader)?;
        for each in layouts {
            layout::check(&source.module, shader, each)?;
        }
        let label = shader.trim_end_matches(".wgsl");
        let bindings = Bindings::of(&source, label, &[vertex, fragment])?;
        let compilation_options = wgpu::PipelineCompilationOptions { constants, ..Default::default() };
        // A pass must have an attachment; this one is the cheapest and stays untouched.
        let target = wgpu::ColorTargetState {
            format: wgpu::TextureFormat::R8Unorm,
            blend: None,
            write_mask: wgpu::ColorWrites::empty(),
        };
        let pipeline = guarded(gpu, shader, || {
            let module = module_of(gpu, &source);
            gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(label),
                layout: None,
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some(vertex),
                    compilation_options: compilation_options.clone(),
                    buffers: &[],
                },
                primitive,
                depth_stencil: None,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some(fragment),
                    compilation_options: compilation_options.clone(),
                    targets: &[Some(target)],
                }),
                multiview_mask: None,
                cache: None,
            })
        })?;
        Ok(Self { label, bindings, pipeline, target: None })
    }

    /// Draws over a raster of `size` pixels.
    pub(super) fn record(
        &mut self,
        rec: &mut Recorder<'_>,
        size: UVec2,
        resources: &[(&str, wgpu::BindingResource<'_>)],
        draw: Draw<'_>,
    ) {
        if self.target.as_ref().is_none_or(|(made, _)| *made != size) {
            self.target = Some((size, target(rec.gpu, self.label, size)));
        }
        let Some((_, view)) = &self.target else { return };
        let group = self.bindings.group(rec.gpu, &self.pipeline.get_bind_group_layout(0), resources);
        let mut pass = rec.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(self.label),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Discard,
                },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        match draw {
            Draw::Counted { vertices, instances } => pass.draw(0..vertices, 0..instances),
            Draw::Slice { vertices, instances, slice } => {
                pass.draw(0..vertices, slice * instances..(slice + 1) * instances);
            }
            Draw::Indirect(arguments) => pass.draw_indirect(arguments, 0),
        }
    }
}

fn target(gpu: &Gpu, label: &str, size: UVec2) -> wgpu::TextureView {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::R8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
