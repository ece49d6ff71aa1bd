//! Saved voxels as a model: reads the `.npz` that `murrine voxelize` writes (CL §2: a volume is kept "for later usage").
//!
//! The volume enters the house as a mesh, so that every voxelizer and every effect runs on it: each part's solid cells
//! are closed in by their boundary faces, whose corners move onto the surface that the voxels keep ([`body`]). Materials
//! are the file's own. What is lost: the triangles, and with them what is thinner than a cell; edges are a cell round;
//! colours lie at corners, and pictures are gone; nothing moves but by deformers.
//!
//! | array       | type    | shape       | what                                                                     |
//! |-------------|---------|-------------|--------------------------------------------------------------------------|
//! | `occupancy` | u8      | \[z\]\[y\]\[x\] | 1 where the surface is                                               |
//! | `interior`  | u16     | \[z\]\[y\]\[x\] | what fills the cell: 1 + part, 0 outside; without it the outside is flooded |
//! | `index`     | u16     | \[n\]\[3\]  | x, y, z of each surface voxel, sorted by rank                            |
//! | `position`  | f32     | \[n\]\[3\]  | of the surface there, world                                              |
//! | `normal`    | f32     | \[n\]\[3\]  | smooth, outward                                                          |
//! | `color`     | f32     | \[n\]\[3\]  | linear; what it reflects or its surface lets through                     |
//! | `part`      | u16     | \[n\]       | row of the materials                                                     |
//! | `triangle`  | i32     | \[n\]       | of the mesh, −1 for none; not read                                       |
//! | `origin`    | f64     | \[3\]       | lower corner of cell (0, 0, 0), world                                    |
//! | `cell`      | f64     | \[\]        | side of a cell                                                           |
//! | `part_name` | S       | \[p\]       | names                                                                    |
//! | `ior`, `sigma`, `base_color`, `opaque`, `roughness`, `priority` | | \[p\] or \[p\]\[3\] | the materials          |

mod archive;
mod body;

use super::SceneError;
use super::gltf::{Loaded, MAX_FILE_BYTES, read_file};
use super::material::Material;
use archive::{Archive, Array};
use glam::{DVec3, UVec3, Vec3};
use std::path::Path;

/// The most cells along an axis.
const MAX_CELLS: u64 = 512;
/// The most parts.
const MAX_PARTS: usize = 4096;
/// How far out a body may lie.
const FARTHEST: f64 = 1e9;

/// What a file holds, checked: every index points at something, every number is finite.
struct Saved {
    cells: UVec3,
    origin: DVec3,
    cell: f64,
    /// [z][y][x].
    occupancy: Vec<u8>,
    /// [z][y][x]: 1 + part, or 0.
    interior: Option<Vec<u16>>,
    voxels: Vec<SurfaceVoxel>,
    parts: Vec<(String, Material)>,
}

/// A voxel of the surface.
struct SurfaceVoxel {
    cell: UVec3,
    position: DVec3,
    normal: Vec3,
    color: Vec3,
    part: u16,
}

/// True for the name of a file of saved voxels.
#[must_use]
pub fn is_saved(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("npz"))
}

/// Reads a file of saved voxels.
///
/// # Errors
/// When the file can't be read, contradicts itself, or holds nothing.
pub fn read(path: &Path) -> Result<Loaded, SceneError> {
    let place = path.display().to_string();
    let bytes = read_file(path, MAX_FILE_BYTES).map_err(|e| SceneError::new(&place, e))?;
    parse(&bytes, &place)
}

/// Reads saved voxels from a file's bytes.
///
/// # Errors
/// As [`read`]; messages start with `place`.
pub fn parse(bytes: &[u8], place: &str) -> Result<Loaded, SceneError> {
    let geometry = saved(bytes).and_then(|saved| body::geometry(&saved)).map_err(|e| SceneError::new(place, e))?;
    Ok(Loaded { geometry, warnings: Vec::new(), files: Vec::new(), lost_pictures: Vec::new() })
}

fn saved(bytes: &[u8]) -> Result<Saved, String> {
    let mut file = Archive::open(bytes)?;
    let Array { shape, values: occupancy } = file.numbers("occupancy", |x| Some(u8::from(x != 0.0)))?;
    let cells = cells_of(&shape)?;
    let interior = if file.has("interior") {
        let Array { shape: own, values } = file.numbers("interior", whole::<u16>)?;
        if own != shape {
            return Err(format!("`interior` has shape {own:?}, `occupancy` {shape:?}; save them alike"));
        }
        Some(values)
    } else {
        None
    };
    let origin = vectors(&mut file, "origin", 1, FARTHEST)?[0];
    let cell = file.numbers("cell", |x| (1e-9..=FARTHEST).contains(&x).then_some(x))?;
    let cell = *cell.values.first().ok_or("array `cell` is empty; save the side of a cell")?;
    let parts = parts(&mut file)?;
    let part_of_voxel = file.numbers("part", whole::<u16>)?.values;
    let most = parts.len();
    let fills = interior.iter().flatten().copied().max().unwrap_or(0);
    let highest = part_of_voxel.iter().copied().max().map_or(0, |p| usize::from(p) + 1).max(usize::from(fills));
    if highest > most {
        return Err(format!("names part {}, but there are {most} materials; save the voxels again", highest - 1));
    }
    let voxels = voxels(&mut file, cells, &part_of_voxel)?;
    Ok(Saved { cells, origin, cell, occupancy, interior, voxels, parts })
}

