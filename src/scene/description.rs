//! The scene as its file says it: plain data with the defaults of the scene format.
//!
//! Lengths are world units, angles degrees, colours linear RGB, times seconds. y is up.

use super::csg::Tree;
use super::surface::Surface;
use glam::{DVec3, Mat4, Quat, UVec3, Vec3};
use std::path::PathBuf;
use std::sync::Arc;

/// Everything a scene file says.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scene {
    /// The view.
    pub camera: Camera,
    /// The view's grid.
    pub grid: GridSettings,
    /// The grid of every casting light.
    pub light_grid: GridSettings,
    /// How the grids are marked.
    pub voxelizer: VoxelizerSettings,
    /// How the volume is lit.
    pub effect: EffectSettings,
    /// What rays meet that meet nothing else.
    pub background: Background,
    /// The lights; light 0 is the key light.
    pub lights: Vec<Light>,
    /// The models.
    pub models: Vec<Model>,
    /// The folder that model and environment files are relative to; they may not leave its parent.
    pub folder: PathBuf,
    /// The scene was written for a body of radius 1 and is to be fitted to the true ones once they are loaded: see
    /// [`super::framing::frame`].
    pub frame_camera: bool,
}

/// The most lights of a scene.
pub const MAX_LIGHTS: usize = 8;
/// The most analytic planes of a scene.
pub const MAX_PLANES: usize = 8;

/// A pinhole camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Where it stands.
    pub eye: Vec3,
    /// What it looks at.
    pub target: Vec3,
    /// Which way is up.
    pub up: Vec3,
    /// Vertical field of view, degrees.
    pub fov_deg: f32,
}

impl Default for Camera {
    fn default() -> Self {
        Self { eye: Vec3::new(0.0, 0.0, 5.0), target: Vec3::ZERO, up: Vec3::Y, fov_deg: 30.0 }
    }
}

/// What a grid is turned to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Align {
    /// To the camera (or, for a light's grid, the light).
    #[default]
    Camera,
    /// To the world's axes.
    World,
}

/// How a voxel camera projects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Projection {
    /// Parallel columns.
    #[default]
    Orthographic,
    /// Columns through the eye; slices uniform in eye depth.
    Perspective,
}

/// Cells that a grid may have along an axis: a cell's place is packed in ten bits each.
pub const CELLS: std::ops::RangeInclusive<u32> = 16..=1024;

/// Resolution of a grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cells {
    /// Cells along the longest axis of the bounds; cells are cubes.
    Longest(u32),
    /// Cells along each axis of the grid.
    Each(UVec3),
}

/// A voxel camera's settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridSettings {
    /// Resolution, [`CELLS`] in each axis.
    pub cells: Cells,
    /// Alignment.
    pub align: Align,
    /// Projection.
    pub projection: Projection,
    /// The view's grid alone: only what lies in this box of the world is voxelized, at full resolution (DO §5.1).
    pub region: Option<Region>,
}

/// A box of the world, `min` below `max` in every axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Region {
    /// Lower corner.
    pub min: Vec3,
    /// Upper corner.
    pub max: Vec3,
}

impl Region {
    /// As bounds.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        Bounds { min: self.min.as_dvec3(), max: self.max.as_dvec3() }
    }
}

impl Default for GridSettings {
    fn default() -> Self {
        Self { cells: Cells::Longest(128), align: Align::Camera, projection: Projection::Orthographic, region: None }
    }
}

/// How thin a voxelized surface is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Separability {
    /// Every cell that the surface touches: no 26-connected path leaks through.
    #[default]
    TwentySix,
    /// Thin: no 6-connected path leaks through.
    Six,
}

