//! Stage 1: moves every vertex in compute: morphs, then joints, then deformers, into world space.
//!
//! What a scene shows is uploaded once; a frame uploads matrices, morph weights and deformers, nothing else.

mod neighbors;

use crate::gpu::{ComputePass, Gpu, GpuError, GpuStruct, Recorder, buffer};
use crate::scene::deform::Deformation;
use crate::scene::geometry::{Geometry, Influence, Morph, RestVertex, Sampling, Texture};
use crate::scene::material::{Material, PartMaterial, flags};
use crate::scene::{Pose, Scene, World};
use glam::{Mat4, UVec2, Vec3};
use neighbors::neighbors;
use std::f64::consts::TAU;

crate::gpu_struct! {
    /// An animated vertex.
    pub struct Vertex {
        /// World.
        pub position: Vec3,
        /// Index of its part in [`World::parts`].
        pub part: u32,
        /// World, unit.
        pub normal: Vec3,
        /// 1 where the pose mirrors it: its triangles' corners run clockwise as seen from outside.
        pub mirrored: u32,
    }
}

crate::gpu_struct! {
    /// Where a part's vertices, morph targets and weights lie.
    pub struct PartMotion {
        /// Index of its model.
        pub model: u32,
        /// First vertex in the world.
        pub vertex_first: u32,
        /// Number of vertices.
        pub vertex_count: u32,
        /// 1 where normals are the triangles' own.
        pub flat_shaded: u32,
        /// First displacement in the world's morphs.
        pub morph_first: u32,
        /// Number of morph targets.
        pub morph_count: u32,
        /// First weight in [`Pose::morph_weights`].
        pub weight_first: u32,
        /// Padding.
        pub _pad: u32,
    }
}

crate::gpu_struct! {
    /// What moves a model as a whole.
    pub struct ModelMotion {
        /// Placement.
        pub world_from_model: Mat4,
        /// First of its deformers.
        pub deformer_first: u32,
        /// How many.
        pub deformer_count: u32,
        /// Padding.
        pub _pad: UVec2,
    }
}

crate::gpu_struct! {
    /// A [`Deformation`] as shaders see it.
    pub struct DeformerMotion {
        /// Unit, model space.
        pub axis: Vec3,
        /// 0 twist, 1 wave.
        pub kind: u32,
        /// Wave: the way points move, unit, model space.
        pub along: Vec3,
        /// Radians for each unit along `axis`.
        pub rate: f32,
        /// Wave: model units.
        pub amplitude: f32,
        /// Wave: radians.
        pub phase: f32,
        /// Padding.
        pub _pad: UVec2,
    }
}

/// The most deformers in a scene, `MAX_DEFORMERS` in the shader.
pub const MAX_DEFORMERS: usize = 64;
/// Triangle numbers have 24 bits in winners' keys and in records.
pub const MAX_TRIANGLES: usize = 1 << 24;
/// No triangle, in [`Triangles::neighbors`] and in the shaders.
pub const NO_TRIANGLE: u32 = 0x00ff_ffff;
/// Part numbers have 12 bits in records.
pub const MAX_PARTS: usize = 1 << 12;

/// Fills the list of flat triangles up, `PADDING` in the shader: the smallest buffer has room for four.
const PADDING: u32 = u32::MAX;
/// Largest side of a layer of the texture array, texels.
const MAX_TEXTURE_SIDE: u32 = 1024;
/// Most bytes of the texture array.
const MAX_TEXTURE_BYTES: u64 = 128 << 20;

