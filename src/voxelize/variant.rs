//! Pipelines compiled for one kind of grid and one separability: lavapipe runs both sides of every branch, so what is
//! known beforehand is an `override`.

use super::Input;
use crate::gpu::{Gpu, GpuError};
use crate::grid::PERSPECTIVE;
use crate::scene::description::Separability;
use std::collections::BTreeMap;

/// What `lib/triangle_box.inc.wgsl` is compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) struct Variant {
    thin: bool,
    perspective: bool,
}

impl Variant {
    /// The one that this grid and these settings need.
    pub(super) fn of(input: &Input<'_>) -> Self {
        Self {
            thin: input.settings.separability == Separability::Six,
            perspective: input.volume.grids[input.grid].projection == PERSPECTIVE,
        }
    }

    /// Values of the overrides of a shader that tests boxes.
    pub(super) fn constants(self) -> [(&'static str, f64); 2] {
        let [projection] = self.projection_constants();
        [("thin", f64::from(u8::from(self.thin))), projection]
    }

    /// Values of the overrides of a shader that only maps triangles into a grid.
    pub(super) fn projection_constants(self) -> [(&'static str, f64); 1] {
        [("perspective", f64::from(u8::from(self.perspective)))]
    }
}

/// Compiled variants, by what they are compiled for; the first is compiled at once, so that a faulty shader is told at once, the others when needed.
#[derive(Debug)]
pub(super) struct Variants<P, K = Variant> {
    make: fn(&Gpu, K) -> Result<P, GpuError>,
    made: BTreeMap<K, P>,
}

impl<P, K: Copy + Ord + Default> Variants<P, K> {
    pub(super) fn new(gpu: &Gpu, make: fn(&Gpu, K) -> Result<P, GpuError>) -> Result<Self, GpuError> {
        let first = K::default();
        Ok(Self { make, made: BTreeMap::from([(first, make(gpu, first)?)]) })
    }

    pub(super) fn get(&mut self, gpu: &Gpu, variant: K) -> Result<&mut P, GpuError> {
        use std::collections::btree_map::Entry;
        Ok(match self.made.entry(variant) {
            Entry::Occupied(made) => made.into_mut(),
            Entry::Vacant(missing) => missing.insert((self.make)(gpu, variant)?),
        })
    }
}
