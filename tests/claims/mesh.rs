//! What a mesh is, by itself: its corners, its volume, whether it is closed.

use glam::DVec3;
use murrine::scene::geometry::Geometry;
use std::collections::HashMap;

pub(crate) fn corners(geometry: &Geometry, triangle: [u32; 3]) -> [DVec3; 3] {
    triangle.map(|v| geometry.vertices[v as usize].position.as_dvec3())
}

/// Positive where triangles are wound outward.
pub(crate) fn volume(geometry: &Geometry) -> f64 {
    let signed = |t: &[u32; 3]| {
        let [a, b, c] = corners(geometry, *t);
        a.dot(b.cross(c)) / 6.0
    };
    geometry.triangles.iter().map(signed).sum()
}

/// How many directed edges lack their opposite, vertices told apart by the bits of their positions.
pub(crate) fn open_edges(geometry: &Geometry) -> usize {
    let key = |v: u32| geometry.vertices[v as usize].position.to_array().map(|x| (x + 0.0).to_bits());
    let mut balance: HashMap<_, i64> = HashMap::new();
    for &[a, b, c] in &geometry.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *balance.entry((key(from), key(to))).or_default() += 1;
            *balance.entry((key(to), key(from))).or_default() -= 1;
        }
    }
    balance.values().filter(|&&n| n != 0).count()
}
