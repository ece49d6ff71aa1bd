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
    /// What each morph target does at weight 1.
    pub morphs: Vec<MorphReach>,
}

/// What one target does to the vertices of a [`Reach`] at weight 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MorphReach {
    /// The box of the displacements: its centre and half its sides.
    pub displacement: [DVec3; 2],
    /// The box of the displaced vertices, likewise.
    pub displaced: [DVec3; 2],
}

impl Reach {
    /// Centre, half sides and radius with the morph weights of the part applied.
    ///
    /// A vertex is p + Σ w·d, and likewise (1 − Σ w)·p + Σ w·(p + d): each sum of boxes bounds it, and the second is
    /// exact where one target rules.
    fn morphed(&self, weights: &[f32]) -> (DVec3, DVec3, f64) {
        if weights.iter().all(|&w| w == 0.0) {
            return (self.center, self.half, self.radius);
        }
        let rest = 1.0 - weights.iter().map(|&w| f64::from(w)).sum::<f64>();
        let (mut added, mut mixed) = ([self.center, self.half], [self.center * rest, self.half * rest.abs()]);
        for (morph, &weight) in self.morphs.iter().zip(weights) {
            let weight = f64::from(weight);
            for (sum, [center, half]) in [(&mut added, morph.displacement), (&mut mixed, morph.displaced)] {
                sum[0] += center * weight;
                sum[1] += half * weight.abs();
            }
        }
        let [min, max] =
            [(added[0] - added[1]).max(mixed[0] - mixed[1]), (added[0] + added[1]).min(mixed[0] + mixed[1])];
        // Where both boxes are flat in an axis, rounding may put one beside the other.
        let half = ((max - min) * 0.5).max(DVec3::ZERO);
        ((min + max) * 0.5, half, half.length())
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
    let mut boxes: BTreeMap<u32, (Bounds, Vec<[Bounds; 2]>)> = BTreeMap::new();
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
        let (rest, morphed) = boxes.entry(joint).or_insert_with(|| (Bounds::EMPTY, vec![[Bounds::EMPTY; 2]; targets]));
        let position = geometry.vertices[v].position.as_dvec3();
        rest.add(position);
        for (target, [displacement, displaced]) in morphed.iter_mut().enumerate() {
            let morph = part.morph_first as usize + target * stride + (v - vertices.start);
            let moved = geometry.morphs[morph].position.as_dvec3();
            displacement.add(moved);
            displaced.add(position + moved);
        }
    });
    let mut reaches: Vec<Reach> = boxes
        .into_iter()
        .map(|(matrix, (rest, morphed))| Reach {
            matrix,
            center: rest.center(),
            half: half_of(&rest),
            radius: 0.0,
            morphs: morphed
                .iter()
                .map(|[displacement, displaced]| MorphReach {
                    displacement: [displacement.center(), half_of(displacement)],
                    displaced: [displaced.center(), half_of(displaced)],
                })
                .collect(),
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

fn half_of(bounds: &Bounds) -> DVec3 {
    (bounds.max - bounds.min) * 0.5
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
    let half = half_of(&deformed);
    let whole = Reach { matrix: 0, center: deformed.center(), half, radius: half.length(), morphs: Vec::new() };
    whole.bounds_under(world_from_model, &[])
}
