//! Cuts the holes of an alpha mask out of a mesh, so that voxels, shadows and rays all meet the same leaf.
//!
//! A triangle that a hole's edge crosses is split until its pieces are small; the last ones are cut straight
//! along the edge. It costs triangles once, and nothing a frame.

use super::primitive::{Mesh, Room};
use crate::scene::geometry::{Influence, Morph, Sampling, Texture, Wrap};
use glam::{IVec2, Vec2};
use std::collections::HashMap;

/// How often a triangle is split in four.
const MAX_SPLITS: u32 = 5;
/// Pieces no wider than this share of the picture are not split.
const LEAST_SHARE: f32 = 1.0 / 32.0;
/// Nor those of no more than this, texels.
const LEAST_TEXELS: f32 = 4.0;
/// The most triangles that a mesh may have after its holes are cut, unless it had more before.
const MAX_CUT: usize = 1 << 19;

/// Where a picture has holes.
pub(super) struct Mask {
    size: IVec2,
    sampling: Sampling,
    /// Holes above and left of each corner of a texel, row by row.
    sums: Vec<u32>,
}

/// What of a stretch of a picture is holes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Holes {
    None,
    Some,
    All,
}

impl Mask {
    /// The holes of a picture, if it has any.
    pub(super) fn of(picture: &Texture) -> Option<Self> {
        let (width, height) = (picture.width as usize, picture.height as usize);
        let mut sums = vec![0_u32; (width + 1) * (height + 1)];
        for y in 0..height {
            let mut row = 0;
            for x in 0..width {
                row += u32::from(picture.rgba8[4 * (y * width + x) + 3] < 128);
                sums[(y + 1) * (width + 1) + x + 1] = sums[y * (width + 1) + x + 1] + row;
            }
        }
        let size = IVec2::new(i32::try_from(width).ok()?, i32::try_from(height).ok()?);
        (sums.last() != Some(&0)).then_some(Self { size, sampling: picture.sampling, sums })
    }

    /// How many texels from `from` up to before `to` are holes.
    fn count(&self, from: IVec2, to: IVec2) -> i64 {
        let at = |x: i32, y: i32| {
            let place = i64::from(y) * (i64::from(self.size.x) + 1) + i64::from(x);
            usize::try_from(place).ok().and_then(|i| self.sums.get(i)).map_or(0, |n| i64::from(*n))
        };
        at(to.x, to.y) - at(from.x, to.y) - at(to.x, from.y) + at(from.x, from.y)
    }

    /// 1 where the picture is solid, 0 in a hole, blended between texels.
    fn solid_at(&self, uv: Vec2) -> f32 {
        let at = self.texels(uv) - 0.5;
        let (first, f) = (at.floor(), at - at.floor());
        let texel = |dx: f32, dy: f32| {
            let at = first + Vec2::new(dx, dy);
            let from = IVec2::new(
                wrapped(at.x, self.size.x, self.sampling.wrap[0]),
                wrapped(at.y, self.size.y, self.sampling.wrap[1]),
            );
            if self.count(from, from + 1) == 0 { 1.0 } else { 0.0 }
        };
        let row = |dy: f32| texel(0.0, dy) * (1.0 - f.x) + texel(1.0, dy) * f.x;
        row(0.0) * (1.0 - f.y) + row(1.0) * f.y
    }

    fn texels(&self, uv: Vec2) -> Vec2 {
        uv * self.size.as_vec2()
    }

