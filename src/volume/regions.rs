//! Which words and records of the shared buffers belong to which grid.

use super::{CHUNK, GridCounters, LIGHT_RECORD_BYTES, Record, SLOTS};
use crate::grid::Grid;
use glam::UVec3;

/// A further sheet's number has 20 bits in a record.
const MAX_EXTRAS: u32 = 1 << 20;
/// Room is given in whole blocks of so many words or records.
const BLOCK: u32 = 1024;
/// Fits in a row that must find a region more than [`ROOMY`] times too large before it shrinks.
const PATIENCE: u32 = 120;
/// How many times larger than needed a region may stay.
const ROOMY: u64 = 3;

/// One grid's region.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Region {
    /// First word.
    pub(super) word_base: u32,
    /// Words.
    pub(super) word_capacity: u32,
    /// First record.
    pub(super) record_base: u32,
    /// Records of voxels.
    pub(super) record_capacity: u32,
    /// First record of further sheets.
    pub(super) extra_base: u32,
    /// Records of further sheets.
    pub(super) extra_capacity: u32,
}

/// Bytes of the buffers that hold all regions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sizes {
    /// Of `occupancy`, of `ranks` and of `interior`.
    pub(super) words: u64,
    pub(super) records: u64,
    pub(super) keys: u64,
    pub(super) chunk_sums: u64,
    pub(super) light_records: u64,
}

impl Sizes {
    /// Each buffer and its size.
    pub(super) fn named(&self) -> [(&'static str, u64); 7] {
        [
            ("occupancy", self.words),
            ("ranks", self.words),
            ("interior", self.words),
            ("records", self.records),
            ("keys", self.keys),
            ("chunk_sums", self.chunk_sums),
            ("light_records", self.light_records),
        ]
    }
}

/// All grids' regions.
#[derive(Debug, Clone, Default)]
pub(super) struct Regions {
    /// One a grid.
    pub(super) of_grids: Vec<Region>,
    /// Counts the layouts: another one means new buffers.
    pub(super) generation: u64,
    roomy_fits: u32,
}

impl Region {
    /// True if everything counted has a place.
    pub(super) fn holds(&self, counted: &GridCounters) -> bool {
        counted.occupied <= self.record_capacity && counted.extras.min(MAX_EXTRAS) <= self.extra_capacity
    }

    /// What was counted, and what would have been if every voxel had had a record: sheets are counted in records.
    fn whole(&self, counted: &GridCounters) -> GridCounters {
        let of_records = counted.occupied.min(self.record_capacity).max(1);
        let extras = u64::from(counted.extras) * u64::from(counted.occupied.max(1)) / u64::from(of_records);
        GridCounters { extras: u32::try_from(extras).unwrap_or(u32::MAX), ..*counted }
    }

