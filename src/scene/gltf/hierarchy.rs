//! The node tree, ordered so that parents come first, and the matrices that skins need.

use super::accessor::Accessors;
use super::document::{self, Document};
use super::{Report, name};
use crate::scene::geometry::{MatrixSource, Node};
use glam::{Mat4, Quat, Vec3};

/// The tree of a document.
pub(super) struct Hierarchy {
    /// Parents before children.
    pub(super) nodes: Vec<Node>,
    /// For each of the document's nodes its place in `nodes`.
    pub(super) places: Vec<u32>,
    /// The document's nodes that the chosen scene shows, in `nodes`' order.
    pub(super) shown: Vec<usize>,
}

impl Hierarchy {
    /// Orders the nodes.
    ///
    /// # Errors
    /// When a node is its own ancestor, has two parents, or names a child that does not exist.
    pub(super) fn of(document: &Document, report: &mut Report) -> Result<Self, String> {
        let sources = &document.nodes;
        let count = sources.len();
        let mut parents: Vec<Option<usize>> = vec![None; count];
        for (node, source) in sources.iter().enumerate() {
            for &child in &source.children {
                let parent = parents.get_mut(child).ok_or_else(|| {
                    format!("node {node} has the child {child}, but there are {count} nodes; export the file again")
                })?;
                if parent.replace(node).is_some() {
                    return Err(format!(
                        "node {child} has two parents; a node may only have one, export the file again"
                    ));
                }
            }
        }
        let mut order: Vec<usize> = (0..count).filter(|&n| parents[n].is_none()).collect();
        let mut next = 0;
        while let Some(&node) = order.get(next) {
            order.extend(&sources[node].children);
            next += 1;
        }
        if order.len() < count {
            let mut reached = vec![false; count];
            order.iter().for_each(|&n| reached[n] = true);
            let node = reached.iter().position(|r| !r).unwrap_or(0);
            return Err(format!("node {node} is its own ancestor; break the cycle and export the file again"));
        }
        let mut places = vec![0; count];
        for (place, &node) in order.iter().enumerate() {
            places[node] = super::number(place)?;
        }
        let nodes = order
            .iter()
            .map(|&n| {
                let parent = parents[n].map(|p| places[p]);
                node(&sources[n], parent, &mut |what| report.warn(format!("node {n}: {what}")))
            })
            .collect();
        Ok(Self { shown: shown(document, &order, &parents, report), nodes, places })
    }
}

/// The nodes under the roots of the document's scene; all of them where it has no scenes.
fn shown(document: &Document, order: &[usize], parents: &[Option<usize>], report: &mut Report) -> Vec<usize> {
    let chosen = document.scene.unwrap_or(0);
    let scene = document.scenes.get(chosen).or_else(|| {
        if document.scene.is_some() {
            report.warn(format!("scene {chosen} does not exist; the first one is shown"));
        }
        document.scenes.first()
    });
    let Some(scene) = scene else { return order.to_vec() };
    let mut visible = vec![false; order.len()];
    for &root in &scene.nodes {
        match visible.get_mut(root) {
            Some(root) => *root = true,
            None => report.warn(format!("the scene names node {root}, which does not exist")),
        }
    }
    for &node in order {
        visible[node] |= parents[node].is_some_and(|p| visible[p]);
    }
    order.iter().copied().filter(|&n| visible[n]).collect()
}

fn node(source: &document::Node, parent: Option<u32>, warn: &mut impl FnMut(&str)) -> Node {
    let mut scale = Vec3::from_array(source.scale.unwrap_or([1.0; 3]));
    let mut rotation = Quat::from_array(source.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
    let mut translation = Vec3::from_array(source.translation.unwrap_or_default());
    if let Some(matrix) = source.matrix {
        (scale, rotation, translation) = Mat4::from_cols_array(&matrix).to_scale_rotation_translation();
        if !rotation.is_finite() {
            // A matrix that flattens space has no rotation that could be told from it.
            rotation = Quat::IDENTITY;
        }
    }
    if !(scale.is_finite() && rotation.is_finite() && translation.is_finite()) {
        warn("its transform is not finite and is left out");
        (scale, rotation, translation) = (Vec3::ONE, Quat::IDENTITY, Vec3::ZERO);
    }
    // In double precision no finite number's square is endless.
    let long = rotation.as_dquat();
    if (long.length() - 1.0).abs() > 1e-2 {
        warn("its rotation is no unit quaternion and is brought to length 1");
    }
    let rotation = if long.length() > 0.0 { long.normalize().as_quat() } else { Quat::IDENTITY };
    let weights = source.weights.clone().unwrap_or_default();
    Node { name: name(source.name.as_deref(), ""), parent, translation, rotation, scale, weights }
}

/// The matrices of a skin's joints, in the skin's order.
///
/// # Errors
/// When a joint or its inverse bind matrix does not exist.
pub(super) fn skin(
    index: usize,
    document: &Document,
    accessors: &Accessors<'_>,
    hierarchy: &Hierarchy,
    report: &mut Report,
) -> Result<Vec<MatrixSource>, String> {
    let skin = document.skins.get(index).ok_or_else(|| {
        format!("skin {index} does not exist, there are {}; export the file again", document.skins.len())
    })?;
    let inverse_binds = match skin.inverse_bind_matrices {
        Some(accessor) => accessors.numbers::<16>(accessor).map_err(|e| format!("skin {index}: {e}"))?,
        None => vec![Mat4::IDENTITY.to_cols_array(); skin.joints.len()],
    };
    if inverse_binds.len() < skin.joints.len() {
        let (have, need) = (inverse_binds.len(), skin.joints.len());
        return Err(format!("skin {index} has {need} joints but {have} inverse bind matrices; export the file again"));
    }
    let mut sources = Vec::with_capacity(skin.joints.len());
    for (&joint, inverse_bind) in skin.joints.iter().zip(inverse_binds) {
        let node = *hierarchy.places.get(joint).ok_or_else(|| {
            format!("skin {index} has node {joint} for a joint, which does not exist; export the file again")
        })?;
        let mut inverse_bind = Mat4::from_cols_array(&inverse_bind);
        if !inverse_bind.is_finite() {
            report.warn(format!("skin {index} has an inverse bind matrix that is not finite; it is left out"));
            inverse_bind = Mat4::IDENTITY;
        }
        sources.push(MatrixSource::Joint { node, inverse_bind });
    }
    Ok(sources)
}
