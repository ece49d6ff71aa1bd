//! A tree: an opaque trunk that forks, and thin leaves that drink little light (after CL Fig. 4).
//!
//! It grows from y = 0 to about 2.4. Every leaf is a closed thin body.

use super::field::{polygonize, smooth_step, tapered_capsule, union};
use super::glb::Glb;
use super::mesh::{Mesh, index};
use glam::{DMat3, DMat4, DVec2, DVec3};
use serde_json::json;

pub(crate) fn make() -> Vec<u8> {
    let mut dice = Dice(0x2545_f491_4f6c_dd1d);
    let mut branches = Vec::new();
    let mut twigs = Vec::new();
    let trunk = Branch { from: DVec3::ZERO, to: DVec3::new(0.04, 0.78, 0.02), thick: 0.105, thin: 0.072 };
    branches.push(trunk);
    grow(&trunk, 0, &mut dice, &mut branches, &mut twigs);
    let wood = polygonize(&|p| wood(&branches, p), DVec3::new(-1.3, -0.06, -1.3), DVec3::new(1.3, 2.5, 1.3), 0.0235);

    let leaf = leaf();
    let mut leaves = Mesh::default();
    for twig in &twigs {
        for _ in 0..5 {
            let along = twig.to.lerp(twig.from, dice.between(-0.15, 0.75));
            let outward = (twig.to - twig.from).normalize() + dice.direction() * 0.9 + DVec3::Y * 0.1;
            let x = outward.normalize();
            let (side, other) = x.any_orthonormal_pair();
            let roll = dice.between(0.0, std::f64::consts::TAU);
            let y = side * libm::cos(roll) + other * libm::sin(roll);
            let scale = dice.between(0.75, 1.15);
            let turned = DMat3::from_cols(x, y, x.cross(y)) * scale;
            leaves.add(&leaf, DMat4::from_translation(along) * DMat4::from_mat3(turned));
        }
    }

    let mut glb = Glb::default();
    let bark = glb.opaque("trunk", [0.20, 0.125, 0.08], 0.9);
    // Thinner than a voxel: a wall that tints, not a volume.
    let green = glb.thin_wall("leaves", [0.50, 0.74, 0.22]);
    for (name, mesh, material) in [("trunk", wood, bark), ("leaves", leaves, green)] {
        let primitive = glb.primitive(&mesh, material, None);
        glb.meshes.push(json!({ "name": name, "primitives": [primitive] }));
        glb.nodes.push(json!({ "name": name, "mesh": glb.meshes.len() - 1 }));
    }
    glb.bytes(&[0, 1])
}

/// A straight piece of wood.
#[derive(Clone, Copy)]
struct Branch {
    from: DVec3,
    to: DVec3,
    thick: f64,
    thin: f64,
}

/// Forks a branch in three until it is a twig.
fn grow(parent: &Branch, depth: u32, dice: &mut Dice, branches: &mut Vec<Branch>, twigs: &mut Vec<Branch>) {
    const DEPTH: u32 = 4;
    if depth == DEPTH {
        twigs.push(*parent);
        return;
    }
    let along = (parent.to - parent.from).normalize();
    let (side, other) = along.any_orthonormal_pair();
    let children = if depth == 0 { 4 } else { 3 };
    let start = dice.between(0.0, 1.0);
    for child in 0..children {
        let around =
            std::f64::consts::TAU * (start + (f64::from(child) + dice.between(-0.12, 0.12)) / f64::from(children));
        let spread = if child == 0 && depth > 0 { dice.between(0.15, 0.35) } else { dice.between(0.70, 1.15) };
        let aside = side * libm::cos(around) + other * libm::sin(around);
        let direction = (along + aside * spread + DVec3::Y * 0.12).normalize();
        let length = [0.50, 0.38, 0.28, 0.20][depth as usize] * dice.between(0.85, 1.15);
        let thin = (parent.thin * 0.62).max(0.025);
        let branch = Branch { from: parent.to, to: parent.to + direction * length, thick: parent.thin * 0.85, thin };
        branches.push(branch);
        grow(&branch, depth + 1, dice, branches, twigs);
    }
}

/// The wood as a field: branches blend where they fork; the foot spreads.
fn wood(branches: &[Branch], p: DVec3) -> f64 {
    let mut f = 1.0;
    for branch in branches {
        let near = branch.from.min(branch.to) - branch.thick;
        let far = branch.from.max(branch.to) + branch.thick;
        let bound = (near - p).max(p - far).max(DVec3::ZERO).length();
        if bound < 0.09 {
            let piece = tapered_capsule(p, branch.from, branch.to, branch.thick, branch.thin.min(branch.thick));
            f = union(f, piece, 0.05);
        } else {
            f = f.min(bound);
        }
    }
    let flare = 0.055 * smooth_step(0.25, 0.0, p.y) * smooth_step(0.4, 0.1, DVec2::new(p.x, p.z).length());
    let cut = -p.y;
    -union(-(f - flare), -cut, 0.02)
}

/// A leaf along +x, 0.26 long: two domes over one pointed outline, bent along its middle.
fn leaf() -> Mesh {
    const ALONG: u32 = 6;
    const LENGTH: f64 = 0.26;
    let half_width = |t: f64| 0.070 * libm::sin(std::f64::consts::PI * libm::pow(t, 0.8));
    let bend = |x: f64, z: f64| DVec3::new(x, -0.8 * x * x + 1.2 * z * z, z);
    let mut leaf = Mesh::default();
    let base = 0_u32;
    leaf.positions.push(bend(0.0, 0.0));
    for step in 1..ALONG {
        let t = f64::from(step) / f64::from(ALONG);
        let (x, w) = (LENGTH * t, half_width(t));
        let thick = 0.012 * libm::sin(std::f64::consts::PI * t).max(0.5);
        // Right rim, top, left rim, bottom.
        leaf.positions.extend([
            bend(x, w),
            bend(x, 0.0) + DVec3::Y * thick,
            bend(x, -w),
            bend(x, 0.0) - DVec3::Y * thick,
        ]);
    }
    leaf.positions.push(bend(LENGTH, 0.0));
    let tip = index(leaf.positions.len() - 1);
    let ring = |step: u32, corner: u32| 1 + (step - 1) * 4 + corner % 4;
    for corner in 0..4 {
        leaf.triangles.push([base, ring(1, corner), ring(1, corner + 1)]);
        for step in 1..ALONG - 1 {
            let [a, b] = [ring(step, corner), ring(step, corner + 1)];
            let [c, d] = [ring(step + 1, corner + 1), ring(step + 1, corner)];
            leaf.triangles.extend([[a, d, c], [a, c, b]]);
        }
        leaf.triangles.push([ring(ALONG - 1, corner), tip, ring(ALONG - 1, corner + 1)]);
    }
    leaf.smooth_normals();
    leaf
}

/// Numbers that look random and are always the same (SplitMix64).
struct Dice(u64);

impl Dice {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let high_bits = u32::try_from((z ^ (z >> 31)) >> 32).expect("32 bits are left");
        low + (high - low) * f64::from(high_bits) / 4_294_967_296.0
    }

    /// Uniform on the sphere.
    fn direction(&mut self) -> DVec3 {
        let y = self.between(-1.0, 1.0);
        let around = self.between(0.0, std::f64::consts::TAU);
        let r = (1.0 - y * y).sqrt();
        DVec3::new(r * libm::cos(around), y, r * libm::sin(around))
    }
}
