//! Triangles in their rest pose, as every source of models makes them.

use glam::{Mat4, Vec3};

use super::bounds::{self, Reach};
use super::material::Material;

crate::gpu_struct! {
    /// A vertex at rest: what the animation starts from and what paint is fixed to.
    pub struct RestVertex {
        /// In the space of its node's mesh.
        pub position: Vec3,
        /// Texture coordinate.
        pub u: f32,
        /// Unit; zero where the part is flat-shaded and the normal is its triangle's at each pose.
        pub normal: Vec3,
        /// Texture coordinate.
        pub v: f32,
    }
}

crate::gpu_struct! {
    /// What moves a vertex: up to four matrices of the pose. An unskinned vertex has its node's matrix with weight 1.
    pub struct Influence {
        /// Indices into the model's matrices.
        pub joints: [u32; 4],
        /// Sum to one.
        pub weights: [f32; 4],
    }
}

/// A vertex's linear colour in the room of its texture coordinate, 12 bits a component: the first two in `u`, the third
/// in `v`, as whole numbers that a float holds exactly. `color_from_uv` in `shaders/lib/texel.inc.wgsl` is its inverse.
#[must_use]
pub fn uv_from_color(color: Vec3) -> (f32, f32) {
    let steps = (color.clamp(Vec3::ZERO, Vec3::ONE) * 4095.0).round();
    (steps.x * 4096.0 + steps.y, steps.z)
}

/// One model's triangles and all that can move or colour them.
#[derive(Debug, Clone, Default)]
pub struct Geometry {
    /// Vertices of all parts.
    pub vertices: Vec<RestVertex>,
    /// As many as vertices.
    pub influences: Vec<Influence>,
    /// Three vertex indices a triangle, counter-clockwise from outside in the space of the part's mesh; they are of one
    /// part. A pose that mirrors turns them round.
    pub triangles: Vec<[u32; 3]>,
    /// Parts, each a run of vertices and a run of triangles.
    pub parts: Vec<Part>,
    /// Morph displacements: for each part with targets, target after target, a displacement a vertex.
    pub morphs: Vec<Morph>,
    /// The node hierarchy, parents before children.
    pub nodes: Vec<Node>,
    /// Where each pose matrix comes from, in the order that [`Influence::joints`] counts.
    pub matrices: Vec<MatrixSource>,
    /// Animation clips.
    pub clips: Vec<super::clips::Clip>,
    /// Decoded base-colour and emissive pictures of opaque parts.
    pub textures: Vec<Texture>,
    /// Names of KHR_materials_variants, in file order.
    pub variants: Vec<String>,
    /// The surface of expressions with `t` that this is at one time.
    pub made_from: Option<super::surface::MadeFrom>,
    /// What is odd about that surface at that time.
    pub warning: Option<String>,
    /// How far each part reaches, parts in order; made by [`Geometry::measure`].
    pub reaches: Vec<Vec<Reach>>,
}

impl Geometry {
    /// Fills [`Geometry::reaches`]. To be called once when everything else stands.
    pub fn measure(&mut self) {
        self.reaches = self.parts.iter().map(|part| bounds::reaches(self, part)).collect();
    }
}

/// A run of triangles with one material: a glTF primitive at a node, or a shape.
#[derive(Debug, Clone)]
pub struct Part {
    /// Unique within the model: the material's name, or the node's, numbered if need be.
    pub name: String,
    /// First vertex and how many.
    pub vertices: std::ops::Range<u32>,
    /// First triangle and how many.
    pub triangles: std::ops::Range<u32>,
    /// First entry in [`Geometry::morphs`] and the number of targets.
    pub morph_first: u32,
    /// Number of morph targets.
    pub morph_count: u32,
    /// The node whose morph weights count.
    pub node: u32,
    /// Normals are the triangles' own at each pose; vertices are not shared between triangles.
    pub flat: bool,
    /// Vertices carry colours in place of texture coordinates: [`uv_from_color`].
    pub vertex_colors: bool,
    /// As the file says.
    pub material: Material,
    /// The material of each variant, where it differs.
    pub variant_materials: Vec<(usize, Material)>,
    /// An analytic plane: `Some(half side)` for `shape = "plane"`.
    pub plane_half: Option<f32>,
}

crate::gpu_struct! {
    /// What one morph target adds to a vertex at weight 1.
    pub struct Morph {
        /// Added to the position.
        pub position: Vec3,
        /// Padding.
        pub _pad0: u32,
        /// Added to the normal.
        pub normal: Vec3,
        /// Padding.
        pub _pad1: u32,
    }
}

/// A node of the hierarchy.
#[derive(Debug, Clone)]
pub struct Node {
    /// Its name, or empty.
    pub name: String,
    /// Index of its parent, always smaller than its own.
    pub parent: Option<u32>,
    /// Rest transform.
    pub translation: Vec3,
    /// Rest rotation, a unit quaternion (x, y, z, w).
    pub rotation: glam::Quat,
    /// Rest scale.
    pub scale: Vec3,
    /// Rest morph weights of its mesh.
    pub weights: Vec<f32>,
}

/// Where a pose matrix comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MatrixSource {
    /// A node's global transform.
    Node(u32),
    /// A joint's global transform times its inverse bind matrix.
    Joint {
        /// The joint's node.
        node: u32,
        /// `joint_from_mesh` at rest.
        inverse_bind: Mat4,
    },
}

/// A decoded picture, linear RGBA8 if `srgb` is false.
#[derive(Debug, Clone)]
pub struct Texture {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// RGBA, row by row from the top. Alpha is 255, but 0 in the holes of a part with an alpha mask.
    pub rgba8: Vec<u8>,
    /// Stored with the sRGB curve.
    pub srgb: bool,
    /// How it is laid on.
    pub sampling: Sampling,
}

/// How a picture goes on beyond its edges and between its texels: a glTF sampler.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sampling {
    /// Beyond the edges, across and down.
    pub wrap: [Wrap; 2],
    /// The nearest texel alone; else neighbours blend.
    pub nearest: bool,
}

/// How a picture goes on beyond its edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wrap {
    /// Again and again.
    #[default]
    Repeat,
    /// Again, every second time mirrored.
    Mirror,
    /// As its edge.
    Clamp,
}

impl Sampling {
    /// Five bits as shaders see them, 0 for the default: two for each wrap, one for the nearest texel. See
    /// `shaders/lib/texel.inc.wgsl`.
    #[must_use]
    pub const fn bits(self) -> u32 {
        self.wrap[0] as u32 | (self.wrap[1] as u32) << 2 | (self.nearest as u32) << 4
    }
}
