//! Smooth implicit surfaces: their parts, how they blend, and their polygons.
//!
//! A field is negative inside and grows about as fast as distance near its surface. Transcendental functions come from
//! `libm`, so that every machine makes the same bytes.

use super::mesh::{Mesh, index};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// A field, callable from every core.
pub(crate) type Field<'a> = &'a (dyn Fn(DVec3) -> f64 + Sync);

/// Union of two fields with a fillet about `k` wide; twice continuously differentiable.
pub(crate) fn union(a: f64, b: f64, k: f64) -> f64 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * h * k / 6.0
}

/// What is in `a` and not in `b`, with a rounded rim about `k` wide.
pub(crate) fn difference(a: f64, b: f64, k: f64) -> f64 {
    -union(-a, b, k)
}

/// 0 below `from`, 1 above `to`, smooth between.
pub(crate) fn smooth_step(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A bell of height 1 and width `width`.
pub(crate) fn bell(x: f64, width: f64) -> f64 {
    libm::exp(-(x / width) * (x / width))
}

/// An ellipsoid's field.
pub(crate) fn ellipsoid(p: DVec3, center: DVec3, radii: DVec3) -> f64 {
    let q = (p - center) / radii;
    let length = q.length();
    if length < 1e-9 {
        return -radii.min_element();
    }
    length * (length - 1.0) / (q / radii).length()
}

/// A capsule whose radius goes from `ra` at `a` to `rb` at `b`.
pub(crate) fn tapered_capsule(p: DVec3, a: DVec3, b: DVec3, ra: f64, rb: f64) -> f64 {
    let axis = b - a;
    let t = ((p - a).dot(axis) / axis.length_squared()).clamp(0.0, 1.0);
    (p - a - axis * t).length() - (ra + (rb - ra) * t)
}

/// A curve through points, twice continuously differentiable, straight beyond its ends.
#[derive(Debug, Clone)]
pub(crate) struct Spline {
    points: Vec<(f64, f64)>,
    /// Second derivatives at the points.
    bends: Vec<f64>,
}

impl Spline {
    /// The natural cubic spline; `x` ascends.
    pub(crate) fn new(points: &[(f64, f64)]) -> Self {
        let n = points.len();
        let (mut bends, mut scratch) = (vec![0.0; n], vec![0.0; n]);
        for i in 1..n - 1 {
            let [(x0, y0), (x1, y1), (x2, y2)] = [points[i - 1], points[i], points[i + 1]];
            let ratio = (x1 - x0) / (x2 - x0);
            let pivot = ratio * bends[i - 1] + 2.0;
            bends[i] = (ratio - 1.0) / pivot;
            let jump = (y2 - y1) / (x2 - x1) - (y1 - y0) / (x1 - x0);
            scratch[i] = (6.0 * jump / (x2 - x0) - ratio * scratch[i - 1]) / pivot;
        }
        bends[n - 1] = 0.0;
        for i in (0..n - 1).rev() {
            bends[i] = bends[i] * bends[i + 1] + scratch[i];
        }
        Self { points: points.to_vec(), bends }
    }

    /// Its value at `x`.
    pub(crate) fn at(&self, x: f64) -> f64 {
        let last = self.points.len() - 2;
        let i = self.points[1..=last].iter().take_while(|p| p.0 < x).count();
        let [(x0, y0), (x1, y1)] = [self.points[i], self.points[i + 1]];
        let width = x1 - x0;
        let slope = (y1 - y0) / width;
        if x < x0 {
            return y0 + (x - x0) * (slope - width * self.bends[i + 1] / 6.0);
        }
        if x > x1 {
            return y1 + (x - x1) * (slope + width * self.bends[i] / 6.0);
        }
        let (a, b) = ((x1 - x) / width, (x - x0) / width);
        let bend = (a * a * a - a) * self.bends[i] + (b * b * b - b) * self.bends[i + 1];
        a * y0 + b * y1 + bend * width * width / 6.0
    }
}

/// A closed smooth curve in a plane and its signed distance, negative inside.
#[derive(Debug, Clone)]
pub(crate) struct Outline {
    points: Vec<DVec2>,
    min: DVec2,
    max: DVec2,
}

impl Outline {
    /// Through the given points (Catmull–Rom).
    pub(crate) fn through(points: &[(f64, f64)]) -> Self {
        const STEPS: u32 = 7;
        let n = points.len();
        let at = |i: usize| DVec2::from(points[i % n]);
        let mut fine = Vec::new();
        for i in 0..n {
            let [p0, p1, p2, p3] = [at(i + n - 1), at(i), at(i + 1), at(i + 2)];
            for step in 0..STEPS {
                let t = f64::from(step) / f64::from(STEPS);
                let linear = (p2 - p0) * t;
                let square = (p0 * 2.0 - p1 * 5.0 + p2 * 4.0 - p3) * (t * t);
                let cube = (p1 * 3.0 - p0 - p2 * 3.0 + p3) * (t * t * t);
                fine.push(p1 + (linear + square + cube) * 0.5);
            }
        }
        let min = fine.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let max = fine.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        Self { points: fine, min, max }
    }

    /// A lower bound of the distance, cheap.
    pub(crate) fn box_distance(&self, p: DVec2) -> f64 {
        (self.min - p).max(p - self.max).max(DVec2::ZERO).length()
    }

    /// The signed distance.
    pub(crate) fn distance(&self, p: DVec2) -> f64 {
        let mut nearest2 = f64::INFINITY;
        let mut inside = false;
        let mut a = self.points[self.points.len() - 1];
        for &b in &self.points {
            let (edge, from_a) = (b - a, p - a);
            let t = (from_a.dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
            nearest2 = nearest2.min((from_a - edge * t).length_squared());
            if (a.y > p.y) != (b.y > p.y) && p.x < a.x + edge.x * (p.y - a.y) / edge.y {
                inside = !inside;
            }
            a = b;
        }
        if inside { -nearest2.sqrt() } else { nearest2.sqrt() }
    }
}

/// A thin body along an outline: `across` is the signed distance from its middle sheet, `half_thickness` its half
/// thickness there; its edges are rounded.
pub(crate) fn sheet(outline: &Outline, p: DVec2, across: f64, half_thickness: f64) -> f64 {
    const EDGE: f64 = 1.6;
    let bound = outline.box_distance(p).max(across.abs() - half_thickness);
    if bound > 0.2 {
        return bound;
    }
    let beyond = (outline.distance(p) + half_thickness * EDGE).max(0.0) / EDGE;
    DVec2::new(beyond, across).length() - half_thickness
}

/// The outward gradient by central differences.
pub(crate) fn gradient(field: Field<'_>, p: DVec3) -> DVec3 {
    const STEP: f64 = 1e-4;
    let slope = |axis: DVec3| field(p + axis * STEP) - field(p - axis * STEP);
    DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)) / (2.0 * STEP)
}

