//! Turns a primitive at a node into vertices and triangles of one part.

use super::Report;
use super::accessor::Accessors;
use super::cutout::Mask;
use super::document::{Attributes, Primitive, Target};
use super::materials::UvUse;
use crate::scene::geometry::{Influence, Morph, RestVertex, Texture, uv_from_color};
use glam::{Vec2, Vec3};

/// The most triangles of a model: records number them with 24 bits.
pub(super) const MAX_TRIANGLES: usize = 1 << 24;
/// The most vertices of a model.
pub(super) const MAX_VERTICES: usize = 1 << 24;
/// The most morph displacements of a model.
pub(super) const MAX_MORPHS: usize = 1 << 25;
/// Coordinates further out than this are taken for broken: single precision could not hold their squares' products.
const MAX_COORDINATE: f32 = 1e12;

/// The vertices and triangles of a primitive, its own numbers from 0.
#[derive(Debug, Default)]
pub(super) struct Mesh {
    pub(super) vertices: Vec<RestVertex>,
    pub(super) influences: Vec<Influence>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Target after target, a displacement a vertex.
    pub(super) morphs: Vec<Morph>,
    pub(super) targets: usize,
    pub(super) flat: bool,
    /// Colours stand in place of texture coordinates.
    pub(super) colored: bool,
}

/// What moves the vertices.
#[derive(Debug, Clone, Copy)]
pub(super) enum Rig {
    /// One matrix of the model's.
    Node(u32),
    /// Matrices from `first` on, `joints` of them.
    Skin {
        /// Index of the skin's first matrix.
        first: u32,
        /// How many joints it has, at least one.
        joints: u32,
    },
}

/// What a part's material wants of its mesh.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surface<'a> {
    /// The texture coordinates of its pictures, if it has any.
    pub(super) uv_use: Option<&'a UvUse>,
    /// Its base colour's picture, whose holes are cut out.
    pub(super) picture: Option<&'a Texture>,
}

/// How much more a model may hold.
#[derive(Debug, Clone, Copy)]
pub(super) struct Room {
    pub(super) vertices: usize,
    pub(super) triangles: usize,
    pub(super) morphs: usize,
}

/// Reads a primitive; `None` when it has no triangles.
///
/// # Errors
/// When its data are not as it says, or more than there is room for.
pub(super) fn mesh(
    primitive: &Primitive,
    accessors: &Accessors<'_>,
    rig: Rig,
    surface: &Surface<'_>,
    room: Room,
    report: &mut Report,
) -> Result<Option<Mesh>, String> {
    let mode = primitive.mode.unwrap_or(4);
    if !(4..=6).contains(&mode) {
        report.warn("points and lines are not drawn".to_owned());
        return Ok(None);
    }
    if primitive.extensions.draco.is_some() && primitive.attributes.position.is_none() {
        return Err("the mesh is packed with Draco; export it without compression".to_owned());
    }
    let Some(position) = primitive.attributes.position else {
        report.warn("a mesh without positions is left out".to_owned());
        return Ok(None);
    };
    let count = accessors.shape(position)?.count;
    if count > room.vertices {
        return Err(too_many_vertices(count));
    }
    let positions = accessors.numbers::<3>(position)?;
    let mut triangles = triangles(primitive, mode, accessors, count, room)?;
    leave_out_broken(&mut triangles, &positions, report);
    if triangles.is_empty() {
        return Ok(None);
    }
    let attributes = &primitive.attributes;
    let mut mesh = Mesh { flat: attributes.normal.is_none(), targets: primitive.targets.len(), ..Mesh::default() };
    mesh.vertices = vertices(attributes, &positions, accessors)?;
    if let Some(uv_use) = surface.uv_use {
        mesh.add_coordinates(attributes, uv_use, accessors, report)?;
    } else if let Some(color) = attributes.color0 {
        mesh.add_colors(color, accessors)?;
    }
    mesh.influences = influences(attributes, count, accessors, rig, report)?;
    if count.checked_mul(mesh.targets).is_none_or(|n| n > room.morphs) {
        return Err(format!("more than {MAX_MORPHS} morph displacements; leave out some targets"));
    }
    for target in &primitive.targets {
        mesh.add_target(target, mesh.flat, accessors, report)?;
    }
    mesh.triangles = triangles;
    if let Some(mask) = surface.picture.and_then(Mask::of) {
        mesh.cut_out(&mask, room);
        if mesh.triangles.is_empty() {
            report.warn("a part of nothing but its mask's holes is left out".to_owned());
            return Ok(None);
        }
    }
    if mesh.flat {
        if mesh.triangles.len() * 3 > room.vertices {
            return Err(too_many_vertices(mesh.triangles.len() * 3));
        }
        if mesh.triangles.len() * 3 * mesh.targets > room.morphs {
            return Err(format!("more than {MAX_MORPHS} morph displacements; export the model with normals"));
        }
        mesh.unshare();
    } else {
        mesh.mend_normals(report);
        let turned = |(_, target): &(usize, &Target)| target.position.is_some() && target.normal.is_none();
        let targets = primitive.targets.iter().enumerate().filter(turned).map(|(i, _)| i);
        mesh.turn_morph_normals(&targets.collect::<Vec<_>>());
    }
    Ok(Some(mesh))
}

