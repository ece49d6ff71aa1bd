//! Stage 1: moves every vertex in compute: morphs, then joints, then deformers, into world space.
//!
//! What a scene shows is uploaded once; a frame uploads matrices, morph weights and deformers, nothing else.

mod neighbors;
mod room;

mod pictures;

use crate::gpu::{ComputePass, Gpu, GpuError, GpuStruct, Recorder, buffer};
use crate::scene::deform::Deformation;
use crate::scene::geometry::{Geometry, Influence, Morph, RestVertex, Sampling};
use crate::scene::material::{Material, PartMaterial, flags};
use crate::scene::{Pose, Scene, World};
use glam::{Mat4, UVec2, Vec3};
use neighbors::neighbors;
pub(crate) use pictures::srgb8_from_linear;
use room::Room;
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
    /// Where the models lie whose triangles are made anew.
    rooms: Vec<Room>,
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
        triangles.textures = pictures::array(gpu, &pictures)?;
        triangles.samplings = pictures.iter().map(|p| p.sampling).collect();
        triangles.part_flags = joined.part_flags;
        triangles.rooms = joined.rooms;

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

    /// Writes the models whose triangles are made anew ([`World::at`]). False where one outgrew its room: the world must
    /// be uploaded again.
    #[must_use]
    pub fn write_remade(&self, gpu: &Gpu, triangles: &Triangles, world: &World) -> bool {
        triangles.rooms.iter().all(|room| {
            let Some(geometry) = world.models.get(room.model as usize) else { return false };
            let fits = room.holds(geometry);
            if fits {
                room.write(gpu, triangles, geometry);
            }
            fits
        })
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

    /// Some of these triangles by themselves: they share vertices and materials, and have no neighbours.
    ///
    /// # Errors
    /// When the device refuses the buffer.
    pub fn of(&self, gpu: &Gpu, triangles: &[[u32; 3]]) -> Result<Self, GpuError> {
        Ok(Self {
            vertices: self.vertices.clone(),
            indices: buffer::storage_with(gpu, "indices", triangles)?,
            rest_vertices: self.rest_vertices.clone(),
            materials: self.materials.clone(),
            textures: self.textures.clone(),
            neighbors: buffer::storage_with(gpu, "neighbors", &vec![NO_TRIANGLE; 3 * triangles.len()])?,
            vertex_count: self.vertex_count,
            triangle_count: u32_of(triangles.len()),
            part_flags: self.part_flags.clone(),
            samplings: self.samplings.clone(),
            rooms: Vec::new(),
            motion: None,
        })
    }

    /// These triangles as they are now: what is recorded later moves them no more.
    ///
    /// # Errors
    /// When the device refuses a buffer.
    pub fn standing(&self, gpu: &Gpu) -> Result<Self, GpuError> {
        let vertices = buffer::with_usage(gpu, "vertices", self.vertices.size(), self.vertices.usage())?;
        let mut encoder =
            gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("standing") });
        encoder.copy_buffer_to_buffer(&self.vertices, 0, &vertices, 0, self.vertices.size());
        gpu.queue.submit([encoder.finish()]);
        Ok(Self {
            vertices,
            indices: self.indices.clone(),
            rest_vertices: self.rest_vertices.clone(),
            materials: self.materials.clone(),
            textures: self.textures.clone(),
            neighbors: self.neighbors.clone(),
            vertex_count: self.vertex_count,
            triangle_count: self.triangle_count,
            part_flags: self.part_flags.clone(),
            samplings: self.samplings.clone(),
            rooms: Vec::new(),
            motion: None,
        })
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
            textures: pictures::array(gpu, &[])?,
            neighbors: filled("neighbors", bytemuck::cast_slice(&neighbors(triangles, vertices.len(), place)))?,
            vertex_count: u32_of(vertices.len()),
            triangle_count: u32_of(triangles.len()),
            part_flags: Vec::new(),
            samplings: Vec::new(),
            rooms: Vec::new(),
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
    rooms: Vec<Room>,
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
        let room = geometry.made_from.is_some().then(|| Room::for_model(model, geometry, self));
        let padded = room.as_ref().map(|room| room.filled(geometry));
        let geometry = padded.as_ref().unwrap_or(geometry);
        self.rooms.extend(room);
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
    let turned = if material.turned { flags::TURNED } else { 0 };
    let operand = material.operand << flags::OPERAND_SHIFT | turned;
    let unlit = if material.unlit { flags::UNLIT } else { 0 };
    PartMaterial {
        sigma: material.sigma,
        ior: material.ior,
        base_color: material.base_color,
        flags: of_part | operand | opaque | thin_wall | double_sided | unlit | sampled,
        emissive: material.emissive,
        roughness: material.roughness,
        dispersion: material.dispersion,
        priority: material.priority,
        base_color_layer: layer(material.base_color_texture),
        emissive_layer: layer(material.emissive_texture),
    }
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
