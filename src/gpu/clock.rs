//! Times stages by the device's own timestamps, where those tell the truth.
//!
//! Two timestamps a stage are resolved into a small ring of buffers, which are mapped without waiting: the times of a
//! frame arrive a frame or more late. Some drivers count something other than time (lavapipe of Mesa 22.3 reports
//! 0.13 ms for 50): [`StageClock::is_true`] checks once against the wall clock.

use super::{Gpu, GpuError, StageTimes};
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Instant;

/// The most stages that one frame may have.
const MAX_STAGES: u32 = 32;
/// Frames whose times may be on their way at once.
const RING: usize = 3;
/// How long the check's work must take by the wall clock, milliseconds.
const CHECK_MS: f64 = 10.0;
/// Measured by timestamps over measured by the wall clock: what passes for true.
const TRUE_RATIO: std::ops::RangeInclusive<f64> = 0.5..=1.1;
/// Each of the check's two works takes at least this share of the wall clock's time.
const LEAST_SHARE: f64 = 0.1;

const FREE: u8 = 0;
const MAPPING: u8 = 1;
const MAPPED: u8 = 2;
const FAILED: u8 = 3;

/// The timestamps of a device: at most one frame records into them at a time.
#[derive(Debug, Default)]
pub struct StageClock {
    truth: OnceLock<bool>,
    ring: Mutex<Option<Ring>>,
}

#[derive(Debug)]
struct Ring {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    slots: Vec<Slot>,
    latest: StageTimes,
}

#[derive(Debug)]
struct Slot {
    staging: wgpu::Buffer,
    state: Arc<AtomicU8>,
    stages: Vec<&'static str>,
}

/// The stages of the frame that is being recorded, in order.
#[derive(Debug, Default)]
pub(super) struct Marks {
    stages: Vec<&'static str>,
    open: bool,
}

impl StageClock {
    /// True where the device has timestamps at all.
    #[must_use]
    pub fn is_supported(gpu: &Gpu) -> bool {
        let needed = wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
        gpu.device.features().contains(needed)
    }

    /// True where the device's timestamps agree with the wall clock. The first call works the device for some 20 ms.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn is_true(&self, gpu: &Gpu) -> Result<bool, GpuError> {
        if let Some(known) = self.truth.get() {
            return Ok(*known);
        }
        let truth = Self::is_supported(gpu) && check(gpu)?;
        Ok(*self.truth.get_or_init(|| truth))
    }

    /// The times that arrived last, in the order recorded; empty until the first arrive.
    #[must_use]
    pub fn latest(&self) -> StageTimes {
        self.lock().as_ref().map(|r| r.latest.clone()).unwrap_or_default()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Option<Ring>> {
        // A panic while the lock was held leaves at worst a slot that never maps.
        self.ring.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn begin(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, marks: &mut Marks, stage: &'static str) {
        let at = index_of(marks.stages.len()) * 2;
        if at + 1 < MAX_STAGES * 2 {
            encoder.write_timestamp(&self.lock().get_or_insert_with(|| Ring::new(gpu)).queries, at);
            marks.stages.push(stage);
            marks.open = true;
        }
    }

    pub(super) fn end(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, marks: &mut Marks) {
        if std::mem::take(&mut marks.open) {
            let at = index_of(marks.stages.len()) * 2 - 1;
            encoder.write_timestamp(&self.lock().get_or_insert_with(|| Ring::new(gpu)).queries, at);
        }
    }

    /// Records how the marks come back, and takes in what has arrived of earlier ones, without waiting.
    pub(super) fn resolve(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, marks: Marks) -> StageTimes {
        // A lost device shows at the next submission that is waited for.
        let _ = gpu.device.poll(wgpu::PollType::Poll);
        let mut guard = self.lock();
        let Some(ring) = guard.as_mut() else { return StageTimes::new() };
        ring.harvest(f64::from(gpu.queue.get_timestamp_period()));
        let count = index_of(marks.stages.len()) * 2;
        let free = ring.slots.iter_mut().find(|s| s.state.load(Ordering::Acquire) == FREE);
        if let Some(slot) = free.filter(|_| count > 0) {
            encoder.resolve_query_set(&ring.queries, 0..count, &ring.resolved, 0);
            encoder.copy_buffer_to_buffer(&ring.resolved, 0, &slot.staging, 0, u64::from(count) * 8);
            slot.stages = marks.stages;
            slot.state.store(MAPPING, Ordering::Release);
            let state = Arc::clone(&slot.state);
            encoder.map_buffer_on_submit(&slot.staging, wgpu::MapMode::Read, .., move |result| {
                state.store(if result.is_ok() { MAPPED } else { FAILED }, Ordering::Release);
            });
        }
        ring.latest.clone()
    }
}

impl Ring {
    fn new(gpu: &Gpu) -> Self {
        let bytes = u64::from(MAX_STAGES) * 2 * 8;
        let buffer = |label, usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: bytes,
                usage,
                mapped_at_creation: false,
            })
        };
        let slot = |_| Slot {
            staging: buffer("stage times", wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST),
            state: Arc::new(AtomicU8::new(FREE)),
            stages: Vec::new(),
        };
        Self {
            queries: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("stages"),
                ty: wgpu::QueryType::Timestamp,
                count: MAX_STAGES * 2,
            }),
            resolved: buffer("stage ticks", wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            slots: (0..RING).map(slot).collect(),
            latest: StageTimes::new(),
        }
    }

    fn harvest(&mut self, ns_per_tick: f64) {
        for slot in &self.slots {
            let state = slot.state.load(Ordering::Acquire);
            if state == MAPPED {
                if let Ok(view) = slot.staging.slice(..).get_mapped_range() {
                    let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&view[..slot.stages.len() * 16]);
                    self.latest = times_of(&slot.stages, &ticks, ns_per_tick);
                }
                slot.staging.unmap();
            }
            if state == MAPPED || state == FAILED {
                slot.state.store(FREE, Ordering::Release);
            }
        }
    }
}

