//! `murrine bench --cutoffs`: what marking takes with `hybrid`, by cut-off.
//!
//! Source: [`crate::papers::RAUWENDAAL_BAILEY_2013`], Figs. 13 and 14.

use super::{BenchError, Spread};
use crate::compose::DebugView;
use crate::frame::{Frame, Request};
use crate::gpu::{Gpu, Timing};
use crate::march::Channel;
use crate::scene::{Scene, World};
use glam::UVec2;
use serde::Serialize;
use std::fmt::Write as _;

/// Octaves of cut-off between all triangles by fragments and all by threads.
const OCTAVES: std::ops::RangeInclusive<i8> = -3..=16;

/// Frames before the timed ones.
const WARM_UP: u32 = 2;

/// A scene's times by cut-off.
#[derive(Debug, Clone, Serialize)]
pub struct Sweep {
    /// The scene.
    pub name: String,
    /// Its triangles.
    pub triangles: usize,
    /// In rising order, from 0, where all triangles are large, to where none is.
    pub points: Vec<CutoffTime>,
    /// What `cutoff_cells2 = "auto"` takes, in words.
    pub auto: String,
}

/// What marking every grid of a frame took with a cut-off.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct CutoffTime {
    /// Voxels², or the unit of the scene's `size_measure`; none for `"auto"`.
    pub cutoff_cells2: Option<f32>,
    /// Milliseconds.
    pub ms: Spread,
}

/// The cut-offs of a sweep.
#[must_use]
pub fn cutoffs() -> Vec<f32> {
    let octaves = OCTAVES.map(|octave| f32::from(octave).exp2());
    [0.0].into_iter().chain(octaves).chain([f32::MAX]).collect()
}

/// Times a scene's marking with each cut-off and with `"auto"`; they take turns, frame by frame.
///
/// # Errors
/// When the device is lost or refuses a buffer.
pub fn sweep(gpu: &Gpu, name: &str, scene: &Scene, world: &World, iterations: u32) -> Result<Sweep, BenchError> {
    let mut scene = scene.clone();
    "hybrid".clone_into(&mut scene.voxelizer.method);
    let settings: Vec<Option<f32>> = cutoffs().into_iter().map(Some).chain([None]).collect();
    let mut samples = vec![Vec::new(); settings.len()];
    let mut frame = Frame::new(gpu)?;
    let mut auto = String::new();
    for iteration in 0..WARM_UP + iterations.max(3) {
        for (samples, cutoff_cells2) in samples.iter_mut().zip(&settings) {
            scene.voxelizer.cutoff_cells2 = *cutoff_cells2;
            frame.forget();
            let request = Request {
                scene: &scene,
                world,
                time_secs: f64::from(iteration) * super::STEP_SECS,
                size: UVec2::ONE,
                picture_size: UVec2::ONE,
                channel: Channel::Beauty,
                view: DebugView::None,
                timing: Timing::Submit,
            };
            let times = frame.render(gpu, &request)?;
            frame.settle(gpu)?;
            if let Some((_, ms)) = times.iter().find(|(stage, _)| *stage == "voxelize" && iteration >= WARM_UP) {
                samples.push(*ms);
            }
        }
        auto = frame.cutoff().map_or_else(String::new, |cutoff| cutoff.to_string());
    }
    let point =
        |(samples, cutoff): (&Vec<f64>, &Option<f32>)| CutoffTime { cutoff_cells2: *cutoff, ms: Spread::of(samples) };
    let triangles = world.models.iter().map(|model| model.triangles.len()).sum();
    Ok(Sweep { name: name.to_owned(), triangles, points: samples.iter().zip(&settings).map(point).collect(), auto })
}

/// Sweeps as a table.
#[must_use]
pub fn table(sweeps: &[Sweep]) -> String {
    let mut text = "milliseconds of marking by cut-off: median (min–max)\n".to_owned();
    for Sweep { name, triangles, points, auto } in sweeps {
        // Writing to a string can't fail.
        let _ = writeln!(text, "\n{name}, {triangles} triangles");
        for CutoffTime { cutoff_cells2, ms: Spread { min, median, max } } in points {
            let cutoff = match cutoff_cells2 {
                None => "auto".to_owned(),
                Some(0.0) => "all large".to_owned(),
                Some(cells2) if *cells2 == f32::MAX => "all small".to_owned(),
                Some(cells2) => cells2.to_string(),
            };
            let _ = writeln!(text, "  {cutoff:>12} {median:8.2} ({min:.2}–{max:.2})");
        }
        let _ = writeln!(text, "  auto: {auto}");
    }
    text
}