/// How many triangles and vertices a primitive will have at most; none where its accessors can't be read.
pub(super) fn size(primitive: &Primitive, accessors: &Accessors<'_>) -> (usize, usize) {
    let count = |accessor: Option<usize>| accessors.shape(accessor?).ok().map(|shape| shape.count);
    let mode = primitive.mode.unwrap_or(4);
    let Some(vertices) = count(primitive.attributes.position).filter(|_| (4..=6).contains(&mode)) else {
        return (0, 0);
    };
    let triangles = triangle_count(mode, count(primitive.indices).unwrap_or(vertices));
    let shared = primitive.attributes.normal.is_some();
    (triangles, if shared { vertices } else { triangles.saturating_mul(3) })
}

fn triangle_count(mode: u64, corners: usize) -> usize {
    if mode == 4 { corners / 3 } else { corners.saturating_sub(2) }
}

pub(super) fn too_many_triangles() -> String {
    format!("more than {MAX_TRIANGLES} triangles; simplify the model")
}

pub(super) fn too_many_vertices(count: usize) -> String {
    format!(
        "{count} vertices, more than {MAX_VERTICES} (without normals each triangle needs its own three); simplify the \
         model or export it with normals"
    )
}

/// The triangles that indices and mode make, those that name a corner twice left out.
fn triangles(
    primitive: &Primitive,
    mode: u64,
    accessors: &Accessors<'_>,
    count: usize,
    room: Room,
) -> Result<Vec<[u32; 3]>, String> {
    let corners = primitive.indices.map_or(Ok(count), |i| accessors.shape(i).map(|s| s.count))?;
    if triangle_count(mode, corners) > room.triangles {
        return Err(too_many_triangles());
    }
    let corners: Vec<u32> = match primitive.indices {
        Some(i) => accessors.indices::<1>(i)?.into_iter().flatten().collect(),
        None => (0..super::number(count)?).collect(),
    };
    if let Some(at) = corners.iter().position(|&c| c as usize >= count) {
        let corner = corners[at];
        return Err(format!("index {at} is vertex {corner}, but there are {count} vertices; export the file again"));
    }
    let mut triangles: Vec<[u32; 3]> = match mode {
        4 => corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
        5 => {
            let turned = |(i, c): (usize, &[u32])| if i % 2 == 0 { [c[0], c[1], c[2]] } else { [c[0], c[2], c[1]] };
            corners.windows(3).enumerate().map(turned).collect()
        }
        _ => corners.windows(2).skip(1).map(|c| [c[0], c[1], corners[0]]).collect(),
    };
    triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    Ok(triangles)
}

/// Leaves out triangles with a corner that is nowhere.
fn leave_out_broken(triangles: &mut Vec<[u32; 3]>, positions: &[[f32; 3]], report: &mut Report) {
    let before = triangles.len();
    let sound = |&v: &u32| within_reach(Vec3::from_array(positions[v as usize]));
    triangles.retain(|t| t.iter().all(sound));
    let broken = before - triangles.len();
    if broken > 0 {
        report.warn(format!("{broken} triangles with corners that are not finite, or beyond 1e12, are left out"));
    }
}

