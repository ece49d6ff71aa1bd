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
