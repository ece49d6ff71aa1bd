//! A glass fish that swims: one closed body with its fins grown into it, a spine of twelve joints, two for the pectoral
//! fins, and eyes of dark opaque glass.
//!
//! It looks along +x, y is up, about 2.5 units long.

use super::field::{Outline, Spline, bell, polygonize, sheet, smooth_step, union};
use super::glb::{Bindings, Glass, Glb};
use super::mesh::{Mesh, index};
use glam::{DMat4, DVec2, DVec3};
use serde_json::json;
use std::f64::consts::TAU;

const SPINE_JOINTS: u16 = 12;
/// x of the first joint.
const HEAD_X: f64 = 0.80;
/// Between joints.
const BONE: f64 = 0.185;
const SWIM_SECS: f64 = 2.0;
const EYE: DVec3 = DVec3::new(0.70, 0.055, 0.158);

pub(crate) fn make() -> Vec<u8> {
    let shape = Shape::new();
    let body = polygonize(&|p| shape.field(p), DVec3::new(-1.85, -0.80, -0.80), DVec3::new(1.1, 0.85, 0.80), 0.0195);
    let bindings: Bindings = body.positions.iter().map(|&p| shape.binding(p)).collect();
    let eyes = eyes();
    let eye_bindings: Bindings = eyes.positions.iter().map(|_| spine_binding(EYE.x, None)).collect();

    let mut glb = Glb::default();
    let glass = glb.glass(&Glass { name: "glass", ior: 1.5, color: [0.95, 0.52, 0.16], distance: 0.45 });
    let dark = glb.opaque("eyes", [0.015, 0.012, 0.012], 0.25);
    let primitives = [glb.primitive(&body, glass, Some(&bindings)), glb.primitive(&eyes, dark, Some(&eye_bindings))];
    glb.meshes.push(json!({ "name": "fish", "primitives": primitives }));
    skeleton(&mut glb);
    swim(&mut glb);
    glb.bytes(&[0, 1])
}

/// The fish as a field.
struct Shape {
    /// Square of the body's half height by x.
    height2: Spline,
    /// Half width over half height by x.
    slimness: Spline,
    /// The height of its middle by x.
    middle: Spline,
    tail: Outline,
    dorsal: Outline,
    anal: Outline,
    pectoral: Outline,
    pelvic: Outline,
}

/// Where a paired fin grows and how it lies: along `out`, its chord along `back`.
struct FinFrame {
    root: DVec3,
    out: DVec3,
    back: DVec3,
}

impl FinFrame {
    fn new(root: DVec3, out: DVec3, back: DVec3) -> Self {
        let out = out.normalize();
        Self { root, out, back: back.reject_from_normalized(out).normalize() }
    }

    /// Along the fin, along its chord, across its sheet.
    fn local(&self, p: DVec3) -> DVec3 {
        let from_root = p - self.root;
        DVec3::new(from_root.dot(self.out), from_root.dot(self.back), from_root.dot(self.out.cross(self.back)))
    }
}

/// The fin of the side that z > 0.
fn pectoral_frame() -> FinFrame {
    FinFrame::new(DVec3::new(0.42, -0.14, 0.17), DVec3::new(-0.52, -0.30, 0.64), DVec3::new(-1.0, 0.10, -0.2))
}

fn pelvic_frame() -> FinFrame {
    FinFrame::new(DVec3::new(0.02, -0.22, 0.07), DVec3::new(-0.55, -0.72, 0.30), DVec3::new(-1.0, 0.2, 0.0))
}