/// The world's triangles on the device: what `animate` writes and every later stage reads.
#[derive(Debug)]
pub struct Triangles {
    /// `array<Vertex>`.
    pub vertices: wgpu::Buffer,
    /// `array<u32>`, three a triangle.
    pub indices: wgpu::Buffer,
    /// `array<RestVertex>`, parallel to `vertices`.
    pub rest_vertices: wgpu::Buffer,
    /// `array<PartMaterial>`.
    pub materials: wgpu::Buffer,
    /// Pictures of opaque parts, `texture_2d_array`, one layer each.
    pub textures: wgpu::TextureView,
    /// `array<u32>`, three a triangle: those beyond the edges opposite its corners, or [`NO_TRIANGLE`].
    pub neighbors: wgpu::Buffer,
    /// Number of vertices.
    pub vertex_count: u32,
    /// Number of triangles.
    pub triangle_count: u32,
    /// For each part, those of [`flags`] that its geometry sets.
    part_flags: Vec<u32>,
    /// For each layer of `textures`, how it is laid on.
    samplings: Vec<Sampling>,
    /// What moves them; none for triangles that were made in place.
    motion: Option<Motion>,
}

/// What the pass reads and a frame writes.
#[derive(Debug)]
struct Motion {
    matrices: wgpu::Buffer,
    weights: wgpu::Buffer,
    model_motions: wgpu::Buffer,
    deformers: wgpu::Buffer,
    group: wgpu::BindGroup,
    flat_group: Option<wgpu::BindGroup>,
    flat_count: u32,
}

/// The passes.
#[derive(Debug)]
pub struct Animate {
    main: ComputePass,
    flat_normals: ComputePass,
}

