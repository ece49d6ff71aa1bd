//! `.nrrd`, version 4: a text header, an empty line, gzipped labels, x fastest.
//!
//! Source: the format's definition, teem.sourceforge.net/nrrd/format.html.

use super::VoxelBody;
use flate2::{Compression, write::GzEncoder};
use std::io::{Result, Write};

pub(super) fn write(to: &mut impl Write, body: &VoxelBody) -> Result<()> {
    let [nx, ny, nz] = body.cells.to_array();
    // Its origin is the middle of the first sample.
    let [x, y, z] = (body.origin + body.cell * 0.5).to_array();
    let cell = body.cell;
    writeln!(to, "NRRD0004\n# voxels by murrine: 0 is empty, else 1 + the part")?;
    writeln!(to, "type: uint16\ndimension: 3\nspace dimension: 3\nsizes: {nx} {ny} {nz}")?;
    writeln!(to, "space directions: ({cell},0,0) (0,{cell},0) (0,0,{cell})\nspace origin: ({x},{y},{z})")?;
    writeln!(to, "kinds: domain domain domain\ncenterings: cell cell cell\nendian: little\nencoding: gzip")?;
    for (i, (name, material)) in (1..).zip(&body.parts) {
        let [r, g, b] = material.sigma.to_array();
        let name: String = name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        writeln!(to, "part {i} name:={name}\npart {i} opaque:={}", material.opaque)?;
        writeln!(to, "part {i} ior:={}\npart {i} sigma:={r} {g} {b}", material.ior)?;
    }
    writeln!(to)?;
    let mut packed = GzEncoder::new(to, Compression::fast());
    for label in body.labels() {
        packed.write_all(&label.to_le_bytes())?;
    }
    packed.finish()?.flush()
}
