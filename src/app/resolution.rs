//! Chooses the internal resolution while things move, between what is sharp and what is smooth.
//!
//! Up to [`GOOD_SCALE`] of the full side sharpness counts more: a frame may take [`SLOWEST_MS`]. Beyond it smoothness
//! does: a finer picture must keep within [`SMOOTH_MS`]. So a fast device shows every pixel at 25 frames a second and
//! more, and a slow one some nine good pictures a second rather than twenty bad ones.
//!
//! A frame's time is taken as `fixed + per_pixel · pixels`: animating and voxelizing don't depend on the picture's
//! size, so that a naive ratio would shrink the picture in vain. Both are estimated from the frames measured, the older
//! the less. The side is a quantised fraction of the full one; it falls at once and rises after a calm while.

use glam::UVec2;

/// The longest that a frame should take, milliseconds; with what painting takes, eight to ten frames a second.
pub const SLOWEST_MS: f64 = 95.0;
/// A frame that takes no longer moves smoothly, milliseconds.
pub const SMOOTH_MS: f64 = 40.0;
/// Fraction of the full side from which a moving picture is good enough for smoothness to count more.
pub const GOOD_SCALE: f32 = 0.5;
/// Fractions of the full side, coarse to fine, each with about √2 times the pixels of the one before.
pub const STEPS: &[f32] = &[0.15, 0.18, 0.21, 0.25, 0.30, 0.35, 0.42, 0.50, 0.59, 0.71, 0.84, 1.0];
/// No picture is smaller than this on its longer side, unless the full one is.
const FEWEST_PIXELS: u32 = 224;
/// How much of an older frame's weight is left when a new one comes.
const FORGET: f64 = 0.85;
/// Longer than this many times what is allowed: the picture shrinks at once.
const TOO_LONG: f64 = 1.15;
/// A step finer would be shorter than this many times what is allowed, for [`CALM_FRAMES`]: it grows by that step.
const SHORT: f64 = 0.9;
/// Frames in a row that must be short.
const CALM_FRAMES: u32 = 4;
/// The pixels of a picture that is not good yet may take this share of what its other work takes, however long that is:
/// less would cost much sharpness and gain little time.
const PIXEL_SHARE: f64 = 0.6;
/// The share of a frame's time laid to its pixels until frames of two sizes have been measured.
const FIRST_SHARE: f64 = 0.6;
/// The least share that is believed, whatever the estimate says: a scene that changes while the size does misleads it.
const LEAST_SHARE: f64 = 0.2;

/// The controller.
#[derive(Debug, Clone)]
pub struct Resolution {
    step: usize,
    calm: u32,
    per_pixel_ms: Option<f64>,
    // Sums over the frames measured, with falling weights: 1, x, y, x², xy for x = pixels, y = milliseconds.
    sums: [f64; 5],
}

impl Default for Resolution {
    /// Starts at a good size.
    fn default() -> Self {
        let step = STEPS.iter().position(|s| *s >= GOOD_SCALE).unwrap_or(0);
        Self { step, calm: 0, per_pixel_ms: None, sums: [0.0; 5] }
    }
}

impl Resolution {
    /// Fraction of the full side that moving pictures have now.
    #[must_use]
    pub fn scale(&self) -> f32 {
        STEPS[self.step]
    }

    /// Size of a moving picture of this full size.
    #[must_use]
    pub fn moving_size(&self, full: UVec2) -> UVec2 {
        size_at(full, self.step)
    }

    /// What marching `size` pixels is expected to take, milliseconds; 0 before the first frame is measured.
    #[must_use]
    pub fn march_ms(&self, size: UVec2) -> f64 {
        self.line().1 * pixels(size)
    }

    /// Takes in a moving frame of `size` that took `ms`, out of a `full` size, and chooses the next one's.
    pub fn measured(&mut self, full: UVec2, size: UVec2, ms: f64) {
        if !ms.is_finite() || ms < 0.0 || pixels(full) < 1.0 {
            return;
        }
        let x = pixels(size);
        for (sum, term) in self.sums.iter_mut().zip([1.0, x, ms, x * x, x * ms]) {
            *sum = *sum * FORGET + term;
        }
        let [n, sx, sy, sxx, sxy] = self.sums;
        let variance = n * sxx - sx * sx;
        if variance > 1e-3 * sx * sx {
            self.per_pixel_ms = Some((n * sxy - sx * sy) / variance);
        }
        self.choose(full);
    }

    fn choose(&mut self, full: UVec2) {
        let (fixed, per_pixel) = self.line();
        // Time over what is allowed, of a picture of this step.
        let excess = |step: usize| {
            let cost = per_pixel * pixels(size_at(full, step));
            let smooth = STEPS[step] > GOOD_SCALE;
            let allowed = if smooth { SMOOTH_MS } else { SLOWEST_MS.max(fixed * (1.0 + PIXEL_SHARE)) };
            (fixed + cost) / allowed
        };
        if excess(self.step) > TOO_LONG {
            self.step = (0..self.step).rev().find(|s| excess(*s) <= 1.0).unwrap_or(0);
            self.calm = 0;
        } else if self.step + 1 < STEPS.len() && excess(self.step + 1) < SHORT {
            self.calm += 1;
            if self.calm >= CALM_FRAMES {
                self.step += 1;
                self.calm = 0;
            }
        } else {
            self.calm = 0;
        }
    }

    /// Fixed milliseconds, and milliseconds a pixel.
    fn line(&self) -> (f64, f64) {
        let [n, sx, sy, ..] = self.sums;
        if n == 0.0 || sx == 0.0 {
            return (0.0, 0.0);
        }
        let whole = sy / sx;
        let per_pixel = self.per_pixel_ms.unwrap_or(FIRST_SHARE * whole).clamp(LEAST_SHARE * whole, whole);
        ((sy - per_pixel * sx) / n, per_pixel)
    }
}

/// Size of a picture at one of the [`STEPS`]; never smaller than a pixel, nor than a usable picture unless `full` is.
fn size_at(full: UVec2, step: usize) -> UVec2 {
    let longest = full.max_element().max(1);
    #[expect(clippy::cast_precision_loss, reason = "sizes of pictures are small")]
    let floor = FEWEST_PIXELS.min(longest) as f32 / longest as f32;
    let scale = STEPS[step].max(floor);
    (full.as_vec2() * scale).round().as_uvec2().max(UVec2::ONE).min(full.max(UVec2::ONE))
}

fn pixels(size: UVec2) -> f64 {
    f64::from(size.x) * f64::from(size.y)
}
