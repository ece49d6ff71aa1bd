//! How large the triangles are that `hybrid` marks, counted by the device and read back without waiting.

use super::Input;
use super::cutoff::OCTAVES;
use crate::gpu::{ComputePass, Gpu, GpuError, Recorder, buffer};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

const BYTES: u64 = (OCTAVES * size_of::<u32>()) as u64;

/// One count, on its way or arrived.
#[derive(Debug)]
pub(super) struct Survey {
    sizes: wgpu::Buffer,
    staging: wgpu::Buffer,
    answer: Option<Receiver<Result<(), wgpu::BufferAsyncError>>>,
}

impl Survey {
    pub(super) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            sizes: buffer::storage(gpu, "sizes", BYTES)?,
            staging: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("sizes"),
                size: BYTES,
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            answer: None,
        })
    }

    /// True while a count is on its way.
    pub(super) fn is_pending(&self) -> bool {
        self.answer.is_some()
    }

    /// Asks for the sizes of the input's triangles by `pass`, the shader's `survey`; part of the frame's own submission.
    pub(super) fn ask(&mut self, rec: &mut Recorder<'_>, input: &Input<'_>, pass: &ComputePass) {
        rec.encoder.clear_buffer(&self.sizes, 0, None);
        let mut resources = input.resources().to_vec();
        resources.push(("sizes", self.sizes.as_entire_binding()));
        let group = pass.bind_used(rec.gpu, &resources);
        pass.dispatch(&mut rec.encoder, &group, [input.triangles.triangle_count, 1, 1]);
        rec.encoder.copy_buffer_to_buffer(&self.sizes, 0, &self.staging, 0, BYTES);
        let (sender, answer) = channel();
        rec.encoder.map_buffer_on_submit(&self.staging, wgpu::MapMode::Read, .., move |result| {
            // Nobody listens any more once the voxelizer is dropped.
            let _ = sender.send(result);
        });
        self.answer = Some(answer);
    }

    /// The count, once, if it has arrived; never waits.
    pub(super) fn arrived(&mut self, gpu: &Gpu) -> Option<[u32; OCTAVES]> {
        let answer = self.answer.as_ref()?;
        // A lost device is told by the frame that needs it.
        let _ = gpu.device.poll(wgpu::PollType::Poll);
        match answer.try_recv() {
            Err(TryRecvError::Empty) => None,
            Ok(Ok(())) => {
                let view = self.staging.slice(..).get_mapped_range().ok();
                let sizes = view.map(|view| bytemuck::pod_read_unaligned(&view));
                self.staging.unmap();
                self.answer = None;
                sizes
            }
            Ok(Err(_)) | Err(TryRecvError::Disconnected) => {
                self.answer = None;
                None
            }
        }
    }
}
