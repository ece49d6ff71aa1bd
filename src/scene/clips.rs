//! Animation clips: keys of nodes' transforms and morph weights over time.

/// A named clip.
#[derive(Debug, Clone, Default)]
pub struct Clip {
    /// Its name; unnamed clips are numbered.
    pub name: String,
    /// Time of the last key, seconds. Looped over this length.
    pub duration_secs: f32,
    /// What it moves.
    pub channels: Vec<Channel>,
}

/// One animated property.
#[derive(Debug, Clone)]
pub struct Channel {
    /// The node.
    pub node: u32,
    /// Which property.
    pub property: Property,
    /// Between keys.
    pub interpolation: Interpolation,
    /// Key times, seconds, ascending.
    pub times_secs: Vec<f32>,
    /// Values: 3, 4 or the number of targets a key; cubic splines have three such groups a key (in-tangent, value,
    /// out-tangent).
    pub values: Vec<f32>,
}

/// What a channel moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Property {
    /// 3 values a key.
    Translation,
    /// 4 values a key, a quaternion.
    Rotation,
    /// 3 values a key.
    Scale,
    /// As many values a key as the mesh has targets.
    Weights,
}

/// How values between keys are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// The earlier key's.
    Step,
    /// Straight, or along the shorter arc.
    Linear,
    /// Hermite; tangents scale with the segment's length.
    CubicSpline,
}

impl Clip {
    /// The time within the clip, looped; a clip without length stands at 0.
    #[must_use]
    pub fn local_time_secs(&self, time_secs: f64) -> f64 {
        let duration = f64::from(self.duration_secs);
        if duration > 0.0 { time_secs.rem_euclid(duration) } else { 0.0 }
    }
}

impl Channel {
    /// Values a key: 3, 4 or the number of targets.
    #[must_use]
    pub fn width(&self) -> usize {
        let groups = if self.interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        self.values.len().checked_div(self.times_secs.len() * groups).unwrap_or(0)
    }

    /// The value at a time of the clip, clamped outside the keys; rotations come out as unit quaternions.
    ///
    /// Empty when the channel has no keys.
    #[must_use]
    pub fn sample(&self, time_secs: f64) -> Vec<f64> {
        let width = self.width();
        let keys = self.times_secs.len();
        if keys == 0 || width == 0 {
            return Vec::new();
        }
        let time = |key: usize| f64::from(self.times_secs[key]);
        let cubic = self.interpolation == Interpolation::CubicSpline;
        // Cubic splines: group 0 is the in-tangent, 1 the value, 2 the out-tangent.
        let group = |key: usize, group: usize| {
            let first = if cubic { (key * 3 + group) * width } else { key * width };
            self.values[first..first + width].iter().map(|&v| f64::from(v))
        };
        let next = self.times_secs.partition_point(|&t| f64::from(t) <= time_secs);
        let mut value: Vec<f64> = if next == 0 {
            group(0, 1).collect()
        } else if next == keys || self.interpolation == Interpolation::Step {
            group(next - 1, 1).collect()
        } else {
            let key = next - 1;
            let length = time(next) - time(key);
            let t = (time_secs - time(key)) / length;
            match self.interpolation {
                Interpolation::CubicSpline => {
                    let (t2, t3) = (t * t, t * t * t);
                    let points = group(key, 1).zip(group(next, 1));
                    let tangents = group(key, 2).zip(group(next, 0));
                    points
                        .zip(tangents)
                        .map(|((p0, p1), (out0, in1))| {
                            (2.0 * t3 - 3.0 * t2 + 1.0) * p0
                                + length * (t3 - 2.0 * t2 + t) * out0
                                + (3.0 * t2 - 2.0 * t3) * p1
                                + length * (t3 - t2) * in1
                        })
                        .collect()
                }
                _ if self.property == Property::Rotation => slerp(group(key, 1).collect(), group(next, 1).collect(), t),
                _ => group(key, 1).zip(group(next, 1)).map(|(a, b)| a + (b - a) * t).collect(),
            }
        };
        if self.property == Property::Rotation {
            let length = value.iter().map(|v| v * v).sum::<f64>().sqrt();
            if length > 1e-12 {
                value.iter_mut().for_each(|v| *v /= length);
            } else {
                value = vec![0.0, 0.0, 0.0, 1.0];
            }
        }
        value
    }
}

/// Along the shorter arc between two quaternions (x, y, z, w).
fn slerp(a: Vec<f64>, b: Vec<f64>, t: f64) -> Vec<f64> {
    let dot: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
    let sign = if dot < 0.0 { -1.0 } else { 1.0 };
    let angle = dot.abs().min(1.0).acos();
    let (wa, wb) = if angle < 1e-6 {
        (1.0 - t, t)
    } else {
        (((1.0 - t) * angle).sin() / angle.sin(), (t * angle).sin() / angle.sin())
    };
    a.into_iter().zip(b).map(|(a, b)| wa * a + wb * sign * b).collect()
}
