//! The state of everything that moves, at one time.

use super::bounds;
use super::clips::{Clip, Property};
use super::deform::Deformation;
use super::description::{Bounds, Model, Scene};
use super::geometry::{Geometry, MatrixSource};
use super::world::World;
use glam::{DMat3, DMat4, DQuat, DVec3, Mat4, Vec3};

/// The state of everything that moves, at one time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Pose {
    /// `model_from_rest` of every matrix of every model, models in order: what influences index, plus the model's first.
    /// Deformers act in model space, after these and before `world_from_model`.
    pub matrices: Vec<Mat4>,
    /// Placement of every model, models in order.
    pub world_from_model: Vec<Mat4>,
    /// Morph weights of every part with targets, parts in order, targets in order.
    pub morph_weights: Vec<f32>,
    /// Conservative world bounds of each part at this pose (deformers included).
    pub part_bounds: Vec<Bounds>,
    /// Seconds.
    pub time_secs: f64,
}

impl World {
    /// The pose at `time_secs`, a pure function of scene and time.
    ///
    /// Clips loop over their own length, at the model's speed. A model that the scene no longer has stands at rest. What
    /// an animation throws out of the numbers' range collapses to a point.
    #[must_use]
    pub fn pose(&self, scene: &Scene, time_secs: f64) -> Pose {
        let mut pose = Pose { time_secs, ..Pose::default() };
        let absent = Model::default();
        for (i, geometry) in self.models.iter().enumerate() {
            let model = scene.models.get(i).unwrap_or(&absent);
            pose.add(geometry, model, time_secs);
        }
        pose
    }
}

impl Pose {
    fn add(&mut self, geometry: &Geometry, model: &Model, time_secs: f64) {
        let clip = geometry.clip(model);
        let nodes = NodeStates::at(geometry, clip, time_secs * f64::from(model.speed));
        let within_range = |m: DMat4| if m.as_mat4().is_finite() { m } else { DMat4::ZERO };
        let matrices: Vec<DMat4> = geometry
            .matrices
            .iter()
            .map(|source| match *source {
                MatrixSource::Node(node) => nodes.model_from_node[node as usize],
                MatrixSource::Joint { node, inverse_bind } => {
                    nodes.model_from_node[node as usize] * inverse_bind.as_dmat4()
                }
            })
            .map(within_range)
            .collect();
        let world_from_model = model.placement();
        let deformations: Vec<Deformation> = model.deformers.iter().map(|d| d.at(time_secs)).collect();
        for (part, reaches) in geometry.parts.iter().zip(&geometry.reaches) {
            let first = self.morph_weights.len();
            let weights = nodes.weights.get(part.node as usize).map_or(&[][..], Vec::as_slice);
            let count = part.morph_count as usize;
            self.morph_weights.extend((0..count).map(|t| weights.get(t).copied().unwrap_or(0.0)));
            self.part_bounds.push(bounds::part_bounds(
                reaches,
                &matrices,
                &self.morph_weights[first..],
                &deformations,
                &world_from_model.as_dmat4(),
            ));
        }
        self.matrices.extend(matrices.iter().map(DMat4::as_mat4));
        self.world_from_model.push(world_from_model);
    }
}

impl Geometry {
    /// The clip that a scene's model plays: the one it names, else the first.
    #[must_use]
    pub fn clip(&self, model: &Model) -> Option<&Clip> {
        match &model.animation {
            Some(name) => self.clips.iter().find(|c| c.name == *name),
            None => self.clips.first(),
        }
    }
}

/// All nodes of a model at one time of a clip.
struct NodeStates {
    model_from_node: Vec<DMat4>,
    weights: Vec<Vec<f32>>,
}

impl NodeStates {
    fn at(geometry: &Geometry, clip: Option<&Clip>, time_secs: f64) -> Self {
        struct Local {
            translation: DVec3,
            rotation: DQuat,
            scale: DVec3,
        }
        let mut weights: Vec<Vec<f32>> = geometry.nodes.iter().map(|n| n.weights.clone()).collect();
        let mut locals: Vec<Local> = geometry
            .nodes
            .iter()
            .map(|n| Local {
                translation: n.translation.as_dvec3(),
                rotation: n.rotation.as_dquat(),
                scale: n.scale.as_dvec3(),
            })
            .collect();
        if let Some(clip) = clip {
            let time = clip.local_time_secs(time_secs);
            for channel in &clip.channels {
                let node = channel.node as usize;
                let Some(local) = locals.get_mut(node) else { continue };
                let value = channel.sample(time);
                match (channel.property, value.as_slice()) {
                    (Property::Translation, &[x, y, z]) => local.translation = DVec3::new(x, y, z),
                    (Property::Scale, &[x, y, z]) => local.scale = DVec3::new(x, y, z),
                    (Property::Rotation, &[x, y, z, w]) => local.rotation = DQuat::from_xyzw(x, y, z, w),
                    (Property::Weights, values) => weights[node] = values.iter().map(|&v| single(v)).collect(),
                    _ => {}
                }
            }
        }
        let mut model_from_node: Vec<DMat4> = Vec::with_capacity(locals.len());
        for (node, local) in geometry.nodes.iter().zip(&locals) {
            let local = DMat4::from_scale_rotation_translation(local.scale, local.rotation, local.translation);
            let global = match node.parent {
                Some(parent) => model_from_node[parent as usize] * local,
                None => local,
            };
            model_from_node.push(global);
        }
        Self { model_from_node, weights }
    }
}

