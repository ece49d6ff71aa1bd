//! Separating axes in f64 on all cores: the truth that the other methods are held to.
//!
//! Source: [`papers::AKENINE_MOLLER_2001`], as TR §1.4.1 gives it; the thin rule from RB §3.1, Fig. 18.
//!
//! | paper (TR §1.4.1)       | here                      | meaning                                      |
//! |-------------------------|---------------------------|----------------------------------------------|
//! | c, h                    | `AxisBox::center`, `half` | the voxel's centre and half extents          |
//! | v_i − c                 | `v`                       | vertices seen from the centre                |
//! | f_i                     | `e`                       | edges                                        |
//! | a_ij = e_i × f_j, n     | `axis`                    | what may separate                            |
//! | r                       | `reach`                   | the box's half length along it               |
//!
//! Differs: each triangle descends a tree of boxes that halve the grid, so that a huge one doesn't visit every voxel of
//! its own box; the test at each node is the same. Vertices are mapped in f64 by the matrices that the device has.
//! Promises: every voxel that the closed triangle touches (26), or Schwarz & Seidel's thin set (6). Costs: reads the
//! triangles back, the one voxelizer that waits for the device.

use super::clip::grid_triangles;
use super::separating_axes::{AxisBox, overlaps, thick, thin};
use super::{Input, Method, Promise, Voxelizer};
use crate::animate::{Triangles, Vertex};
use crate::gpu::{Gpu, GpuError, Recorder, buffer};
use crate::grid::Grid;
use crate::papers;
use crate::scene::description::Separability;
use crate::scene::material::PartMaterial;
use glam::{DVec3, UVec3, Vec3};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering};

pub(super) const METHOD: Method = Method {
    name: "cpu-exact",
    summary: "separating axes in f64 on the CPU: the truth; slow",
    shader: None,
    paper: &papers::AKENINE_MOLLER_2001,
    promise: Promise::Exact,
    interior: false,
    conservative: &[],
    new: |_| Ok(Box::new(CpuExact {})),
};

/// Half width of the band in which f32 can't be held to the truth, as a fraction of the grid's longest axis, or of the
/// distance to a triangle's farthest vertex where that is more.
pub const TIE_BAND: f64 = 1e-6;

/// The true voxels of a set of triangles, as occupancy words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExactVoxels {
    /// Marked voxels.
    pub words: Vec<u32>,
    /// Voxels that are marked or not by less than [`TIE_BAND`].
    pub ties: Vec<u32>,
}

/// Marks the voxels of `grid` that world-space `triangles` meet. Words are laid out as [`Grid::word_of`] says.
#[must_use]
pub fn exact_voxels(grid: &Grid, triangles: &[[Vec3; 3]], separability: Separability) -> ExactVoxels {
    let words = || -> Vec<AtomicU32> { (0..grid.word_count()).map(|_| AtomicU32::new(0)).collect() };
    let (marked, sure, maybe) = (words(), words(), words());
    let grid_from_world = grid.grid_from_world.as_dmat4();
    let set = |to: &[AtomicU32], cell: [u32; 3]| {
        to[grid.word_of(cell)].fetch_or(1 << (cell[2] & 31), Ordering::Relaxed);
    };
    triangles.par_iter().for_each(|&triangle| {
        for t in grid_triangles(grid, &grid_from_world, triangle) {
            let farthest = t.iter().map(|v| v.abs().max_element()).fold(0.0, f64::max);
            let band = TIE_BAND * farthest.max(f64::from(grid.cells.max_element()));
            for_each_cell_near(grid, &t, band, &mut |cell| {
                let cell_box = box_of(grid, UVec3::from_array(cell), UVec3::ONE);
                let verdict = match separability {
                    Separability::TwentySix => thick(&t, cell_box, band),
                    Separability::Six => thin(&t, cell_box, band),
                };
                let to = [(verdict.marked, &marked), (verdict.surely_marked, &sure), (verdict.maybe_marked, &maybe)];
                for (holds, to) in to {
                    if holds {
                        set(to, cell);
                    }
                }
            });
        }
    });
    let plain = |words: Vec<AtomicU32>| words.into_iter().map(AtomicU32::into_inner);
    ExactVoxels {
        words: plain(marked).collect(),
        ties: plain(maybe).zip(plain(sure)).map(|(maybe, sure)| maybe & !sure).collect(),
    }
}