    /// Bytes of words, ranks, interior, records and light records.
    pub(super) fn bytes(&self) -> u64 {
        let records = u64::from(self.record_capacity) + u64::from(self.extra_capacity);
        u64::from(self.word_capacity) * 12 + records * (size_of::<Record>() as u64 + LIGHT_RECORD_BYTES)
    }
}

impl Regions {
    /// Keeps the layout while it has room for `grids` and for what was counted in them, else makes another. Returns
    /// for each grid whether its region is new. No estimate passes what fits in `binding_bytes`.
    pub(super) fn fit(&mut self, grids: &[Grid], counts: &[GridCounters], binding_bytes: u64) -> Vec<bool> {
        let counted = |i: usize| counts.get(i).filter(|_| counts.len() >= grids.len());
        let whole = |i: usize| counted(i).map(|c| self.of_grids.get(i).map_or(*c, |have| have.whole(c)));
        let needs: Vec<Region> =
            grids.iter().enumerate().map(|(i, grid)| need(grid, whole(i), binding_bytes)).collect();
        let same_number = self.of_grids.len() == needs.len();
        let holds = same_number
            && self.of_grids.iter().zip(&needs).enumerate().all(|(i, (have, need))| {
                have.word_capacity >= need.word_capacity && counted(i).is_none_or(|c| have.holds(c))
            });
        let bytes = |regions: &[Region]| regions.iter().map(|r| r.bytes()).sum::<u64>();
        let roomy = same_number && bytes(&self.of_grids) > ROOMY * bytes(&needs);
        self.roomy_fits = if roomy { self.roomy_fits + 1 } else { 0 };
        let shrinks = self.roomy_fits >= PATIENCE;
        if holds && !shrinks {
            return vec![false; grids.len()];
        }
        let keeps = same_number && !shrinks;
        let mut next = Region::default();
        let mut of_grids = Vec::with_capacity(needs.len());
        for (i, need) in needs.iter().enumerate() {
            let old = if keeps { self.of_grids[i] } else { Region::default() };
            next.word_capacity = old.word_capacity;
            if need.word_capacity > old.word_capacity {
                // A grid that has grown once, with its body, will do so again.
                let spare = if keeps { need.word_capacity / 4 } else { 0 };
                next.word_capacity = blocks(u64::from(need.word_capacity) + u64::from(spare));
            }
            next.record_capacity = need.record_capacity.max(old.record_capacity);
            next.extra_capacity = need.extra_capacity.max(old.extra_capacity);
            next.extra_base = next.record_base.saturating_add(next.record_capacity);
            of_grids.push(next);
            next.word_base = next.word_base.saturating_add(next.word_capacity);
            next.record_base = next.extra_base.saturating_add(next.extra_capacity);
        }
        *self = Self { of_grids, generation: self.generation + 1, roomy_fits: 0 };
        vec![true; grids.len()]
    }

    /// No layout: the next fit makes another.
    pub(super) fn forget(&mut self) {
        self.of_grids.clear();
    }

    /// Bytes that all regions take.
    pub(super) fn sizes(&self) -> Sizes {
        let sum = |of: fn(&Region) -> u64| self.of_grids.iter().map(of).sum::<u64>();
        let most = |of: fn(&Region) -> u64| self.of_grids.iter().map(of).max().unwrap_or(0);
        let records = sum(|r| u64::from(r.record_capacity) + u64::from(r.extra_capacity));
        let most_records = most(|r| r.record_capacity.into());
        Sizes {
            words: sum(|r| r.word_capacity.into()) * 4,
            records: records * size_of::<Record>() as u64,
            keys: most_records * KEY_BYTES,
            chunk_sums: most(|r| r.word_capacity.into()).max(most_records).div_ceil(CHUNK.into()) * 4,
            light_records: records * LIGHT_RECORD_BYTES,
        }
    }
}

/// Bytes of the keys of a voxel that has a record.
const KEY_BYTES: u64 = SLOTS * 4;

/// Room that a grid needs, with some to spare; bases are not set.
fn need(grid: &Grid, counted: Option<GridCounters>, binding_bytes: u64) -> Region {
    let UVec3 { x, y, z } = grid.cells;
    let all_cells = u64::from(x) * u64::from(y) * u64::from(z);
    // A ball touches 1.5 times its area in cells, three quarters of its box's area.
    let estimate = 2 * (u64::from(x) * u64::from(y) + u64::from(y) * u64::from(z) + u64::from(z) * u64::from(x));
    // What is counted is truly needed, an estimate may be too high: no grid is refused for one.
    let most = (binding_bytes / KEY_BYTES).saturating_sub(BLOCK.into());
    let records =
        counted.map_or(estimate.min(most), |c| u64::from(c.occupied) + u64::from(c.occupied) / 4).min(all_cells);
    let extras = counted.map_or(estimate / 4, |c| u64::from(c.extras) + u64::from(c.extras) / 4);
    Region {
        word_capacity: blocks(u64::from(grid.word_count())),
        record_capacity: blocks(records),
        extra_capacity: blocks(extras).min(MAX_EXTRAS),
        ..Region::default()
    }
}

/// At least `count`, in whole blocks; what passes 32 bits is refused when the buffer is made.
fn blocks(count: u64) -> u32 {
    u32::try_from(count.next_multiple_of(BLOCK.into())).unwrap_or(u32::MAX)
}
