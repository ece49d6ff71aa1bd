//! Triangles with smooth normals.

use glam::{DMat4, DVec3};
use std::collections::BTreeMap;

/// A mesh; normals are unit and as many as positions; triangles are counter-clockwise from outside.
#[derive(Debug, Clone, Default)]
pub(crate) struct Mesh {
    pub(crate) positions: Vec<DVec3>,
    pub(crate) normals: Vec<DVec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The unit sphere: an icosahedron whose triangles are split in four `subdivisions` times.
    pub(crate) fn icosphere(subdivisions: u32) -> Self {
        let golden = (1.0 + 5.0_f64.sqrt()) * 0.5;
        let mut positions = Vec::new();
        for (a, b) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
            positions.push(DVec3::new(a, b, 0.0).normalize());
        }
        for (a, b) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
            positions.push(DVec3::new(0.0, a, b).normalize());
        }
        for (a, b) in [(golden, -1.0), (golden, 1.0), (-golden, -1.0), (-golden, 1.0)] {
            positions.push(DVec3::new(a, 0.0, b).normalize());
        }
        let mut triangles: Vec<[u32; 3]> = vec![
            [0, 11, 5],
            [0, 5, 1],
            [0, 1, 7],
            [0, 7, 10],
            [0, 10, 11],
            [1, 5, 9],
            [5, 11, 4],
            [11, 10, 2],
            [10, 7, 6],
            [7, 1, 8],
            [3, 9, 4],
            [3, 4, 2],
            [3, 2, 6],
            [3, 6, 8],
            [3, 8, 9],
            [4, 9, 5],
            [2, 4, 11],
            [6, 2, 10],
            [8, 6, 7],
            [9, 8, 1],
        ];
        for _ in 0..subdivisions {
            let mut middles = BTreeMap::new();
            let mut finer = Vec::with_capacity(triangles.len() * 4);
            for [a, b, c] in triangles {
                let mut middle = |i: u32, j: u32| {
                    *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                        let sum = positions[i as usize] + positions[j as usize];
                        positions.push(sum.normalize());
                        index(positions.len() - 1)
                    })
                };
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
            }
            triangles = finer;
        }
        Self { normals: positions.clone(), positions, triangles }
    }

    /// Adds another mesh, moved by a rotation, a uniform scale and a translation.
    pub(crate) fn add(&mut self, other: &Self, placement: DMat4) {
        let first = index(self.positions.len());
        self.positions.extend(other.positions.iter().map(|&p| placement.transform_point3(p)));
        self.normals.extend(other.normals.iter().map(|&n| placement.transform_vector3(n).normalize()));
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + first)));
    }

    /// Replaces the normals by the mean of the triangles around each vertex, weighted by angle-free area.
    pub(crate) fn smooth_normals(&mut self) {
        self.normals = vec![DVec3::ZERO; self.positions.len()];
        for &[a, b, c] in &self.triangles {
            let [pa, pb, pc] = [a, b, c].map(|i| self.positions[i as usize]);
            let area = (pb - pa).cross(pc - pa);
            for i in [a, b, c] {
                self.normals[i as usize] += area;
            }
        }
        for normal in &mut self.normals {
            *normal = normal.normalize();
        }
    }
}

/// A vertex's index as files store it.
pub(crate) fn index(i: usize) -> u32 {
    u32::try_from(i).expect("fewer than 2^32 vertices")
}
