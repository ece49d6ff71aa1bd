//! A grid cut into slabs along z, each a grid of its own whose words fit in one binding.
//!
//! Source: [`papers::CHANG_LAI_2011`], §5, which asks for it where a volume does not fit the device. A slab holds one more
//! slice at either cut, so that what looks at a cell's neighbours sees them; only the slices between are kept. Methods see
//! every triangle, those before a slab too, so parity needs nothing handed on from slab to slab.
//!
//! [`papers::CHANG_LAI_2011`]: crate::papers::CHANG_LAI_2011

use super::{Grid, ORTHOGRAPHIC};
use std::ops::Range;

/// Slices beyond a cut.
const HALO: u32 = 1;

/// Slices of a word.
const WORD_SLICES: u32 = 32;

/// Some slices of a grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Slab {
    /// A grid of these slices and those at the cuts.
    pub grid: Grid,
    /// Which slices of the whole grid are kept.
    pub slices: Range<u32>,
    /// Slices of `grid` before the first that is kept.
    pub skipped: u32,
}

impl Slab {
    /// The kept slices one by one from the slab's own words: a byte a cell, 1 where its bit is set, \[y\]\[x\].
    pub fn cell_bytes<W: AsRef<[u32]>>(&self, words: W) -> impl Iterator<Item = Vec<u8>> + use<W> {
        let per_column = self.grid.words_per_column as usize;
        let mut layer = (usize::MAX, Vec::new());
        (self.skipped..self.skipped + self.slices.end - self.slices.start).map(move |z| {
            // The words of a layer lie together while its slices are read.
            let word = (z / WORD_SLICES) as usize;
            if layer.0 != word {
                layer = (word, words.as_ref().iter().skip(word).step_by(per_column).copied().collect());
            }
            layer.1.iter().map(|bits: &u32| (bits >> (z % WORD_SLICES) & 1) as u8).collect()
        })
    }
}

impl Grid {
    /// Slabs of at most `most_bytes` bytes of words that make up the grid, an orthographic one, in order; nothing if even
    /// the thinnest is larger.
    #[must_use]
    pub fn slabs(&self, most_bytes: u64) -> Option<Vec<Slab>> {
        debug_assert_eq!(self.projection, ORTHOGRAPHIC, "slices of a perspective grid are not alike");
        let layer_bytes = u64::from(self.cells.x) * u64::from(self.cells.y) * 4;
        let words = u32::try_from(most_bytes / layer_bytes.max(1)).unwrap_or(u32::MAX);
        if words >= self.words_per_column {
            return Some(vec![Slab { grid: *self, slices: 0..self.cells.z, skipped: 0 }]);
        }
        let most = (words * WORD_SLICES).checked_sub(2 * HALO)?;
        let kept = self.cells.z.div_ceil(self.cells.z.div_ceil(most)); // all about as thick
        let slab = |first: u32| {
            let slices = first..self.cells.z.min(first + kept);
            let begin = slices.start.saturating_sub(HALO);
            let grid = self.of_slices(begin..self.cells.z.min(slices.end + HALO));
            Slab { grid, skipped: slices.start - begin, slices }
        };
        Some((0..self.cells.z).step_by(kept as usize).map(slab).collect())
    }

    /// The grid of some slices of this one, an orthographic one. Columns are the same to the last bit.
    fn of_slices(&self, slices: Range<u32>) -> Self {
        let cells = self.cells.with_z(slices.end - slices.start);
        let mut grid = Self { cells, words_per_column: cells.z.div_ceil(WORD_SLICES), ..*self };
        let first = slices.start as f32;
        grid.grid_from_world.w_axis.z -= first;
        grid.world_from_grid.w_axis += self.world_from_grid.z_axis * first;
        grid
    }
}
