//! How much of a sharp picture the device is given at once, so that no input waits for the whole of it.

use glam::UVec2;

/// A part should take this long, milliseconds. It is what an input may have to wait for.
pub const PART_MS: f64 = 40.0;
/// No picture has more parts than about this many: each costs some milliseconds of its own.
const MOST_PARTS: u32 = 32;
/// Rows of the first part where nothing is known yet.
const FIRST_ROWS: u32 = 64;

/// The parts of one picture.
#[derive(Debug, Clone, Copy)]
pub struct Parts {
    rows: u32,
    least_rows: u32,
    most_rows: u32,
    spent_ms: f64,
}

impl Parts {
    /// One part, for a picture that is wanted at once.
    #[must_use]
    pub fn whole() -> Self {
        Self { rows: u32::MAX, least_rows: u32::MAX, most_rows: u32::MAX, spent_ms: 0.0 }
    }

    /// The parts of a picture of this size that is expected to take so long; 0 where that is not known.
    #[must_use]
    pub fn of(size: UVec2, expected_ms: f64) -> Self {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative, and smaller")]
        let (rows, most_rows) = match expected_ms {
            0.0 => (FIRST_ROWS, u32::MAX),
            ms if ms <= PART_MS => (u32::MAX, u32::MAX),
            ms => {
                // The first part has more to do than to march. Above the glass rows cost little: what comes next costs
                // more, so that no part has more rows than fit on the average.
                let average = (f64::from(size.y) * PART_MS / ms) as u32;
                (average / 2, average)
            }
        };
        let least_rows = size.y.div_ceil(MOST_PARTS);
        Self { rows: rows.max(least_rows), least_rows, most_rows: most_rows.max(least_rows), spent_ms: 0.0 }
    }

    /// Rows of the next part, at most.
    #[must_use]
    pub fn rows(&self) -> u32 {
        self.rows
    }

    /// Takes in how long the last part took; the next has more rows or fewer.
    pub fn measured(&mut self, ms: f64) {
        self.spent_ms += ms;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a cast saturates")]
        let rows = (f64::from(self.rows) * (PART_MS / ms).clamp(0.1, 2.0)) as u32;
        self.rows = rows.clamp(self.least_rows, self.most_rows);
    }

    /// What all parts together took, milliseconds.
    #[must_use]
    pub fn spent_ms(&self) -> f64 {
        self.spent_ms
    }
}
