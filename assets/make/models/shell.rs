//! A bowl without thickness and with a jagged rim: an open surface, which leaves rays in doubt of where they are.

use super::glb::{Glass, Glb};
use super::mesh::{Mesh, index};
use glam::DVec3;
use serde_json::json;
use std::f64::consts::TAU;

const AROUND: u32 = 192;
const DOWN: u32 = 64;

pub(crate) fn make() -> Vec<u8> {
    let mut glb = Glb::default();
    let glass = glb.glass(&Glass { name: "glass", ior: 1.3, color: [0.85, 0.45, 0.55], distance: 0.9 });
    let primitive = glb.primitive(&bowl(), glass, None);
    glb.meshes.push(json!({ "name": "shell", "primitives": [primitive] }));
    glb.nodes.push(json!({ "name": "shell", "mesh": 0 }));
    glb.bytes(&[0])
}

/// Most of a unit sphere: rings from the pole below to the torn rim above.
fn bowl() -> Mesh {
    let mut bowl = Mesh::default();
    bowl.positions.push(DVec3::NEG_Y);
    for ring in 1..=DOWN {
        for step in 0..AROUND {
            let around = TAU * f64::from(step) / f64::from(AROUND);
            let polar = rim(around) * f64::from(ring) / f64::from(DOWN);
            let (sin, cos) = (libm::sin(polar), libm::cos(polar));
            bowl.positions.push(DVec3::new(sin * libm::cos(around), -cos, sin * libm::sin(around)));
        }
    }
    let at = |ring: u32, step: u32| 1 + (ring - 1) * AROUND + step % AROUND;
    for step in 0..AROUND {
        bowl.triangles.push([0, at(1, step), at(1, step + 1)]);
        for ring in 1..DOWN {
            let [a, b] = [at(ring, step), at(ring, step + 1)];
            let [c, d] = [at(ring + 1, step + 1), at(ring + 1, step)];
            bowl.triangles.extend([[a, d, c], [a, c, b]]);
        }
    }
    debug_assert_eq!(bowl.positions.len(), index(1 + (DOWN * AROUND) as usize) as usize);
    bowl.normals = bowl.positions.clone();
    bowl
}

/// The angle from the pole below at which the surface ends: teeth of uneven height, and a bite out of one side.
fn rim(around: f64) -> f64 {
    let saw = |teeth: f64, offset: f64| {
        let x = (around / TAU * teeth + offset).fract();
        (2.0 * x - 1.0).abs()
    };
    let bite = libm::exp(-2.5 * (1.0 - libm::cos(around - 0.9)));
    2.15 + 0.22 * saw(9.0, 0.0) + 0.13 * saw(14.0, 0.4) - 0.75 * bite
}
