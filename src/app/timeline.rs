//! The window's clock: plays, pauses, scrubs. The frame itself knows no clock; time is given to it.

/// Longest time that one frame may advance, seconds: a stall does not make the picture jump.
const LONGEST_STEP_SECS: f64 = 0.25;
/// A step by key, seconds.
pub const KEY_STEP_SECS: f64 = 1.0 / 30.0;

/// Time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Timeline {
    /// Now, seconds; may run past the duration, since clips of different lengths loop each on their own.
    pub time_secs: f64,
    /// Whether it advances.
    pub playing: bool,
    /// Seconds after which the longest clip repeats; 0 where nothing moves.
    pub duration_secs: f64,
}

impl Timeline {
    /// True where time changes the picture.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.duration_secs > 0.0
    }

    /// True while the picture changes by itself.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.playing && self.moves()
    }

    /// Advances by what the wall clock did, while it plays.
    pub fn advance(&mut self, elapsed_secs: f64) {
        if self.is_running() {
            self.time_secs += elapsed_secs.clamp(0.0, LONGEST_STEP_SECS);
        }
    }

    /// Pauses and moves by `secs`; not before the start.
    pub fn step(&mut self, secs: f64) {
        self.playing = false;
        self.time_secs = (self.time_secs + secs).max(0.0);
    }

    /// Where the slider stands: seconds within the duration.
    #[must_use]
    pub fn phase_secs(&self) -> f64 {
        if self.moves() { self.time_secs.rem_euclid(self.duration_secs) } else { 0.0 }
    }
}