    /// What a triangle's surroundings hold. Beyond the edges of a picture that does not repeat nothing is known.
    fn holes_around(&self, corners: [Vec2; 3]) -> Holes {
        let [a, b, c] = corners.map(|uv| self.texels(uv) - 0.5);
        let (mut low, mut high) = (a.min(b).min(c).floor(), a.max(b).max(c).floor() + 2.0);
        let size = self.size.as_vec2();
        for axis in 0..2 {
            if self.sampling.wrap[axis] == Wrap::Repeat {
                let tile = (low[axis] / size[axis]).floor() * size[axis];
                (low[axis], high[axis]) = (low[axis] - tile, high[axis] - tile);
            }
        }
        if low.min_element() < 0.0 || high.cmpgt(size).any() {
            return Holes::Some;
        }
        let (low, high) = (low.as_ivec2(), high.as_ivec2());
        let area = i64::from(high.x - low.x) * i64::from(high.y - low.y);
        match self.count(low, high) {
            0 => Holes::None,
            n if n == area => Holes::All,
            _ => Holes::Some,
        }
    }
}

/// The texel that stands at place `x` of an endless row.
#[expect(clippy::cast_possible_truncation, reason = "within the picture's size")]
fn wrapped(x: f32, size: i32, wrap: Wrap) -> i32 {
    let whole = size as f32;
    let at = match wrap {
        Wrap::Repeat => x.rem_euclid(whole),
        Wrap::Clamp => x,
        Wrap::Mirror => {
            let at = x.rem_euclid(2.0 * whole);
            if at < whole { at } else { 2.0 * whole - 1.0 - at }
        }
    };
    (at as i32).clamp(0, size - 1)
}

impl Mesh {
    /// Cuts the holes out, as far as there is room.
    pub(super) fn cut_out(&mut self, mask: &Mask, room: Room) {
        let most_triangles = room.triangles.min(MAX_CUT.max(self.triangles.len()));
        let most_vertices = room.vertices.min(room.morphs / self.targets.max(1));
        let least = (mask.size.max_element() as f32 * LEAST_SHARE).max(LEAST_TEXELS);
        let old_count = self.vertices.len();
        let mut cutter = Cutter { mesh: self, known: HashMap::new(), added: Vec::new() };
        let mut kept: Vec<[u32; 3]> = Vec::new();
        let mut left: Vec<([u32; 3], u32)> = cutter.mesh.triangles.iter().map(|&t| (t, 0)).collect();
        while let Some((triangle, splits)) = left.pop() {
            // A piece that is left over makes two more of itself at most, with two new corners.
            let crowded =
                kept.len() + left.len() + 4 > most_triangles || cutter.mesh.vertices.len() + 3 > most_vertices;
            let uv = triangle.map(|v| cutter.uv(v));
            match mask.holes_around(uv) {
                Holes::None => kept.push(triangle),
                Holes::All => {}
                Holes::Some if crowded => kept.push(triangle),
                Holes::Some => {
                    let [a, b, c] = uv.map(|uv| mask.texels(uv));
                    let width = a.distance(b).max(b.distance(c)).max(c.distance(a));
                    if splits < MAX_SPLITS && width > least {
                        left.extend(cutter.split(triangle).map(|t| (t, splits + 1)));
                    } else {
                        cutter.cut(triangle, mask, &mut kept);
                    }
                }
            }
        }
        let added = cutter.added;
        kept.reverse();
        self.triangles = kept;
        self.extend_morphs(old_count, &added);
    }

    /// Gives the vertices after the first `count` their displacements: each lies between two before it.
    fn extend_morphs(&mut self, count: usize, added: &[(u32, u32, f32)]) {
        let mut morphs: Vec<Morph> = Vec::with_capacity(self.targets * (count + added.len()));
        for target in 0..self.targets {
            let first = morphs.len();
            morphs.extend(&self.morphs[target * count..(target + 1) * count]);
            for &(a, b, t) in added {
                let (a, b) = (morphs[first + a as usize], morphs[first + b as usize]);
                let (position, normal) = (a.position.lerp(b.position, t), a.normal.lerp(b.normal, t));
                morphs.push(Morph { position, normal, ..a });
            }
        }
        self.morphs = morphs;
    }
}