fn cells_of(shape: &[u64]) -> Result<UVec3, String> {
    let side = |n: u64| u32::try_from(n).ok().filter(|_| (1..=MAX_CELLS).contains(&n));
    match *shape {
        [z, y, x] => side(x).zip(side(y)).zip(side(z)).map(|((x, y), z)| UVec3::new(x, y, z)),
        _ => None,
    }
    .ok_or_else(|| format!("`occupancy` has shape {shape:?}; three axes of 1 to {MAX_CELLS} cells can be read"))
}

fn voxels(file: &mut Archive<'_>, cells: UVec3, parts: &[u16]) -> Result<Vec<SurfaceVoxel>, String> {
    let count = parts.len();
    let Array { shape, values: index } = file.numbers("index", whole::<u32>)?;
    if shape != [count as u64, 3] {
        return Err(format!("`index` has shape {shape:?}, not [{count}, 3] as `part` asks; save the voxels again"));
    }
    let positions = vectors(file, "position", count, FARTHEST)?;
    let normals = vectors(file, "normal", count, 1.001)?;
    let colors = vectors(file, "color", count, 1e4)?;
    let mut voxels = Vec::with_capacity(count);
    for (i, cell) in index.chunks_exact(3).enumerate() {
        let cell = UVec3::new(cell[0], cell[1], cell[2]);
        if !cell.cmplt(cells).all() {
            return Err(format!("`index` {i} is {cell}, outside the grid of {cells}; save the voxels again"));
        }
        voxels.push(SurfaceVoxel {
            cell,
            position: positions[i],
            normal: normals[i].as_vec3().normalize_or_zero(),
            color: colors[i].as_vec3(),
            part: parts[i],
        });
    }
    Ok(voxels)
}

/// The table of materials.
fn parts(file: &mut Archive<'_>) -> Result<Vec<(String, Material)>, String> {
    let names = file.texts("part_name")?;
    let count = names.len();
    if !(1..=MAX_PARTS).contains(&count) {
        return Err(format!("has {count} parts; 1 to {MAX_PARTS} can be read"));
    }
    let ior = column(file, "ior", count, |x| (0.1..=10.0).contains(&x))?;
    let sigma = vectors(file, "sigma", count, FARTHEST)?;
    let base_color = vectors(file, "base_color", count, 1.0)?;
    let opaque = column(file, "opaque", count, |x| x == 0.0 || x == 1.0)?;
    let roughness = column(file, "roughness", count, |x| (0.0..=1.0).contains(&x))?;
    let priority = column(file, "priority", count, |x| x.abs() <= 1000.0 && x.fract() == 0.0)?;
    let mut parts: Vec<(String, Material)> = Vec::with_capacity(count);
    for (i, name) in names.iter().enumerate() {
        let plain: String = name.chars().filter(|c| !c.is_control()).take(100).collect();
        let plain = if plain.trim().is_empty() { "part".to_owned() } else { plain.trim().to_owned() };
        // Names must be told apart.
        let taken = parts.iter().any(|(other, _)| *other == plain);
        let name = if taken { format!("{plain} #{i}") } else { plain };
        #[expect(clippy::cast_possible_truncation, reason = "in range, checked above")]
        let material = Material {
            opaque: opaque[i] == 1.0,
            ior: ior[i] as f32,
            sigma: sigma[i].as_vec3().max(Vec3::ZERO),
            base_color: base_color[i].as_vec3().max(Vec3::ZERO),
            roughness: roughness[i] as f32,
            priority: priority[i] as i32,
            ..Material::default()
        };
        parts.push((name, material));
    }
    Ok(parts)
}

fn column(file: &mut Archive<'_>, name: &str, count: usize, fits: impl Fn(f64) -> bool) -> Result<Vec<f64>, String> {
    let Array { shape, values } = file.numbers(name, |x| fits(x).then_some(x))?;
    if values.len() == count { Ok(values) } else { Err(wrong_shape(name, &shape, &[count])) }
}

/// So many vectors, no component further from 0 than `most`.
fn vectors(file: &mut Archive<'_>, name: &str, count: usize, most: f64) -> Result<Vec<DVec3>, String> {
    let Array { shape, values } = file.numbers(name, |x| (x.abs() <= most).then_some(x))?;
    if values.len() != 3 * count {
        return Err(wrong_shape(name, &shape, &[count, 3]));
    }
    Ok(values.chunks_exact(3).map(DVec3::from_slice).collect())
}

fn wrong_shape(name: &str, shape: &[u64], wanted: &[usize]) -> String {
    format!("`{name}` has shape {shape:?}, not {wanted:?} as the other arrays ask; save the voxels again")
}

/// A whole number in the range of `T`.
fn whole<T: TryFrom<u32>>(x: f64) -> Option<T> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "whole and in range, checked first")]
    let number = ((0.0..=4e9).contains(&x) && x.fract() == 0.0).then_some(x as u32)?;
    T::try_from(number).ok()
}
