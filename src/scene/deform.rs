//! The procedural deformers at a time: what the shader of `animate` does to a point, and how far it can carry one.

use super::description::{Bounds, Deformer};
use glam::{DMat3, DVec3};
use std::f64::consts::TAU;

/// A [`Deformer`] at one time, in the model's rest space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Deformation {
    /// Turns a point p about an axis, right-handed, by `rad_per_unit`·p\[axis\].
    Twist {
        /// 0 = x, 1 = y, 2 = z.
        axis: usize,
        /// Radians for each unit along the axis, at this time.
        rad_per_unit: f64,
    },
    /// Adds amplitude·sin(2π(p\[axis\]·`per_unit` − `phase_turns`)) to p\[along\].
    Wave {
        /// The axis that the wave runs along.
        axis: usize,
        /// The axis that points move along.
        along: usize,
        /// Units.
        amplitude: f64,
        /// Waves a unit: 1/wavelength.
        per_unit: f64,
        /// 0 to 1.
        phase_turns: f64,
    },
}

impl Deformer {
    /// The deformer at a time. A wavelength of 0 makes a wave that does nothing.
    #[must_use]
    pub fn at(&self, time_secs: f64) -> Deformation {
        match *self {
            Self::Twist { axis, deg_per_unit, hz } => {
                // The phase is taken modulo one before the sine, so that long times stay exact.
                let swing = if hz == 0.0 { 1.0 } else { (TAU * (f64::from(hz) * time_secs).rem_euclid(1.0)).sin() };
                Deformation::Twist {
                    axis: axis.min(2) as usize,
                    rad_per_unit: f64::from(deg_per_unit).to_radians() * swing,
                }
            }
            Self::Wave { axis, along, amplitude, wavelength, hz } => Deformation::Wave {
                axis: axis.min(2) as usize,
                along: along.min(2) as usize,
                amplitude: if wavelength == 0.0 { 0.0 } else { f64::from(amplitude) },
                per_unit: if wavelength == 0.0 { 0.0 } else { 1.0 / f64::from(wavelength) },
                phase_turns: (f64::from(hz) * time_secs).rem_euclid(1.0),
            },
        }
    }
}

impl Deformation {
    /// Where a point goes, and the Jacobian there (normals go with its inverse transpose).
    #[must_use]
    pub fn apply(&self, p: DVec3) -> (DVec3, DMat3) {
        match *self {
            Self::Twist { axis, rad_per_unit } => {
                let (second, third) = ((axis + 1) % 3, (axis + 2) % 3);
                let (sin, cos) = (rad_per_unit * p[axis]).sin_cos();
                let mut moved = p;
                moved[second] = cos * p[second] - sin * p[third];
                moved[third] = sin * p[second] + cos * p[third];
                let mut columns = [[0.0; 3]; 3];
                columns[axis][axis] = 1.0;
                columns[axis][second] = -rad_per_unit * moved[third];
                columns[axis][third] = rad_per_unit * moved[second];
                columns[second][second] = cos;
                columns[second][third] = sin;
                columns[third][second] = -sin;
                columns[third][third] = cos;
                (moved, DMat3::from_cols_array_2d(&columns))
            }
            Self::Wave { axis, along, amplitude, per_unit, phase_turns } => {
                let (sin, cos) = (TAU * (p[axis] * per_unit - phase_turns)).sin_cos();
                let mut moved = p;
                moved[along] += amplitude * sin;
                let mut columns = DMat3::IDENTITY.to_cols_array_2d();
                columns[axis][along] += amplitude * cos * TAU * per_unit;
                (moved, DMat3::from_cols_array_2d(&columns))
            }
        }
    }

    /// A box that contains all that the deformer makes of a box.
    #[must_use]
    pub fn bounds(&self, bounds: Bounds) -> Bounds {
        if bounds.is_empty() {
            return bounds;
        }
        let Bounds { mut min, mut max } = bounds;
        match *self {
            Self::Twist { axis, rad_per_unit } => {
                let (second, third) = ((axis + 1) % 3, (axis + 2) % 3);
                let [a, b] = [rad_per_unit * min[axis], rad_per_unit * max[axis]];
                let (from, to) = (a.min(b), a.max(b));
                let corners = [[min, min], [max, min], [max, max], [min, max]].map(|[s, t]| (s[second], t[third]));
                // The furthest that a corner's arc comes along the direction at `towards`: r·max cos over its angles.
                let reach = |towards: f64| {
                    corners
                        .iter()
                        .map(|&(s, t)| {
                            s.hypot(t) * greatest_cosine(t.atan2(s) + from - towards, t.atan2(s) + to - towards)
                        })
                        .fold(f64::NEG_INFINITY, f64::max)
                };
                max[second] = reach(0.0);
                max[third] = reach(TAU * 0.25);
                min[second] = -reach(TAU * 0.5);
                min[third] = -reach(TAU * 0.75);
            }
            Self::Wave { along, amplitude, .. } => {
                min[along] -= amplitude.abs();
                max[along] += amplitude.abs();
            }
        }
        Bounds { min, max }
    }
}

/// The greatest cosine of the angles from `from` to `to`.
fn greatest_cosine(from: f64, to: f64) -> f64 {
    let next_top = (from / TAU).ceil() * TAU;
    if next_top <= to { 1.0 } else { from.cos().max(to.cos()) }
}
