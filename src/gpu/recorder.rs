//! Records the stages of a frame and, when asked, times them.

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
}

impl<'g> Recorder<'g> {
    /// Starts recording.
    #[must_use]
    pub fn new(gpu: &'g Gpu, timing: Timing) -> Self {
        Self { gpu, encoder: encoder(gpu), timing, stage: None, started: Instant::now(), times: Vec::new() }
    }

    /// Begins the stage `name`; the one before it ends.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn stage(&mut self, name: &'static str) -> Result<(), GpuError> {
        self.end_stage()?;
        self.stage = Some(name);
        Ok(())
    }

    /// Ends the last stage and submits. Stages of one name are summed.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn finish(mut self) -> Result<StageTimes, GpuError> {
        self.end_stage()?;
        self.gpu.queue.submit([self.encoder.finish()]);
        Ok(self.times)
    }

    fn end_stage(&mut self) -> Result<(), GpuError> {
        if self.timing == Timing::Submit {
            let done = std::mem::replace(&mut self.encoder, encoder(self.gpu));
            self.gpu.queue.submit([done.finish()]);
            self.gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| GpuError::Lost(e.to_string()))?;
            let ms = self.started.elapsed().as_secs_f64() * 1e3;
            if let Some(stage) = self.stage {
                match self.times.iter_mut().find(|(name, _)| *name == stage) {
                    Some((_, sum)) => *sum += ms,
                    None => self.times.push((stage, ms)),
                }
            }
        }
        self.started = Instant::now();
        self.stage = None;
        Ok(())
    }
}

fn encoder(gpu: &Gpu) -> wgpu::CommandEncoder {
    gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("frame") })
}
