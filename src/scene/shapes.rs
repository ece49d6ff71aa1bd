//! Built-in shapes: meshes like every model, with the true surface's normals where it is smooth.
//!
//! Triangles wind counter-clockwise seen from outside. Shapes are closed in the strict sense: vertices that are one
//! point of the surface have the same position to the bit, also along seams of the texture coordinates.

use super::description::Shape;
use super::geometry::{Geometry, Influence, MatrixSource, Node, Part, RestVertex};
use super::material::Material;
use glam::{DVec3, Quat, Vec3};
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// Makes a shape's triangles: one part, one node, named after the shape.
///
/// Counts out of range are brought into it (rings and segments: 3 to 2048, subdivisions: at most 9), so that every
/// shape can be made. A plane has no triangles: it is met analytically ([`Part::plane_half`]).
#[must_use]
pub fn shape(shape: &Shape) -> Geometry {
    let mut mesh = Mesh::default();
    let (name, plane_half) = match *shape {
        Shape::Sphere { radius, rings } => {
            mesh.sphere(f64::from(radius), rings.clamp(3, 2048));
            ("sphere", None)
        }
        Shape::Icosphere { radius, subdivisions } => {
            mesh.icosphere(f64::from(radius), subdivisions.min(9));
            ("icosphere", None)
        }
        Shape::Torus { radius, tube, segments } => {
            mesh.torus(f64::from(radius), f64::from(tube), segments.clamp(3, 2048));
            ("torus", None)
        }
        Shape::Box { min, max } => {
            mesh.cuboid(min.min(max), min.max(max));
            ("box", None)
        }
        Shape::Plane { size } => ("plane", Some(size.abs() * 0.5)),
    };
    mesh.into_geometry(name, plane_half)
}

/// Triangles in the making: one part, one node.
#[derive(Debug, Default)]
pub(super) struct Mesh {
    pub(super) vertices: Vec<RestVertex>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Mesh {
    pub(super) fn add(&mut self, position: DVec3, normal: DVec3, [u, v]: [f64; 2]) -> u32 {
        self.vertices.push(RestVertex {
            position: position.as_vec3(),
            u: single(u),
            normal: normal.as_vec3(),
            v: single(v),
        });
        index(self.vertices.len() - 1)
    }

    /// Two triangles over the corners `a b c d`, counter-clockwise from outside.
    fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        self.triangles.push([a, b, c]);
        self.triangles.push([a, c, d]);
    }

    /// Latitudes and longitudes: `rings` bands from pole to pole, twice as many segments around.
    fn sphere(&mut self, radius: f64, rings: u32) {
        let segments = rings * 2;
        for ring in 0..=rings {
            let v = f64::from(ring) / f64::from(rings);
            // The poles are exact, so that all their vertices are one point.
            let (sin_polar, cos_polar) = match ring {
                0 => (0.0, 1.0),
                r if r == rings => (0.0, -1.0),
                _ => (PI * v).sin_cos(),
            };
            for segment in 0..=segments {
                let (sin, cos) = (TAU * f64::from(segment % segments) / f64::from(segments)).sin_cos();
                let normal = DVec3::new(sin_polar * cos, cos_polar, -sin_polar * sin);
                self.add(normal * radius, normal, [f64::from(segment) / f64::from(segments), v]);
            }
        }
        let at = |ring: u32, segment: u32| ring * (segments + 1) + segment;
        for ring in 0..rings {
            for segment in 0..segments {
                let [a, b] = [at(ring, segment), at(ring + 1, segment)];
                let [c, d] = [at(ring + 1, segment + 1), at(ring, segment + 1)];
                if ring + 1 < rings {
                    self.triangles.push([a, b, c]);
                }
                if ring > 0 {
                    self.triangles.push([a, c, d]);
                }
            }
        }
    }

