//! Animation clips as a document has them. A channel that can't be used is left out with a warning; the others play.

use super::accessor::Accessors;
use super::document::{self, Document};
use super::hierarchy::Hierarchy;
use super::{Report, name, unique};
use crate::scene::clips::{Channel, Clip, Interpolation, Property};

/// The most numbers that all channels may have together.
const MAX_NUMBERS: usize = 1 << 26;

/// Reads all clips. `targets` tells how many morph targets the mesh of a node has, by place in the hierarchy.
pub(super) fn clips(
    document: &Document,
    accessors: &Accessors<'_>,
    hierarchy: &Hierarchy,
    targets: &[usize],
    report: &mut Report,
) -> Vec<Clip> {
    let mut clips: Vec<Clip> = Vec::with_capacity(document.animations.len());
    let mut names = std::collections::BTreeSet::new();
    let mut numbers_left = MAX_NUMBERS;
    for (i, animation) in document.animations.iter().enumerate() {
        let mut clip =
            Clip { name: unique(&name(animation.name.as_deref(), "animation"), &mut names), ..Clip::default() };
        for source in &animation.channels {
            match channel(source, animation, accessors, hierarchy, targets) {
                Ok(channel) if channel.times_secs.len() + channel.values.len() > numbers_left => {
                    report.warn(format!("animation {i} has too many keys to hold; the rest of it is left out"));
                    break;
                }
                Ok(channel) => {
                    numbers_left -= channel.times_secs.len() + channel.values.len();
                    let last = channel.times_secs.last().copied().unwrap_or(0.0);
                    clip.duration_secs = clip.duration_secs.max(last);
                    clip.channels.push(channel);
                }
                Err(what) => report.warn(format!("animation {i} ({}): {what}; that channel is left out", clip.name)),
            }
        }
        clips.push(clip);
    }
    clips
}

fn channel(
    source: &document::Channel,
    animation: &document::Animation,
    accessors: &Accessors<'_>,
    hierarchy: &Hierarchy,
    targets: &[usize],
) -> Result<Channel, String> {
    let node = source.target.node.ok_or("it moves a property by pointer, which is not supported")?;
    let node = *hierarchy.places.get(node).ok_or_else(|| format!("it moves node {node}, which does not exist"))?;
    let (property, width) = match source.target.path.as_str() {
        "translation" => (Property::Translation, 3),
        "rotation" => (Property::Rotation, 4),
        "scale" => (Property::Scale, 3),
        "weights" => (Property::Weights, targets[node as usize]),
        _ => return Err("it moves an unknown property".to_owned()),
    };
    let sampler = animation.samplers.get(source.sampler).ok_or("it names a sampler that does not exist")?;
    let interpolation = match sampler.interpolation.as_deref() {
        None | Some("LINEAR") => Interpolation::Linear,
        Some("STEP") => Interpolation::Step,
        Some("CUBICSPLINE") => Interpolation::CubicSpline,
        Some(_) => return Err("it interpolates in an unknown way".to_owned()),
    };
    let times_secs: Vec<f32> = accessors.numbers::<1>(sampler.input)?.into_iter().flatten().collect();
    let ascending = times_secs.windows(2).all(|pair| pair[0] <= pair[1]);
    if times_secs.is_empty() || !ascending || !times_secs.iter().all(|t| t.is_finite()) {
        return Err("its key times are missing, not finite or not ascending".to_owned());
    }
    let mut values: Vec<f32> = match accessors.shape(sampler.output)?.components {
        1 => accessors.numbers::<1>(sampler.output)?.into_iter().flatten().collect(),
        3 => accessors.numbers::<3>(sampler.output)?.into_iter().flatten().collect(),
        4 => accessors.numbers::<4>(sampler.output)?.into_iter().flatten().collect(),
        _ => return Err("its values have the wrong type".to_owned()),
    };
    let groups = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    let needed = times_secs.len() * width * groups;
    if width == 0 || values.len() < needed {
        return Err(format!("its {} values are too few for {} keys", values.len(), times_secs.len()));
    }
    values.truncate(needed);
    if !values.iter().all(|v| v.is_finite()) {
        return Err("it has values that are not finite".to_owned());
    }
    Ok(Channel { node, property, interpolation, times_secs, values })
}
