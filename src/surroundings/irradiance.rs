//! What a background sheds on a surface: nine spherical harmonics of the surface's normal, cosine lobe folded in.
//!
//! Source: Ramamoorthi & Hanrahan 2001, "An Efficient Representation for Irradiance Environment Maps". The polynomials
//! are, in order: 1, y, z, x, xy, yz, 3z² − 1, xz, x² − y²; `background_irradiance` in `lib/shading.inc.wgsl` sums
//! them. Mean error of a diffuse surface under any distant light: about 1%.

use crate::scene::world::EnvironmentMap;
use glam::{Vec3, Vec4};
use std::f32::consts::PI;

/// Coefficients of the nine polynomials.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Irradiance([Vec3; 9]);

/// Squared normalisation of each polynomial times the cosine lobe's weight of its band.
const WEIGHTS: [f32; 9] = {
    const BAND_0: f32 = PI * 0.079_577_47;
    const BAND_1: f32 = 2.0 * PI / 3.0 * 0.238_732_41;
    const BAND_2: f32 = PI / 4.0 * 1.193_662;
    [BAND_0, BAND_1, BAND_1, BAND_1, BAND_2, BAND_2, BAND_2 / 12.0, BAND_2, BAND_2 / 4.0]
};

fn polynomials(d: Vec3) -> [f32; 9] {
    [1.0, d.y, d.z, d.x, d.x * d.y, d.y * d.z, 3.0 * d.z * d.z - 1.0, d.x * d.z, d.x * d.x - d.y * d.y]
}

/// Rows and columns of directions that a formula is summed over.
const ROWS: u32 = 32;
const COLUMNS: u32 = 64;

impl Irradiance {
    /// Of the radiance that `radiance` gives for each unit direction.
    pub(super) fn of(radiance: impl Fn(Vec3) -> Vec3) -> Self {
        Self::sum(COLUMNS, ROWS, |_, _, direction| radiance(direction))
    }

    /// Of an equirectangular picture as it stands; see `background_from` for which way it faces.
    pub(super) fn of_map(map: &EnvironmentMap) -> Self {
        Self::sum(map.width, map.height, |column, row, _| {
            let rgb = Vec3::from(map.rgb[row as usize * map.width as usize + column as usize]);
            rgb.map(|x| if x.is_nan() { 0.0 } else { x.clamp(0.0, 65_504.0) })
        })
    }

    /// Sums texels of an equirectangular picture, each by its solid angle.
    fn sum(columns: u32, rows: u32, texel: impl Fn(u32, u32, Vec3) -> Vec3) -> Self {
        let mut sums = [Vec3::ZERO; 9];
        let mut solid_angle = 0.0;
        for row in 0..rows {
            let (sin, cos) = (PI * (row as f32 + 0.5) / rows as f32).sin_cos();
            let mut line = [Vec3::ZERO; 9];
            for column in 0..columns {
                let (x, z) = (2.0 * PI * ((column as f32 + 0.5) / columns as f32 - 0.5)).sin_cos();
                let direction = Vec3::new(sin * x, cos, -sin * z);
                let radiance = texel(column, row, direction);
                for (sum, value) in line.iter_mut().zip(polynomials(direction)) {
                    *sum += radiance * value;
                }
            }
            for (sum, of_line) in sums.iter_mut().zip(line) {
                *sum += of_line * sin;
            }
            solid_angle += sin * columns as f32;
        }
        let per_texel = 4.0 * PI / solid_angle;
        Self(std::array::from_fn(|i| sums[i] * (per_texel * WEIGHTS[i])))
    }

    /// Of the same surroundings looked up with directions turned by `turn` radians about y, as `background_from` does.
    pub(super) fn turned(&self, turn: f32) -> Self {
        let [c0, cy, cz, cx, cxy, cyz, czz, cxz, cxx] = self.0;
        let (s, c) = turn.sin_cos();
        // Substitute x → c·x − s·z and z → s·x + c·z, then gather; x², y² and z² sum to one.
        let xx = 3.0 * s * s * czz + c * s * cxz + c * c * cxx;
        let zz = 3.0 * c * c * czz - c * s * cxz + s * s * cxx;
        Self([
            c0,
            cy,
            c * cz - s * cx,
            s * cz + c * cx,
            c * cxy + s * cyz,
            c * cyz - s * cxy,
            (zz - czz) * 0.5,
            6.0 * s * c * czz + (c * c - s * s) * cxz - 2.0 * c * s * cxx,
            (xx + cxx) * 0.5,
        ])
    }

    /// As the uniform holds them.
    pub(super) fn coefficients(&self, scale: f32) -> [Vec4; 9] {
        self.0.map(|rgb| (rgb * scale).extend(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(irradiance: &Irradiance, n: Vec3) -> Vec3 {
        irradiance.0.iter().zip(polynomials(n)).map(|(rgb, value)| *rgb * value).sum()
    }

    const NORMALS: [Vec3; 4] = [Vec3::Y, Vec3::NEG_Y, Vec3::new(0.6, 0.0, -0.8), Vec3::new(-0.36, 0.48, 0.8)];

    #[test]
    fn a_uniform_sky_sheds_pi_times_its_radiance_on_every_side() {
        let uniform = Irradiance::of(|_| Vec3::new(1.0, 2.0, 0.5));
        for n in NORMALS {
            let error = at(&uniform, n) - PI * Vec3::new(1.0, 2.0, 0.5);
            assert!(error.length() < 0.02, "{n}: off by {error}");
        }
    }

    #[test]
    fn a_half_sky_sheds_what_the_cosine_integral_says() {
        // Radiance 1 above the horizon: E(n) = π/2·(1 + n.y), which two bands hold exactly.
        let half = Irradiance::of(|d| Vec3::splat(if d.y > 0.0 { 1.0 } else { 0.0 }));
        for n in NORMALS {
            let truth = PI / 2.0 * (1.0 + n.y);
            assert!((at(&half, n).x - truth).abs() < 0.02, "{n}: {} instead of {truth}", at(&half, n).x);
        }
    }

    #[test]
    fn turning_the_coefficients_is_turning_the_picture() {
        let radiance = |d: Vec3| Vec3::new(d.x.max(0.0), (d.x * d.z).abs(), d.z * d.z + d.y * d.x + 2.0);
        let turn = |d: Vec3| {
            let (s, c) = 0.7_f32.sin_cos();
            Vec3::new(c * d.x - s * d.z, d.y, s * d.x + c * d.z)
        };
        let turned_map = Irradiance::of(|d| radiance(turn(d)));
        let plain = Irradiance::of(radiance);
        for n in NORMALS {
            let error = (at(&plain.turned(0.7), n) - at(&turned_map, n)).length();
            assert!(error < 0.01, "{n}: off by {error}");
        }
        let unturned = (at(&plain, NORMALS[2]) - at(&turned_map, NORMALS[2])).length();
        assert!(unturned > 0.05, "the test's picture must not look the same all around: {unturned}");
    }
}