/// Makes new vertices between those that a mesh has.
struct Cutter<'a> {
    mesh: &'a mut Mesh,
    /// By its neighbours, the lesser first, and whether it is the middle: neighbouring triangles share it.
    known: HashMap<(u32, u32, bool), u32>,
    /// Between which two vertices each new one lies, and how far from the first.
    added: Vec<(u32, u32, f32)>,
}

impl Cutter<'_> {
    fn uv(&self, v: u32) -> Vec2 {
        let vertex = &self.mesh.vertices[v as usize];
        Vec2::new(vertex.u, vertex.v)
    }

    /// The vertex at share `t` of the way from `a` to `b`; `None` is the middle.
    fn between(&mut self, a: u32, b: u32, t: Option<f32>) -> u32 {
        let (a, b, t) = if a < b { (a, b, t) } else { (b, a, t.map(|t| 1.0 - t)) };
        let key = (a, b, t.is_none());
        if let Some(&known) = self.known.get(&key) {
            return known;
        }
        let t = t.unwrap_or(0.5);
        let mesh = &mut *self.mesh;
        let (va, vb) = (mesh.vertices[a as usize], mesh.vertices[b as usize]);
        let mut new = va;
        new.position = va.position.lerp(vb.position, t);
        new.normal = va.normal.lerp(vb.normal, t).normalize_or_zero();
        (new.u, new.v) = (va.u + (vb.u - va.u) * t, va.v + (vb.v - va.v) * t);
        let influence = blended(&mesh.influences[a as usize], &mesh.influences[b as usize], t);
        // There are fewer than 2²⁴.
        let number = u32::try_from(mesh.vertices.len()).unwrap_or(u32::MAX);
        mesh.vertices.push(new);
        mesh.influences.push(influence);
        self.added.push((a, b, t));
        self.known.insert(key, number);
        number
    }

    fn split(&mut self, [a, b, c]: [u32; 3]) -> [[u32; 3]; 4] {
        let (ab, bc, ca) = (self.between(a, b, None), self.between(b, c, None), self.between(c, a, None));
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    }

    /// Keeps what of a triangle lies on the solid side of a straight edge.
    fn cut(&mut self, triangle: [u32; 3], mask: &Mask, kept: &mut Vec<[u32; 3]>) {
        let solid = triangle.map(|v| mask.solid_at(self.uv(v)) - 0.5);
        let mut outline = Vec::with_capacity(4);
        for i in 0..3 {
            let (next, from, to) = ((i + 1) % 3, solid[i], solid[(i + 1) % 3]);
            if from >= 0.0 {
                outline.push(triangle[i]);
            }
            if (from >= 0.0) != (to >= 0.0) {
                outline.push(self.between(triangle[i], triangle[next], Some(from / (from - to))));
            }
        }
        for i in 2..outline.len() {
            kept.push([outline[0], outline[i - 1], outline[i]]);
        }
    }
}

/// What moves a vertex at share `t` of the way between two: the four strongest of both.
fn blended(a: &Influence, b: &Influence, t: f32) -> Influence {
    let mut pairs: Vec<(u32, f32)> = Vec::with_capacity(8);
    for (influence, share) in [(a, 1.0 - t), (b, t)] {
        for (&joint, &weight) in influence.joints.iter().zip(&influence.weights).filter(|(_, w)| **w > 0.0) {
            match pairs.iter_mut().find(|(known, _)| *known == joint) {
                Some((_, sum)) => *sum += weight * share,
                None => pairs.push((joint, weight * share)),
            }
        }
    }
    pairs.sort_by(|a, b| b.1.total_cmp(&a.1));
    pairs.truncate(4);
    let sum: f32 = pairs.iter().map(|p| p.1).sum();
    let first = pairs.first().map_or(a.joints[0], |p| p.0);
    let mut made = Influence { joints: [first; 4], weights: [0.0; 4] };
    for (i, (joint, weight)) in pairs.into_iter().enumerate() {
        (made.joints[i], made.weights[i]) = (joint, weight / sum);
    }
    made
}
