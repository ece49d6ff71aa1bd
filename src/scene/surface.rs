//! Surfaces given by expressions. Each becomes a mesh like every model, so that every effect runs on it; one whose
//! expressions hold `t` is made anew for each time.

use super::geometry::Geometry;
use super::implicit::Implicit;
use super::parametric::Parametric;
use super::shapes::Mesh;
use std::ops::Range;

/// A surface that is not made of triangles by itself.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "always behind an Arc")]
pub enum Surface {
    /// Points as a function of two parameters.
    Parametric(Parametric),
    /// Where an expression is zero.
    Implicit(Implicit),
}

/// A surface's geometry at one time, kept with what it was made from.
#[derive(Debug, Clone, PartialEq)]
pub struct MadeFrom {
    /// The surface.
    pub surface: std::sync::Arc<Surface>,
    /// The `t` of its expressions.
    pub time_secs: f64,
}

/// The largest coordinate that a surface may have; beyond it single precision has no digits left for a cell.
pub(super) const FARTHEST: f64 = 1e6;

impl Surface {
    /// Whether it changes with time.
    #[must_use]
    pub fn moves(&self) -> bool {
        match self {
            Self::Parametric(parametric) => parametric.moves(),
            Self::Implicit(implicit) => implicit.moves(),
        }
    }

    /// Its word in scene files, and its part's name.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Parametric(_) => "parametric",
            Self::Implicit(_) => "implicit",
        }
    }

    /// Its triangles at a time, with a warning where an expression is no number and the like.
    #[must_use]
    pub fn geometry(&self, time_secs: f64) -> Geometry {
        let (mesh, warning): (Mesh, _) = match self {
            Self::Parametric(parametric) => parametric.mesh(time_secs),
            Self::Implicit(implicit) => implicit.mesh(time_secs),
        };
        Geometry { warning, ..mesh.into_geometry(self.word(), None) }
    }
}

/// Splits `0..count` into a run for each core, works them out at once and returns the results in order.
pub(super) fn in_runs<T: Send>(count: usize, work: impl Fn(Range<usize>) -> T + Sync) -> Vec<T> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from).min(count.max(1));
    let run = |i: usize| count * i / cores..count * (i + 1) / cores;
    if cores == 1 {
        return vec![work(run(0))];
    }
    std::thread::scope(|scope| {
        let work = &work;
        let threads: Vec<_> = (1..cores).map(|i| scope.spawn(move || work(run(i)))).collect();
        let first = work(run(0));
        let rest = threads.into_iter().map(|t| t.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        std::iter::once(first).chain(rest).collect()
    })
}
