//! Voxels to closed meshes, one a part.
//!
//! Every cell has at most one part ([`labels`]). A face between two cells of different parts bounds both: each part's
//! faces are a closed surface, whatever the cells. A face's corners are shared; each moves onto the planes (position and
//! normal) of the surface voxels around it, and takes their mean normal and colour.

use super::{Saved, SurfaceVoxel};
use crate::scene::geometry::{Geometry, Influence, MatrixSource, Node, Part, RestVertex, uv_from_color};
use glam::{DMat3, DVec3, IVec3, Quat, UVec3, Vec3};
use std::collections::{HashMap, VecDeque};

/// The most triangles of all parts: numbers in records have 24 bits.
const MAX_TRIANGLES: usize = 1 << 24;
/// How strongly a corner is held where planes leave it free, against one plane.
const HOLD: f64 = 0.02;
/// A corner moves no further, cells.
const FARTHEST_CELLS: f64 = 1.5;

/// The faces of a cell: the way out, and the corners of the face counter-clockwise seen from there.
const FACES: [(IVec3, [[u32; 3]; 4]); 6] = [
    (IVec3::NEG_X, [[0, 0, 0], [0, 0, 1], [0, 1, 1], [0, 1, 0]]),
    (IVec3::X, [[1, 0, 0], [1, 1, 0], [1, 1, 1], [1, 0, 1]]),
    (IVec3::NEG_Y, [[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]]),
    (IVec3::Y, [[0, 1, 0], [0, 1, 1], [1, 1, 1], [1, 1, 0]]),
    (IVec3::NEG_Z, [[0, 0, 0], [0, 1, 0], [1, 1, 0], [1, 0, 0]]),
    (IVec3::Z, [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]),
];

/// The model of a file's voxels.
pub(super) fn geometry(saved: &Saved) -> Result<Geometry, String> {
    let labels = Labels { cells: saved.cells, of_cells: labels(saved) };
    let mut at_cell = HashMap::with_capacity(saved.voxels.len());
    for (i, voxel) in saved.voxels.iter().enumerate() {
        at_cell.insert(voxel.cell, i);
    }
    let mut geometry = Geometry {
        nodes: vec![Node {
            name: "voxels".to_owned(),
            parent: None,
            translation: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            scale: Vec3::ONE,
            weights: Vec::new(),
        }],
        matrices: vec![MatrixSource::Node(0)],
        ..Geometry::default()
    };
    for (number, (name, material)) in (1_u16..).zip(&saved.parts) {
        let (vertex_first, triangle_first) = (geometry.vertices.len(), geometry.triangles.len());
        add_faces(&mut geometry, saved, &labels, &at_cell, number)?;
        let mut material = material.clone();
        if material.opaque {
            // Its vertices carry the whole colour.
            material.base_color = Vec3::ONE;
        }
        geometry.parts.push(Part {
            name: name.clone(),
            vertices: index(vertex_first)..index(geometry.vertices.len()),
            triangles: index(triangle_first)..index(geometry.triangles.len()),
            morph_first: 0,
            morph_count: 0,
            node: 0,
            flat: false,
            vertex_colors: material.opaque,
            material,
            variant_materials: Vec::new(),
            plane_half: None,
        });
    }
    if geometry.triangles.is_empty() {
        return Err("has no voxels; voxelize a model that has some in the grid".to_owned());
    }
    let still = Influence { joints: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] };
    geometry.influences = vec![still; geometry.vertices.len()];
    geometry.measure();
    Ok(geometry)
}

/// Part + 1 of each cell, 0 outside all.
struct Labels {
    cells: UVec3,
    of_cells: Vec<u16>,
}

impl Labels {
    fn at(&self, cell: IVec3) -> u16 {
        let inside = cell.cmpge(IVec3::ZERO).all() && cell.cmplt(self.cells.as_ivec3()).all();
        if inside { self.of_cells[place(self.cells, cell.as_uvec3())] } else { 0 }
    }
}

fn place(cells: UVec3, cell: UVec3) -> usize {
    ((cell.z as usize * cells.y as usize) + cell.y as usize) * cells.x as usize + cell.x as usize
}

/// What fills each cell. A part that encloses no cell's centre stands as its surface voxels.
fn labels(saved: &Saved) -> Vec<u16> {
    let Some(interior) = &saved.interior else { return flooded(saved) };
    let mut labels = interior.clone();
    let mut encloses = vec![false; saved.parts.len() + 1];
    interior.iter().for_each(|label| encloses[usize::from(*label)] = true);
    for voxel in saved.voxels.iter().filter(|v| !encloses[usize::from(v.part) + 1]) {
        let label = &mut labels[place(saved.cells, voxel.cell)];
        if *label == 0 {
            *label = voxel.part + 1;
        }
    }
    labels
}