/// How a rasterizing method sees to it that a triangle reaches every column that it touches, not only those whose middle
/// line it meets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Conservative {
    /// Not at all: middle lines alone.
    #[default]
    None,
    /// The triangle grown by a column's square, exactly (Hasselgren et al. 2005, first algorithm).
    Polygon,
    /// Its bounding triangle, clipped by the triangle's box in the fragment (the same, second algorithm).
    Box,
    /// The triangle's sides moved out by half a column's diagonal, clipped likewise (Hertel et al. 2009; RB §3.3.2).
    Dilated,
    /// The adapter's own, where it has one.
    Hardware,
}

/// How `exact-columns` walks the cells of a column that a triangle may meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum ColumnLoop {
    /// All of them (TR ch. 2).
    #[default]
    Whole,
    /// From the middle outwards, until the run of cells that are met is passed (TR ch. 5).
    TwoEnded,
}

/// How `three-axis` puts a bit into a sheet buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Blending {
    /// Bits are united: no voxel is lost.
    #[default]
    Or,
    /// Bits are added within 8-bit components, as published (DO §4.2): where two triangles meet in a voxel, its bit
    /// carries into the next.
    Additive,
}

/// What `hybrid` takes for a triangle's size, seen along the columns (RB §3.4.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum SizeMeasure {
    /// Area of the projected triangle, cells²: the one that RB chose.
    #[default]
    Area,
    /// Area of the dilated triangle that is rasterized, cells².
    DilatedArea,
    /// Columns of its box.
    Extent2d,
    /// Cells of its box.
    Extent3d,
    /// Area over dilated area, 0 to 1.
    AreaRatio,
}

/// When `hybrid` tells small triangles from large ones (RB §3.4.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Classify {
    /// While it marks the small ones: a little more than one pass (RB Fig. 15).
    #[default]
    OnTheFly,
    /// Before it marks any: two lists, then both are worked off (RB Fig. 12).
    First,
}

/// How the interior is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Fill {
    /// Inside the walk, when needed (CL §2.3, second strategy).
    #[default]
    Lazy,
    /// One toggled bit a crossing, then a prefix XOR down each column (CL §2.3, first strategy).
    Eager,
    /// No interior.
    None,
}

/// Which voxelizer, and its options.
#[derive(Debug, Clone, PartialEq)]
pub struct VoxelizerSettings {
    /// A name from [`crate::voxelize::METHODS`].
    pub method: String,
    /// Thin or thick.
    pub separability: Separability,
    /// Which columns a triangle reaches; methods of which [`crate::voxelize::Method::conservative`] lists it only.
    pub conservative: Conservative,
    /// Every slice between the least and the greatest depth of a triangle's plane over a column is marked, not only that
    /// of one depth (TR §1.4.5.3); the same methods only.
    pub conservative_depth: bool,
    /// Fraction of a cell by which slices overlap (CL §3.2.2); `slice-amplified` only.
    pub slice_overlap: f32,
    /// The loop over a column's cells; `exact-columns` only.
    pub column_loop: ColumnLoop,
    /// How sheet buffers take bits; `three-axis` only.
    pub three_axis_blending: Blending,
    /// Triangles of a larger size than this go to fragments, `None` for what suits device and scene; in cells², or the
    /// unit of `size_measure`; `hybrid` only.
    pub cutoff_cells2: Option<f32>,
    /// What a triangle's size is; `hybrid` only.
    pub size_measure: SizeMeasure,
    /// When sizes are compared; `hybrid` only.
    pub classify: Classify,
    /// How the interior is made.
    pub fill: Fill,
}

impl Default for VoxelizerSettings {
    fn default() -> Self {
        Self {
            method: "hybrid".to_owned(),
            separability: Separability::TwentySix,
            conservative: Conservative::None,
            conservative_depth: false,
            slice_overlap: 0.0,
            column_loop: ColumnLoop::Whole,
            three_axis_blending: Blending::Or,
            cutoff_cells2: None,
            size_measure: SizeMeasure::Area,
            classify: Classify::OnTheFly,
            fill: Fill::Lazy,
        }
    }
}