fn vertices(
    attributes: &Attributes,
    positions: &[[f32; 3]],
    accessors: &Accessors<'_>,
) -> Result<Vec<RestVertex>, String> {
    let mut vertices: Vec<RestVertex> =
        positions.iter().map(|&p| RestVertex { position: sound(p), u: 0.0, normal: Vec3::ZERO, v: 0.0 }).collect();
    if let Some(normal) = attributes.normal {
        let normals = accessors.numbers::<3>(normal)?;
        same_count("normals", normals.len(), positions.len())?;
        for (vertex, normal) in vertices.iter_mut().zip(normals) {
            vertex.normal = sound(normal).normalize_or_zero();
        }
    }
    Ok(vertices)
}

fn influences(
    attributes: &Attributes,
    count: usize,
    accessors: &Accessors<'_>,
    rig: Rig,
    report: &mut Report,
) -> Result<Vec<Influence>, String> {
    let still = |matrix: u32| Influence { joints: [matrix, 0, 0, 0], weights: [1.0, 0.0, 0.0, 0.0] };
    let (first, joints) = match rig {
        Rig::Node(matrix) => return Ok(vec![still(matrix); count]),
        Rig::Skin { first, joints } => (first, joints),
    };
    let mut sets = Vec::new();
    for (j, w) in [(attributes.joints0, attributes.weights0), (attributes.joints1, attributes.weights1)] {
        let (Some(j), Some(w)) = (j, w) else { continue };
        let set = (accessors.indices::<4>(j)?, accessors.numbers::<4>(w)?);
        same_count("joints", set.0.len(), count)?;
        same_count("weights", set.1.len(), count)?;
        sets.push(set);
    }
    if sets.len() > 1 {
        report.warn("more than four joints move a vertex; only the four strongest count".to_owned());
    }
    let mut influences = Vec::with_capacity(count);
    let (mut odd, mut lost, mut strange) = (0, 0, 0);
    for v in 0..count {
        let mut pairs: Vec<(u32, f32)> = Vec::with_capacity(8);
        for (joint, weight) in sets.iter().flat_map(|(j, w)| j[v].into_iter().zip(w[v])) {
            if weight == 0.0 {
                continue;
            }
            let usable = weight.is_finite() && weight > 0.0 && joint < joints;
            strange += u32::from(!usable);
            if usable {
                pairs.push((joint, weight.min(1e6)));
            }
        }
        pairs.sort_by(|a, b| b.1.total_cmp(&a.1));
        let total: f32 = pairs.iter().map(|p| p.1).sum();
        odd += u32::from((total - 1.0).abs() > 0.02 && total > 0.0);
        pairs.truncate(4);
        let kept: f32 = pairs.iter().map(|p| p.1).sum();
        if kept <= 0.0 {
            lost += 1;
            influences.push(still(first));
            continue;
        }
        let mut influence = Influence { joints: [first; 4], weights: [0.0; 4] };
        for (slot, (joint, weight)) in pairs.into_iter().enumerate() {
            influence.joints[slot] = first + joint;
            influence.weights[slot] = weight / kept;
        }
        influences.push(influence);
    }
    for (number, what) in [
        (odd, "vertices had weights that did not sum to one; they were scaled"),
        (lost, "vertices had no weights; they follow the first joint"),
        (strange, "weights were negative, not finite, or of joints that do not exist; they are left out"),
    ] {
        if number > 0 {
            report.warn(format!("{number} {what}"));
        }
    }
    Ok(influences)
}

