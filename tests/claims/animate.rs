//! The device moves every vertex to where the host's reference does.
#![expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small whole numbers")]

use crate::gpu;
use crate::probe;
use glam::{Mat4, Quat, UVec4, Vec3, Vec4};
use murrine::animate::{Animate, Triangles, Vertex};
use murrine::gpu::{AdapterChoice, Gpu, Recorder, Timing, buffer};
use murrine::scene::description::{Deformer, Model, Scene, Shape, Source};
use murrine::scene::geometry::{Geometry, Influence, MatrixSource, Morph, Sampling, Texture};
use murrine::scene::material::{PartMaterial, flags};
use murrine::scene::pose::{Pose, pose_vertices};
use murrine::scene::{World, shapes};
use std::sync::Arc;

/// Numbers between −1 and 1, the same every time.
struct Numbers(u32);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / (1 << 23) as f32 - 1.0
    }

    fn vec3(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }

    fn matrix(&mut self) -> Mat4 {
        let turn = Quat::from_scaled_axis(0.6 * self.vec3());
        Mat4::from_scale_rotation_translation(Vec3::ONE + 0.2 * self.vec3(), turn, 0.3 * self.vec3())
    }
}

const JOINTS: u32 = 7;
const TARGETS: u32 = 3;

/// A ball with four joints and three morph targets a vertex.
fn creature(numbers: &mut Numbers) -> Geometry {
    let mut geometry = shapes::shape(&Shape::Icosphere { radius: 1.0, subdivisions: 3 });
    let count = geometry.vertices.len();
    geometry.matrices = vec![MatrixSource::Node(0); JOINTS as usize];
    for influence in &mut geometry.influences {
        let joint = |n: &mut Numbers| ((n.next() + 1.0) * 0.5 * JOINTS as f32) as u32 % JOINTS;
        let weights = Vec4::new(numbers.next(), numbers.next(), numbers.next(), numbers.next()).abs();
        *influence = Influence {
            joints: [joint(numbers), joint(numbers), joint(numbers), joint(numbers)],
            weights: (weights / weights.element_sum()).to_array(),
        };
    }
    let displacement =
        |n: &mut Numbers| Morph { position: 0.05 * n.vec3(), normal: 0.1 * n.vec3(), _pad0: 0, _pad1: 0 };
    geometry.morphs = (0..count * TARGETS as usize).map(|_| displacement(numbers)).collect();
    geometry.parts[0].morph_count = TARGETS;
    geometry
}

/// A flat-shaded box, a creature and a plane, posed at random; the box is mirrored.
fn menagerie() -> (Scene, World, Pose) {
    let mut numbers = Numbers(7);
    let deformers = vec![
        Deformer::Twist { axis: 1, deg_per_unit: 40.0, hz: 0.3 },
        Deformer::Wave { axis: 2, along: 0, amplitude: 0.1, wavelength: 0.9, hz: 0.7 },
        Deformer::Wave { axis: 0, along: 0, amplitude: 0.05, wavelength: 1.1, hz: 0.2 },
    ];
    let shape = |shape| Source::Shape(shape);
    let flat_box = Shape::Box { min: Vec3::splat(-0.5), max: Vec3::new(0.5, 0.7, 0.6) };
    let mut flat = shapes::shape(&flat_box);
    flat.parts[0].flat = true;
    let plane = Shape::Plane { size: 4.0 };
    let models = vec![
        Model { source: shape(flat_box), ..Model::default() },
        Model { deformers, ..Model::default() },
        Model { source: shape(plane), ..Model::default() },
    ];
    let scene = Scene { models, ..Scene::default() };
    let geometries = vec![Arc::new(flat), Arc::new(creature(&mut numbers)), Arc::new(shapes::shape(&plane))];
    let world = World::from_geometry(&scene, geometries);
    let mirror = Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    let still = Mat4::IDENTITY;
    let matrices = [mirror].into_iter().chain((0..JOINTS).map(|_| numbers.matrix())).chain([still]).collect();
    let pose = Pose {
        matrices,
        world_from_model: vec![still, numbers.matrix(), still],
        morph_weights: vec![0.7, 0.0, -0.4],
        time_secs: 1.37,
        ..Pose::default()
    };
    (scene, world, pose)
}