/// How rays bend.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Refraction {
    /// Straight through.
    None,
    /// Bent once, where the ray enters.
    Single,
    /// Bent at entry and at the estimated exit (CL §3.2.1, Fig. 5).
    TwoSurface,
    /// Bent wherever a surface is met (CL §3.2.2, Eqs. 3–4).
    #[default]
    MultipleSurface,
}

/// How a ray meets the volume.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Hit {
    /// Ours: the first surface is rasterized; a crossing counts where the ray meets a record's plane.
    #[default]
    Surfel,
    /// The paper whole: the first hit is a voxel, fixed steps of one voxel, an angle threshold.
    Voxel,
}

/// How light is shadowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shadow {
    /// Not at all.
    None,
    /// CL Eq. 1 as printed: one minus the sum of absorption.
    Linear,
    /// exp of minus the optical depth.
    #[default]
    BeerLambert,
}

/// How the volume is lit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectSettings {
    /// How rays bend.
    pub refraction: Refraction,
    /// How a ray meets the volume.
    pub hit: Hit,
    /// `hit = "voxel"`: a second refraction within this angle of the last normal is ignored (CL §3.2.2).
    pub angle_threshold_deg: f32,
    /// The most refractions and reflections along one ray, 1 to 32.
    pub max_events: u32,
    /// Absorption along the view ray (CL Eq. 5).
    pub transmittance: bool,
    /// Questionable rays are filled from their neighbours (CL §2.3, Fig. 3).
    pub fill_questionable: bool,
    /// The transparent shadow map (CL §3.1).
    pub shadow: Shadow,
    /// Fresnel-weighted reflection of the surroundings at the first surface.
    pub reflection: bool,
    /// Scales the linear radiance before the tone map.
    pub exposure: f32,
}

impl Default for EffectSettings {
    fn default() -> Self {
        Self {
            refraction: Refraction::MultipleSurface,
            hit: Hit::Surfel,
            angle_threshold_deg: 12.0,
            max_events: 8,
            transmittance: true,
            fill_questionable: true,
            shadow: Shadow::BeerLambert,
            reflection: true,
            exposure: 1.0,
        }
    }
}

/// What rays meet that meet nothing else.
#[derive(Debug, Clone, PartialEq)]
pub enum Background {
    /// One colour.
    Color {
        /// Linear radiance.
        color: Vec3,
    },
    /// A gradient: `horizon` to `zenith` by height^exponent, `ground` below the horizon.
    Sky {
        /// Radiance at the horizon.
        horizon: Vec3,
        /// Radiance overhead.
        zenith: Vec3,
        /// Radiance below the horizon.
        ground: Vec3,
        /// Power of the height.
        exponent: f32,
        /// Scales all three.
        intensity: f32,
    },
    /// A checkerboard behind everything: a plane facing the camera of the scene file at `distance` beyond its target.
    Checker {
        /// One colour.
        a: Vec3,
        /// The other.
        b: Vec3,
        /// Side of a square, world units.
        square: f32,
        /// Distance beyond the target, world units.
        distance: f32,
    },
    /// An equirectangular picture.
    Environment {
        /// `.hdr` or `.exr`, relative to the scene's folder.
        file: PathBuf,
        /// Turned about y, degrees.
        rotate_deg: f32,
        /// Scale.
        intensity: f32,
    },
}

impl Default for Background {
    fn default() -> Self {
        Self::Sky {
            horizon: Vec3::new(0.95, 0.90, 0.85),
            zenith: Vec3::new(0.30, 0.45, 0.75),
            ground: Vec3::new(0.80, 0.76, 0.71),
            exponent: 0.6,
            intensity: 0.55,
        }
    }
}

/// Half the angles under which lights may be seen, degrees: from the sun's to a wide lamp's.
pub const ANGULAR_RADIUS_DEG: std::ops::RangeInclusive<f32> = 0.25..=30.0;