impl Mesh {
    /// Texture coordinates of the set that the part's pictures want, turned as they want them.
    fn add_coordinates(
        &mut self,
        attributes: &Attributes,
        uv_use: &UvUse,
        accessors: &Accessors<'_>,
        report: &mut Report,
    ) -> Result<(), String> {
        if attributes.color0.is_some() {
            report.warn("vertex colours of a part with a picture are not shown".to_owned());
        }
        let uv = match uv_use.set {
            0 => attributes.uv0,
            1 => attributes.uv1,
            set => {
                report.warn(format!("texture coordinates {set} are not read; only sets 0 and 1 are"));
                None
            }
        };
        let Some(uv) = uv else { return Ok(()) };
        let coordinates = accessors.numbers::<2>(uv)?;
        same_count("texture coordinates", coordinates.len(), self.vertices.len())?;
        for (vertex, uv) in self.vertices.iter_mut().zip(coordinates) {
            let uv = uv_use.transform.transform_point2(Vec2::from_array(uv));
            if uv.is_finite() {
                (vertex.u, vertex.v) = (uv.x, uv.y);
            }
        }
        Ok(())
    }

    /// Linear colours, with alpha or without, where texture coordinates would stand.
    fn add_colors(&mut self, accessor: usize, accessors: &Accessors<'_>) -> Result<(), String> {
        let colors: Vec<Vec3> = if accessors.shape(accessor)?.components == 4 {
            accessors.numbers::<4>(accessor)?.into_iter().map(|[r, g, b, _]| Vec3::new(r, g, b)).collect()
        } else {
            accessors.numbers::<3>(accessor)?.into_iter().map(Vec3::from_array).collect()
        };
        same_count("vertex colours", colors.len(), self.vertices.len())?;
        for (vertex, color) in self.vertices.iter_mut().zip(colors) {
            let color = color.map(|x| if x.is_finite() { x } else { 1.0 });
            (vertex.u, vertex.v) = uv_from_color(color);
        }
        self.colored = true;
        Ok(())
    }

    fn add_target(
        &mut self,
        target: &Target,
        flat: bool,
        accessors: &Accessors<'_>,
        report: &mut Report,
    ) -> Result<(), String> {
        let count = self.vertices.len();
        let still = Morph { position: Vec3::ZERO, _pad0: 0, normal: Vec3::ZERO, _pad1: 0 };
        let first = self.morphs.len();
        self.morphs.resize(first + count, still);
        let mut broken = 0;
        let mut fill = |accessor: Option<usize>, what: &str, set: fn(&mut Morph, Vec3)| -> Result<(), String> {
            let Some(accessor) = accessor else { return Ok(()) };
            same_count(what, accessors.shape(accessor)?.count, count)?;
            for (morph, value) in self.morphs[first..].iter_mut().zip(accessors.numbers::<3>(accessor)?) {
                let value = Vec3::from_array(value);
                if within_reach(value) {
                    set(morph, value);
                } else {
                    broken += 1;
                }
            }
            Ok(())
        };
        fill(target.position, "morph positions", |m, v| m.position = v)?;
        if !flat {
            fill(target.normal, "morph normals", |m, v| m.normal = v)?;
        }
        if broken > 0 {
            report.warn(format!("{broken} morph displacements that are not finite are left out"));
        }
        Ok(())
    }

    /// Gives each triangle vertices of its own, so that each can have its own normal at every pose.
    fn unshare(&mut self) {
        let corners: Vec<usize> = self.triangles.iter().flatten().map(|&v| v as usize).collect();
        let count = self.vertices.len();
        self.vertices = corners.iter().map(|&v| self.vertices[v]).collect();
        self.influences = corners.iter().map(|&v| self.influences[v]).collect();
        let morphs = &self.morphs;
        self.morphs = (0..self.targets).flat_map(|t| corners.iter().map(move |&v| morphs[t * count + v])).collect();
        let mut next = 0..;
        for corner in self.triangles.iter_mut().flatten() {
            *corner = next.next().unwrap_or(u32::MAX);
        }
    }
}

/// A point, or the origin where it is not finite: no triangle uses such a vertex.
fn sound(p: [f32; 3]) -> Vec3 {
    let p = Vec3::from_array(p);
    if within_reach(p) { p } else { Vec3::ZERO }
}

fn within_reach(p: Vec3) -> bool {
    p.to_array().iter().all(|x| x.abs() <= MAX_COORDINATE)
}

fn same_count(what: &str, found: usize, vertices: usize) -> Result<(), String> {
    if found == vertices {
        return Ok(());
    }
    Err(format!("{found} {what} for {vertices} vertices; export the file again"))
}
