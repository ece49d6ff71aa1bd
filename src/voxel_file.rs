//! Voxels on disk: `.npy`, `.npz`, `.vti`, `.nrrd`, `.vox` and `.ply`.
//!
//! | file    | holds                                                                                             |
//! |---------|---------------------------------------------------------------------------------------------------|
//! | `.npy`  | one array \[z\]\[y\]\[x\]: which voxels are marked, on the surface or inside                      |
//! | `.npz`  | everything: both arrays, the list with place, normal, part, triangle and colour, all materials    |
//! | `.vti`  | VTK image data, a value a cell: occupancy, interior, part, colour, normal; a table of materials   |
//! | `.nrrd` | one label a cell, 1 + its part; the materials as keys of its header                               |
//! | `.vox`  | MagicaVoxel: a colour of a palette of 255 and its material a cell; no more than 256 along an axis |
//! | `.ply`  | a point a surface voxel with normal, colour and part; a table of materials; no interior           |
//!
//! What a file can't hold is refused before anything is written. [`crate::scene::voxels`] reads `.npz` again.

mod npz;
mod nrrd;
mod ply;
mod vox;
mod vti;

use crate::animate::srgb8_from_linear;
use crate::image::{self, ImageError};
use crate::scene::material::Material;
use crate::voxel_list::ListedVoxel;
use glam::{DVec3, UVec3, Vec3};
use std::path::Path;

/// The most cells along an axis of what is written from memory, attributes and all; `.npy` is written slab by slab.
const MOST_CELLS: u32 = 512;

/// A format of voxels on disk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VoxelFormat {
    /// NumPy array.
    Npy,
    /// NumPy archive.
    Npz,
    /// VTK image data.
    Vti,
    /// Nearly raw raster data.
    Nrrd,
    /// MagicaVoxel.
    Vox,
    /// Points.
    Ply,
}

impl VoxelFormat {
    /// All, with their endings.
    pub const ALL: [(Self, &'static str); 6] = [
        (Self::Npy, "npy"),
        (Self::Npz, "npz"),
        (Self::Vti, "vti"),
        (Self::Nrrd, "nrrd"),
        (Self::Vox, "vox"),
        (Self::Ply, "ply"),
    ];

    /// The format that the ending of `path` names, once it is sure that a file can stand there and that the format
    /// holds a grid of `cells`, and the interior if `solid`.
    ///
    /// # Errors
    /// An unknown ending, a missing folder, something at `path` that is no file, or what the format can't hold.
    pub fn of(path: &Path, cells: UVec3, solid: bool) -> Result<Self, ImageError> {
        let unfit = |what: String| Err(ImageError::Unfit(path.to_owned(), what));
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        let Some((format, _)) = Self::ALL.iter().find(|(_, e)| *e == ending) else {
            let endings: Vec<String> = Self::ALL.iter().map(|(_, e)| format!(".{e}")).collect();
            return unfit(format!("unknown ending; write one of {}", endings.join(", ")));
        };
        image::check_place(path)?;
        match format {
            Self::Ply if solid => {
                unfit("holds points of the surface, no interior; leave out --solid, or write .npz".into())
            }
            Self::Vox if cells.max_element() > vox::MAX_CELLS => {
                let most = vox::MAX_CELLS;
                unfit(format!(
                    "holds {most} cells along an axis, not {cells}; choose --grid {most} or less, or write .npz"
                ))
            }
            Self::Npz | Self::Vti | Self::Nrrd | Self::Ply if cells.max_element() > MOST_CELLS => unfit(format!(
                "holds {MOST_CELLS} cells along an axis, not {cells}; choose --grid {MOST_CELLS} or less, or write .npy"
            )),
            _ => Ok(*format),
        }
    }
}

/// A body's voxels, of a grid of cubes along the world's axes.
#[derive(Debug, Clone, PartialEq)]
pub struct VoxelBody {
    /// Resolution.
    pub cells: UVec3,
    /// Lower corner of cell (0, 0, 0), world.
    pub origin: DVec3,
    /// Side of a cell, world units.
    pub cell: f64,
    /// What the voxelizer marked, or with `interior` what it made of the inside; 1 or 0, \[z\]\[y\]\[x\].
    pub marked: Vec<u8>,
    /// What fills each cell: 1 + its part, or 0; \[z\]\[y\]\[x\]. Only where the inside was asked for.
    pub interior: Option<Vec<u16>>,
    /// The surface's voxels, by rank.
    pub voxels: Vec<ListedVoxel>,
    /// Names and materials, in the order of [`ListedVoxel::part`].
    pub parts: Vec<(String, Material)>,
}

/// Writes the file, whole or not at all.
///
/// # Errors
/// When the place can't take it, or the disk is full; then nothing is left behind.
pub fn write(path: &Path, format: VoxelFormat, body: &VoxelBody) -> Result<(), ImageError> {
    let [nx, ny, nz] = body.cells.to_array().map(u64::from);
    match format {
        VoxelFormat::Npy => image::write_array(path, &[nz, ny, nx], &body.marked),
        VoxelFormat::Npz => image::atomically(path, |to| npz::write(to, body)),
        VoxelFormat::Vti => image::atomically(path, |to| vti::write(to, body)),
        VoxelFormat::Nrrd => image::atomically(path, |to| nrrd::write(to, body)),
        VoxelFormat::Vox => image::atomically(path, |to| vox::write(to, body)),
        VoxelFormat::Ply => image::atomically(path, |to| ply::write(to, body)),
    }
}

impl VoxelBody {
    /// Cells of one slice.
    fn slice_len(&self) -> usize {
        self.cells.x as usize * self.cells.y as usize
    }

    /// The list's voxels of each slice in turn: their place in the slice, and they.
    fn by_slice(&self) -> Vec<Vec<(usize, &ListedVoxel)>> {
        let mut slices = vec![Vec::new(); self.cells.z as usize];
        for voxel in &self.voxels {
            let cell = voxel.cell();
            slices[cell.z as usize].push((cell.y as usize * self.cells.x as usize + cell.x as usize, voxel));
        }
        slices
    }

    /// What is in each cell, 1 + its part: the interior where there is one, else the surface.
    fn labels(&self) -> Vec<u16> {
        let slice = self.slice_len();
        self.interior.clone().unwrap_or_else(|| {
            let mut labels = vec![0; slice * self.cells.z as usize];
            for (z, voxels) in self.by_slice().into_iter().enumerate() {
                voxels.into_iter().for_each(|(place, voxel)| labels[z * slice + place] = label(voxel));
            }
            labels
        })
    }

    /// The colour that a picture of a part's surface has, sRGB: for clear parts, what so much of the glass lets through
    /// as is a quarter of the grid's longest side.
    fn shown_color(&self, part: u32, linear: Vec3) -> [u8; 3] {
        let depth = self.cell * f64::from(self.cells.max_element()) * 0.25;
        let material = self.parts.get(part as usize).map(|(_, material)| material).filter(|m| !m.opaque);
        #[expect(clippy::cast_possible_truncation, reason = "colours are f32")]
        let left = material.map_or(Vec3::ONE, |m| (-m.sigma * depth as f32).exp());
        (linear * left).to_array().map(srgb8_from_linear)
    }
}

/// 1 + the voxel's part.
fn label(voxel: &ListedVoxel) -> u16 {
    u16::try_from(voxel.part + 1).unwrap_or(u16::MAX)
}