/// The field's surface within a box as a closed mesh of triangles about `cell` long, with the field's own normals.
///
/// Surface nets: a vertex for each sheet of surface that crosses a cell, a quad for each crossed edge; then the vertices
/// are spread evenly and drawn onto the surface, which must keep clear of the box's walls.
pub(crate) fn polygonize(field: Field<'_>, min: DVec3, max: DVec3, cell: f64) -> Mesh {
    let size = ((max - min) / cell).ceil().as_uvec3();
    let corner = |x: u32, y: u32, z: u32| min + DVec3::new(f64::from(x), f64::from(y), f64::from(z)) * cell;
    let number = |x: u32, y: u32, z: u32| ((z * (size.y + 1) + y) * (size.x + 1) + x) as usize;
    let values = sample(field, min, cell, size);
    let value = |x: u32, y: u32, z: u32| values[number(x, y, z)];

    let mut positions = Vec::new();
    let mut vertex_of = BTreeMap::new();
    for z in 0..size.z {
        for y in 0..size.y {
            for x in 0..size.x {
                let at = |corner: usize| value(x + bit(corner, 0), y + bit(corner, 1), z + bit(corner, 2));
                let corners: [f64; 8] = std::array::from_fn(at);
                for (edges, offset) in sheets_in_cell(&corners) {
                    vertex_of.extend(edges.iter().map(|&edge| (((x, y, z), edge), index(positions.len()))));
                    positions.push(corner(x, y, z) + offset * cell);
                }
            }
        }
    }

    let mut triangles = Vec::new();
    for z in 1..size.z {
        for y in 1..size.y {
            for x in 1..size.x {
                let here = value(x, y, z);
                // The four cells around an edge, counter-clockwise seen against it, each with what it calls that edge.
                let mut quad = |there: f64, axis: usize| {
                    if (here < 0.0) == (there < 0.0) {
                        return;
                    }
                    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                    let mut quad = [(1, 1), (0, 1), (0, 0), (1, 0)].map(|(back_u, back_v)| {
                        let mut cell = [x, y, z];
                        cell[u] -= back_u;
                        cell[v] -= back_v;
                        let start = (back_u as usize) << u | (back_v as usize) << v;
                        vertex_of[&((cell[0], cell[1], cell[2]), (start, start | 1 << axis))]
                    });
                    if here >= 0.0 {
                        quad.reverse();
                    }
                    let [a, b, c, d] = quad;
                    // The shorter diagonal.
                    let length2 = |i: u32, j: u32| positions[i as usize].distance_squared(positions[j as usize]);
                    if length2(a, c) <= length2(b, d) {
                        triangles.extend([[a, b, c], [a, c, d]]);
                    } else {
                        triangles.extend([[a, b, d], [b, c, d]]);
                    }
                };
                quad(value(x + 1, y, z), 0);
                quad(value(x, y + 1, z), 1);
                quad(value(x, y, z + 1), 2);
            }
        }
    }

    settle(field, &mut positions, &triangles, cell);
    let normals = positions.par_iter().map(|&p| gradient(field, p).normalize()).collect();
    Mesh { positions, normals, triangles }
}