/// Marks the same voxels as [`exact_voxels`] does, without asking which of them are ties.
#[must_use]
pub fn marked_voxels(grid: &Grid, triangles: &[[Vec3; 3]], separability: Separability) -> Vec<u32> {
    let words: Vec<AtomicU32> = (0..grid.word_count()).map(|_| AtomicU32::new(0)).collect();
    let grid_from_world = grid.grid_from_world.as_dmat4();
    triangles.par_iter().for_each(|&triangle| {
        for t in grid_triangles(grid, &grid_from_world, triangle) {
            // Boxes of many cells round otherwise than those of one: the slack keeps any of them from cutting one off.
            for_each_cell_near(grid, &t, TIE_BAND, &mut |cell| {
                let cell_box = box_of(grid, UVec3::from_array(cell), UVec3::ONE);
                let marked = match separability {
                    Separability::TwentySix => overlaps(&t, cell_box),
                    Separability::Six => thin(&t, cell_box, 0.0).marked,
                };
                if marked {
                    words[grid.word_of(cell)].fetch_or(1 << (cell[2] & 31), Ordering::Relaxed);
                }
            });
        }
    });
    words.into_iter().map(AtomicU32::into_inner).collect()
}

/// Calls `visit` for every cell whose box, grown by `slack`, meets the triangle; and for no other.
fn for_each_cell_near(grid: &Grid, triangle: &[DVec3; 3], slack: f64, visit: &mut impl FnMut([u32; 3])) {
    let lo = triangle[0].min(triangle[1]).min(triangle[2]);
    let hi = triangle[0].max(triangle[1]).max(triangle[2]);
    // Widened by a whole cell, so that nothing hangs on how these round.
    let slice_of = |z: f64| grid.slice_of(z.clamp(0.0, f64::from(grid.cells.z)));
    let first = whole(DVec3::new(lo.x, lo.y, slice_of(lo.z)) - 1.0, grid.cells);
    let end = whole(DVec3::new(hi.x, hi.y, slice_of(hi.z)) + 2.0, grid.cells);
    let mut stack = vec![(first, end)];
    while let Some((first, end)) = stack.pop() {
        if first.cmpge(end).any() {
            continue;
        }
        let mut cell_box = box_of(grid, first, end - first);
        cell_box.half += slack;
        if !overlaps(triangle, cell_box) {
            continue;
        }
        let size = end - first;
        if size == UVec3::ONE {
            visit(first.to_array());
            continue;
        }
        let axis = (0..3).max_by_key(|&a| size[a]).unwrap_or(0);
        let mut middle_end = end;
        middle_end[axis] = first[axis] + size[axis] / 2;
        let mut middle_first = first;
        middle_first[axis] = middle_end[axis];
        stack.push((first, middle_end));
        stack.push((middle_first, end));
    }
}

/// The box of `size` cells from `first` in grid space.
fn box_of(grid: &Grid, first: UVec3, size: UVec3) -> AxisBox {
    let corner = |cell: UVec3| {
        let p = cell.as_dvec3();
        DVec3::new(p.x, p.y, grid.slab(p.z))
    };
    let (lo, hi) = (corner(first), corner(first + size));
    AxisBox { center: (lo + hi) * 0.5, half: (hi - lo) * 0.5 }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the grid")]
fn whole(cell: DVec3, cells: UVec3) -> UVec3 {
    let cell = cell.floor().clamp(DVec3::ZERO, cells.as_dvec3());
    UVec3::new(cell.x as u32, cell.y as u32, cell.z as u32)
}

#[derive(Debug)]
struct CpuExact {}

impl Voxelizer for CpuExact {
    fn record(&mut self, rec: &mut Recorder<'_>, input: &Input<'_>) -> Result<(), GpuError> {
        rec.flush()?;
        let grid = &input.volume.grids[input.grid];
        let triangles = world_triangles(rec.gpu, input.triangles, grid.required_flags)?;
        let words = marked_voxels(grid, &triangles, input.settings.separability);
        let offset = u64::from(grid.word_base) * size_of::<u32>() as u64;
        rec.gpu.queue.write_buffer(&input.volume.occupancy, offset, bytemuck::cast_slice(&words));
        Ok(())
    }
}

/// The animated triangles of the parts that have all `required_flags`, in world space. Waits for the device.
///
/// # Errors
/// When it is lost.
pub fn world_triangles(gpu: &Gpu, from: &Triangles, required_flags: u32) -> Result<Vec<[Vec3; 3]>, GpuError> {
    let vertices: Vec<Vertex> = buffer::read(gpu, &from.vertices, 0, from.vertex_count as usize)?;
    let indices: Vec<[u32; 3]> = buffer::read(gpu, &from.indices, 0, from.triangle_count as usize)?;
    let part_count = vertices.iter().map(|v| v.part as usize + 1).max().unwrap_or(0);
    let materials: Vec<PartMaterial> = buffer::read(gpu, &from.materials, 0, part_count)?;
    let wanted = |part: u32| materials[part as usize].flags & required_flags == required_flags;
    Ok((indices.iter().filter(|[first, ..]| wanted(vertices[*first as usize].part)))
        .map(|t| t.map(|i| vertices[i as usize].position))
        .collect())
}
