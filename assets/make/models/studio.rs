//! Surroundings for glass: a dim room with a warm window on one side, a cool one on the other and a pale ceiling, as an
//! equirectangular picture in Radiance's format. Whole numbers only: a mantissa of eight bits a colour, one exponent.

const WIDTH: usize = 64;
const HEIGHT: usize = 32;

/// A pixel's red, green, blue, and the exponent that they share: value · 2^(exponent − 136).
type Rgbe = [u8; 4];

const WARM: Rgbe = [250, 190, 120, 131];
const COOL: Rgbe = [120, 175, 250, 130];
const CEILING: Rgbe = [230, 225, 215, 128];

fn pixel(x: usize, y: usize) -> Rgbe {
    let in_window = |left: usize| (left..left + 10).contains(&x) && (9..19).contains(&y) && x != left + 5;
    if in_window(8) {
        WARM
    } else if in_window(42) {
        COOL
    } else if y < 5 {
        CEILING
    } else {
        // Walls and floor: a dark gradient, a step a row.
        let level = u8::try_from(150 - 3 * y.min(31)).unwrap_or(0);
        [level, level - level / 8, level - level / 4, 126]
    }
}

pub(crate) fn make() -> Vec<u8> {
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {HEIGHT} +X {WIDTH}\n").into_bytes();
    for y in 0..HEIGHT {
        // Each row says its width, then the four components one after the other, in runs of at most 128 plain bytes.
        bytes.extend([2, 2, 0, 64]);
        for component in 0..4 {
            bytes.push(64);
            bytes.extend((0..WIDTH).map(|x| pixel(x, y)[component]));
        }
    }
    bytes
}
