//! Where `hybrid` draws its line between small and large when it is left to itself (`cutoff_cells2 = "auto"`).
//!
//! Source: [`crate::papers::RAUWENDAAL_BAILEY_2013`], §3.4.1, which suggests a bracketing search over measured times.
//!
//! Every cut-off gives the same voxels, so only time hangs on it. Three ways, the later the better it knows: the device's
//! own constant; the least of a fixed model of costs over the sizes of the scene's triangles, which needs no clock; and,
//! where the device's timestamps are true, a search over measured times that starts there, settles and then stays. It
//! begins anew only when the triangles or the grid's resolution are others.

use std::collections::BTreeMap;

/// A cut-off in use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cutoff {
    /// Cells², or the unit of `size_measure` where the scene gives it.
    pub cells2: f32,
    /// Where it comes from.
    pub from: CutoffFrom,
}

/// Where a cut-off comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CutoffFrom {
    /// The scene gives it.
    Scene,
    /// The device's own.
    Device,
    /// The least of the model of costs over the triangles' sizes.
    Sizes,
    /// A search over measured times is under way.
    Search,
    /// That search has settled.
    Times,
}

impl std::fmt::Display for Cutoff {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let from = match self.from {
            CutoffFrom::Scene => "as the scene says",
            CutoffFrom::Device => "this kind of device's",
            CutoffFrom::Sizes => "by the triangles' sizes",
            CutoffFrom::Search => "searching by measured times",
            CutoffFrom::Times => "by measured times, settled",
        };
        write!(f, "cut-off {} voxels²: {from}", self.cells2)
    }
}

/// Octaves of area that sizes are counted in, `OCTAVES` in the shader, and the first one, `LEAST_OCTAVE`.
pub(super) const OCTAVES: usize = 24;
const LEAST_OCTAVE: i32 = -2;
/// Where all that is counted is small.
const LAST_OCTAVE: i32 = 22;

/// Milliseconds that a kind of device takes, as measured: `t` stands for threads, `f` for fragments.
#[derive(Debug, Clone, Copy)]
pub(super) struct Costs {
    /// Cut-off where nothing is known of the triangles, cells².
    pub(super) cutoff_cells2: f64,
    /// Threads that run at once.
    threads: f64,
    /// A thread's triangle, and each of its columns.
    t_triangle: f64,
    t_column: f64,
    /// Fragments' triangle and column, all cores at work.
    f_triangle: f64,
    f_column: f64,
    /// A draw.
    draw: f64,
}

/// Lavapipe on two cores of eight lanes. A column costs a thread no more than a fragment, so only a triangle that would
/// keep all but one core waiting is worth a draw.
pub(super) const SOFTWARE: Costs = Costs {
    cutoff_cells2: 8192.0,
    threads: 16.0,
    t_triangle: 7e-4,
    t_column: 6.6e-5,
    f_triangle: 6.5e-4,
    f_column: 1.5e-5,
    draw: 0.2,
};

/// A GPU, after RB Table 1 (GTX 480): threads are many and weak; a few cells² were best on every scene but one.
pub(super) const HARDWARE: Costs = Costs {
    cutoff_cells2: 8.0,
    threads: 8192.0,
    t_triangle: 7e-3,
    t_column: 1e-3,
    f_triangle: 2.2e-5,
    f_column: 2e-6,
    draw: 0.01,
};

/// The octave of the least predicted time, for triangles counted by octave of area.
pub(super) fn octave_for(sizes: &[u32; OCTAVES], costs: &Costs) -> i32 {
    let area = |bin: usize| 1.5 * f64::exp2((LEAST_OCTAVE as f64) + bin as f64);
    let predicted = |cutoff: i32| {
        let (mut threads, mut longest, mut fragments) = (0.0, 0.0_f64, 0.0);
        for (bin, &count) in sizes.iter().enumerate().filter(|(_, count)| **count > 0) {
            let (count, area) = (f64::from(count), area(bin));
            if area < f64::exp2(f64::from(cutoff)) {
                let each = costs.t_triangle + costs.t_column * area;
                threads += count * each;
                longest = longest.max(each);
            } else {
                fragments += count * (costs.f_triangle + costs.f_column * area);
            }
        }
        let draw = if fragments > 0.0 { costs.draw } else { 0.0 };
        (threads / costs.threads).max(longest) + fragments + draw
    };
    let octaves = LEAST_OCTAVE..=LAST_OCTAVE;
    // Of equals the largest: the fewest drawn.
    octaves.rev().min_by(|a, b| predicted(*a).total_cmp(&predicted(*b))).unwrap_or(LEAST_OCTAVE)
}

/// Frames left out after a change: their times are still on their way.
const LATE: usize = 4;
/// Frames whose times count, as their median.
const SAMPLES: usize = 7;
/// By how much a time must be less to count as less.
const BETTER: f64 = 0.95;
/// How far from the middle the search begins, octaves.
const FIRST_STRIDE: i32 = 4;

