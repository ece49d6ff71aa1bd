//! Triangles in grid space, cut at the eye where the grid is a perspective one; the twin in f64 of
//! `shaders/lib/grid_triangle.inc.wgsl`.

use crate::grid::{Grid, ORTHOGRAPHIC};
use glam::{DMat4, DVec3, DVec4, Vec3};

/// The parts of a world-space triangle that a grid may see, in its grid space: none, one, or two where a perspective
/// grid's triangle reaches behind the eye with one vertex. It is cut where the eye depth is half of `near`. A triangle
/// with a vertex that is not finite has no parts.
pub(super) fn grid_triangles(grid: &Grid, grid_from_world: &DMat4, triangle: [Vec3; 3]) -> Vec<[DVec3; 3]> {
    if !triangle.iter().all(|p| p.is_finite()) {
        return Vec::new();
    }
    let mut h = triangle.map(|p| *grid_from_world * p.as_dvec3().extend(1.0));
    if grid.projection == ORTHOGRAPHIC {
        return vec![h.map(DVec4::truncate)];
    }
    let limit = 0.5 * f64::from(grid.near);
    let behind = h.map(|h| h.w < limit);
    let count = behind.iter().filter(|b| **b).count();
    // Turn the triangle until vertex 0 is the one on its own side.
    if let Some(odd) = behind.iter().position(|b| *b == (count == 1)) {
        h.rotate_left(odd);
    }
    let towards = |to: DVec4| h[0] + (to - h[0]) * ((limit - h[0].w) / (to.w - h[0].w));
    let project = |h: DVec4| h.truncate() / h.w;
    match count {
        0 => vec![h.map(project)],
        1 => {
            let [to_1, b, c, to_2] = [towards(h[1]), h[1], h[2], towards(h[2])].map(project);
            vec![[to_1, b, c], [to_1, c, to_2]]
        }
        2 => vec![[h[0], towards(h[1]), towards(h[2])].map(project)],
        _ => Vec::new(),
    }
}