impl Animate {
    /// Compiles the passes.
    ///
    /// # Errors
    /// When a shader is wrong.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let layouts = [
            Vertex::LAYOUT,
            RestVertex::LAYOUT,
            Influence::LAYOUT,
            Morph::LAYOUT,
            PartMotion::LAYOUT,
            ModelMotion::LAYOUT,
            DeformerMotion::LAYOUT,
        ];
        Ok(Self {
            main: ComputePass::new(gpu, "animate.wgsl", "main", &layouts)?,
            flat_normals: ComputePass::new(gpu, "animate.wgsl", "flat_normals", &layouts)?,
        })
    }

    /// Uploads what does not change while a scene is shown. Analytic planes have no triangles here.
    ///
    /// # Errors
    /// When the model is larger than the device's bindings, or than numbers in records have bits for.
    pub fn upload(&mut self, gpu: &Gpu, world: &World) -> Result<Triangles, GpuError> {
        self.upload_all(gpu, world).map_err(|error| match error {
            GpuError::Limit { what, needed, allowed, .. } => {
                let remedy = "simplify the model, or choose an adapter that allows more (`murrine doctor`)";
                GpuError::Limit { what, needed, allowed, remedy }
            }
            other => other,
        })
    }

    fn upload_all(&mut self, gpu: &Gpu, world: &World) -> Result<Triangles, GpuError> {
        let joined = Joined::of(world)?.with_something_to_bind();
        let place = |v: u32| (joined.vertices[v as usize].part, joined.rest_vertices[v as usize].position);
        let mut triangles = Triangles::placed(gpu, &joined.vertices, &joined.triangles, &[], place)?;
        triangles.rest_vertices = buffer::storage_with(gpu, "rest_vertices", &joined.rest_vertices)?;
        triangles.materials =
            buffer::storage(gpu, "materials", (world.parts.len().max(1) * size_of::<PartMaterial>()) as u64)?;
        let pictures = world.textures();
        triangles.textures = texture_array(gpu, &pictures)?;
        triangles.samplings = pictures.iter().map(|p| p.sampling).collect();
        triangles.part_flags = joined.part_flags;

        let matrices = buffer::storage(gpu, "matrices", (joined.matrix_count * size_of::<Mat4>()) as u64)?;
        let weights = buffer::storage(gpu, "weights", (joined.weight_count * size_of::<f32>()) as u64)?;
        let model_motions =
            buffer::storage(gpu, "model_motions", (world.models.len().max(1) * size_of::<ModelMotion>()) as u64)?;
        let none: [DeformerMotion; MAX_DEFORMERS] = bytemuck::Zeroable::zeroed();
        let deformers = buffer::uniform(gpu, "deformers", &none);
        let influences = buffer::storage_with(gpu, "influences", &joined.influences)?;
        let morphs = buffer::storage_with(gpu, "morphs", &joined.morphs)?;
        let part_motions = buffer::storage_with(gpu, "part_motions", &joined.part_motions)?;
        let group = self.main.bind(
            gpu,
            &[
                ("vertices", triangles.vertices.as_entire_binding()),
                ("rest_vertices", triangles.rest_vertices.as_entire_binding()),
                ("influences", influences.as_entire_binding()),
                ("morphs", morphs.as_entire_binding()),
                ("part_motions", part_motions.as_entire_binding()),
                ("model_motions", model_motions.as_entire_binding()),
                ("matrices", matrices.as_entire_binding()),
                ("weights", weights.as_entire_binding()),
                ("deformers", deformers.as_entire_binding()),
            ],
        );
        let flat_group = if joined.flat_triangles.is_empty() {
            None
        } else {
            let mut padded = joined.flat_triangles.clone();
            padded.resize(padded.len().next_multiple_of(4), PADDING);
            let flat_triangles = buffer::storage_with(gpu, "flat_triangles", &padded)?;
            Some(self.flat_normals.bind(
                gpu,
                &[
                    ("vertices", triangles.vertices.as_entire_binding()),
                    ("indices", triangles.indices.as_entire_binding()),
                    ("flat_triangles", flat_triangles.as_entire_binding()),
                ],
            ))
        };
        let flat_count = u32_of(joined.flat_triangles.len());
        triangles.motion = Some(Motion { matrices, weights, model_motions, deformers, group, flat_group, flat_count });
        Ok(triangles)
    }

    /// Records the stage: matrices, weights and deformers up, vertices out.
    pub fn record(&self, rec: &mut Recorder<'_>, triangles: &Triangles, world: &World, scene: &Scene, pose: &Pose) {
        let Some(motion) = &triangles.motion else { return };
        let queue = &rec.gpu.queue;
        let mut deformers = Vec::new();
        let mut model_motions = Vec::with_capacity(world.models.len());
        for (index, world_from_model) in pose.world_from_model.iter().enumerate().take(world.models.len()) {
            let first = deformers.len();
            let described = scene.models.get(index).map_or(&[][..], |model| &model.deformers);
            deformers.extend(described.iter().map(|d| DeformerMotion::from(d.at(pose.time_secs))));
            deformers.truncate(MAX_DEFORMERS);
            model_motions.push(ModelMotion {
                world_from_model: *world_from_model,
                deformer_first: u32_of(first),
                deformer_count: u32_of(deformers.len() - first),
                _pad: UVec2::ZERO,
            });
        }
        queue.write_buffer(&motion.matrices, 0, bytemuck::cast_slice(&pose.matrices));
        queue.write_buffer(&motion.weights, 0, bytemuck::cast_slice(&pose.morph_weights));
        queue.write_buffer(&motion.model_motions, 0, bytemuck::cast_slice(&model_motions));
        queue.write_buffer(&motion.deformers, 0, bytemuck::cast_slice(&deformers));
        self.main.dispatch(&mut rec.encoder, &motion.group, [triangles.vertex_count, 1, 1]);
        if let Some(group) = &motion.flat_group {
            self.flat_normals.dispatch(&mut rec.encoder, group, [motion.flat_count, 1, 1]);
        }
    }

    /// Writes each part's material; called when one changed.
    pub fn write_materials(&self, gpu: &Gpu, triangles: &Triangles, materials: &[Material]) {
        let of_parts = materials.iter().zip(&triangles.part_flags);
        let packed: Vec<_> = of_parts.map(|(m, f)| packed_material(m, *f, &triangles.samplings)).collect();
        gpu.queue.write_buffer(&triangles.materials, 0, bytemuck::cast_slice(&packed));
    }
}