impl Shape {
    fn new() -> Self {
        let squared = |points: &[(f64, f64)]| points.iter().map(|&(x, h)| (x, h * h.abs())).collect::<Vec<_>>();
        Self {
            height2: Spline::new(&squared(&[
                (-0.90, -0.05),
                (-0.72, 0.075),
                (-0.55, 0.108),
                (-0.30, 0.198),
                (0.0, 0.288),
                (0.28, 0.322),
                (0.55, 0.275),
                (0.78, 0.186),
                (0.92, 0.112),
                (1.0, -0.02),
            ])),
            slimness: Spline::new(&[(-0.9, 0.55), (-0.55, 0.52), (0.0, 0.60), (0.45, 0.70), (0.8, 0.80), (1.0, 0.85)]),
            middle: Spline::new(&[
                (-0.9, 0.045),
                (-0.5, 0.03),
                (0.0, 0.0),
                (0.4, -0.015),
                (0.8, -0.025),
                (1.0, -0.045),
            ]),
            tail: Outline::through(&[
                (-0.60, 0.080),
                (-0.84, 0.185),
                (-1.10, 0.42),
                (-1.38, 0.655),
                (-1.62, 0.765),
                (-1.73, 0.74),
                (-1.70, 0.60),
                (-1.57, 0.38),
                (-1.40, 0.17),
                (-1.31, 0.02),
                (-1.37, -0.125),
                (-1.52, -0.31),
                (-1.62, -0.49),
                (-1.61, -0.60),
                (-1.50, -0.62),
                (-1.28, -0.53),
                (-1.04, -0.345),
                (-0.82, -0.125),
                (-0.60, -0.03),
            ]),
            dorsal: Outline::through(&[
                (0.44, 0.20),
                (0.37, 0.35),
                (0.23, 0.50),
                (0.04, 0.61),
                (-0.17, 0.67),
                (-0.34, 0.675),
                (-0.375, 0.62),
                (-0.32, 0.50),
                (-0.30, 0.39),
                (-0.35, 0.29),
                (-0.42, 0.20),
                (-0.38, 0.10),
                (0.0, 0.12),
            ]),
            anal: Outline::through(&[
                (-0.18, -0.12),
                (-0.30, -0.29),
                (-0.46, -0.415),
                (-0.56, -0.43),
                (-0.56, -0.35),
                (-0.52, -0.24),
                (-0.53, -0.12),
                (-0.50, 0.0),
                (-0.30, 0.0),
            ]),
            pectoral: Outline::through(&[
                (-0.10, -0.06),
                (0.10, -0.075),
                (0.34, -0.085),
                (0.56, -0.045),
                (0.70, 0.055),
                (0.725, 0.135),
                (0.66, 0.175),
                (0.50, 0.205),
                (0.28, 0.195),
                (0.08, 0.10),
                (-0.10, 0.05),
            ]),
            pelvic: Outline::through(&[
                (-0.10, -0.05),
                (0.08, -0.06),
                (0.22, -0.04),
                (0.33, 0.03),
                (0.34, 0.09),
                (0.24, 0.12),
                (0.10, 0.085),
                (-0.10, 0.06),
            ]),
        }
    }

    fn field(&self, p: DVec3) -> f64 {
        let mut f = self.body(p);
        f = union(f, self.tail_fin(p), 0.13);
        f = union(f, self.midline_fin(&self.dorsal, p, DVec2::new(0.30, -0.35), 0.036), 0.10);
        f = union(f, self.midline_fin(&self.anal, p, DVec2::new(-0.05, 0.35), 0.032), 0.09);
        let mirrored = DVec3::new(p.x, p.y, p.z.abs());
        f = union(f, paired_fin(&self.pectoral, &pectoral_frame(), mirrored, 0.036), 0.10);
        union(f, paired_fin(&self.pelvic, &pelvic_frame(), mirrored, 0.031), 0.08)
    }

    /// About the distance to the body without fins: (y − m)² + (z/s)² − h² over the length of its gradient.
    fn body(&self, p: DVec3) -> f64 {
        let implicit = |q: DVec3| {
            let (y, z) = (q.y - self.middle.at(q.x), q.z / self.slimness.at(q.x));
            y * y + z * z - self.height2.at(q.x)
        };
        let value = implicit(p);
        let (y, slim) = (p.y - self.middle.at(p.x), self.slimness.at(p.x));
        let along = (self.height2.at(p.x + 1e-3) - self.height2.at(p.x - 1e-3)) / 2e-3;
        let slope = DVec3::new(along, 2.0 * y, 2.0 * p.z / (slim * slim)).length();
        let distance = value / (slope * slope + 0.01).sqrt();
        distance + Self::relief(p)
    }

    /// The edge of the gill cover and the line of the mouth, drawn into the body.
    fn relief(p: DVec3) -> f64 {
        let gill = DVec2::new((p.x - 0.74) * 1.05, p.y + 0.02);
        let behind = smooth_step(-0.02, -0.14, gill.x);
        let cover = bell(gill.length() - 0.245, 0.020) * behind * 0.013;
        let mouth_y = p.y + 0.062 - (0.97 - p.x) * 0.35;
        let mouth = bell(mouth_y, 0.013) * smooth_step(0.86, 0.91, p.x) * 0.016;
        cover + mouth
    }