/// A light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Its kind and place.
    pub kind: LightKind,
    /// Linear colour.
    pub color: Vec3,
    /// Directional: irradiance at normal incidence. Point and spot: radiant intensity (falls with distance²).
    pub intensity: f32,
    /// Half the angle under which it is seen, degrees: how wide highlights are and how soft the edges of shadows. How much
    /// light arrives does not hang on it.
    pub angular_radius_deg: f32,
    /// Whether it throws shadows (and so has a grid).
    pub casts_shadow: bool,
}

/// Kind and place of a light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LightKind {
    /// Parallel light that travels along `direction` (unit).
    Directional {
        /// The way the light travels.
        direction: Vec3,
    },
    /// From `position`, all around.
    Point {
        /// Where it stands.
        position: Vec3,
    },
    /// From `position` along `direction`, within `angle_deg` of it (full cone's half angle), soft by `blend`.
    Spot {
        /// Where it stands.
        position: Vec3,
        /// The way it points (unit).
        direction: Vec3,
        /// Half angle of the cone, degrees.
        angle_deg: f32,
        /// Fraction of the half angle over which it fades, 0 to 1.
        blend: f32,
    },
}

impl Default for Light {
    fn default() -> Self {
        Self {
            kind: LightKind::Directional { direction: Vec3::new(0.4, -1.0, 0.25).normalize() },
            color: Vec3::ONE,
            intensity: 3.0,
            angular_radius_deg: 3.44, // a low sun through thin haze
            casts_shadow: true,
        }
    }
}

/// Where a model's triangles come from.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// A `.glb` or `.gltf` file, or saved voxels (`.npz`), relative to the scene's folder.
    File(PathBuf),
    /// A built-in shape.
    Shape(Shape),
    /// A surface given by expressions.
    Surface(Arc<Surface>),
    /// What union, intersection and difference make of other models, which then don't appear on their own.
    Csg(Tree),
}

/// A built-in shape: a mesh like every model, with smooth normals where the true surface is smooth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// Latitudes and longitudes.
    Sphere {
        /// Radius.
        radius: f32,
        /// Rings between the poles; twice as many segments around.
        rings: u32,
    },
    /// A subdivided icosahedron, 20·4^subdivisions triangles.
    Icosphere {
        /// Radius.
        radius: f32,
        /// Times each triangle is split in four, 0 to 9.
        subdivisions: u32,
    },
    /// About the y axis.
    Torus {
        /// From the centre to the middle of the tube.
        radius: f32,
        /// Radius of the tube.
        tube: f32,
        /// Segments around; half as many around the tube.
        segments: u32,
    },
    /// Axis-aligned.
    Box {
        /// Lower corner.
        min: Vec3,
        /// Upper corner.
        max: Vec3,
    },
    /// A square at y = 0 facing up. Opaque planes are met exactly by every ray and never voxelized.
    Plane {
        /// Side.
        size: f32,
    },
}

/// A procedural deformer, applied in the model's rest space after skinning and morphing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Deformer {
    /// Turns about `axis` by `deg_per_unit` degrees for each unit along it, swinging with `hz` (0: constant).
    Twist {
        /// 0 = x, 1 = y, 2 = z.
        axis: u32,
        /// Degrees for each unit along the axis.
        deg_per_unit: f32,
        /// Swings a second; 0 keeps still.
        hz: f32,
    },
    /// Moves along `along` by amplitude·sin(2π(x_axis/wavelength − hz·t)).
    Wave {
        /// The axis that the wave runs along.
        axis: u32,
        /// The axis that points move along.
        along: u32,
        /// World units before the model's scale.
        amplitude: f32,
        /// Units.
        wavelength: f32,
        /// Waves a second.
        hz: f32,
    },
}