impl Triangles {
    /// Triangles that stand still: vertices and materials as given, wound outward.
    ///
    /// # Errors
    /// When they are larger than the device's bindings, or than numbers in records have bits for.
    pub fn still(
        gpu: &Gpu,
        vertices: &[Vertex],
        triangles: &[[u32; 3]],
        materials: &[PartMaterial],
    ) -> Result<Self, GpuError> {
        let place = |v: u32| (vertices[v as usize].part, vertices[v as usize].position);
        Self::placed(gpu, vertices, triangles, materials, place)
    }

    /// As [`Triangles::still`]; `place` tells a vertex's part and the position by which triangles are neighbours.
    fn placed(
        gpu: &Gpu,
        vertices: &[Vertex],
        triangles: &[[u32; 3]],
        materials: &[PartMaterial],
        place: impl Fn(u32) -> (u32, Vec3),
    ) -> Result<Self, GpuError> {
        if triangles.len() > MAX_TRIANGLES {
            return Err(too_many("triangles", triangles.len(), MAX_TRIANGLES));
        }
        let usage = buffer::STORAGE | wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::INDEX;
        let filled = |label, bytes: &[u8]| -> Result<wgpu::Buffer, GpuError> {
            let made = buffer::with_usage(gpu, label, bytes.len() as u64, usage)?;
            gpu.queue.write_buffer(&made, 0, bytes);
            Ok(made)
        };
        Ok(Self {
            vertices: filled("vertices", bytemuck::cast_slice(vertices))?,
            indices: filled("indices", bytemuck::cast_slice(triangles))?,
            rest_vertices: buffer::storage(gpu, "rest_vertices", size_of_val(vertices) as u64)?,
            materials: buffer::storage_with(gpu, "materials", materials)?,
            textures: texture_array(gpu, &[])?,
            neighbors: filled("neighbors", bytemuck::cast_slice(&neighbors(triangles, vertices.len(), place)))?,
            vertex_count: u32_of(vertices.len()),
            triangle_count: u32_of(triangles.len()),
            part_flags: Vec::new(),
            samplings: Vec::new(),
            motion: None,
        })
    }
}

impl From<Deformation> for DeformerMotion {
    #[expect(clippy::cast_possible_truncation, reason = "shaders work in f32")]
    fn from(deformation: Deformation) -> Self {
        const AXES: [Vec3; 3] = [Vec3::X, Vec3::Y, Vec3::Z];
        match deformation {
            Deformation::Twist { axis, rad_per_unit } => Self {
                axis: AXES[axis],
                kind: 0,
                along: Vec3::ZERO,
                rate: rad_per_unit as f32,
                amplitude: 0.0,
                phase: 0.0,
                _pad: UVec2::ZERO,
            },
            Deformation::Wave { axis, along, amplitude, per_unit, phase_turns } => Self {
                axis: AXES[axis],
                kind: 1,
                along: AXES[along],
                rate: (TAU * per_unit) as f32,
                amplitude: amplitude as f32,
                phase: -(TAU * phase_turns) as f32,
                _pad: UVec2::ZERO,
            },
        }
    }
}

/// All models' arrays one after the other, their indices counted through.
#[derive(Default)]
struct Joined {
    vertices: Vec<Vertex>,
    rest_vertices: Vec<RestVertex>,
    influences: Vec<Influence>,
    triangles: Vec<[u32; 3]>,
    flat_triangles: Vec<u32>,
    morphs: Vec<Morph>,
    part_motions: Vec<PartMotion>,
    part_flags: Vec<u32>,
    matrix_count: usize,
    weight_count: usize,
}

impl Joined {
    fn of(world: &World) -> Result<Self, GpuError> {
        if world.parts.len() > MAX_PARTS {
            return Err(too_many("parts", world.parts.len(), MAX_PARTS));
        }
        let mut joined = Self::default();
        for (index, model) in world.models.iter().enumerate() {
            joined.add(u32_of(index), model);
        }
        Ok(joined)
    }

