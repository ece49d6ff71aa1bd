//! A ball of clear glass, flat at its foot, with an angel of another glass inside (after CL Fig. 10).

use super::field::{Outline, difference, ellipsoid, polygonize, sheet, smooth_step, tapered_capsule, union};
use super::glb::{Glass, Glb};
use super::mesh::Mesh;
use glam::{DVec2, DVec3};
use serde_json::json;

/// Height of the flat foot.
const FOOT: f64 = -0.88;

pub(crate) fn make() -> Vec<u8> {
    let angel = Angel::new();
    let figure = polygonize(&|p| angel.field(p), DVec3::new(-0.66, -0.66, -0.42), DVec3::new(0.66, 0.76, 0.36), 0.0135);
    let mut glb = Glb::default();
    let clear = glb.glass(&Glass { name: "ball", ior: 1.45, color: [0.86, 0.95, 0.97], distance: 2.0 });
    let ruby = glb.glass(&Glass { name: "figure", ior: 1.7, color: [0.90, 0.30, 0.16], distance: 0.22 });
    for (name, mesh, material) in [("ball", ball(), clear), ("figure", figure, ruby)] {
        let primitive = glb.primitive(&mesh, material, None);
        glb.meshes.push(json!({ "name": name, "primitives": [primitive] }));
        glb.nodes.push(json!({ "name": name, "mesh": glb.meshes.len() - 1 }));
    }
    glb.bytes(&[0, 1])
}

/// The unit ball, cut flat below with a soft rim: the icosphere drawn along its radii onto that surface.
fn ball() -> Mesh {
    let field = |p: DVec3| difference(p.length() - 1.0, p.y - FOOT, 0.10);
    let mut ball = Mesh::icosphere(5);
    for position in &mut ball.positions {
        let direction = *position;
        let (mut inside, mut outside) = (0.5, 1.1);
        for _ in 0..50 {
            let middle = 0.5 * (inside + outside);
            if field(direction * middle) < 0.0 { inside = middle } else { outside = middle }
        }
        *position = direction * inside;
    }
    ball.normals = ball.positions.iter().map(|&p| super::field::gradient(&field, p).normalize()).collect();
    ball
}

/// Robe, head with a halo, folded hands and two wings.
struct Angel {
    wing: Outline,
}

impl Angel {
    fn new() -> Self {
        Self {
            wing: Outline::through(&[
                (-0.04, -0.10),
                (0.10, 0.02),
                (0.20, 0.18),
                (0.32, 0.31),
                (0.45, 0.345),
                (0.50, 0.28),
                (0.47, 0.14),
                (0.40, 0.0),
                (0.30, -0.13),
                (0.17, -0.245),
                (0.03, -0.27),
                (-0.05, -0.20),
            ]),
        }
    }

    fn field(&self, p: DVec3) -> f64 {
        let aside = DVec3::new(p.x.abs(), p.y, p.z);
        let mut f = Self::robe(p);
        // Shoulders, arms that meet in front, neck and head.
        f = union(f, ellipsoid(p, DVec3::new(0.0, 0.18, 0.0), DVec3::new(0.135, 0.10, 0.085)), 0.08);
        let (elbow, hands) = (DVec3::new(0.14, 0.04, 0.09), DVec3::new(0.015, 0.115, 0.19));
        f = union(f, tapered_capsule(aside, DVec3::new(0.12, 0.19, 0.01), elbow, 0.050, 0.045), 0.04);
        f = union(f, tapered_capsule(aside, elbow, hands, 0.045, 0.032), 0.035);
        f = union(f, tapered_capsule(p, DVec3::new(0.0, 0.22, 0.0), DVec3::new(0.0, 0.34, 0.005), 0.045, 0.045), 0.05);
        f = union(f, ellipsoid(p, DVec3::new(0.0, 0.395, 0.015), DVec3::new(0.088, 0.105, 0.095)), 0.03);
        f = union(f, self.wings(aside), 0.06);
        f.min(Self::halo(p))
    }

    /// A bell with folds that deepen towards the hem.
    fn robe(p: DVec3) -> f64 {
        let t = smooth_step(0.22, -0.55, p.y);
        let angle = libm::atan2(p.x, p.z);
        let folds = 1.0 + 0.055 * t * libm::cos(angle * 9.0);
        let radius = (0.085 + 0.205 * t) * folds;
        let around = DVec2::new(p.x, p.z * 1.15).length() - radius;
        let capped = difference(around * 0.92, -(p.y - 0.24), 0.06);
        difference(capped, p.y + 0.55, 0.05)
    }

    /// Swept back from the shoulder blades, feathers as shallow rays.
    fn wings(&self, p: DVec3) -> f64 {
        let from = p - DVec3::new(0.03, 0.16, -0.07);
        // The sheet turns backwards away from the body.
        let (sin, cos) = (0.48, (1.0_f64 - 0.48 * 0.48).sqrt());
        let (along, across) = (from.x * cos - from.z * sin, from.x * sin + from.z * cos);
        let q = DVec2::new(along, from.y);
        let angle = libm::atan2(q.y - 0.30, q.x + 0.20);
        let rays = 1.0 + 0.22 * smooth_step(0.05, 0.25, along) * libm::cos(angle * 22.0);
        sheet(&self.wing, q, across + 0.25 * along * along, 0.034 * rays)
    }

    fn halo(p: DVec3) -> f64 {
        let from = p - DVec3::new(0.0, 0.56, -0.01);
        let tilted = DVec3::new(from.x, from.y * 0.97 - from.z * 0.24, from.y * 0.24 + from.z * 0.97);
        DVec2::new(DVec2::new(tilted.x, tilted.z).length() - 0.105, tilted.y).length() - 0.024
    }
}
