//! How far a part reaches: conservative boxes of posed parts, without touching their vertices.
//!
//! A skinned vertex is a weighted mean of where its joints carry it, so it lies in the hull of what each joint makes
//! of the box of all vertices that it moves at all. Morphs widen that box by their own extremes.

use super::deform::Deformation;
use super::description::Bounds;
use super::geometry::{Geometry, Part};
use glam::{DMat4, DVec3};
use std::collections::BTreeMap;

/// The rest vertices of a part that one matrix moves: a box and a ball about the same centre.
#[derive(Debug, Clone, PartialEq)]
pub struct Reach {
    /// Index into the model's matrices.
    pub matrix: u32,
    /// Centre of both, rest space.
    pub center: DVec3,
    /// Half the box's sides.
    pub half: DVec3,
    /// The ball's radius.
    pub radius: f64,
    /// What each morph target can add at weight 1.
    pub morphs: Vec<MorphReach>,
}

/// The displacements that one target gives the vertices of a [`Reach`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MorphReach {
    /// Centre of the box of displacements.
    pub center: DVec3,
    /// Half its sides.
    pub half: DVec3,
}

impl Reach {
    /// Centre, half sides and radius with the morph weights of the part applied.
    fn morphed(&self, weights: &[f32]) -> (DVec3, DVec3, f64) {
        let (mut center, mut half, mut radius) = (self.center, self.half, self.radius);
        for (morph, &weight) in self.morphs.iter().zip(weights) {
            let weight = f64::from(weight);
            center += morph.center * weight;
            half += morph.half * weight.abs();
            radius += morph.half.length() * weight.abs();
        }
        (center, half, radius)
    }

    /// The box of the reach under an affine transform, after morphing.
    fn bounds_under(&self, transform: &DMat4, weights: &[f32]) -> Bounds {
        let (center, half, radius) = self.morphed(weights);
        let center = transform.transform_point3(center);
        let [x, y, z] = [transform.x_axis, transform.y_axis, transform.z_axis].map(|c| c.truncate());
        let by_box = x.abs() * half.x + y.abs() * half.y + z.abs() * half.z;
        let by_ball = (x * x + y * y + z * z).map(f64::sqrt) * radius;
        // The device computes in single precision: a little more room than that loses.
        let room = (center.abs() + by_box) * 4e-6;
        let half = by_box.min(by_ball) + room;
        Bounds { min: center - half, max: center + half }
    }
}

/// The reaches of a part: one for each matrix that moves any of its vertices, in the matrices' order.
#[must_use]
pub fn reaches(geometry: &Geometry, part: &Part) -> Vec<Reach> {
    if let Some(half) = part.plane_half {
        let half = f64::from(half);
        return vec![Reach {
            matrix: 0,
            center: DVec3::ZERO,
            half: DVec3::new(half, 0.0, half),
            radius: half * std::f64::consts::SQRT_2,
            morphs: Vec::new(),
        }];
    }
    let vertices = part.vertices.start as usize..part.vertices.end as usize;
    let stride = vertices.len();
    let targets = part.morph_count as usize;
    let mut boxes: BTreeMap<u32, Vec<Bounds>> = BTreeMap::new();
    let each_use = |visit: &mut dyn FnMut(u32, usize)| {
        for v in vertices.clone() {
            let influence = &geometry.influences[v];
            for (&joint, &weight) in influence.joints.iter().zip(&influence.weights) {
                if weight != 0.0 {
                    visit(joint, v);
                }
            }
        }
    };
    each_use(&mut |joint, v| {
        let boxes = boxes.entry(joint).or_insert_with(|| vec![Bounds::EMPTY; targets + 1]);
        boxes[0].add(geometry.vertices[v].position.as_dvec3());
        for (target, bounds) in boxes[1..].iter_mut().enumerate() {
            let morph = part.morph_first as usize + target * stride + (v - vertices.start);
            bounds.add(geometry.morphs[morph].position.as_dvec3());
        }
    });
    let mut reaches: Vec<Reach> = boxes
        .into_iter()
        .map(|(matrix, boxes)| Reach {
            matrix,
            center: boxes[0].center(),
            half: (boxes[0].max - boxes[0].min) * 0.5,
            radius: 0.0,
            morphs: boxes[1..].iter().map(|b| MorphReach { center: b.center(), half: (b.max - b.min) * 0.5 }).collect(),
        })
        .collect();
    each_use(&mut |joint, v| {
        if let Ok(i) = reaches.binary_search_by_key(&joint, |r| r.matrix) {
            let distance = geometry.vertices[v].position.as_dvec3().distance(reaches[i].center);
            reaches[i].radius = reaches[i].radius.max(distance);
        }
    });
    reaches
}

/// The world box of a part.
///
/// `matrices` are the model's `model_from_rest`; `weights` the part's morph weights.
#[must_use]
pub fn part_bounds(
    reaches: &[Reach],
    matrices: &[DMat4],
    weights: &[f32],
    deformations: &[Deformation],
    world_from_model: &DMat4,
) -> Bounds {
    let mut bounds = Bounds::EMPTY;
    for reach in reaches {
        let Some(model_from_rest) = matrices.get(reach.matrix as usize) else { continue };
        if deformations.is_empty() {
            bounds = bounds.union(reach.bounds_under(&(*world_from_model * *model_from_rest), weights));
        } else {
            bounds = bounds.union(reach.bounds_under(model_from_rest, weights));
        }
    }
    if deformations.is_empty() || bounds.is_empty() {
        return bounds;
    }
    let deformed = deformations.iter().fold(bounds, |b, d| d.bounds(b));
    let half = (deformed.max - deformed.min) * 0.5;
    let whole = Reach { matrix: 0, center: deformed.center(), half, radius: half.length(), morphs: Vec::new() };
    whole.bounds_under(world_from_model, &[])
}