/// World position and unit normal of every vertex of every model in order, worked out on the host in double precision:
/// what the `animate` stage must agree with.
///
/// Normals go with the inverse transpose of the blended matrix and of the deformers; flat parts take their triangle's,
/// turned round where the pose mirrors.
#[must_use]
pub fn pose_vertices(world: &World, scene: &Scene, pose: &Pose) -> Vec<(Vec3, Vec3)> {
    let mut posed = Vec::new();
    let (mut first_matrix, mut first_weight) = (0, 0);
    let absent = Model::default();
    for (i, geometry) in world.models.iter().enumerate() {
        let deformers = &scene.models.get(i).unwrap_or(&absent).deformers;
        let deformations: Vec<Deformation> = deformers.iter().map(|d| d.at(pose.time_secs)).collect();
        let world_from_model = pose.world_from_model[i].as_dmat4();
        let matrices = &pose.matrices[first_matrix..first_matrix + geometry.matrices.len()];
        first_matrix += geometry.matrices.len();
        let first_vertex = posed.len();
        posed.resize(first_vertex + geometry.vertices.len(), (Vec3::ZERO, Vec3::ZERO));
        let posed = &mut posed[first_vertex..];
        let mut mirrored = vec![false; geometry.vertices.len()];
        for part in &geometry.parts {
            let weights = &pose.morph_weights[first_weight..first_weight + part.morph_count as usize];
            first_weight += weights.len();
            for v in part.vertices.clone() {
                let (mut position, mut normal) = {
                    let rest = &geometry.vertices[v as usize];
                    (rest.position.as_dvec3(), rest.normal.as_dvec3())
                };
                for (target, &weight) in weights.iter().enumerate() {
                    let displacement = &geometry.morphs
                        [part.morph_first as usize + target * part.vertices.len() + (v - part.vertices.start) as usize];
                    position += displacement.position.as_dvec3() * f64::from(weight);
                    normal += displacement.normal.as_dvec3() * f64::from(weight);
                }
                let influence = &geometry.influences[v as usize];
                let mut model_from_rest = DMat4::ZERO;
                for (&joint, &weight) in influence.joints.iter().zip(&influence.weights) {
                    model_from_rest += matrices[joint as usize].as_dmat4() * f64::from(weight);
                }
                mirrored[v as usize] = (model_from_rest.determinant() < 0.0) != (world_from_model.determinant() < 0.0);
                position = model_from_rest.transform_point3(position);
                normal = carry_normal(DMat3::from_mat4(model_from_rest), normal);
                for deformation in &deformations {
                    let (moved, jacobian) = deformation.apply(position);
                    position = moved;
                    normal = carry_normal(jacobian, normal);
                }
                position = world_from_model.transform_point3(position);
                normal = carry_normal(DMat3::from_mat4(world_from_model), normal);
                posed[v as usize] = (position.as_vec3(), normal.as_vec3());
            }
            if part.flat {
                for t in part.triangles.clone() {
                    let triangle = geometry.triangles[t as usize].map(|v| v as usize);
                    let [a, b, c] = triangle.map(|v| posed[v].0.as_dvec3());
                    let area = (b - a).cross(c - a) * if mirrored[triangle[0]] { -1.0 } else { 1.0 };
                    let normal = area.normalize_or_zero().as_vec3();
                    for v in triangle {
                        posed[v].1 = normal;
                    }
                }
            }
        }
    }
    posed
}

/// A unit normal under a linear map: the inverse transpose, written with cofactors so that flat maps do no harm.
fn carry_normal(map: DMat3, normal: DVec3) -> DVec3 {
    let cofactors =
        DMat3::from_cols(map.y_axis.cross(map.z_axis), map.z_axis.cross(map.x_axis), map.x_axis.cross(map.y_axis));
    (cofactors * normal * map.determinant().signum()).normalize_or_zero()
}

#[expect(clippy::cast_possible_truncation, reason = "rounding to single precision is meant")]
fn single(x: f64) -> f32 {
    x as f32
}
