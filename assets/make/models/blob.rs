//! A blob that breathes: a sphere with three morph targets, normals and all, on cubic-spline weights.

use super::glb::{Glass, Glb};
use super::mesh::Mesh;
use glam::DVec3;
use serde_json::json;
use std::f64::consts::TAU;

const BREATH_SECS: f64 = 4.0;

/// A shape over the unit sphere: where the point in a direction lies.
type Shape = fn(DVec3) -> DVec3;

const TARGETS: [(&str, Shape); 3] = [("drop", drop_shape), ("clover", clover), ("swirl", swirl)];

pub(crate) fn make() -> Vec<u8> {
    let sphere = Mesh::icosphere(5);
    let rest = shaped(&sphere, resting);
    let mut glb = Glb::default();
    let glass = glb.glass(&Glass { name: "glass", ior: 1.45, color: [0.30, 0.80, 0.72], distance: 1.5 });
    let mut primitive = glb.primitive(&rest, glass, None);
    let targets: Vec<_> = TARGETS
        .iter()
        .map(|(_, shape)| {
            let target = shaped(&sphere, *shape);
            let difference = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| *a - *b).collect::<Vec<_>>();
            glb.target(&difference(&target.positions, &rest.positions), &difference(&target.normals, &rest.normals))
        })
        .collect();
    primitive["targets"] = json!(targets);
    let names: Vec<&str> = TARGETS.iter().map(|(name, _)| *name).collect();
    glb.meshes.push(json!({
        "name": "blob", "primitives": [primitive], "weights": [0, 0, 0], "extras": { "targetNames": names },
    }));
    glb.nodes.push(json!({ "name": "blob", "mesh": 0 }));
    breathe(&mut glb);
    glb.bytes(&[0])
}

/// Each target swells in turn; tangents are the curve's own, so that the loop has no seam.
fn breathe(glb: &mut Glb) {
    const STEPS: u32 = 12;
    let times: Vec<f64> = (0..=STEPS).map(|i| BREATH_SECS * f64::from(i) / f64::from(STEPS)).collect();
    let rate = TAU / BREATH_SECS;
    let mut values = Vec::new();
    for t in &times {
        // sin² of half the phase rises and falls once a breath.
        let weight = |lag: f64| (0.5 - 0.5 * libm::cos(rate * t - lag), 0.5 * rate * libm::sin(rate * t - lag));
        let weights = [0.0, TAU / 3.0, 2.0 * TAU / 3.0].map(weight);
        values.extend(weights.map(|(_, slope)| slope));
        values.extend(weights.map(|(value, _)| value));
        values.extend(weights.map(|(_, slope)| slope));
    }
    let (input, output) = glb.keys(&times, &values, "SCALAR");
    glb.animations.push(json!({
        "name": "Breathe",
        "samplers": [{ "input": input, "output": output, "interpolation": "CUBICSPLINE" }],
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "weights" } }],
    }));
}

/// A sphere's mesh over a shape, with the shape's own normals.
fn shaped(sphere: &Mesh, shape: Shape) -> Mesh {
    const STEP: f64 = 1e-4;
    let normal = |d: DVec3| {
        let (u, v) = d.any_orthonormal_pair();
        let slope = |axis: DVec3| shape((d + axis * STEP).normalize()) - shape((d - axis * STEP).normalize());
        slope(u).cross(slope(v)).normalize()
    };
    Mesh {
        positions: sphere.positions.iter().map(|&d| shape(d)).collect(),
        normals: sphere.positions.iter().map(|&d| normal(d)).collect(),
        triangles: sphere.triangles.clone(),
    }
}

fn resting(d: DVec3) -> DVec3 {
    d * (1.0 + 0.06 * libm::sin(2.0 * d.y + 1.0) + 0.04 * libm::cos(3.0 * d.x - d.z))
}

/// Drawn upwards to a rounded tip.
fn drop_shape(d: DVec3) -> DVec3 {
    let rise = 0.5 + 0.5 * d.y;
    let waist = 1.0 - 0.35 * rise * rise;
    DVec3::new(d.x * waist, d.y * 0.85 + 0.75 * rise * rise * rise * rise, d.z * waist)
}

/// Three lobes about the axis.
fn clover(d: DVec3) -> DVec3 {
    let lobes = d.x * d.x * d.x - 3.0 * d.x * d.z * d.z;
    let out = 1.02 + 0.42 * lobes;
    DVec3::new(d.x * out, d.y * 0.78, d.z * out)
}

/// Pressed together and turned about the axis by height.
fn swirl(d: DVec3) -> DVec3 {
    let turn = 1.3 * d.y;
    let (x, z) = (d.x * 1.18, d.z * 0.72);
    DVec3::new(
        x * libm::cos(turn) - z * libm::sin(turn),
        d.y * 1.12 + 0.12 * libm::sin(3.0 * d.x),
        x * libm::sin(turn) + z * libm::cos(turn),
    )
}
