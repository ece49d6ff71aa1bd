//! The queue of large triangles: walked by many threads in a second, indirect dispatch; see `lib/large.inc.wgsl`.

use crate::gpu::{ComputePass, Gpu, GpuError, Recorder, buffer};

/// Shares in the queue: as many workgroups as one row of a dispatch may have.
const SHARES: u64 = 65_535;

/// Its buffers.
#[derive(Debug)]
pub(crate) struct LargeTriangles {
    dispatch: wgpu::Buffer,
    empty: wgpu::Buffer,
    shares: wgpu::Buffer,
}

impl LargeTriangles {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let indirect = buffer::STORAGE | wgpu::BufferUsages::INDIRECT;
        Ok(Self {
            dispatch: buffer::with_usage(gpu, "large_dispatch", 16, indirect)?,
            empty: buffer::storage_with(gpu, "large_dispatch_empty", &[0_u32, 1, 1, 0])?,
            shares: buffer::storage(gpu, "large_shares", SHARES * 4)?,
        })
    }

    /// Records a pass over all triangles, then one over the shares of those that it deferred.
    pub(crate) fn record(
        &self,
        rec: &mut Recorder<'_>,
        [all, large]: [&ComputePass; 2],
        resources: &[(&'static str, wgpu::BindingResource<'_>)],
        triangle_count: u32,
    ) {
        rec.encoder.copy_buffer_to_buffer(&self.empty, 0, &self.dispatch, 0, 16);
        let mut resources = resources.to_vec();
        resources.push(("large_dispatch", self.dispatch.as_entire_binding()));
        resources.push(("large_shares", self.shares.as_entire_binding()));
        let group = all.bind_used(rec.gpu, &resources);
        all.dispatch(&mut rec.encoder, &group, [triangle_count, 1, 1]);
        let group = large.bind_used(rec.gpu, &resources);
        large.dispatch_indirect(&mut rec.encoder, &group, &self.dispatch, 0);
    }
}