/// Milliseconds of each stage from its two ticks; stages of one name are summed.
fn times_of(stages: &[&'static str], ticks: &[u64], ns_per_tick: f64) -> StageTimes {
    let mut times = StageTimes::new();
    for (stage, pair) in stages.iter().zip(ticks.chunks_exact(2)) {
        #[expect(clippy::cast_precision_loss, reason = "a stage takes far fewer than 2^52 ticks")]
        let ms = pair[1].saturating_sub(pair[0]) as f64 * ns_per_tick * 1e-6;
        super::recorder::add_time(&mut times, stage, ms);
    }
    times
}

fn index_of(stages: usize) -> u32 {
    u32::try_from(stages).unwrap_or(MAX_STAGES)
}

/// Side of the check's render target, and root of its number of threads.
const CHECK_SIDE: u32 = 64;

/// Works the device for [`CHECK_MS`] and more, by compute and by rasterizing, and compares its own account of it with the
/// wall clock's.
fn check(gpu: &Gpu) -> Result<bool, GpuError> {
    let pass = super::ComputePass::new(gpu, "spin.wgsl", "main", &[])?;
    let output = super::buffer::storage(gpu, "spin", u64::from(CHECK_SIDE * CHECK_SIDE) * 4)?;
    let by_compute = |encoder: &mut wgpu::CommandEncoder, turns: &wgpu::Buffer| {
        let group = pass.bind(gpu, &[("turns", turns.as_entire_binding()), ("output", output.as_entire_binding())]);
        pass.dispatch(encoder, &group, [CHECK_SIDE * CHECK_SIDE, 1, 1]);
    };
    let (pipeline, bindings) = raster(gpu)?;
    let target = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("spin"),
        size: wgpu::Extent3d { width: CHECK_SIDE, height: CHECK_SIDE, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    let by_raster = |encoder: &mut wgpu::CommandEncoder, turns: &wgpu::Buffer| {
        let group = bindings.group(gpu, &pipeline.get_bind_group_layout(0), &[("turns", turns.as_entire_binding())]);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("spin"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
                depth_slice: None,
            })],
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
    };
    agree(gpu, &[("compute", &by_compute), ("raster", &by_raster)])
}

