//! `.npz`: a zip of NumPy arrays. Their names and shapes stand in [`crate::scene::voxels`], which reads them again.

use super::{VoxelBody, label};
use crate::animate::NO_TRIANGLE;
use crate::voxel_list::ListedVoxel;
use npyz::{AutoSerialize, DType, WriterBuilder as _};
use std::io::{Result, Seek, Write};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

pub(super) fn write(to: &mut (impl Write + Seek), body: &VoxelBody) -> Result<()> {
    let mut zip = ZipWriter::new(to);
    let [nx, ny, nz] = body.cells.to_array().map(u64::from);
    let count = body.voxels.len() as u64;
    let volume = [nz, ny, nx];
    let slice = body.slice_len();
    let surface = body.by_slice().into_iter().flat_map(|voxels| {
        let mut marked = vec![0_u8; slice];
        voxels.into_iter().for_each(|(place, _)| marked[place] = 1);
        marked
    });
    array(&mut zip, "occupancy", &volume, surface)?;
    if let Some(interior) = &body.interior {
        array(&mut zip, "interior", &volume, interior.iter().copied())?;
    }
    let vectors = |of: fn(&ListedVoxel) -> glam::Vec3| body.voxels.iter().flat_map(move |v| of(v).to_array());
    #[expect(clippy::cast_possible_truncation, reason = "cells of a grid of at most 512³")]
    let index = body.voxels.iter().flat_map(|v| v.cell().to_array().map(|n| n as u16));
    array(&mut zip, "index", &[count, 3], index)?;
    array(&mut zip, "position", &[count, 3], vectors(|v| v.position))?;
    array(&mut zip, "normal", &[count, 3], vectors(|v| v.normal))?;
    array(&mut zip, "color", &[count, 3], vectors(|v| v.color))?;
    array(&mut zip, "part", &[count], body.voxels.iter().map(|v| label(v) - 1))?;
    let number = |v: &ListedVoxel| if v.triangle == NO_TRIANGLE { -1 } else { i32::try_from(v.triangle).unwrap_or(-1) };
    array(&mut zip, "triangle", &[count], body.voxels.iter().map(number))?;
    array(&mut zip, "origin", &[3], body.origin.to_array())?;
    array(&mut zip, "cell", &[], [body.cell])?;
    materials(&mut zip, body)?;
    zip.finish()?.flush()
}

fn materials<W: Write + Seek>(zip: &mut ZipWriter<W>, body: &VoxelBody) -> Result<()> {
    let parts = &body.parts;
    let count = parts.len() as u64;
    let longest = parts.iter().map(|(name, _)| name.len()).max().unwrap_or(0).clamp(1, 256);
    zip.start_file("part_name.npy", options())?;
    let text: DType = DType::Plain(format!("|S{longest}").parse().map_err(std::io::Error::other)?);
    let mut writer = npyz::WriteOptions::<[u8]>::new().dtype(text).shape(&[count]).writer(&mut *zip).begin_nd()?;
    for (name, _) in parts {
        let mut end = name.len().min(longest);
        while !name.is_char_boundary(end) {
            end -= 1;
        }
        writer.push(&name.as_bytes()[..end])?;
    }
    writer.finish()?;
    let of = |each: fn(&crate::scene::material::Material) -> f32| parts.iter().map(move |(_, m)| each(m));
    array(zip, "ior", &[count], of(|m| m.ior))?;
    array(zip, "sigma", &[count, 3], parts.iter().flat_map(|(_, m)| m.sigma.to_array()))?;
    array(zip, "base_color", &[count, 3], parts.iter().flat_map(|(_, m)| m.base_color.to_array()))?;
    array(zip, "opaque", &[count], parts.iter().map(|(_, m)| u8::from(m.opaque)))?;
    array(zip, "roughness", &[count], of(|m| m.roughness))?;
    array(zip, "priority", &[count], parts.iter().map(|(_, m)| m.priority))
}

/// The same bytes every time: no time of day.
fn options() -> SimpleFileOptions {
    SimpleFileOptions::default()
        .compression_method(zip::CompressionMethod::Deflated)
        .compression_level(Some(3))
        .last_modified_time(zip::DateTime::default())
        .large_file(true)
}

fn array<W: Write + Seek, T: AutoSerialize>(
    zip: &mut ZipWriter<W>,
    name: &str,
    shape: &[u64],
    values: impl IntoIterator<Item = T>,
) -> Result<()> {
    zip.start_file(format!("{name}.npy"), options())?;
    let to = std::io::BufWriter::new(&mut *zip);
    let mut writer = npyz::WriteOptions::new().default_dtype().shape(shape).writer(to).begin_nd()?;
    writer.extend(values)?;
    writer.finish()
}
