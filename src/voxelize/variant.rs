//! Pipelines compiled for one kind of grid, one separability, one way of being conservative: lavapipe runs both sides of
//! every branch, so what is known beforehand is an `override`.

use super::Input;
use crate::gpu::{Gpu, GpuError};
use crate::grid::PERSPECTIVE;
use crate::scene::description::{Conservative, Separability, VoxelizerSettings};
use std::collections::BTreeMap;

/// What `lib/triangle_box.inc.wgsl` and `lib/conservative.inc.wgsl` are compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) struct Variant {
    thin: bool,
    perspective: bool,
    conservative: Conservative,
    conservative_depth: bool,
}

/// The ways that every method can take that draws footprints.
pub(super) const EVERY_WAY: &[Conservative] =
    &[Conservative::Polygon, Conservative::Box, Conservative::Dilated, Conservative::Hardware];

impl Variant {
    /// The one that this grid and these settings need of a shader that tests boxes.
    pub(super) fn of(input: &Input<'_>) -> Self {
        Self {
            thin: input.settings.separability == Separability::Six,
            perspective: input.volume.grids[input.grid].projection == PERSPECTIVE,
            ..Self::default()
        }
    }

    /// The one that this grid needs of a shader that draws footprints, middle lines alone.
    pub(super) fn plain(input: &Input<'_>) -> Self {
        Self { thin: false, ..Self::of(input) }
    }

    /// The one that this grid and these settings need of a shader that draws footprints.
    pub(super) fn footprint(input: &Input<'_>) -> Self {
        let VoxelizerSettings { conservative, conservative_depth, .. } = *input.settings;
        Self { conservative, conservative_depth, ..Self::plain(input) }
    }

    /// Whether the adapter itself is to be conservative.
    pub(super) fn by_hardware(self) -> bool {
        self.conservative == Conservative::Hardware
    }

    /// Pieces that a triangle may be cut into, at the eye.
    pub(super) fn pieces(self) -> u32 {
        if self.perspective { 2 } else { 1 }
    }

    /// Vertices of a triangle's footprint.
    pub(super) fn footprint_vertices(self) -> u32 {
        if self.conservative == Conservative::Polygon { 21 } else { 3 }
    }

    /// Values of the overrides of a shader that draws footprints.
    pub(super) fn footprint_constants(self) -> [(&'static str, f64); 3] {
        let [projection] = self.projection_constants();
        let depth = f64::from(u8::from(self.conservative_depth));
        [projection, ("conservative", f64::from(self.conservative as u8)), ("conservative_depth", depth)]
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
