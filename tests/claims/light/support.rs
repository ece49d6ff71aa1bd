//! The stages up to the light, and a probe that looks up what is left of it at given points.

use crate::{gpu, probe};
use glam::Vec3;
use murrine::animate::Animate;
use murrine::gpu::{ComputePass, GpuStruct, Recorder, Timing, buffer};
use murrine::grid::Grid;
use murrine::light::LightColumns;
use murrine::plane_light::PlaneLight;
use murrine::resolve::Resolve;
use murrine::scene::World;
use murrine::scene::description::{Light, LightKind, MaterialOverride, Model, Scene, Shape, Source};
use murrine::scene::material::PartMaterial;
use murrine::surroundings::{LightData, PlaneData, Surroundings, SurroundingsBuffers, surroundings};
use murrine::volume::{Record, Volume};
use murrine::voxel_cameras::VoxelCameras;
use murrine::voxelize::{self, Input};

const PROBE: &str = r#"
#include "lib/shading.inc.wgsl"
struct Question { p: vec3f, light: u32, n: vec3f, what: u32 }
@group(0) @binding(0) var<uniform> surroundings: Surroundings;
@group(0) @binding(1) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(2) var<storage, read> occupancy: array<u32>;
@group(0) @binding(3) var<storage, read> ranks: array<u32>;
@group(0) @binding(4) var<storage, read> records: array<Record>;
@group(0) @binding(5) var<storage, read> light_records: array<vec2u>;
@group(0) @binding(6) var<storage, read> materials: array<PartMaterial>;
@group(0) @binding(7) var<storage, read> questions: array<Question>;
@group(0) @binding(8) var<storage, read_write> answers: array<vec4f>;
@group(0) @binding(9) var environment: texture_2d<f32>;
@group(0) @binding(10) var environment_sampler: sampler;
@group(0) @binding(11) var plane_light: texture_2d_array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x < arrayLength(&questions) {
        let q = questions[id.x];
        switch q.what {
            case 0u: { answers[id.x] = vec4f(light_absorption(q.light, q.p, q.n), 0.0); }
            case 1u: { answers[id.x] = vec4f(light_transmittance(q.light, q.p, q.n), 0.0); }
            default: { answers[id.x] = vec4f(light_share(q.light, q.p, vec3f(0.0), 0u), 0.0); }
        }
    }
}
"#;

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Question {
    p: Vec3,
    light: u32,
    n: Vec3,
    what: u32,
}

/// A scene whose lights' grids are walked.
pub(super) struct Lit {
    volume: Volume,
    materials: wgpu::Buffer,
    surroundings: SurroundingsBuffers,
    plane_light: PlaneLight,
    grids: std::ops::Range<u32>,
    probe: ComputePass,
}

impl Lit {
    pub(super) fn new(scene: &Scene) -> Self {
        Self::of(scene, &World::load(scene, None).unwrap())
    }

    pub(super) fn of(scene: &Scene, world: &World) -> Self {
        let pose = world.pose(scene, 0.0);
        let parts = world.materials(scene);
        let cameras = VoxelCameras::fit(scene, world, &parts, &pose);
        let mut animate = Animate::new(gpu()).unwrap();
        let triangles = animate.upload(gpu(), world).unwrap();
        animate.write_materials(gpu(), &triangles, &parts);
        let surroundings_data = surroundings(scene, world, &parts, (1.0, 512), &cameras.light_grids, None);
        let buffers = SurroundingsBuffers::new(gpu(), world).unwrap();
        buffers.write(gpu(), &surroundings_data);

        let mut voxelizer = (voxelize::method("triangle-parallel").unwrap().new)(gpu()).unwrap();
        let resolve = Resolve::new(gpu()).unwrap();
        let light = LightColumns::new(gpu()).unwrap();
        let mut plane_light = PlaneLight::new(gpu()).unwrap();
        let mut volume = Volume::new(gpu()).unwrap();
        let lit: Vec<u32> = cameras.light_grids.iter().cloned().flatten().collect();
        loop {
            volume.fit(gpu(), &cameras.grids).unwrap();
            let mut rec = Recorder::new(gpu(), Timing::Off);
            animate.record(&mut rec, &triangles, world, scene, &pose);
            for grid in lit.iter().map(|g| *g as usize) {
                volume.clear(&mut rec, grid);
                let input = Input { volume: &volume, grid, triangles: &triangles, settings: &scene.voxelizer };
                voxelizer.record(&mut rec, &input).unwrap();
                resolve.record(&mut rec, &volume, grid, &triangles);
                light.record(&mut rec, &volume, grid, &triangles, &scene.effect);
            }
            plane_light.record(&mut rec, &volume, &triangles, (&surroundings_data, &buffers)).unwrap();
            rec.finish().unwrap();
            if volume.settle(gpu()).unwrap() {
                break;
            }
        }
        let layouts = [
            Surroundings::LAYOUT,
            LightData::LAYOUT,
            PlaneData::LAYOUT,
            Grid::LAYOUT,
            Record::LAYOUT,
            PartMaterial::LAYOUT,
        ];
        Self {
            volume,
            materials: triangles.materials.clone(),
            surroundings: buffers,
            plane_light,
            grids: cameras.light_grids[0].clone(),
            probe: probe::compile(PROBE, &layouts),
        }
    }

