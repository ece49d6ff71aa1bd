//! Triangle against box in f64, axis by axis, as the papers print it: what the exact methods are held to.

use glam::DVec3;

/// A box with faces along the axes of grid space.
#[derive(Debug, Clone, Copy)]
pub(super) struct AxisBox {
    pub(super) center: DVec3,
    pub(super) half: DVec3,
}

/// True unless one of the thirteen axes separates the closed box and the closed triangle (Akenine-Möller 2001): the
/// three of the box, the triangle's normal, and the nine crossed from the box's axes and the triangle's edges. An axis
/// that vanishes separates nothing, so a segment or a point is right as well.
pub(super) fn overlaps(triangle: &[DVec3; 3], cell: AxisBox) -> bool {
    let v = triangle.map(|p| p - cell.center);
    let e = [v[1] - v[0], v[2] - v[1], v[0] - v[2]];
    let separates = |axis: DVec3| {
        let p = v.map(|v| axis.dot(v));
        let reach = cell.half.dot(axis.abs());
        p[0].min(p[1]).min(p[2]) > reach || p[0].max(p[1]).max(p[2]) < -reach
    };
    !(DVec3::AXES.into_iter().any(separates)
        || separates(e[0].cross(e[1]))
        || e.iter().any(|e| DVec3::AXES.into_iter().any(|axis| separates(axis.cross(*e)))))
}

/// What a rule makes of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Verdict {
    /// The rule holds.
    pub(super) marked: bool,
    /// It holds, and would if every vertex moved by the band.
    pub(super) surely_marked: bool,
    /// It holds, or might if every vertex moved by the band.
    pub(super) maybe_marked: bool,
}

impl Verdict {
    const HOLDS: Self = Self { marked: true, surely_marked: true, maybe_marked: true };

    /// Asks for `slack` ≥ 0, which changes by at most `sensitivity` for each unit that vertices move.
    fn require(&mut self, band: f64, slack: f64, sensitivity: f64) {
        self.marked &= slack >= 0.0;
        self.surely_marked &= slack > sensitivity * band;
        self.maybe_marked &= slack >= -sensitivity * band;
    }
}

/// As [`overlaps`], with what a displacement of the vertices by `band` cells could change: that of the box's faces by as
/// much covers it.
pub(super) fn thick(triangle: &[DVec3; 3], cell: AxisBox, band: f64) -> Verdict {
    let v = triangle.map(|p| p - cell.center);
    let e = [v[1] - v[0], v[2] - v[1], v[0] - v[2]];
    let mut result = Verdict::HOLDS;
    let mut require = |axis: DVec3| {
        let p = v.map(|v| axis.dot(v));
        let reach = cell.half.dot(axis.abs());
        let slack = (reach - p[0].min(p[1]).min(p[2])).min(reach + p[0].max(p[1]).max(p[2]));
        if axis != DVec3::ZERO {
            result.require(band, slack, axis.abs().element_sum());
        }
    };
    DVec3::AXES.into_iter().for_each(&mut require);
    require(e[0].cross(e[1]));
    for edge in e {
        DVec3::AXES.into_iter().for_each(|axis| require(axis.cross(edge)));
    }
    result
}

/// The thin, 6-separating rule (Schwarz & Seidel 2010; RB §3.1, Figs. 2, 3 and 18): the cell's box meets the triangle's,
/// the plane meets the diamond inscribed in the cell, and in each of the three projections the diamond inscribed in the
/// cell's square reaches to the inner side of each edge.
///
/// `band` is a displacement of the vertices, cells; for what it can do the first-order bound is taken.
pub(super) fn thin(triangle: &[DVec3; 3], cell: AxisBox, band: f64) -> Verdict {
    let v = triangle.map(|p| p - cell.center);
    let e = [v[1] - v[0], v[2] - v[1], v[0] - v[2]];
    let mut result = Verdict::HOLDS;
    for axis in 0..3 {
        let p = v.map(|v| v[axis]);
        result.require(band, cell.half[axis] - p[0].min(p[1]).min(p[2]), 1.0);
        result.require(band, cell.half[axis] + p[0].max(p[1]).max(p[2]), 1.0);
    }
    let n = e[0].cross(e[1]);
    let one = |v: DVec3| v.abs().element_sum();
    let turn = 2.0 * (one(e[0]) + one(e[1]));
    let reach = (n.abs() * cell.half).max_element();
    result.require(band, reach - n.dot(v[0]).abs(), one(n) + turn * (one(v[0]) + cell.half.max_element()));

    for (axis_a, axis_b) in [(0, 1), (1, 2), (2, 0)] {
        for i in 0..3 {
            let (edge, start, opposite) = (e[i], v[i], v[(i + 2) % 3]);
            // Points to the triangle's inner side or straight away from it.
            let (a, b) = (-edge[axis_b], edge[axis_a]);
            let reach = (a.abs() * cell.half[axis_a]).max(b.abs() * cell.half[axis_b]);
            let at_edge = a * start[axis_a] + b * start[axis_b];
            let at_opposite = a * opposite[axis_a] + b * opposite[axis_b];
            let to = |p: DVec3| p[axis_a].abs() + p[axis_b].abs();
            let sensitivity = a.abs() + b.abs() + 2.0 * (to(start) + cell.half.max_element());
            let width_sensitivity = a.abs() + b.abs() + 2.0 * to(opposite - start);
            let [above, below] = [reach - at_edge.min(at_opposite), reach + at_edge.max(at_opposite)];
            let width = at_opposite - at_edge;
            let tiny = f64::EPSILON * 4.0 * width_sensitivity;
            let holds = (above >= 0.0 || width < -tiny) && (below >= 0.0 || width > tiny);
            if width.abs() > width_sensitivity * band {
                result.require(band, if width > 0.0 { above } else { below }, sensitivity);
            } else {
                // Which side is the inner one is a matter of rounding; of a projection that is a line, both.
                result.marked &= holds;
                result.surely_marked &= above.min(below) > sensitivity * band;
                result.maybe_marked &= above.max(below) >= -sensitivity * band;
            }
        }
    }
    result
}
