//! The sheet buffers and the worksheet of `three-axis` as pictures, as DO Figs. 2 and 3 show them.
//!
//! A pixel is a texel: 32 cells along the sheet's axis. Its patches, a slab each, stand in rows from the top left. A bit's
//! colour runs from blue at the slab's near end to amber at the far one; a texel has the mean of its bits'.

use crate::frame::Frame;
use crate::gpu::{Gpu, GpuError, buffer};
use crate::grid::Grid;
use crate::image::Picture;
use crate::voxelize::Sheets;

/// Colours of an empty texel, of the lines between patches, and of the first and the last bit.
const EMPTY: [u8; 3] = [22, 22, 26];
const LINE: [u8; 3] = [70, 70, 78];
const NEAR: [f32; 3] = [74.0, 132.0, 255.0];
const FAR: [f32; 3] = [255.0, 178.0, 64.0];

/// The sheets along x, y and z of the view's grid as last marked, and the worksheet; none of a method that has no sheets.
/// Waits for the device: never in a frame.
///
/// # Errors
/// When the device is lost.
pub fn pictures(gpu: &Gpu, frame: &Frame) -> Result<Vec<(&'static str, Picture)>, GpuError> {
    let (Some(sheets), Some(grid)) = (frame.sheets(), frame.volume().grids.first()) else { return Ok(Vec::new()) };
    let mut pictures = Vec::new();
    for (axis, name) in ["sheet along x", "sheet along y", "sheet along z"].into_iter().enumerate() {
        let sheet = Sheets::sheet(sheets.cells, axis);
        let count = (sheet.size.element_product() * sheet.patches) as usize;
        let texels: Vec<u32> = buffer::read(gpu, &sheets.words, sheet.first.into(), count)?;
        pictures.push((name, picture(sheet.size.to_array(), sheet.patches, &texels)));
    }
    let words = buffer::read(gpu, &frame.volume().occupancy, grid.word_base.into(), grid.word_count() as usize)?;
    pictures.push(("worksheet", worksheet(grid, &words)));
    Ok(pictures)
}

/// The volume's words in patches, as a sheet along z has them.
fn worksheet(grid: &Grid, words: &[u32]) -> Picture {
    let (columns, patches) = (grid.cells.x * grid.cells.y, grid.words_per_column);
    let texel = |slab: u32, column: u32| words[(column * patches + slab) as usize];
    let texels: Vec<u32> = (0..patches).flat_map(|slab| (0..columns).map(move |column| texel(slab, column))).collect();
    picture([grid.cells.x, grid.cells.y], patches, &texels)
}

/// Texels of `patches` patches of a size, one after the other, as a picture of nearly as many rows as columns of them.
fn picture([width, height]: [u32; 2], patches: u32, texels: &[u32]) -> Picture {
    let across = (1..=patches).find(|across| across * across >= patches).unwrap_or(1);
    let down = patches.div_ceil(across);
    let size = [across * (width + 1) + 1, down * (height + 1) + 1];
    let mut rgb8 = vec![LINE; (size[0] * size[1]) as usize];
    for (i, &texel) in (0..).zip(texels) {
        let (patch, at) = (i / (width * height), i % (width * height));
        let x = patch % across * (width + 1) + 1 + at % width;
        let y = patch / across * (height + 1) + 1 + at / width;
        rgb8[(y * size[0] + x) as usize] = color(texel);
    }
    Picture { width: size[0], height: size[1], rgb8 }
}

/// The mean colour of a texel's bits.
fn color(texel: u32) -> [u8; 3] {
    if texel == 0 {
        return EMPTY;
    }
    let sum: u32 = (0..32).filter(|bit| texel >> bit & 1 == 1).sum();
    let far = sum as f32 / texel.count_ones() as f32 / 31.0;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between two colours")]
    [0, 1, 2].map(|i| (NEAR[i] + (FAR[i] - NEAR[i]) * far).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_stand_in_rows_and_bits_run_from_blue_to_amber() {
        // Five patches of 2 by 1: three a row.
        let mut texels = [0; 10];
        (texels[0], texels[7], texels[9]) = (1, 1 << 31, 1 | 1 << 31);
        let picture = picture([2, 1], 5, &texels);
        assert_eq!((picture.width, picture.height), (10, 5));
        let at = |x: u32, y: u32| picture.rgb8[(y * 10 + x) as usize];
        assert_eq!([at(1, 1), at(2, 3), at(5, 3)], [[74, 132, 255], [255, 178, 64], [165, 155, 160]]);
        assert_eq!([at(2, 1), at(0, 0), at(8, 3)], [EMPTY, LINE, LINE]);
    }
}
