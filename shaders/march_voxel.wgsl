#include "lib/path_store.inc.wgsl"
#include "lib/voxel_path.inc.wgsl"
// The paper's marcher over the records: see `lib/voxel_path.inc.wgsl`.

@group(0) @binding(0) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(1) var<storage, read> indices: array<u32>;
@group(0) @binding(2) var<storage, read> materials: array<PartMaterial>;
@group(0) @binding(3) var<storage, read> occupancy: array<u32>;
@group(0) @binding(4) var<storage, read> ranks: array<u32>;
@group(0) @binding(5) var<storage, read> records: array<Record>;
@group(0) @binding(6) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(7) var<uniform> surroundings: Surroundings;
@group(0) @binding(8) var<uniform> settings: MarchSettings;
@group(0) @binding(9) var path_place: texture_storage_2d<rgba32float, write>;
@group(0) @binding(10) var path_way: texture_storage_2d<rgba32float, write>;
@group(0) @binding(11) var path_depth: texture_storage_2d<rgba32uint, write>;
@group(0) @binding(12) var path_first: texture_storage_2d<rgba32float, write>;
@group(0) @binding(13) var<storage, read_write> questionable: array<atomic<u32>>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let pixel = vec2u(id.x, settings.rows.x + id.y);
    if pixel.x >= settings.size.x || pixel.y >= settings.rows.y {
        return;
    }
    store_path(pixel, voxel_path(pixel));
}

fn next_boundary(ray: GridRay, steps: ptr<function, Steps>) -> bool {
    return next_boundary_voxel(ray, steps);
}

fn boundary_at(steps: Steps) -> Boundary {
    let record = record_at(VIEW, steps);
    return Boundary(unpack_unit(record.normal), record_part(record), record.triangle & RECORD_TRIANGLE_MASK);
}