    /// Two flowing lobes with rays, gently waved.
    fn tail_fin(&self, p: DVec3) -> f64 {
        let q = DVec2::new(p.x, p.y);
        let from = q - DVec2::new(-0.42, 0.02);
        let (reach, angle) = (from.length(), libm::atan2(from.y, -from.x));
        let spread = smooth_step(0.30, 0.95, reach);
        let ribs = 1.0 + 0.34 * spread * libm::cos(angle * 26.0);
        let half = (0.062 - 0.030 * smooth_step(0.15, 0.9, reach)) * ribs;
        let wave = 0.042 * spread * libm::sin(angle * 4.2 + 0.6);
        sheet(&self.tail, q, p.z - wave, half)
    }

    /// A fin in the plane of symmetry whose rays fan out from `fan`.
    fn midline_fin(&self, outline: &Outline, p: DVec3, fan: DVec2, half_thickness: f64) -> f64 {
        let q = DVec2::new(p.x, p.y);
        let from = q - fan;
        let away = self.body(DVec3::new(p.x, p.y, 0.0)).max(0.0);
        let angle = libm::atan2(from.x, from.y.abs());
        let ribs = 1.0 + 0.26 * smooth_step(0.02, 0.14, away) * libm::cos(angle * 30.0);
        let half = half_thickness * (1.0 - 0.32 * smooth_step(0.0, 0.25, away)) * ribs;
        sheet(outline, q, p.z, half)
    }

    /// The joints of a vertex.
    fn binding(&self, p: DVec3) -> [(u16, f64); 4] {
        let frame = pectoral_frame();
        let local = frame.local(DVec3::new(p.x, p.y, p.z.abs()));
        let near = 1.0 - smooth_step(0.03, 0.16, self.pectoral.box_distance(DVec2::new(local.x, local.y)));
        let flat = 1.0 - smooth_step(0.08, 0.16, (local.z - sheet_bend(local.x)).abs());
        let fin = smooth_step(0.0, 0.22, local.x) * near * flat;
        let joint = if p.z > 0.0 { SPINE_JOINTS } else { SPINE_JOINTS + 1 };
        spine_binding(p.x, (fin > 0.0).then_some((joint, fin)))
    }
}

/// How far a paired fin's sheet leaves its plane, `reach` from its root.
fn sheet_bend(reach: f64) -> f64 {
    0.30 * reach.max(0.0) * reach.max(0.0)
}

/// A fin on each side, its sheet bent a little backwards towards the tip.
fn paired_fin(outline: &Outline, frame: &FinFrame, p: DVec3, half_thickness: f64) -> f64 {
    let local = frame.local(p);
    let q = DVec2::new(local.x, local.y);
    let reach = local.x.max(0.0);
    let angle = libm::atan2(local.y - 0.02, local.x + 0.22);
    let ribs = 1.0 + 0.26 * smooth_step(0.06, 0.25, reach) * libm::cos(angle * 26.0);
    let half = half_thickness * (1.0 - 0.30 * smooth_step(0.1, 0.5, reach)) * ribs;
    sheet(outline, q, local.z - sheet_bend(reach), half)
}

/// Two beads, set into the head.
fn eyes() -> Mesh {
    let bead = Mesh::icosphere(2);
    let mut eyes = Mesh::default();
    for side in [1.0, -1.0] {
        let center = EYE * DVec3::new(1.0, 1.0, side);
        eyes.add(&bead, DMat4::from_translation(center) * DMat4::from_scale(DVec3::splat(0.038)));
    }
    eyes
}

/// Quadratic B-spline weights of the spine's joints at `x`, and a fin's joint with its share.
fn spine_binding(x: f64, fin: Option<(u16, f64)>) -> [(u16, f64); 4] {
    let along = ((HEAD_X - x) / BONE).clamp(0.0, f64::from(SPINE_JOINTS) - 1e-9);
    let bone = along.floor();
    let t = along - bone;
    let weights = [0.5 * (1.0 - t) * (1.0 - t), 0.5 + t * (1.0 - t), 0.5 * t * t];
    let (fin_joint, fin_share) = fin.unwrap_or((0, 0.0));
    let joint = |offset: f64| {
        let clamped = (bone + offset).clamp(0.0, f64::from(SPINE_JOINTS - 1));
        (0..SPINE_JOINTS).find(|&j| f64::from(j) >= clamped).unwrap_or(0)
    };
    let share = 1.0 - fin_share;
    [
        (joint(-1.0), weights[0] * share),
        (joint(0.0), weights[1] * share),
        (joint(1.0), weights[2] * share),
        (fin_joint, fin_share),
    ]
}

