//! Structs that host and shaders share agree by name, offset and size, in every shader that has them.

use murrine::gpu::{GpuStruct, Layout, layout, shader::ShaderLibrary};
use murrine::{animate, csg, grid, march, scene, surroundings, volume, voxel_list};

const SHARED: &[Layout] = &[
    grid::Grid::LAYOUT,
    volume::Record::LAYOUT,
    volume::GridCounters::LAYOUT,
    animate::Vertex::LAYOUT,
    scene::geometry::RestVertex::LAYOUT,
    scene::geometry::Influence::LAYOUT,
    scene::geometry::Morph::LAYOUT,
    scene::material::PartMaterial::LAYOUT,
    surroundings::LightData::LAYOUT,
    surroundings::PlaneData::LAYOUT,
    surroundings::Surroundings::LAYOUT,
    march::MarchSettings::LAYOUT,
    voxel_list::ListedVoxel::LAYOUT,
    csg::CsgProgram::LAYOUT,
];

fn shaders() -> Vec<murrine::gpu::shader::Shader> {
    let library = ShaderLibrary::default();
    let names = library.names().unwrap();
    names.iter().filter(|n| !n.ends_with(".inc.wgsl")).map(|n| library.load(n).unwrap()).collect()
}

#[test]
fn shared_structs_agree_in_every_shader() {
    let shaders = shaders();
    for shared in SHARED {
        let mut seen = 0;
        for shader in &shaders {
            layout::check(&shader.module, &shader.name, shared).unwrap_or_else(|e| panic!("{e}"));
            seen += usize::from(shader.module.types.iter().any(|(_, t)| t.name.as_deref() == Some(shared.name)));
        }
        assert!(seen > 0, "no shader has a struct `{}`", shared.name);
    }
}

#[test]
fn drift_between_structs_of_equal_size_is_caught() {
    let shader = ShaderLibrary::default().load("voxelize/triangle_parallel.wgsl").unwrap();
    let mut fields = grid::Grid::LAYOUT.fields.to_vec();
    fields.swap(4, 5);
    let drifted = Layout { name: "Grid", fields: Box::leak(fields.into_boxed_slice()), size: grid::Grid::LAYOUT.size };
    let error = layout::check(&shader.module, &shader.name, &drifted).unwrap_err().to_string();
    assert!(error.contains("struct `Grid`"), "{error}");
}
