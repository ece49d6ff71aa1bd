//! Records the stages of a frame and, when asked, times them.

use super::clock::Marks;
use super::{Gpu, GpuError};
use std::time::Instant;

/// How the stages are timed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Timing {
    /// Not at all: one submission.
    #[default]
    Off,
    /// Each stage is submitted on its own and waited for: true on every adapter, slower as a whole.
    Submit,
    /// By the device's timestamps: costs nothing and comes a frame or more late. Only where
    /// [`StageClock::is_true`](super::clock::StageClock::is_true) holds, else as [`Timing::Off`].
    Timestamps,
}

/// Milliseconds of each stage, in the order recorded.
pub type StageTimes = Vec<(&'static str, f64)>;

/// A command encoder that knows which stage it is in.
#[derive(Debug)]
pub struct Recorder<'g> {
    /// The device.
    pub gpu: &'g Gpu,
    /// Where passes record.
    pub encoder: wgpu::CommandEncoder,
    timing: Timing,
    stage: Option<&'static str>,
    started: Instant,
    times: StageTimes,
    marks: Marks,
}

impl<'g> Recorder<'g> {
    /// Starts recording.
    #[must_use]
    pub fn new(gpu: &'g Gpu, timing: Timing) -> Self {
        let timing = match timing {
            Timing::Timestamps if !gpu.clock.is_true(gpu).unwrap_or(false) => Timing::Off,
            other => other,
        };
        Self {
            gpu,
            encoder: encoder(gpu),
            timing,
            stage: None,
            started: Instant::now(),
            times: Vec::new(),
            marks: Marks::default(),
        }
    }

    /// Begins the stage `name`; the one before it ends.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn stage(&mut self, name: &'static str) -> Result<(), GpuError> {
        self.gpu.check()?;
        self.end_stage()?;
        self.stage = Some(name);
        if self.timing == Timing::Timestamps {
            self.gpu.clock.begin(self.gpu, &mut self.encoder, &mut self.marks, name);
        }
        Ok(())
    }

    /// Submits what is recorded and waits for it; the stage goes on. Only for a pass that must see results on the host,
    /// which no frame that is in a hurry has.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn flush(&mut self) -> Result<(), GpuError> {
        let done = std::mem::replace(&mut self.encoder, encoder(self.gpu));
        self.gpu.queue.submit([done.finish()]);
        self.gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| GpuError::Lost(e.to_string()))?;
        Ok(())
    }

    /// Ends the last stage and submits. Stages of one name are summed. With [`Timing::Timestamps`] the times are those
    /// of the latest frame whose times have arrived.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn finish(mut self) -> Result<StageTimes, GpuError> {
        self.end_stage()?;
        if self.timing == Timing::Timestamps {
            self.times = self.gpu.clock.resolve(self.gpu, &mut self.encoder, self.marks);
        }
        self.gpu.queue.submit([self.encoder.finish()]);
        self.gpu.check()?;
        Ok(self.times)
    }

    fn end_stage(&mut self) -> Result<(), GpuError> {
        match self.timing {
            Timing::Off => {}
            Timing::Submit => {
                self.flush()?;
                let ms = self.started.elapsed().as_secs_f64() * 1e3;
                if let Some(stage) = self.stage {
                    add_time(&mut self.times, stage, ms);
                }
            }
            Timing::Timestamps => self.gpu.clock.end(self.gpu, &mut self.encoder, &mut self.marks),
        }
        self.started = Instant::now();
        self.stage = None;
        Ok(())
    }
}

/// Adds to the time of a stage, which takes its place at the end when it is new.
pub(super) fn add_time(times: &mut StageTimes, stage: &'static str, ms: f64) {
    match times.iter_mut().find(|(name, _)| *name == stage) {
        Some((_, sum)) => *sum += ms,
        None => times.push((stage, ms)),
    }
}

fn encoder(gpu: &Gpu) -> wgpu::CommandEncoder {
    gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("frame") })
}