    /// A binding holds one element at least.
    fn with_something_to_bind(mut self) -> Self {
        use bytemuck::Zeroable as _;
        if self.morphs.is_empty() {
            self.morphs.push(Morph::zeroed());
        }
        if self.rest_vertices.is_empty() {
            self.vertices.push(Vertex::zeroed());
            self.rest_vertices.push(RestVertex::zeroed());
            self.influences.push(Influence::zeroed());
        }
        if self.part_motions.is_empty() {
            self.part_motions.push(PartMotion::zeroed());
        }
        self.matrix_count = self.matrix_count.max(1);
        self
    }

    fn add(&mut self, model: u32, geometry: &Geometry) {
        let first_vertex = u32_of(self.rest_vertices.len());
        let first_matrix = u32_of(self.matrix_count);
        let first_morph = u32_of(self.morphs.len());
        self.rest_vertices.extend(&geometry.vertices);
        self.influences
            .extend(geometry.influences.iter().map(|i| Influence { joints: i.joints.map(|j| j + first_matrix), ..*i }));
        self.morphs.extend(&geometry.morphs);
        self.vertices.resize(self.rest_vertices.len(), bytemuck::Zeroable::zeroed());
        for part in &geometry.parts {
            let number = u32_of(self.part_motions.len());
            self.part_motions.push(PartMotion {
                model,
                vertex_first: first_vertex + part.vertices.start,
                vertex_count: part.vertices.end - part.vertices.start,
                flat_shaded: u32::from(part.flat),
                morph_first: first_morph + part.morph_first,
                morph_count: part.morph_count,
                weight_first: u32_of(self.weight_count),
                _pad: 0,
            });
            let flat = if part.flat { flags::FLAT } else { 0 };
            let plane = if part.plane_half.is_some() { flags::PLANE } else { 0 };
            let colors = if part.vertex_colors { flags::VERTEX_COLOR } else { 0 };
            self.part_flags.push(flat | plane | colors);
            self.weight_count += part.morph_count as usize;
            for v in part.vertices.clone() {
                self.vertices[(first_vertex + v) as usize].part = number;
            }
            if part.plane_half.is_some() {
                continue;
            }
            let first_triangle = u32_of(self.triangles.len());
            let of_part = &geometry.triangles[part.triangles.start as usize..part.triangles.end as usize];
            self.triangles.extend(of_part.iter().map(|t| outward(geometry, *t).map(|v| v + first_vertex)));
            if part.flat {
                self.flat_triangles.extend(first_triangle..u32_of(self.triangles.len()));
            }
        }
        self.matrix_count += geometry.matrices.len();
    }
}

/// The triangle with its corners counterclockwise as seen from outside. Where the vertex normals contradict the order of
/// the corners, they are right: meshes wound inward are common.
fn outward(geometry: &Geometry, [a, b, c]: [u32; 3]) -> [u32; 3] {
    let [va, vb, vc] = [a, b, c].map(|v| &geometry.vertices[v as usize]);
    let area = (vb.position - va.position).cross(vc.position - va.position);
    if area.dot(va.normal + vb.normal + vc.normal) < 0.0 { [a, c, b] } else { [a, b, c] }
}