/// Records work that lasts as many turns as the buffer says.
type Work<'w> = &'w dyn Fn(&mut wgpu::CommandEncoder, &wgpu::Buffer);

fn raster(gpu: &Gpu) -> Result<(wgpu::RenderPipeline, super::pass::Bindings), GpuError> {
    let shader = gpu.shaders.load("spin.wgsl")?;
    let bindings = super::pass::Bindings::of(&shader, "spin", &["corner", "pixel"])?;
    let module = super::pass::module_of(gpu, &shader);
    let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("spin"),
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
            entry_point: Some("pixel"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(wgpu::TextureFormat::Rgba8Unorm.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    Ok((pipeline, bindings))
}

/// Whether timestamps around works of about the same length, made ever longer up to [`CHECK_MS`], agree with the wall
/// clock as a sum, and none is laid to another.
fn agree(gpu: &Gpu, works: &[(&'static str, Work<'_>)]) -> Result<bool, GpuError> {
    let encoder = || gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("spin") });
    let mut turns = 1u32 << 10;
    loop {
        let uniform = super::buffer::uniform(gpu, "spin turns", &[turns, 0, 0, 0]);
        let clock = StageClock::default();
        let (mut encoded, mut marks) = (encoder(), Marks::default());
        let started = Instant::now();
        for (name, work) in works {
            clock.begin(gpu, &mut encoded, &mut marks, name);
            work(&mut encoded, &uniform);
            clock.end(gpu, &mut encoded, &mut marks);
        }
        clock.resolve(gpu, &mut encoded, marks);
        gpu.queue.submit([encoded.finish()]);
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| GpuError::Lost(e.to_string()))?;
        let wall_ms = started.elapsed().as_secs_f64() * 1e3;
        let times = clock.resolve(gpu, &mut encoder(), Marks::default());
        // The first rounds compile the pipeline for the device; they count only if they are long by their work.
        if turns > 1 << 10 && (wall_ms >= CHECK_MS || turns >= 1 << 26) {
            tracing::debug!(?times, wall_ms, "timestamps beside the wall clock");
            return Ok(times.len() == works.len() && tell_the_truth(&times, wall_ms));
        }
        turns *= 4;
    }
}

/// Whether the times of works of about the same length agree with the wall clock's of all of them.
fn tell_the_truth(times: &StageTimes, wall_ms: f64) -> bool {
    let sum_ms: f64 = times.iter().map(|(_, ms)| ms).sum();
    times.iter().all(|(_, ms)| *ms >= LEAST_SHARE * wall_ms) && TRUE_RATIO.contains(&(sum_ms / wall_ms))
}

#[cfg(test)]
mod tests {
    use super::{tell_the_truth, times_of};

    #[test]
    fn timestamps_are_believed_when_they_agree_with_the_wall_clock_and_not_when_they_lie() {
        let told = |compute_ms, raster_ms| tell_the_truth(&vec![("compute", compute_ms), ("raster", raster_ms)], 50.0);
        assert!(told(24.0, 25.0));
        assert!(told(12.0, 18.0), "the wall clock holds the submission too");
        assert!(!told(0.13, 0.13), "as lavapipe of Mesa 22.3 has it");
        assert!(!told(49.0, 0.5), "one work's time is laid to the other");
        assert!(!told(60.0, 45.0), "longer than there was time");
        assert!(!told(f64::NAN, 25.0));
        assert!(!tell_the_truth(&Vec::new(), 50.0), "no times at all");
    }

    #[test]
    fn ticks_become_milliseconds_and_stages_of_one_name_are_summed() {
        let ticks = [0, 1_000_000, 2_000_000, 2_500_000, 2_500_000, 4_500_000];
        let times = times_of(&["march", "light", "march"], &ticks, 2.0);
        assert_eq!(times, vec![("march", 6.0), ("light", 1.0)]);
    }

    #[test]
    fn ticks_that_run_backwards_count_as_nothing() {
        assert_eq!(times_of(&["march"], &[10, 3], 1.0), vec![("march", 0.0)]);
    }
}
