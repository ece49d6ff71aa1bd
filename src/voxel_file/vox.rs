//! `.vox` of MagicaVoxel, version 150: a model of at most 256 cells along an axis, a palette of 255 colours, and a
//! material for each of them. Its z is up: our y.
//!
//! Source: the format's definition, github.com/ephtracy/voxel-model, `MagicaVoxel-file-format-vox.txt` and its extension.
//! Colours that are too many are rounded to fewer bits until they fit; an entry is the mean of its voxels.

use super::VoxelBody;
use crate::scene::material::Material;
use glam::{UVec3, Vec3};
use std::collections::BTreeMap;
use std::io::{Result, Write};

/// The most cells along an axis.
pub(super) const MAX_CELLS: u32 = 256;
/// Colours of a palette; index 0 is empty.
const MAX_COLORS: usize = 255;

/// A voxel with the part and colour that it shows.
struct Shown {
    cell: UVec3,
    part: u32,
    rgb: [u8; 3],
}

pub(super) fn write(to: &mut impl Write, body: &VoxelBody) -> Result<()> {
    let shown = shown(body);
    let (entries, bits) = palette(&shown);
    let index_of: BTreeMap<(u32, [u8; 3]), u8> = entries.keys().copied().zip(1..=255).collect();

    let [nx, ny, nz] = body.cells.to_array();
    let mut chunks = Vec::new();
    chunk(&mut chunks, b"SIZE", &[nx, nz, ny].map(u32::to_le_bytes).concat());
    let mut voxels = u32::try_from(shown.len()).unwrap_or(u32::MAX).to_le_bytes().to_vec();
    for voxel in &shown {
        let UVec3 { x, y, z } = voxel.cell;
        // Turned about x, so that up stays up and left stays left.
        let [x, y, z] = [x, nz - 1 - z, y].map(|n| u8::try_from(n).unwrap_or(u8::MAX));
        let index = index_of.get(&(voxel.part, rounded(voxel.rgb, bits))).copied().unwrap_or(1);
        voxels.extend([x, y, z, index]);
    }
    chunk(&mut chunks, b"XYZI", &voxels);
    let mut colors = [[0_u8; 4]; 256];
    for (color, mean) in colors.iter_mut().zip(entries.values()) {
        let [r, g, b] = mean.rgb();
        *color = [r, g, b, 255];
    }
    chunk(&mut chunks, b"RGBA", colors.as_flattened());
    for (index, (part, _)) in (1_u32..).zip(entries.keys()) {
        if let Some((_, material)) = body.parts.get(*part as usize).filter(|(_, m)| !m.opaque) {
            chunk(&mut chunks, b"MATL", &glass(index, material));
        }
    }
    to.write_all(b"VOX ")?;
    to.write_all(&150_u32.to_le_bytes())?;
    to.write_all(b"MAIN")?;
    to.write_all(&0_u32.to_le_bytes())?;
    to.write_all(&u32::try_from(chunks.len()).map_err(std::io::Error::other)?.to_le_bytes())?;
    to.write_all(&chunks)?;
    to.flush()
}

/// The surface's voxels, or those inside: each of its surface's colour, or of its part's mean where it has none.
fn shown(body: &VoxelBody) -> Vec<Shown> {
    let color_of = |voxel: &crate::voxel_list::ListedVoxel| body.shown_color(voxel.part, voxel.color);
    let of_voxel = |v: &crate::voxel_list::ListedVoxel| Shown { cell: v.cell(), part: v.part, rgb: color_of(v) };
    let Some(interior) = &body.interior else { return body.voxels.iter().map(of_voxel).collect() };
    let mut sums = vec![(Vec3::ZERO, 0.0_f32); body.parts.len()];
    for voxel in &body.voxels {
        if let Some((sum, count)) = sums.get_mut(voxel.part as usize) {
            *sum += voxel.color;
            *count += 1.0;
        }
    }
    let slice = body.slice_len();
    let mut shown = Vec::new();
    for (z, (voxels, labels)) in (0..).zip(body.by_slice().into_iter().zip(interior.chunks_exact(slice))) {
        let surface: BTreeMap<usize, _> = voxels.into_iter().collect();
        for (place, label) in labels.iter().enumerate().filter(|(_, label)| **label != 0) {
            let part = u32::from(*label - 1);
            let rgb = match surface.get(&place).filter(|v| v.part == part) {
                Some(voxel) => color_of(voxel),
                None => {
                    let (sum, count) = sums.get(part as usize).copied().unwrap_or((Vec3::ONE, 1.0));
                    body.shown_color(part, sum / count.max(1.0))
                }
            };
            let across = body.cells.x as usize;
            #[expect(clippy::cast_possible_truncation, reason = "cells of a grid of at most 256³")]
            let cell = UVec3::new((place % across) as u32, (place / across) as u32, z);
            shown.push(Shown { cell, part, rgb });
        }
    }
    shown
}

/// Adds up colours.
#[derive(Default)]
struct Mean {
    sums: [u64; 3],
    count: u64,
}

impl Mean {
    fn rgb(&self) -> [u8; 3] {
        let count = self.count.max(1);
        self.sums.map(|sum| u8::try_from((sum + count / 2) / count).unwrap_or(u8::MAX))
    }
}

/// Parts and colours of so few bits a component that there are no more than a palette holds, and that number of bits.
fn palette(shown: &[Shown]) -> (BTreeMap<(u32, [u8; 3]), Mean>, u32) {
    let mut bits = 8;
    loop {
        let mut entries: BTreeMap<(u32, [u8; 3]), Mean> = BTreeMap::new();
        for voxel in shown {
            let mean = entries.entry((voxel.part, rounded(voxel.rgb, bits))).or_default();
            (0..3).for_each(|c| mean.sums[c] += u64::from(voxel.rgb[c]));
            mean.count += 1;
            if entries.len() > MAX_COLORS && bits > 0 {
                break;
            }
        }
        if entries.len() <= MAX_COLORS || bits == 0 {
            // More parts than colours: the last ones show the first one's.
            while entries.len() > MAX_COLORS {
                entries.pop_last();
            }
            return (entries, bits);
        }
        bits -= 1;
    }
}

/// The colour's highest bits.
fn rounded(rgb: [u8; 3], bits: u32) -> [u8; 3] {
    rgb.map(|c| u8::try_from(u32::from(c) >> (8 - bits)).unwrap_or(0))
}

/// A clear part's material for one colour of the palette.
fn glass(index: u32, material: &Material) -> Vec<u8> {
    let mut bytes = index.to_le_bytes().to_vec();
    let absorbed = material.sigma.element_sum() / 3.0;
    let properties = [
        ("_type", "_glass".to_owned()),
        ("_alpha", "0.5".to_owned()),
        ("_trans", "0.5".to_owned()),
        ("_rough", format!("{}", material.roughness)),
        ("_ior", format!("{}", material.ior - 1.0)),
        ("_att", format!("{absorbed}")),
    ];
    bytes.extend(u32::try_from(properties.len()).unwrap_or(0).to_le_bytes());
    for (key, value) in &properties {
        for text in [key.as_bytes(), value.as_bytes()] {
            bytes.extend(u32::try_from(text.len()).unwrap_or(0).to_le_bytes());
            bytes.extend(text);
        }
    }
    bytes
}

fn chunk(to: &mut Vec<u8>, name: &[u8; 4], content: &[u8]) {
    to.extend(name);
    to.extend(u32::try_from(content.len()).unwrap_or(u32::MAX).to_le_bytes());
    to.extend(0_u32.to_le_bytes());
    to.extend(content);
}