fn packed_material(material: &Material, of_part: u32, samplings: &[Sampling]) -> PartMaterial {
    let sampling = |texture: Option<u32>| texture.and_then(|t| samplings.get(t as usize)).map_or(0, |s| s.bits());
    let sampled = sampling(material.base_color_texture) << flags::BASE_COLOR_SAMPLING_SHIFT
        | sampling(material.emissive_texture) << flags::EMISSIVE_SAMPLING_SHIFT;
    let layer = |texture: Option<u32>| texture.and_then(|t| i32::try_from(t).ok()).unwrap_or(-1);
    let opaque = if material.opaque { flags::OPAQUE } else { 0 };
    let thin_wall = if material.thin_wall { flags::THIN_WALL } else { 0 };
    let double_sided = if material.double_sided { flags::DOUBLE_SIDED } else { 0 };
    let unlit = if material.unlit { flags::UNLIT } else { 0 };
    PartMaterial {
        sigma: material.sigma,
        ior: material.ior,
        base_color: material.base_color,
        flags: of_part | opaque | thin_wall | double_sided | unlit | sampled,
        emissive: material.emissive,
        roughness: material.roughness,
        dispersion: material.dispersion,
        priority: material.priority,
        base_color_layer: layer(material.base_color_texture),
        emissive_layer: layer(material.emissive_texture),
    }
}

/// All pictures in one array of sRGB layers of one size: as large as the largest, within [`MAX_TEXTURE_SIDE`] and
/// [`MAX_TEXTURE_BYTES`].
fn texture_array(gpu: &Gpu, pictures: &[&Texture]) -> Result<wgpu::TextureView, GpuError> {
    let allowed = gpu.device.limits().max_texture_array_layers;
    let layers = u32_of(pictures.len());
    if layers > allowed {
        return Err(too_many("pictures", pictures.len(), allowed as usize));
    }
    let largest = pictures.iter().map(|p| p.width.max(p.height)).max().unwrap_or(1);
    let mut side = largest.clamp(1, MAX_TEXTURE_SIDE);
    while u64::from(layers) * u64::from(side) * u64::from(side) * 4 > MAX_TEXTURE_BYTES {
        side /= 2;
    }
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("textures"),
        size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: layers.max(1) },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (layer, picture) in (0..layers).zip(pictures) {
        let mut place = texture.as_image_copy();
        place.origin.z = layer;
        gpu.queue.write_texture(
            place,
            &resized_srgb(picture, side),
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * side), rows_per_image: None },
            wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
        );
    }
    Ok(texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    }))
}

/// The picture at `side` × `side` texels, sRGB-coded; averaged in linear light.
fn resized_srgb(picture: &Texture, side: u32) -> Vec<u8> {
    if picture.srgb && picture.width == side && picture.height == side {
        return picture.rgba8.clone();
    }
    let linear_of: Vec<f32> = (0..=u8::MAX)
        .map(|code| {
            let value = f32::from(code) / 255.0;
            if picture.srgb { linear_from_srgb(value) } else { value }
        })
        .collect();
    let texels = picture.rgba8.chunks_exact(4).flat_map(|t| {
        let [r, g, b] = [t[0], t[1], t[2]].map(|code| linear_of[code as usize]);
        [r, g, b, f32::from(t[3]) / 255.0]
    });
    let whole = image::Rgba32FImage::from_raw(picture.width, picture.height, texels.collect());
    let Some(whole) = whole else { return vec![255; side as usize * side as usize * 4] };
    let filter = if picture.sampling.nearest {
        image::imageops::FilterType::Nearest
    } else {
        image::imageops::FilterType::Triangle
    };
    let resized = if picture.width == side && picture.height == side {
        whole
    } else {
        image::imageops::resize(&whole, side, side, filter)
    };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to 0 … 255")]
    let coded = |value: f32| (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    resized
        .pixels()
        .flat_map(|p| [0, 1, 2, 3].map(|c| coded(if c < 3 { srgb_from_linear(p.0[c]) } else { p.0[c] })))
        .collect()
}

fn linear_from_srgb(value: f32) -> f32 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

fn srgb_from_linear(value: f32) -> f32 {
    if value <= 0.003_130_8 { value * 12.92 } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
}

fn too_many(what: &str, needed: usize, allowed: usize) -> GpuError {
    GpuError::TooMany {
        what: what.to_owned(),
        needed: needed as u64,
        allowed: allowed as u64,
        remedy: "simplify the model",
    }
}

/// Counts that were checked against 2²⁴, or that a buffer's size bounds.
fn u32_of(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}