fn animated(scene: &Scene, world: &World, pose: &Pose) -> (Triangles, Vec<Vertex>) {
    let mut animate = Animate::new(gpu()).unwrap();
    let triangles = animate.upload(gpu(), world).unwrap();
    animate.write_materials(gpu(), &triangles, &world.materials(scene));
    let mut rec = Recorder::new(gpu(), Timing::Off);
    animate.record(&mut rec, &triangles, world, scene, pose);
    rec.finish().unwrap();
    let vertices = buffer::read(gpu(), &triangles.vertices, 0, triangles.vertex_count as usize).unwrap();
    (triangles, vertices)
}

/// The largest difference in position, and in the normals of smooth parts.
fn differences(vertices: &[Vertex], reference: &[(Vec3, Vec3)]) -> (f32, f32) {
    assert_eq!(vertices.len(), reference.len());
    let pairs = || vertices.iter().zip(reference);
    let position = pairs().map(|(v, (position, _))| v.position.distance(*position)).fold(0.0, f32::max);
    let smooth = pairs().filter(|(v, _)| v.part == 1);
    (position, smooth.map(|(v, (_, normal))| v.normal.distance(*normal)).fold(0.0, f32::max))
}

#[test]
fn morphs_joints_deformers_and_placements_agree_with_the_host() {
    let (scene, world, pose) = menagerie();
    let (_, vertices) = animated(&scene, &world, &pose);
    let reference = pose_vertices(&world, &scene, &pose);
    let (position, normal) = differences(&vertices, &reference);
    assert!(position < 1e-5 && normal < 1e-4, "positions differ by {position}, normals by {normal}");

    for (v, part) in vertices.iter().zip(world.parts.iter().enumerate().flat_map(|(number, part)| {
        let range = world.models[part.model as usize].parts[part.part as usize].vertices.clone();
        range.map(move |_| number as u32)
    })) {
        assert_eq!(v.part, part);
    }

    // Each step leaves its mark: without it the reference is another.
    let without_deformers = Scene { models: vec![Model::default(); 3], ..Scene::default() };
    let without_morphs = Pose { morph_weights: vec![0.0; 3], ..pose.clone() };
    let mut without_turning = pose.clone();
    without_turning.matrices[3] = Mat4::IDENTITY;
    for (scene, pose) in [(&without_deformers, &pose), (&scene, &without_morphs), (&scene, &without_turning)] {
        let (position, normal) = differences(&vertices, &pose_vertices(&world, scene, pose));
        assert!(position > 1e-2 && normal > 1e-2, "positions differ by {position}, normals by {normal}");
    }
}

#[test]
fn a_mirrored_box_still_shows_its_outside() {
    let (scene, world, pose) = menagerie();
    let (triangles, vertices) = animated(&scene, &world, &pose);
    let indices: Vec<[u32; 3]> = buffer::read(gpu(), &triangles.indices, 0, triangles.triangle_count as usize).unwrap();
    let center = Vec3::new(0.0, 0.1, 0.05);
    let mut faces = 0;
    for t in indices.iter().map(|t| t.map(|v| vertices[v as usize])).filter(|t| t[0].part == 0) {
        faces += 1;
        let winding = (t[1].position - t[0].position).cross(t[2].position - t[0].position).normalize();
        assert_eq!(t[0].mirrored, 1);
        assert!(winding.dot(t[0].position - center) < 0.0, "the mirror turns the winding");
        for v in t {
            assert!((v.normal + winding).length() < 1e-6);
        }
    }
    assert_eq!(faces, 12);
}

#[test]
fn triangles_wound_inward_are_turned_and_planes_have_none() {
    let (scene, world, pose) = menagerie();
    let mut inward = (*world.models[1]).clone();
    for t in inward.triangles.iter_mut().step_by(2) {
        t.swap(1, 2);
    }
    let count = inward.triangles.len() as u32 + 12;
    let models = vec![Arc::clone(&world.models[0]), Arc::new(inward), Arc::clone(&world.models[2])];
    let read = |world: &World| -> Vec<[u32; 3]> {
        let (triangles, _) = animated(&scene, world, &pose);
        assert_eq!(triangles.triangle_count, count);
        buffer::read(gpu(), &triangles.indices, 0, count as usize).unwrap()
    };
    let turned = read(&World::from_geometry(&scene, models));
    // The same cyclic order, whichever corner comes first.
    let from_least = |t: &[u32; 3]| {
        let least = (0..3).min_by_key(|i| t[*i]).unwrap();
        [0, 1, 2].map(|i| t[(least + i) % 3])
    };
    assert!(turned.iter().map(from_least).eq(read(&world).iter().map(from_least)));
}