    /// An icosahedron whose triangles are split in four `subdivisions` times.
    fn icosphere(&mut self, radius: f64, subdivisions: u32) {
        let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
        let mut points: Vec<DVec3> = Vec::new();
        for axis in 0..3 {
            for (one, long) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
                let mut p = [0.0; 3];
                p[axis] = one;
                p[(axis + 1) % 3] = long;
                points.push(DVec3::from_array(p).normalize());
            }
        }
        let mut triangles = icosahedron_triangles(&points);
        for _ in 0..subdivisions {
            let mut middles: HashMap<(u32, u32), u32> = HashMap::with_capacity(triangles.len() * 3 / 2);
            let mut middle = |a: u32, b: u32| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let (a, b) = (a.min(b), a.max(b));
                    points.push((points[a as usize] + points[b as usize]).normalize());
                    index(points.len() - 1)
                })
            };
            let mut finer = Vec::with_capacity(triangles.len() * 4);
            for [a, b, c] in triangles {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
            }
            triangles = finer;
        }
        for normal in points {
            let u = 0.5 - normal.z.atan2(normal.x) / TAU;
            self.add(normal * radius, normal, [u, normal.y.clamp(-1.0, 1.0).acos() / PI]);
        }
        self.triangles = triangles;
    }

    /// Around the y axis.
    fn torus(&mut self, radius: f64, tube: f64, segments: u32) {
        let sides = (segments / 2).max(3);
        for segment in 0..=segments {
            let (sin_around, cos_around) = (TAU * f64::from(segment % segments) / f64::from(segments)).sin_cos();
            let outward = DVec3::new(cos_around, 0.0, -sin_around);
            for side in 0..=sides {
                let (sin, cos) = (TAU * f64::from(side % sides) / f64::from(sides)).sin_cos();
                let normal = outward * cos + DVec3::Y * sin;
                let uv = [f64::from(segment) / f64::from(segments), f64::from(side) / f64::from(sides)];
                self.add(outward * radius + normal * tube, normal, uv);
            }
        }
        let at = |segment: u32, side: u32| segment * (sides + 1) + side;
        for segment in 0..segments {
            for side in 0..sides {
                self.quad([at(segment, side), at(segment + 1, side), at(segment + 1, side + 1), at(segment, side + 1)]);
            }
        }
    }

    /// Six flat faces with vertices of their own.
    fn cuboid(&mut self, min: Vec3, max: Vec3) {
        let (min, max) = (min.as_dvec3(), max.as_dvec3());
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let mut normal = [0.0; 3];
                normal[axis] = sign;
                let (second, third) = ((axis + 1) % 3, (axis + 2) % 3);
                let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[s, t]| {
                    // Seen from the low side the two other axes turn the other way round.
                    let (s, t) = if sign > 0.0 { (s, t) } else { (t, s) };
                    let mut p = [0.0; 3];
                    p[axis] = if sign > 0.0 { max[axis] } else { min[axis] };
                    p[second] = if s > 0.5 { max[second] } else { min[second] };
                    p[third] = if t > 0.5 { max[third] } else { min[third] };
                    self.add(DVec3::from_array(p), DVec3::from_array(normal), [s, t])
                });
                self.quad(corners);
            }
        }
    }

    pub(super) fn into_geometry(self, name: &str, plane_half: Option<f32>) -> Geometry {
        let still = Influence { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] };
        let mut material = Material::default();
        if plane_half.is_some() {
            material.opaque = true;
            material.base_color = Vec3::splat(0.8);
        }
        let mut geometry = Geometry {
            influences: vec![still; self.vertices.len()],
            parts: vec![Part {
                name: name.to_owned(),
                vertices: 0..index(self.vertices.len()),
                triangles: 0..index(self.triangles.len()),
                morph_first: 0,
                morph_count: 0,
                node: 0,
                flat: false,
                vertex_colors: false,
                material,
                variant_materials: Vec::new(),
                plane_half,
            }],
            vertices: self.vertices,
            triangles: self.triangles,
            nodes: vec![Node {
                name: name.to_owned(),
                parent: None,
                translation: Vec3::ZERO,
                rotation: Quat::IDENTITY,
                scale: Vec3::ONE,
                weights: Vec::new(),
            }],
            matrices: vec![MatrixSource::Node(0)],
            ..Geometry::default()
        };
        geometry.measure();
        geometry
    }
}

/// The 20 triples of the 12 corners that are neighbours of each other, wound outwards.
fn icosahedron_triangles(points: &[DVec3]) -> Vec<[u32; 3]> {
    // Neighbours are 63.4° apart, all others 116.6° or more.
    let near = |a: usize, b: usize| points[a].dot(points[b]) > 0.0;
    let mut triangles = Vec::with_capacity(20);
    for a in 0..points.len() {
        for b in a + 1..points.len() {
            for c in b + 1..points.len() {
                if near(a, b) && near(b, c) && near(c, a) {
                    let outward = points[a].dot(points[b].cross(points[c])) > 0.0;
                    let [b, c] = if outward { [b, c] } else { [c, b] };
                    triangles.push([index(a), index(b), index(c)]);
                }
            }
        }
    }
    triangles
}

#[expect(clippy::cast_possible_truncation, reason = "shapes have far fewer than 2³² vertices: counts are clamped")]
fn index(n: usize) -> u32 {
    n as u32
}

#[expect(clippy::cast_possible_truncation, reason = "rounding to single precision is meant")]
fn single(x: f64) -> f32 {
    x as f32
}