    fn ask(&self, light: u32, points: &[Vec3], normal: impl Fn(usize) -> Vec3, what: u32) -> Vec<Vec3> {
        let questions: Vec<Question> =
            points.iter().enumerate().map(|(i, p)| Question { p: *p, light, n: normal(i), what }).collect();
        let bound = [
            ("surroundings", self.surroundings.data.as_entire_binding()),
            ("grids", self.volume.grid_data.as_entire_binding()),
            ("occupancy", self.volume.occupancy.as_entire_binding()),
            ("ranks", self.volume.ranks.as_entire_binding()),
            ("records", self.volume.records.as_entire_binding()),
            ("light_records", self.volume.light_records.as_entire_binding()),
            ("materials", self.materials.as_entire_binding()),
            ("environment", wgpu::BindingResource::TextureView(&self.surroundings.environment)),
            ("environment_sampler", wgpu::BindingResource::Sampler(&self.surroundings.sampler)),
            ("plane_light", wgpu::BindingResource::TextureView(self.plane_light.view())),
        ];
        let answers: Vec<[f32; 4]> = probe::ask(&self.probe, &bound, &questions);
        answers.into_iter().map(|[r, g, b, _]| Vec3::new(r, g, b)).collect()
    }

    /// What absorption leaves of a light at `points`, all with the same normal (zero: of no voxelized surface).
    pub(super) fn absorption(&self, light: u32, points: &[Vec3], normal: Vec3) -> Vec<Vec3> {
        self.ask(light, points, |_| normal, 0)
    }

    /// The same, each point with its own normal.
    pub(super) fn absorption_at(&self, light: u32, points: &[Vec3], normals: &[Vec3]) -> Vec<Vec3> {
        self.ask(light, points, |i| normals[i], 0)
    }

    /// What absorption and the surfaces' reflection leave.
    pub(super) fn transmittance(&self, light: u32, points: &[Vec3], normal: Vec3) -> Vec<Vec3> {
        self.ask(light, points, |_| normal, 1)
    }

    /// What is left at `points` of plane 0, shadows soft.
    pub(super) fn on_plane(&self, light: u32, points: &[Vec3]) -> Vec<Vec3> {
        self.ask(light, points, |_| Vec3::ZERO, 2)
    }

    /// Grids of light 0.
    pub(super) fn grid_count(&self) -> usize {
        self.grids.len()
    }

    /// The light records of light 0's first grid.
    pub(super) fn bytes(&self) -> Vec<u8> {
        let grid = self.volume.grids[self.grids.start as usize];
        let counts = self.volume.counts();
        let count = counts[self.grids.start as usize].occupied as usize;
        buffer::read::<[u8; 8]>(gpu(), &self.volume.light_records, u64::from(grid.record_base), count).unwrap().concat()
    }
}

pub(super) fn model(shape: Shape, material: MaterialOverride) -> Model {
    Model { source: Source::Shape(shape), materials: vec![material], ..Model::default() }
}

/// Glass of refraction index 1.5.
pub(super) fn glass(sigma: Vec3) -> MaterialOverride {
    MaterialOverride { sigma: Some(sigma), ior: Some(1.5), ..MaterialOverride::default() }
}

pub(super) fn opaque() -> MaterialOverride {
    MaterialOverride { opaque: Some(true), base_color: Some(Vec3::splat(0.8)), ..MaterialOverride::default() }
}

pub(super) fn sun(direction: Vec3) -> Light {
    Light { kind: LightKind::Directional { direction }, ..Light::default() }
}
