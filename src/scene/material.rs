//! What light sees of a part.

use super::description::MaterialOverride;
use glam::Vec3;

/// A part's material, all overrides applied.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Light does not pass.
    pub opaque: bool,
    /// Refraction index.
    pub ior: f32,
    /// Absorption per world unit: T = exp(−σ·s).
    pub sigma: Vec3,
    /// Diffuse colour (opaque) or the surface's tint (clear), linear.
    pub base_color: Vec3,
    /// Perceptual roughness, 0 to 1.
    pub roughness: f32,
    /// 20/V_d; 0 is off.
    pub dispersion: f32,
    /// A clear part without volume (glTF thickness 0): refracts nothing, tints by its base colour.
    pub thin_wall: bool,
    /// A thin wall tints from behind too.
    pub double_sided: bool,
    /// Where media overlap the higher one counts.
    pub priority: i32,
    /// Linear radiance given off.
    pub emissive: Vec3,
    /// An opaque part that gives off its base colour, whatever the light.
    pub unlit: bool,
    /// Index into the world's textures.
    pub base_color_texture: Option<u32>,
    /// Index into the world's textures.
    pub emissive_texture: Option<u32>,
    /// Opaque planes: second colour of the checkerboard.
    pub checker_color: Vec3,
    /// Side of its squares, world units; 0 is plain.
    pub checker_square: f32,
    /// One more than the number of the operand ([`super::csg::Bodies::operands`]) that the part is, else 0.
    pub operand: u32,
    /// The operand is taken away: its outside is the body's inside.
    pub turned: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            opaque: false,
            ior: 1.5,
            sigma: Vec3::ZERO,
            base_color: Vec3::ONE,
            roughness: 0.0,
            dispersion: 0.0,
            thin_wall: false,
            double_sided: false,
            priority: 0,
            emissive: Vec3::ZERO,
            unlit: false,
            base_color_texture: None,
            emissive_texture: None,
            checker_color: Vec3::ZERO,
            checker_square: 0.0,
            operand: 0,
            turned: false,
        }
    }
}

impl MaterialOverride {
    /// Whether this is meant for the part: by its name, or by the start of it before a final `*`.
    #[must_use]
    pub fn names(&self, part: &str) -> bool {
        self.part == part || self.part.strip_suffix('*').is_some_and(|start| part.starts_with(start))
    }
}

impl Material {
    /// Applies a scene's overrides for the part of this name, in order, later ones winning.
    ///
    /// An opaque part made clear loses what belonged to its paint (colour, pictures, roughness). Asking a thin wall
    /// for a refraction index or absorption makes it solid.
    #[must_use]
    pub fn overridden(mut self, part: &str, overrides: &[MaterialOverride]) -> Self {
        let (mut color, mut distance) = (None, None);
        for o in overrides.iter().filter(|o| o.names(part)) {
            if o.opaque == Some(false) && self.opaque {
                let Self { ior, sigma, dispersion, priority, emissive, .. } = self;
                self = Self { ior, sigma, dispersion, priority, emissive, ..Self::default() };
            }
            self.opaque = o.opaque.unwrap_or(self.opaque);
            color = o.attenuation_color.or(color);
            distance = o.attenuation_distance.or(distance);
            if let Some(sigma) = o.sigma {
                self.sigma = sigma;
            } else if o.attenuation_color.is_some() || o.attenuation_distance.is_some() {
                let over_one_unit = (-self.sigma).map(f32::exp);
                self.sigma = sigma_from_attenuation(color.unwrap_or(over_one_unit), distance.unwrap_or(1.0));
            }
            let solid = o.ior.is_some() || o.sigma.is_some() || o.attenuation_color.is_some();
            self.thin_wall &= !(solid || o.attenuation_distance.is_some());
            self.ior = o.ior.unwrap_or(self.ior);
            self.base_color = o.base_color.unwrap_or(self.base_color);
            self.priority = o.priority.unwrap_or(self.priority);
            self.roughness = o.roughness.unwrap_or(self.roughness);
            self.dispersion = o.dispersion.unwrap_or(self.dispersion);
            self.checker_color = o.checker_color.unwrap_or(self.checker_color);
            self.checker_square = o.checker_square.unwrap_or(self.checker_square);
            self.emissive = o.emissive.unwrap_or(self.emissive);
        }
        self
    }
}

/// σ = −ln(color)/distance per world unit, as glTF's KHR_materials_volume defines it; the colour is clamped to 1e-4 … 1.
///
/// An infinite or non-positive distance absorbs nothing.
#[must_use]
pub fn sigma_from_attenuation(color: Vec3, distance: f32) -> Vec3 {
    if !distance.is_finite() || distance <= 0.0 {
        return Vec3::ZERO;
    }
    -color.clamp(Vec3::splat(1e-4), Vec3::ONE).map(f32::ln) / distance
}

/// `Material::flags` on the GPU.
pub mod flags {
    /// Light does not pass.
    pub const OPAQUE: u32 = 1;
    /// Refracts nothing, tints by its base colour.
    pub const THIN_WALL: u32 = 2;
    /// Normals are the triangle's own.
    pub const FLAT: u32 = 4;
    /// An analytic plane: not voxelized, met exactly.
    pub const PLANE: u32 = 8;
    /// Vertices carry colours in place of texture coordinates.
    pub const VERTEX_COLOR: u32 = 16;
    /// Gives off its base colour, whatever the light.
    pub const UNLIT: u32 = 32;
    /// A thin wall tints from behind too.
    pub const DOUBLE_SIDED: u32 = 64;
    /// From here on five bits: the base colour picture's [`Sampling::bits`](crate::scene::geometry::Sampling::bits).
    pub const BASE_COLOR_SAMPLING_SHIFT: u32 = 8;
    /// From here on five bits: the emissive picture's.
    pub const EMISSIVE_SAMPLING_SHIFT: u32 = 16;
    /// An operand that is taken away from its body.
    pub const TURNED: u32 = 1 << 23;
    /// From here on: [`Material::operand`](super::Material::operand).
    pub const OPERAND_SHIFT: u32 = 24;
}

crate::gpu_struct! {
    /// A part's material as shaders see it, `array<PartMaterial>` indexed by part.
    pub struct PartMaterial {
        /// Absorption per world unit.
        pub sigma: Vec3,
        /// Refraction index.
        pub ior: f32,
        /// Diffuse colour or tint.
        pub base_color: Vec3,
        /// See [`flags`].
        pub flags: u32,
        /// Linear radiance.
        pub emissive: Vec3,
        /// 0 to 1.
        pub roughness: f32,
        /// 20/V_d.
        pub dispersion: f32,
        /// Higher counts where media overlap.
        pub priority: i32,
        /// Layer of the texture array, or −1.
        pub base_color_layer: i32,
        /// Layer of the texture array, or −1.
        pub emissive_layer: i32,
    }
}
