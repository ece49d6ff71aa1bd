//! The words that scene files, menus and the command line share: one for each variant of a choice.

use super::csg::Operation;
use super::description::{
    Align, Blending, Classify, ColumnLoop, Conservative, Fill, Hit, Projection, Refraction, Shadow, SizeMeasure,
};

/// A choice whose variants have one word each.
pub trait Words: Copy + PartialEq + 'static {
    /// Every variant with its word and a line about it, in the order of menus.
    const WORDS: &'static [(Self, &'static str, &'static str)];

    /// This variant's word.
    #[must_use]
    fn word(self) -> &'static str {
        Self::WORDS.iter().find(|(variant, ..)| *variant == self).map_or("?", |(_, word, _)| word)
    }

    /// The variant of this word.
    #[must_use]
    fn from_word(word: &str) -> Option<Self> {
        Self::WORDS.iter().find(|(_, known, _)| *known == word).map(|(variant, ..)| *variant)
    }

    /// All words.
    #[must_use]
    fn words() -> Vec<&'static str> {
        Self::WORDS.iter().map(|(_, word, _)| *word).collect()
    }
}

impl Words for Align {
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Camera, "camera", "turned to the camera"),
        (Self::World, "world", "along the world's axes: an orbit around a still body voxelizes nothing"),
    ];
}

impl Words for Projection {
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Orthographic, "orthographic", "parallel columns"),
        (Self::Perspective, "perspective", "columns through the eye, slices uniform in eye depth"),
    ];
}

impl Words for Conservative {
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::None, "none", "columns whose middle line a triangle meets"),
        (Self::Polygon, "polygon", "every column it touches: the triangle grown by a square (Hasselgren et al. 2005)"),
        (Self::Box, "box", "its grown sides within its box: a triangle clipped in the fragment (the same)"),
        (Self::Dilated, "dilated", "its sides moved out by half a diagonal, within its box (Hertel et al. 2009)"),
        (Self::Hardware, "hardware", "the adapter's own, where it has one"),
    ];
}

impl Words for ColumnLoop {
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Whole, "whole", "every cell of a triangle's depth range (TR ch. 2)"),
        (Self::TwoEnded, "two-ended", "from the range's middle outwards, until the run of cells is passed (TR ch. 5)"),
    ];
}

impl Words for Blending {
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Or, "or", "bits are united: no voxel is lost"),
        (
            Self::Additive,
            "additive",
            "as published: where triangles meet in a voxel, its bit carries into the next (DO §4.2)",
        ),
    ];
}

impl Words for SizeMeasure {
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Area, "area", "of the projected triangle, voxels²"),
        (Self::DilatedArea, "dilated-area", "of the dilated triangle that is rasterized, voxels²"),
        (Self::Extent2d, "extent-2d", "columns of its box"),
        (Self::Extent3d, "extent-3d", "voxels of its box"),
        (Self::AreaRatio, "area-ratio", "area over dilated area, 0 to 1"),
    ];
}

impl Words for Classify {
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::OnTheFly, "on-the-fly", "small triangles are marked while large ones are found (RB Fig. 15)"),
        (Self::First, "first", "triangles are sorted into two lists before any is marked (RB Fig. 12)"),
    ];
}

impl Words for Fill {
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Lazy, "lazy", "inside the walk, when needed (CL §2.3, second strategy)"),
        (Self::Eager, "eager", "a prefix XOR down each column (CL §2.3, first strategy)"),
        (Self::None, "none", "no interior"),
    ];
}

impl Words for Refraction {
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::None, "none", "straight through"),
        (Self::Single, "single", "bent once, where the ray enters"),
        (Self::TwoSurface, "two-surface", "bent at the entry and at the estimated exit (CL §3.2.1)"),
        (Self::MultipleSurface, "multiple-surface", "bent wherever a surface is met (CL §3.2.2)"),
    ];
}

impl Words for Hit {
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Surfel, "surfel", "the first surface rasterized, then crossings of the records' planes"),
        (Self::Voxel, "voxel", "the paper whole: fixed steps of a voxel and an angle threshold"),
    ];
}

impl Words for Operation {
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Union, "union", "in one or the other"),
        (Self::Intersection, "intersection", "in all"),
        (Self::Difference, "difference", "in the first and in none of the others"),
    ];
}

impl Words for Shadow {
    const WORDS: &'static [(Self, &'static str, &'static str)] = &[
        (Self::None, "none", "no shadows"),
        (Self::Linear, "linear", "one minus the sum of absorption (CL Eq. 1 as printed)"),
        (Self::BeerLambert, "beer-lambert", "exp of minus the optical depth"),
    ];
}

/// The known word nearest to `given`, if it is near enough to be a slip of the pen.
#[must_use]
pub fn nearest<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let allowed = (given.chars().count() + 1) / 3;
    known
        .into_iter()
        .map(|word| (edits(given, word), word))
        .filter(|(count, word)| *count <= allowed || (given.len() > 2 && word.starts_with(given)))
        .min_by_key(|(count, _)| *count)
        .map(|(_, word)| word)
}

/// How many letters must be changed, added, dropped or swapped with their neighbour to turn `a` into `b`.
fn edits(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().take(64).collect(), b.chars().take(64).collect());
    let mut before_last = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let change = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            row[j] = change.min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before_last[j - 2] + 1);
            }
        }
        before_last = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn a_slip_is_mended_and_a_strange_word_is_not() {
        let known = ["refraction", "reflection", "exposure", "hit"];
        assert_eq!(nearest("refracton", known), Some("refraction"));
        assert_eq!(nearest("hti", known), Some("hit"));
        assert_eq!(nearest("expo", known), Some("exposure"));
        assert_eq!(nearest("banana", known), None);
        assert_eq!(nearest("", known), None);
    }
}
