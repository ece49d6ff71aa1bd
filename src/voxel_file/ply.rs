//! `.ply`, binary little endian: a point a surface voxel, then a row a material.

use super::{VoxelBody, label};
use std::io::{Result, Write};

pub(super) fn write(to: &mut impl Write, body: &VoxelBody) -> Result<()> {
    writeln!(to, "ply\nformat binary_little_endian 1.0\ncomment surface voxels by murrine, {} wide", body.cell)?;
    writeln!(to, "element vertex {}", body.voxels.len())?;
    for name in ["x", "y", "z", "nx", "ny", "nz"] {
        writeln!(to, "property float {name}")?;
    }
    writeln!(to, "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty ushort part")?;
    writeln!(to, "element material {}", body.parts.len())?;
    for name in ["ior", "sigma_red", "sigma_green", "sigma_blue"] {
        writeln!(to, "property float {name}")?;
    }
    writeln!(to, "property uchar opaque\nend_header")?;
    for voxel in &body.voxels {
        for number in voxel.position.to_array().into_iter().chain(voxel.normal.to_array()) {
            to.write_all(&number.to_le_bytes())?;
        }
        to.write_all(&body.shown_color(voxel.part, voxel.color))?;
        to.write_all(&(label(voxel) - 1).to_le_bytes())?;
    }
    for (_, material) in &body.parts {
        for number in [material.ior].into_iter().chain(material.sigma.to_array()) {
            to.write_all(&number.to_le_bytes())?;
        }
        to.write_all(&[u8::from(material.opaque)])?;
    }
    to.flush()
}