#[test]
fn parts_carry_the_flags_of_their_geometry_and_material() {
    let (scene, world, pose) = menagerie();
    let (triangles, _) = animated(&scene, &world, &pose);
    let materials: Vec<PartMaterial> = buffer::read(gpu(), &triangles.materials, 0, 3).unwrap();
    let found: Vec<u32> = materials.iter().map(|m| m.flags).collect();
    assert_eq!(found, [flags::FLAT, 0, flags::PLANE | flags::OPAQUE]);
}

/// Texels (x, y, layer) of the array.
fn texels(triangles: &Triangles, at: &[UVec4]) -> Vec<Vec4> {
    let pass = probe::compile(
        "@group(0) @binding(0) var textures: texture_2d_array<f32>;
        @group(0) @binding(1) var<storage, read> questions: array<vec4u>;
        @group(0) @binding(2) var<storage, read_write> answers: array<vec4f>;
        @compute @workgroup_size(1) fn main(@builtin(global_invocation_id) id: vec3u) {
            let q = questions[id.x];
            answers[id.x] = textureLoad(textures, q.xy, q.z, 0);
        }",
        &[],
    );
    probe::ask(&pass, &[("textures", wgpu::BindingResource::TextureView(&triangles.textures))], at)
}

#[test]
fn pictures_of_any_size_become_layers_of_one_array_in_linear_light() {
    let (scene, world, pose) = menagerie();
    let mut model = (*world.models[1]).clone();
    let picture = |width: u32, height: u32, srgb: bool, texel: fn(u32) -> u8| {
        let rgba8 = (0..width * height).flat_map(|i| [texel(i), texel(i), texel(i), 255]).collect();
        Texture { width, height, rgba8, srgb, sampling: Sampling::default() }
    };
    let stripes = |i: u32| if i.is_multiple_of(2) { 0 } else { 255 };
    model.textures = vec![picture(2048, 2, true, stripes), picture(3, 5, true, |_| 188), picture(8, 8, false, |_| 51)];
    let models = vec![Arc::clone(&world.models[0]), Arc::new(model), Arc::clone(&world.models[2])];
    let (triangles, _) = animated(&scene, &World::from_geometry(&scene, models), &pose);
    assert_eq!(triangles.textures.texture().width(), 1024);
    let found = texels(&triangles, &[0, 1, 2].map(|layer| UVec4::new(500, 500, layer, 0)));
    // Half of the stripes' light, not half of their code (0.216); sRGB 188 is 0.503; linear 51/255 stays.
    for (found, expected) in found.iter().zip([0.5, 0.503, 0.2]) {
        assert!((found.x - expected).abs() < 4e-3, "{found} instead of {expected}");
        assert!((found.w - 1.0).abs() < 1e-6);
    }
}

/// The claims' adapter with room for `bytes` bytes a buffer.
fn narrow_gpu(bytes: u64) -> Gpu {
    let adapter = Gpu::pick(&wgpu::Instance::new(instance()), &AdapterChoice::Software).unwrap();
    let limits =
        wgpu::Limits { max_storage_buffer_binding_size: bytes, max_buffer_size: bytes, ..wgpu::Limits::default() };
    let descriptor = wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    Gpu::new(adapter, device, queue)
}

fn instance() -> wgpu::InstanceDescriptor {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::PRIMARY;
    descriptor
}

#[test]
fn a_model_larger_than_the_devices_buffers_is_refused_with_the_limit_and_a_remedy() {
    let ball = |subdivisions| {
        let model = Model { source: Source::Shape(Shape::Icosphere { radius: 1.0, subdivisions }), ..Model::default() };
        World::load(&Scene { models: vec![model], ..Scene::default() }, None).unwrap()
    };
    let narrow = narrow_gpu(1 << 20);
    let mut animate = Animate::new(&narrow).unwrap();
    assert!(animate.upload(&narrow, &ball(5)).is_ok(), "10,242 vertices of 32 bytes fit");
    let told = animate.upload(&narrow, &ball(7)).unwrap_err().to_string();
    let expected = "buffer `vertices` needs 5242944 bytes, the adapter allows 1048576; simplify the model";
    assert!(told.starts_with(expected), "{told}");
    assert!(Animate::new(gpu()).unwrap().upload(gpu(), &ball(7)).is_ok(), "a wider device takes it");
}