/// A model in the scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// Its name in the panels; unique.
    pub name: String,
    /// Where its triangles come from.
    pub source: Source,
    /// Clip to play; `None`: the first, if there is one.
    pub animation: Option<String>,
    /// Playback speed.
    pub speed: f32,
    /// KHR_materials_variants name.
    pub variant: Option<String>,
    /// Placement.
    pub translate: Vec3,
    /// Degrees about x, then y, then z.
    pub rotate_deg: Vec3,
    /// Uniform scale.
    pub scale: f32,
    /// Applied in order.
    pub deformers: Vec<Deformer>,
    /// Material overrides, later ones win.
    pub materials: Vec<MaterialOverride>,
}

impl Model {
    /// `world_from_model`.
    #[must_use]
    pub fn placement(&self) -> Mat4 {
        let [x, y, z] = self.rotate_deg.to_array().map(f32::to_radians);
        let rotation = Quat::from_rotation_z(z) * Quat::from_rotation_y(y) * Quat::from_rotation_x(x);
        Mat4::from_scale_rotation_translation(Vec3::splat(self.scale), rotation, self.translate)
    }
}

impl Default for Model {
    fn default() -> Self {
        Self {
            name: String::new(),
            source: Source::Shape(Shape::Icosphere { radius: 1.0, subdivisions: 5 }),
            animation: None,
            speed: 1.0,
            variant: None,
            translate: Vec3::ZERO,
            rotate_deg: Vec3::ZERO,
            scale: 1.0,
            deformers: Vec::new(),
            materials: Vec::new(),
        }
    }
}

/// What a scene file changes of the materials of the parts that `part` names.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialOverride {
    /// A part's name, or the start of names followed by `*`: `*` is all.
    pub part: String,
    /// Refraction index, at least 1 unless inside another medium (0.1 to 10 accepted).
    pub ior: Option<f32>,
    /// Colour that white light has after `attenuation_distance`.
    pub attenuation_color: Option<Vec3>,
    /// World units.
    pub attenuation_distance: Option<f32>,
    /// Absorption per world unit; wins over colour and distance.
    pub sigma: Option<Vec3>,
    /// Light does not pass.
    pub opaque: Option<bool>,
    /// Diffuse colour of opaque parts; a tint of clear ones' surface.
    pub base_color: Option<Vec3>,
    /// Where media overlap the higher one counts; equal: the later model.
    pub priority: Option<i32>,
    /// 0 to 1.
    pub roughness: Option<f32>,
    /// 20/V_d; 0 is off.
    pub dispersion: Option<f32>,
    /// Opaque planes: second colour of a checkerboard, whose squares have side `checker_square`.
    pub checker_color: Option<Vec3>,
    /// World units; 0 is plain.
    pub checker_square: Option<f32>,
    /// Linear radiance that the part gives off.
    pub emissive: Option<Vec3>,
}

impl Default for MaterialOverride {
    fn default() -> Self {
        Self {
            part: "*".to_owned(),
            ior: None,
            attenuation_color: None,
            attenuation_distance: None,
            sigma: None,
            opaque: None,
            base_color: None,
            priority: None,
            roughness: None,
            dispersion: None,
            checker_color: None,
            checker_square: None,
            emissive: None,
        }
    }
}

/// An axis-aligned box in world space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Lower corner.
    pub min: DVec3,
    /// Upper corner.
    pub max: DVec3,
}

impl Bounds {
    /// Contains nothing.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// True when nothing was added.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Grows to contain a point.
    pub fn add(&mut self, point: DVec3) {
        self.min = self.min.min(point);
        self.max = self.max.max(point);
    }

    /// Smallest box that contains both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The eight corners.
    #[must_use]
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, lo: f64, hi: f64| if i >> bit & 1 == 0 { lo } else { hi };
            DVec3::new(
                pick(0, self.min.x, self.max.x),
                pick(1, self.min.y, self.max.y),
                pick(2, self.min.z, self.max.z),
            )
        })
    }

    /// The middle.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        (self.min + self.max) * 0.5
    }

    /// Half the diagonal.
    #[must_use]
    pub fn radius(&self) -> f64 {
        (self.max - self.min).length() * 0.5
    }
}
