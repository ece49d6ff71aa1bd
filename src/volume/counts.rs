//! The device's counts, read back without waiting: a small ring of staging buffers.

use super::GridCounters;
use crate::gpu::{Gpu, Recorder};
use crate::grid::MAX_GRIDS;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// Reads in flight at most; while all are, a frame's counts are not asked for.
const RING: usize = 3;

/// What came back, and what is on its way.
#[derive(Debug, Default)]
pub(super) struct Counts {
    latest: Vec<GridCounters>,
    /// When the newest counts were asked for, and of which layout they are.
    latest_request: u64,
    latest_generation: u64,
    requests: u64,
    ring: Vec<Staging>,
}

#[derive(Debug)]
struct Staging {
    buffer: wgpu::Buffer,
    pending: Option<Pending>,
}

#[derive(Debug)]
struct Pending {
    answer: Receiver<Result<(), wgpu::BufferAsyncError>>,
    request: u64,
    generation: u64,
}

impl Counts {
    /// Asks for `counters` as they will be when all that is recorded is done. Part of the frame's own submission: a
    /// second one would wait on some drivers (lavapipe) until the first is done.
    pub(super) fn ask(&mut self, rec: &mut Recorder<'_>, counters: &wgpu::Buffer, generation: u64) {
        let gpu = rec.gpu;
        self.poll(gpu);
        if self.ring.len() < RING && self.ring.iter().all(|s| s.pending.is_some()) {
            let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("counts"),
                size: (size_of::<GridCounters>() * MAX_GRIDS) as u64,
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            self.ring.push(Staging { buffer, pending: None });
        }
        let Some(free) = self.ring.iter_mut().find(|s| s.pending.is_none()) else { return };
        rec.encoder.copy_buffer_to_buffer(counters, 0, &free.buffer, 0, free.buffer.size());
        let (sender, answer) = channel();
        rec.encoder.map_buffer_on_submit(&free.buffer, wgpu::MapMode::Read, .., move |result| {
            // Nobody listens any more once the volume is dropped.
            let _ = sender.send(result);
        });
        self.requests += 1;
        free.pending = Some(Pending { answer, request: self.requests, generation });
    }

    /// Takes what has come back since; never waits.
    pub(super) fn poll(&mut self, gpu: &Gpu) {
        if self.ring.iter().all(|s| s.pending.is_none()) {
            return;
        }
        // A lost device is told by the frame that needs it.
        let _ = gpu.device.poll(wgpu::PollType::Poll);
        let mut arrived = Vec::new();
        for staging in &mut self.ring {
            let Some(pending) = &staging.pending else { continue };
            match pending.answer.try_recv() {
                Err(TryRecvError::Empty) => {}
                Ok(Ok(())) => {
                    if let Ok(view) = staging.buffer.slice(..).get_mapped_range() {
                        let counters = bytemuck::pod_collect_to_vec::<u8, GridCounters>(&view);
                        arrived.push((pending.request, pending.generation, counters));
                    }
                    staging.buffer.unmap();
                    staging.pending = None;
                }
                Ok(Err(_)) | Err(TryRecvError::Disconnected) => staging.pending = None,
            }
        }
        for (request, generation, counters) in arrived {
            self.put(counters, request, generation);
        }
    }

    /// Takes counts that were waited for: newer than all on their way.
    pub(super) fn put_now(&mut self, counters: Vec<GridCounters>, generation: u64) {
        self.requests += 1;
        self.put(counters, self.requests, generation);
    }

    fn put(&mut self, counters: Vec<GridCounters>, request: u64, generation: u64) {
        if request > self.latest_request {
            (self.latest, self.latest_request, self.latest_generation) = (counters, request, generation);
        }
    }

    /// The newest counts, if they are of the layout `generation`; else none.
    pub(super) fn of(&self, generation: u64) -> &[GridCounters] {
        if self.latest_generation == generation { &self.latest } else { &[] }
    }
}