/// The field at every corner of the cells, x fastest. Where the middle of a block is far from the surface its value
/// stands for the block.
fn sample(field: Field<'_>, min: DVec3, cell: f64, size: glam::UVec3) -> Vec<f64> {
    const BLOCK: u32 = 6;
    let at = |x: u32, y: u32, z: u32| min + DVec3::new(f64::from(x), f64::from(y), f64::from(z)) * cell;
    let reach = cell * f64::from(BLOCK) * 1.5;
    let counts = size / BLOCK + 1;
    let blocks: Vec<f64> = (0..counts.x * counts.y * counts.z)
        .into_par_iter()
        .map(|i| {
            let block = glam::UVec3::new(i % counts.x, i / counts.x % counts.y, i / counts.x / counts.y) * BLOCK;
            field(at(block.x, block.y, block.z) + DVec3::splat(0.5 * cell * f64::from(BLOCK - 1)))
        })
        .collect();
    let corners = size + 1;
    (0..corners.x * corners.y * corners.z)
        .into_par_iter()
        .map(|i| {
            let (x, y, z) = (i % corners.x, i / corners.x % corners.y, i / corners.x / corners.y);
            let block = ((z / BLOCK * counts.y + y / BLOCK) * counts.x + x / BLOCK) as usize;
            if blocks[block].abs() > reach { blocks[block] } else { field(at(x, y, z)) }
        })
        .collect()
}

/// One axis of a cell's corner; corners are numbered x + 2y + 4z.
fn bit(corner: usize, axis: usize) -> u32 {
    index(corner >> axis & 1)
}

/// A cell's edge: its corners, the lower first.
type Edge = (usize, usize);

/// The separate sheets of surface that cross a cell: the edges that each crosses, and the mean of the points where it
/// does, in the unit cube. Where a face's corners alternate, the inner ones are kept apart; the cell beyond the face
/// does the same, so that every edge of the mesh has two triangles.
fn sheets_in_cell(corners: &[f64; 8]) -> Vec<(Vec<Edge>, DVec3)> {
    let inside = |corner: usize| corners[corner] < 0.0;
    let mut crossed: Vec<Edge> = Vec::new();
    for corner in 0..8 {
        for axis in 0..3 {
            let other = corner | 1 << axis;
            if corner < other && inside(corner) != inside(other) {
                crossed.push((corner, other));
            }
        }
    }
    let mut sheet_of: Vec<usize> = (0..crossed.len()).collect();
    let mut join = |a: Edge, b: Edge| {
        let number = |edge: Edge| crossed.iter().position(|&e| e == edge).map(|i| sheet_of[i]);
        if let (Some(a), Some(b)) = (number(a), number(b)) {
            sheet_of.iter_mut().filter(|s| **s == b).for_each(|s| *s = a);
        }
    };
    for axis in 0..3 {
        for side in 0..2 {
            let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
            let start = side << axis;
            let ring = [start, start | u, start | u | v, start | v];
            let edge = |i: usize| (ring[i % 4].min(ring[(i + 1) % 4]), ring[i % 4].max(ring[(i + 1) % 4]));
            let around: Vec<usize> = (0..4).filter(|&i| inside(ring[i]) != inside(ring[(i + 1) % 4])).collect();
            match around.len() {
                2 => join(edge(around[0]), edge(around[1])),
                4 => (0..4).filter(|&i| inside(ring[i])).for_each(|i| join(edge(i + 3), edge(i))),
                _ => {}
            }
        }
    }
    let mut names = sheet_of.clone();
    names.sort_unstable();
    names.dedup();
    names
        .iter()
        .map(|name| {
            let edges: Vec<Edge> = crossed.iter().zip(&sheet_of).filter(|(_, s)| *s == name).map(|(e, _)| *e).collect();
            let point = |c: usize| DVec3::new(f64::from(bit(c, 0)), f64::from(bit(c, 1)), f64::from(bit(c, 2)));
            let crossing = |&(a, b): &Edge| point(a).lerp(point(b), corners[a] / (corners[a] - corners[b]));
            let sum: DVec3 = edges.iter().map(crossing).sum();
            let count = f64::from(index(edges.len()));
            (edges, sum / count)
        })
        .collect()
}

/// Spreads vertices evenly along the surface and draws them onto it.
fn settle(field: Field<'_>, positions: &mut [DVec3], triangles: &[[u32; 3]], cell: f64) {
    const ROUNDS: u32 = 4;
    let mut neighbours = vec![Vec::new(); positions.len()];
    for t in triangles {
        for corner in 0..3 {
            neighbours[t[corner] as usize].push(t[(corner + 1) % 3]);
        }
    }
    // The last rounds only draw onto the surface.
    for round in 0..ROUNDS + 2 {
        let old = positions.to_vec();
        positions.par_iter_mut().enumerate().for_each(|(i, position)| {
            let slope = gradient(field, *position);
            let length2 = slope.length_squared().max(1e-6);
            if round < ROUNDS {
                let around: DVec3 = neighbours[i].iter().map(|&j| old[j as usize]).sum();
                let pull = around / f64::from(index(neighbours[i].len())) - old[i];
                *position += (pull - slope * (pull.dot(slope) / length2)) * 0.6;
            }
            let step = slope * (field(*position) / length2);
            *position -= step.clamp_length_max(cell * 0.5);
        });
    }
}
