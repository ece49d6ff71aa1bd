//! Which triangles share an edge, so that a march can go from a record's triangle to the one that a ray truly meets.

use super::{NO_TRIANGLE, u32_of};
use glam::Vec3;

/// For each triangle the triangles beyond its edges: opposite its first, second and third corner; [`NO_TRIANGLE`] beyond
/// an edge that no other triangle has, or more than one. Edges are the same where their ends lie in the same place of
/// the same part, whatever the seams of normals and pictures. `place` tells a vertex's part and position.
pub(super) fn neighbors(triangles: &[[u32; 3]], vertices: usize, place: impl Fn(u32) -> (u32, Vec3)) -> Vec<[u32; 3]> {
    let welded = welded(vertices, place);
    let mut edges: Vec<(u64, u32)> = Vec::with_capacity(3 * triangles.len());
    for (number, t) in (0_u32..).zip(triangles) {
        let [a, b, c] = t.map(|v| u64::from(welded[v as usize]));
        for (corner, (from, to)) in (0..3).zip([(b, c), (c, a), (a, b)]) {
            if from != to {
                edges.push((from.min(to) << 32 | from.max(to), 3 * number + corner));
            }
        }
    }
    edges.sort_unstable();
    let mut beyond = vec![[NO_TRIANGLE; 3]; triangles.len()];
    for shared in edges.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, a), (_, b)] = shared {
            beyond[*a as usize / 3][*a as usize % 3] = b / 3;
            beyond[*b as usize / 3][*b as usize % 3] = a / 3;
        }
    }
    beyond
}

/// For each vertex the first of those in its place.
fn welded(vertices: usize, place: impl Fn(u32) -> (u32, Vec3)) -> Vec<u32> {
    let key = |v: u32| {
        let (part, position) = place(v);
        (part, (position + 0.0).to_array().map(f32::to_bits)) // −0 is 0
    };
    let mut order: Vec<_> = (0..u32_of(vertices)).map(|v| (key(v), v)).collect();
    order.sort_unstable();
    let mut first_of = vec![0; vertices];
    for same in order.chunk_by(|a, b| a.0 == b.0) {
        for (_, v) in same {
            first_of[*v as usize] = same[0].1;
        }
    }
    first_of
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_meet_over_an_edge_across_seams_and_not_across_parts() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::X, Vec3::Y, Vec3::ONE, Vec3::X, Vec3::Y, Vec3::ONE];
        let place = |v: u32| (u32::from(v >= 6), corners[v as usize]);
        let found = neighbors(&[[0, 1, 2], [3, 5, 4], [6, 7, 8]], corners.len(), place);
        let none = NO_TRIANGLE;
        assert_eq!(found, [[1, none, none], [none, 0, none], [none; 3]]);
    }

    #[test]
    fn an_edge_of_three_triangles_leads_nowhere() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_Y];
        let found = neighbors(&[[0, 1, 2], [0, 1, 3], [1, 0, 4]], 5, |v| (0, corners[v as usize]));
        assert_eq!(found, [[NO_TRIANGLE; 3]; 3]);
    }
}
