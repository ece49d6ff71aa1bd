//! The triangle that each pixel sees first, by rasterizing every triangle straight from the animated vertices.

use crate::animate::{Triangles, Vertex};
use crate::gpu::pass::{Bindings, guarded, module_of};
use crate::gpu::{Gpu, GpuError, GpuStruct, Recorder, layout};
use crate::surroundings::{LightData, PlaneData, Surroundings, SurroundingsBuffers};

const SHADER: &str = "first_surface.wgsl";

/// The pass.
#[derive(Debug)]
pub(super) struct FirstSurface {
    pipeline: wgpu::RenderPipeline,
    bindings: Bindings,
}

impl FirstSurface {
    /// Compiles the pass.
    pub(super) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let source = gpu.shaders.load(SHADER)?;
        for each in [Vertex::LAYOUT, Surroundings::LAYOUT, LightData::LAYOUT, PlaneData::LAYOUT] {
            layout::check(&source.module, SHADER, &each)?;
        }
        let (vertex, fragment) = ("corner", "number_triangle");
        let bindings = Bindings::of(&source, "first_surface", &[vertex, fragment])?;
        let pipeline = guarded(gpu, SHADER, || {
            let module = module_of(gpu, &source);
            gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("first_surface"),
                layout: None,
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some(vertex),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: wgpu::TextureFormat::Depth32Float,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(wgpu::CompareFunction::Greater),
                    stencil: wgpu::StencilState::default(),
                    bias: wgpu::DepthBiasState::default(),
                }),
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some(fragment),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(wgpu::TextureFormat::R32Uint.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        })?;
        Ok(Self { pipeline, bindings })
    }

    /// Draws all triangles: number + 1 of the nearest, 0 where there is none.
    pub(super) fn record(
        &self,
        rec: &mut Recorder<'_>,
        triangles: &Triangles,
        surroundings: &SurroundingsBuffers,
        first_triangle: &wgpu::TextureView,
        depth: &wgpu::TextureView,
    ) {
        let group = self.bindings.group(
            rec.gpu,
            &self.pipeline.get_bind_group_layout(0),
            &[
                ("vertices", triangles.vertices.as_entire_binding()),
                ("indices", triangles.indices.as_entire_binding()),
                ("surroundings", surroundings.data.as_entire_binding()),
            ],
        );
        let mut pass = rec.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("first_surface"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: first_triangle,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..triangles.triangle_count * 3, 0..1);
    }
}