/// All that the outside does not reach past the surface is solid and of the part whose surface is the fewest steps away.
fn flooded(saved: &Saved) -> Vec<u16> {
    const OUTSIDE: u16 = u16::MAX;
    let cells = saved.cells;
    let mut labels = vec![0; saved.occupancy.len()];
    let mut queue = VecDeque::new();
    for (i, _) in saved.occupancy.iter().enumerate().filter(|(_, marked)| **marked == 0) {
        let cell = cell_of(cells, i);
        if cell.cmpeq(UVec3::ZERO).any() || cell.cmpeq(cells - 1).any() {
            labels[i] = OUTSIDE;
            queue.push_back(cell);
        }
    }
    spread(&mut labels, &mut queue, cells, |place| saved.occupancy[place] == 0);
    for voxel in &saved.voxels {
        labels[place(cells, voxel.cell)] = voxel.part + 1;
        queue.push_back(voxel.cell);
    }
    spread(&mut labels, &mut queue, cells, |_| true);
    labels.iter_mut().filter(|l| **l == OUTSIDE).for_each(|l| *l = 0);
    labels
}

/// Hands labels on to cells without one, from the queue's cells through faces, where `open`.
fn spread(labels: &mut [u16], queue: &mut VecDeque<UVec3>, cells: UVec3, open: impl Fn(usize) -> bool) {
    while let Some(cell) = queue.pop_front() {
        let label = labels[place(cells, cell)];
        for (out, _) in FACES {
            let beside = cell.as_ivec3() + out;
            if beside.cmpge(IVec3::ZERO).all() && beside.cmplt(cells.as_ivec3()).all() {
                let at = place(cells, beside.as_uvec3());
                if labels[at] == 0 && open(at) {
                    labels[at] = label;
                    queue.push_back(beside.as_uvec3());
                }
            }
        }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "a cell of a grid of at most 512³")]
fn cell_of(cells: UVec3, place: usize) -> UVec3 {
    let [nx, ny] = [cells.x as usize, cells.y as usize];
    UVec3::new((place % nx) as u32, (place / nx % ny) as u32, (place / nx / ny) as u32)
}

fn add_faces(
    geometry: &mut Geometry,
    saved: &Saved,
    labels: &Labels,
    at_cell: &HashMap<UVec3, usize>,
    number: u16,
) -> Result<(), String> {
    let mut vertex_at: HashMap<UVec3, u32> = HashMap::new();
    for (i, _) in labels.of_cells.iter().enumerate().filter(|(_, label)| **label == number) {
        let cell = cell_of(labels.cells, i);
        for (out, corners) in FACES {
            if labels.at(cell.as_ivec3() + out) == number {
                continue;
            }
            let [a, b, c, d] = corners.map(|corner| {
                let corner = cell + UVec3::from_array(corner);
                *vertex_at.entry(corner).or_insert_with(|| {
                    geometry.vertices.push(vertex(saved, labels, at_cell, corner, number));
                    index(geometry.vertices.len() - 1)
                })
            });
            geometry.triangles.extend([[a, b, c], [a, c, d]]);
        }
        if geometry.triangles.len() > MAX_TRIANGLES {
            return Err(format!("has more than {MAX_TRIANGLES} faces; choose a smaller grid"));
        }
    }
    Ok(())
}

/// A corner of the cells of part `number` − 1, moved onto the surface around it.
fn vertex(saved: &Saved, labels: &Labels, at_cell: &HashMap<UVec3, usize>, corner: UVec3, number: u16) -> RestVertex {
    let at = saved.origin + corner.as_dvec3() * saved.cell;
    // The way out, by the cells around, for a corner that no voxel tells about and to leave out the far side of a wall.
    let mut out = DVec3::ZERO;
    let mut around: Vec<&SurfaceVoxel> = Vec::with_capacity(8);
    for i in 0..8_u32 {
        let step = UVec3::new(i & 1, i >> 1 & 1, i >> 2);
        let cell = corner.as_ivec3() - step.as_ivec3();
        let away = DVec3::splat(0.5) - step.as_dvec3();
        out += if labels.at(cell) == number { -away } else { away };
        if cell.cmpge(IVec3::ZERO).all()
            && let Some(voxel) = at_cell.get(&cell.as_uvec3()).map(|v| &saved.voxels[*v])
            && voxel.part + 1 == number
        {
            around.push(voxel);
        }
    }
    let faces_out = |v: &&SurfaceVoxel| v.normal.as_dvec3().dot(out) > 0.0;
    if around.iter().any(faces_out) {
        around.retain(faces_out);
    }
    let mut pulls = DMat3::from_diagonal(DVec3::splat(HOLD));
    let (mut offset, mut normal, mut color, mut weights) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, 0.0);
    for voxel in &around {
        let n = voxel.normal.as_dvec3();
        let toward = (voxel.position - at) / saved.cell;
        let weight = 1.0 / (0.1 + toward.length_squared());
        pulls += DMat3::from_cols(n * n.x, n * n.y, n * n.z);
        offset += n * n.dot(toward);
        normal += n * weight;
        color += voxel.color.as_dvec3() * weight;
        weights += weight;
    }
    let moved = (pulls.inverse() * offset).clamp_length_max(FARTHEST_CELLS);
    let position = (at + moved * saved.cell).as_vec3();
    let normal = if normal.length_squared() > 1e-9 { normal } else { out };
    let (u, v) = uv_from_color(if weights > 0.0 { (color / weights).as_vec3() } else { Vec3::ONE });
    RestVertex { position, u, normal: normal.normalize_or(DVec3::Y).as_vec3(), v }
}

#[expect(clippy::cast_possible_truncation, reason = "counts are refused above 2²⁴ triangles")]
fn index(n: usize) -> u32 {
    n as u32
}
