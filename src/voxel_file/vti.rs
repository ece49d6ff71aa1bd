//! `.vti`: VTK XML image data, cell values inline, packed by zlib a slice a block, in base 64.
//!
//! Source: the VTK user's guide, "VTK file formats", XML and its compressed blocks.

use super::{VoxelBody, label};
use flate2::{Compression, write::ZlibEncoder};
use std::fmt::Write as _;
use std::io::{Result, Write};

/// An array of the file: its XML element, and its packed bytes in base 64.
struct Array {
    element: String,
    packed: String,
}

pub(super) fn write(to: &mut impl Write, body: &VoxelBody) -> Result<()> {
    let slice = body.slice_len();
    let mut arrays = Vec::new();
    let slices = body.by_slice();
    // One value a cell, slice by slice, from the list.
    let mut of_surface =
        |name: &str, kind: &str, components: usize, bytes: usize, of: &dyn Fn(&super::ListedVoxel) -> Vec<u8>| {
            let blocks = slices.iter().map(|voxels| {
                let mut block = vec![0_u8; slice * bytes];
                for (place, voxel) in voxels {
                    block[place * bytes..(place + 1) * bytes].copy_from_slice(&of(voxel));
                }
                block
            });
            let element = format!("<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\"");
            arrays.push(Array { element, packed: packed(blocks, slice * bytes, slices.len())? });
            Ok::<_, std::io::Error>(())
        };
    of_surface("occupancy", "UInt8", 1, 1, &|_| vec![1])?;
    of_surface("part", "UInt16", 1, 2, &|v| label(v).to_le_bytes().to_vec())?;
    of_surface("color", "UInt8", 3, 3, &|v| body.shown_color(v.part, v.color).to_vec())?;
    of_surface("normal", "Float32", 3, 12, &|v| v.normal.to_array().map(f32::to_le_bytes).concat())?;
    if let Some(interior) = &body.interior {
        let blocks = interior.chunks_exact(slice).map(|labels| labels.iter().flat_map(|l| l.to_le_bytes()).collect());
        let element = "<DataArray type=\"UInt16\" Name=\"interior\" NumberOfComponents=\"1\"".to_owned();
        arrays.push(Array { element, packed: packed(blocks, slice * 2, slices.len())? });
    }

    let [nx, ny, nz] = body.cells.to_array();
    let extent = format!("0 {nx} 0 {ny} 0 {nz}");
    let ([x, y, z], cell) = (body.origin.to_array(), body.cell);
    writeln!(to, "<?xml version=\"1.0\"?>")?;
    writeln!(
        to,
        "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" \
         compressor=\"vtkZLibDataCompressor\">"
    )?;
    writeln!(
        to,
        "<ImageData WholeExtent=\"{extent}\" Origin=\"{x} {y} {z}\" Spacing=\"{cell} {cell} {cell}\" \
         Direction=\"1 0 0 0 1 0 0 0 1\">"
    )?;
    writeln!(to, "{}", materials(body))?;
    writeln!(to, "<Piece Extent=\"{extent}\">\n<PointData/>\n<CellData Scalars=\"part\" Normals=\"normal\">")?;
    for array in &arrays {
        writeln!(to, "{} format=\"binary\">{}</DataArray>", array.element, array.packed)?;
    }
    writeln!(to, "</CellData>\n</Piece>\n</ImageData>\n</VTKFile>")?;
    to.flush()
}

/// The materials' numbers, a row a part; row 0 is part label 1.
fn materials(body: &VoxelBody) -> String {
    let count = body.parts.len();
    let mut text = "<FieldData>".to_owned();
    let mut column = |name: &str, components: usize, values: Vec<f32>| {
        let values: Vec<String> = values.iter().map(f32::to_string).collect();
        // Writing to a string can't fail.
        let _ = write!(
            text,
            "\n<DataArray type=\"Float32\" Name=\"{name}\" NumberOfComponents=\"{components}\" \
             NumberOfTuples=\"{count}\" format=\"ascii\">{}</DataArray>",
            values.join(" ")
        );
    };
    column("ior", 1, body.parts.iter().map(|(_, m)| m.ior).collect());
    column("sigma", 3, body.parts.iter().flat_map(|(_, m)| m.sigma.to_array()).collect());
    column("opaque", 1, body.parts.iter().map(|(_, m)| f32::from(u8::from(m.opaque))).collect());
    text + "\n</FieldData>"
}

/// Blocks of `block_bytes` each, packed: their number, their size, the last one's, and each one's packed size; then they. Both in base 64, each by itself.
fn packed(blocks: impl Iterator<Item = Vec<u8>>, block_bytes: usize, count: usize) -> Result<String> {
    let mut head: Vec<u8> = [count as u64, block_bytes as u64, block_bytes as u64].map(u64::to_le_bytes).concat();
    let mut body = Vec::new();
    for block in blocks {
        let before = body.len();
        let mut encoder = ZlibEncoder::new(&mut body, Compression::fast());
        encoder.write_all(&block)?;
        encoder.finish()?;
        head.extend(((body.len() - before) as u64).to_le_bytes());
    }
    Ok(base64(&head) + &base64(&body))
}

/// RFC 4648, with padding.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let byte = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for i in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * i) & 63) as usize];
            text.push(if i <= three.len() { char::from(digit) } else { '=' });
        }
    }
    text
}