/// Node 0 holds the mesh, nodes 1 to 12 the spine from head to tail, 13 and 14 the pectoral fins.
fn skeleton(glb: &mut Glb) {
    glb.nodes.push(json!({ "name": "fish", "mesh": 0, "skin": 0 }));
    let spine_x = |joint: u16| HEAD_X - BONE * f64::from(joint);
    let fins = [1.0, -1.0].map(|side| pectoral_frame().root * DVec3::new(1.0, 1.0, side));
    let carrier = 2;
    for joint in 0..SPINE_JOINTS {
        let x = if joint == 0 { HEAD_X } else { -BONE };
        let mut node = json!({ "name": format!("spine {joint}"), "translation": [x, 0, 0] });
        let mut children: Vec<u16> = (joint + 1 < SPINE_JOINTS).then_some(joint + 2).into_iter().collect();
        if joint == carrier {
            children.extend([SPINE_JOINTS + 1, SPINE_JOINTS + 2]);
        }
        if !children.is_empty() {
            node["children"] = json!(children);
        }
        glb.nodes.push(node);
    }
    for (fin, name) in fins.iter().zip(["fin left", "fin right"]) {
        let from_carrier = *fin - DVec3::new(spine_x(carrier), 0.0, 0.0);
        glb.nodes.push(json!({ "name": name, "translation": from_carrier.to_array() }));
    }
    let mut joints: Vec<DVec3> = (0..SPINE_JOINTS).map(|j| DVec3::new(spine_x(j), 0.0, 0.0)).collect();
    joints.extend(fins);
    let inverse_binds = glb.inverse_binds(&joints);
    let nodes: Vec<u32> = (1..=index(joints.len())).collect();
    glb.skins.push(json!({ "joints": nodes, "inverseBindMatrices": inverse_binds, "skeleton": 1 }));
}

/// A wave that travels down the spine and grows towards the tail, while the fins row.
fn swim(glb: &mut Glb) {
    const STEPS: u32 = 32;
    let times: Vec<f64> = (0..=STEPS).map(|i| SWIM_SECS * f64::from(i) / f64::from(STEPS)).collect();
    let (mut samplers, mut channels) = (Vec::new(), Vec::new());
    let mut channel = |glb: &mut Glb, node: u16, path: &str, kind: &str, values: &[f64]| {
        let (input, output) = glb.keys(&times, values, kind);
        samplers.push(json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
        channels.push(json!({ "sampler": samplers.len() - 1, "target": { "node": node, "path": path } }));
    };

    let at = |f: &dyn Fn(f64) -> Vec<f64>| times.iter().flat_map(|t| f(TAU * t / SWIM_SECS)).collect::<Vec<f64>>();
    let root = at(&|phase| vec![HEAD_X, 0.018 * libm::sin(phase), lateral(0.0, phase)]);
    channel(glb, 1, "translation", "VEC3", &root);
    for joint in 0..SPINE_JOINTS {
        let values = at(&|phase| {
            let before = if joint == 0 { 0.0 } else { heading(joint - 1, phase) };
            let half = (heading(joint, phase) - before) * 0.5;
            vec![0.0, libm::sin(half), 0.0, libm::cos(half)]
        });
        channel(glb, joint + 1, "rotation", "VEC4", &values);
    }
    for (fin, side) in [(SPINE_JOINTS + 1, 1.0), (SPINE_JOINTS + 2, -1.0)] {
        let values = at(&|phase| {
            let lift = 0.30 * libm::sin(phase + 0.9) * side;
            let sweep = 0.14 * libm::sin(phase - 0.4) * side;
            let (sx, cx) = (libm::sin(lift * 0.5), libm::cos(lift * 0.5));
            let (sy, cy) = (libm::sin(sweep * 0.5), libm::cos(sweep * 0.5));
            // A turn about x after one about y.
            vec![sx * cy, cx * sy, sx * sy, cx * cy]
        });
        channel(glb, fin, "rotation", "VEC4", &values);
    }
    glb.animations.push(json!({ "name": "Swim", "samplers": samplers, "channels": channels }));
}

/// How far the midline lies aside, `along` from the first joint towards the tail.
fn lateral(along: f64, phase: f64) -> f64 {
    let s = along / 2.3;
    let amplitude = 0.035 - 0.05 * s + 0.27 * s * s;
    amplitude * libm::sin(phase - TAU * 0.85 * s)
}

/// The spine's turn about y at a joint's bone.
fn heading(joint: u16, phase: f64) -> f64 {
    let middle = BONE * (f64::from(joint) + 0.5);
    let slope = (lateral(middle + 0.05, phase) - lateral(middle - 0.05, phase)) / 0.1;
    libm::atan2(slope, 1.0)
}
