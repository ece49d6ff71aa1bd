//! Room in the world's buffers for a model whose triangles are made anew for each time, as many as they then are.

use super::neighbors::neighbors;
use super::{Joined, NO_TRIANGLE, Triangles, outward, u32_of};
use crate::gpu::Gpu;
use crate::scene::geometry::{Geometry, Influence, RestVertex};
use glam::Vec3;

/// A run of vertices and one of triangles.
#[derive(Debug)]
pub(super) struct Room {
    /// Index of the model.
    pub(super) model: u32,
    vertex_first: u32,
    vertex_count: usize,
    triangle_first: u32,
    triangle_count: usize,
}

/// Where the corners of triangles lie that a surface does not need, if it has no place of its own: in no grid.
const NOWHERE: Vec3 = Vec3::splat(1e30);

impl Room {
    /// Half as much again as the model needs now, after what is joined already.
    pub(super) fn for_model(model: u32, geometry: &Geometry, joined: &Joined) -> Self {
        let roomy = |count: usize| (count + count / 2 + 1).next_multiple_of(1024);
        Self {
            model,
            vertex_first: u32_of(joined.rest_vertices.len()),
            vertex_count: roomy(geometry.vertices.len()),
            triangle_first: u32_of(joined.triangles.len()),
            triangle_count: roomy(geometry.triangles.len()),
        }
    }

    /// Whether the model as it is now fits.
    pub(super) fn holds(&self, geometry: &Geometry) -> bool {
        geometry.vertices.len() <= self.vertex_count && geometry.triangles.len() <= self.triangle_count
    }

    /// The model, of one part, with all of the room used: triangles that it does not need are points of its surface.
    pub(super) fn filled(&self, geometry: &Geometry) -> Geometry {
        let mut filled = geometry.clone();
        let rest = RestVertex { position: NOWHERE, u: 0.0, normal: Vec3::Y, v: 0.0 };
        let still = Influence { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] };
        filled.vertices.resize(self.vertex_count, rest);
        filled.influences.resize(self.vertex_count, still);
        filled.triangles.resize(self.triangle_count, [0; 3]);
        if let Some(part) = filled.parts.first_mut() {
            part.vertices = 0..u32_of(self.vertex_count);
            part.triangles = 0..u32_of(self.triangle_count);
        }
        filled
    }

    /// Writes the model, which the room holds, to the device.
    pub(super) fn write(&self, gpu: &Gpu, triangles: &Triangles, geometry: &Geometry) {
        let filled = self.filled(geometry);
        let place = |v: u32| (0, filled.vertices[v as usize].position);
        let beyond = neighbors(&filled.triangles, filled.vertices.len(), place);
        let counted_through = |n: u32| if n == NO_TRIANGLE { n } else { n + self.triangle_first };
        let beyond: Vec<[u32; 3]> = beyond.into_iter().map(|t| t.map(counted_through)).collect();
        let indices: Vec<[u32; 3]> =
            filled.triangles.iter().map(|t| outward(&filled, *t).map(|v| v + self.vertex_first)).collect();
        let (vertex_bytes, triangle_bytes) = (size_of::<RestVertex>() as u64, size_of::<[u32; 3]>() as u64);
        let write = |buffer: &wgpu::Buffer, at: u64, bytes: &[u8]| gpu.queue.write_buffer(buffer, at, bytes);
        let first = u64::from(self.triangle_first) * triangle_bytes;
        write(
            &triangles.rest_vertices,
            u64::from(self.vertex_first) * vertex_bytes,
            bytemuck::cast_slice(&filled.vertices),
        );
        write(&triangles.indices, first, bytemuck::cast_slice(&indices));
        write(&triangles.neighbors, first, bytemuck::cast_slice(&beyond));
    }
}