/// A bracketing search for the octave of least time: the middle and one on either side of it are measured; the middle
/// moves to the better one, and where it is the best itself, the sides draw nearer. Each octave is measured once.
#[derive(Debug)]
pub(super) struct Search {
    middle: i32,
    stride: i32,
    trying: i32,
    frames: Vec<f64>,
    ms: BTreeMap<i32, f64>,
}

impl Search {
    /// From an octave on.
    pub(super) fn from(octave: i32) -> Self {
        Self { middle: octave, stride: FIRST_STRIDE, trying: octave, frames: Vec::new(), ms: BTreeMap::new() }
    }

    /// The octave to use now.
    pub(super) fn octave(&self) -> i32 {
        self.trying
    }

    /// True once it stays.
    pub(super) fn is_settled(&self) -> bool {
        self.stride == 0
    }

    /// Takes in the time of a frame that used [`Search::octave`], or of one shortly before.
    pub(super) fn take(&mut self, ms: f64) {
        if self.is_settled() {
            return;
        }
        self.frames.push(ms);
        if self.frames.len() < LATE + SAMPLES {
            return;
        }
        let mut counted = self.frames.split_off(LATE);
        self.frames.clear();
        counted.sort_by(f64::total_cmp);
        self.ms.insert(self.trying, counted[SAMPLES / 2]);
        self.trying = self.next();
    }

    /// The next octave to measure; the best one when there is none.
    fn next(&mut self) -> i32 {
        while self.stride > 0 {
            let inside = |octave: &i32| (LEAST_OCTAVE..=LAST_OCTAVE).contains(octave);
            let sides = [self.middle - self.stride, self.middle + self.stride];
            let sides: Vec<i32> = sides.into_iter().filter(inside).collect();
            let unmeasured = [self.middle].into_iter().chain(sides.iter().copied()).find(|o| !self.ms.contains_key(o));
            if let Some(octave) = unmeasured {
                return octave;
            }
            let best = sides.into_iter().min_by(|a, b| self.ms[a].total_cmp(&self.ms[b]));
            match best.filter(|best| self.ms[best] < self.ms[&self.middle] * BETTER) {
                Some(best) => self.middle = best,
                None => self.stride /= 2,
            }
        }
        self.middle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs a search over times by octave; how many frames it took, and where it ended.
    fn settled(start: i32, ms: impl Fn(i32, usize) -> f64) -> (usize, i32) {
        let mut search = Search::from(start);
        let mut frames = 0;
        while !search.is_settled() && frames < 10_000 {
            search.take(ms(search.octave(), frames));
            frames += 1;
        }
        (frames, search.octave())
    }

    #[test]
    fn the_search_settles_within_a_few_seconds_near_the_least_time() {
        // A stair that falls to octave 6 and rises again, as RB's Fig. 13, with noise of 3%.
        let stair = |octave: i32| 3.0 + 0.5 * f64::from((octave - 6).abs());
        let noise = |frame: usize| 1.0 + 0.03 * ((frame * 7919 % 13) as f64 / 6.0 - 1.0);
        for start in [-2, 0, 3, 8, 13, 22] {
            let (frames, found) = settled(start, |octave, frame| stair(octave) * noise(frame));
            assert!(stair(found) <= stair(6) + 0.5 && frames < 200, "from {start}: {found} after {frames}");
        }
    }

    #[test]
    fn a_flat_time_keeps_the_start_and_a_settled_search_stays() {
        let (_, found) = settled(5, |_, frame| 4.0 + 0.1 * (frame % 2) as f64);
        assert_eq!(found, 5);
        assert_eq!(OCTAVES, (LEAST_OCTAVE..LAST_OCTAVE).count());
        let mut search = Search::from(5);
        while !search.is_settled() {
            search.take(1.0 + f64::from((search.octave() - 9).abs()));
        }
        let found = search.octave();
        assert_eq!(found, 9);
        (0..1000).for_each(|i| search.take(f64::from(i)));
        assert_eq!(search.octave(), found);
    }

    #[test]
    fn times_that_arrive_late_are_not_taken_for_those_of_the_next_octave() {
        let mut last = [9.0; 3];
        let mut search = Search::from(0);
        while !search.is_settled() {
            search.take(last[0]);
            last = [last[1], last[2], f64::from((search.octave() - 5).abs()) + 1.0];
        }
        assert_eq!(search.octave(), 5);
    }

    #[test]
    fn the_model_lets_threads_have_small_triangles_and_fragments_huge_ones() {
        let sizes = |of: &[(usize, u32)]| {
            let mut sizes = [0; OCTAVES];
            of.iter().for_each(|(bin, count)| sizes[*bin] = *count);
            sizes
        };
        for costs in [&SOFTWARE, &HARDWARE] {
            let exp = |bin: i32| LEAST_OCTAVE + bin;
            let small = octave_for(&sizes(&[(1, 70_000)]), costs);
            assert!(small > exp(1), "70,000 triangles of half a cell² go to threads");
            let huge = octave_for(&sizes(&[(16, 1)]), costs);
            assert!(huge <= exp(16), "one triangle of 2¹⁴ cells² goes to fragments");
            let both = octave_for(&sizes(&[(1, 70_000), (20, 1)]), costs);
            assert!((exp(2)..=exp(20)).contains(&both), "{both}");
        }
    }
}
