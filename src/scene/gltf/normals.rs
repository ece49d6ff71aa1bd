//! Normals that a file leaves out where its neighbours have them.

use super::Report;
use super::primitive::Mesh;
use glam::{DQuat, DVec3, Vec3};
use std::collections::HashMap;

impl Mesh {
    /// Vertices whose normal has no length take the mean of their triangles', by area.
    pub(super) fn mend_normals(&mut self, report: &mut Report) {
        let missing: Vec<bool> = self.vertices.iter().map(|v| v.normal == Vec3::ZERO).collect();
        let mut mended = vec![false; self.vertices.len()];
        for triangle in &self.triangles {
            if !triangle.iter().any(|&v| missing[v as usize]) {
                continue;
            }
            let [a, b, c] = triangle.map(|v| self.vertices[v as usize].position.as_dvec3());
            let face = (b - a).cross(c - a).as_vec3();
            for v in triangle.map(|v| v as usize).into_iter().filter(|&v| missing[v]) {
                let sum = self.vertices[v].normal + face;
                self.vertices[v].normal = if sum.is_finite() { sum } else { face.normalize_or_zero() };
                mended[v] = true;
            }
        }
        for (vertex, _) in self.vertices.iter_mut().zip(&missing).filter(|(_, missing)| **missing) {
            vertex.normal = vertex.normal.try_normalize().unwrap_or(Vec3::Y);
        }
        let mended = mended.iter().filter(|m| **m).count();
        if mended > 0 {
            report.warn(format!("{mended} normals without length were worked out anew"));
        }
    }

    /// Fills the normals of morph targets that displace positions alone, so that a body that swells is lit as it
    /// stands.
    ///
    /// A vertex's own normal is turned as the smooth normal of the triangles around it turns between rest and the whole
    /// target: creases and seams of the file stay, and one target at weight 1 is right. glTF leaves such normals at rest.
    pub(super) fn turn_morph_normals(&mut self, targets: &[usize]) {
        if targets.is_empty() {
            return;
        }
        let groups = self.groups();
        let at_rest = self.smooth_normals(&groups, |v| self.vertices[v].position.as_dvec3());
        let count = self.vertices.len();
        for &target in targets {
            let first = target * count;
            let moved = |v: usize| self.vertices[v].position.as_dvec3() + self.morphs[first + v].position.as_dvec3();
            let as_target = self.smooth_normals(&groups, moved);
            for (v, vertex) in self.vertices.iter().enumerate() {
                let group = groups[v] as usize;
                let (from, to) = (at_rest[group], as_target[group]);
                if from != DVec3::ZERO && to != DVec3::ZERO && (to - from).length() > 1e-9 {
                    let normal = vertex.normal.as_dvec3();
                    let turned = DQuat::from_rotation_arc(from, to) * normal;
                    self.morphs[first + v].normal = (turned - normal).as_vec3();
                }
            }
        }
    }

    /// For each vertex the number of the first one with its position and normal: seams between pictures are no edges.
    fn groups(&self) -> Vec<u32> {
        let mut known: HashMap<[u32; 6], u32> = HashMap::with_capacity(self.vertices.len());
        let bits = |p: Vec3, n: Vec3| [p.x, p.y, p.z, n.x, n.y, n.z].map(f32::to_bits);
        let numbered = self.vertices.iter().zip(0_u32..);
        numbered.map(|(v, i)| *known.entry(bits(v.position, v.normal)).or_insert(i)).collect()
    }

    /// By group: the unit mean of its triangles' normals, weighted by their angles there; zero where that is nothing.
    fn smooth_normals(&self, groups: &[u32], position: impl Fn(usize) -> DVec3) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; groups.len()];
        for triangle in &self.triangles {
            let corners = triangle.map(|v| v as usize);
            let at = corners.map(&position);
            let face = (at[1] - at[0]).cross(at[2] - at[0]).normalize_or_zero();
            for i in 0..3 {
                let (forth, back) = (at[(i + 1) % 3] - at[i], at[(i + 2) % 3] - at[i]);
                let angle = forth.cross(back).length().atan2(forth.dot(back));
                sums[groups[corners[i]] as usize] += face * angle;
            }
        }
        sums.into_iter().map(|sum| if sum.length() > 1e-6 { sum.normalize() } else { DVec3::ZERO }).collect()
    }
}
