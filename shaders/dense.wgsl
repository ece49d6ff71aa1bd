#include "lib/dispatch.inc.wgsl"
#include "lib/volume.inc.wgsl"
#include "lib/voxel_path.inc.wgsl"
// A dense volume, to be compared with the records: a texel a voxel, its normal and, in alpha, (1 + part) / 127, 0 where
// nothing is (CL §2.1 keeps normal and boundary so). `fill_*` copy the records into a texture; `march` is the paper's
// marcher over the texture, or over the records.

@group(0) @binding(0) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(1) var<storage, read> indices: array<u32>;
@group(0) @binding(2) var<storage, read> materials: array<PartMaterial>;
@group(0) @binding(3) var<storage, read> occupancy: array<u32>;
@group(0) @binding(4) var<storage, read> ranks: array<u32>;
@group(0) @binding(5) var<storage, read> records: array<Record>;
@group(0) @binding(6) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(7) var<uniform> surroundings: Surroundings;
@group(0) @binding(8) var<uniform> settings: MarchSettings;
@group(0) @binding(9) var float32: texture_storage_3d<rgba32float, write>;
@group(0) @binding(10) var float16: texture_storage_3d<rgba16float, write>;
@group(0) @binding(11) var snorm8: texture_storage_3d<rgba8snorm, write>;
@group(0) @binding(12) var dense: texture_3d<f32>;
@group(0) @binding(13) var exits: texture_storage_2d<rgba32float, write>;

const PART_STEPS: f32 = 127.0;

// Whether the march reads the texture.
override from_texture: bool = false;

// ---- filling: a thread a word writes all its cells, the empty ones too

struct Column {
    corner: vec3u,
    word: u32,
    rank: u32,
    height: u32,        // cells; 0 past the grid's end
}

fn column_of(id: vec3u, workgroups: vec3u) -> Column {
    let number = thread_index(id, workgroups, 64u);
    let per_column = grids[VIEW].words_per_column;
    let cells = grids[VIEW].cells;
    if number >= cells.x * cells.y * per_column {
        return Column(vec3u(0u), 0u, 0u, 0u);
    }
    let column = number / per_column;
    let corner = vec3u(column % cells.x, column / cells.x, (number % per_column) * 32u);
    let index = grids[VIEW].word_base + number;
    return Column(corner, occupancy[index], ranks[index], min(32u, cells.z - corner.z));
}

// Of the column's cell `up` cells above its corner.
fn texel_of(column: Column, up: u32) -> vec4f {
    let bit = 1u << up;
    if (column.word & bit) == 0u {
        return vec4f(0.0);
    }
    let rank = min(column.rank + countOneBits(column.word & (bit - 1u)), grids[VIEW].record_capacity - 1u);
    let record = records[grids[VIEW].record_base + rank];
    return vec4f(unpack_unit(record.normal), f32(record_part(record) + 1u) / PART_STEPS);
}

@compute @workgroup_size(64)
fn fill_float32(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let column = column_of(id, workgroups);
    for (var up = 0u; up < column.height; up++) {
        textureStore(float32, column.corner + vec3u(0u, 0u, up), texel_of(column, up));
    }
}

@compute @workgroup_size(64)
fn fill_float16(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let column = column_of(id, workgroups);
    for (var up = 0u; up < column.height; up++) {
        textureStore(float16, column.corner + vec3u(0u, 0u, up), texel_of(column, up));
    }
}

@compute @workgroup_size(64)
fn fill_snorm8(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let column = column_of(id, workgroups);
    for (var up = 0u; up < column.height; up++) {
        textureStore(snorm8, column.corner + vec3u(0u, 0u, up), texel_of(column, up));
    }
}

// ---- marching

// In a dense volume a step knows its texel by its cell: x and y in `word_index`, z in `slice`.
fn next_texel(ray: GridRay, steps: ptr<function, Steps>) -> bool {
    var at = *steps;
    var found = false;
    loop {
        at.s += at.s_step;
        if at.s > ray.s_last {
            break;
        }
        let column = clamp(vec2i(floor(ray.start.xy + at.s * ray.along.xy)), vec2i(0), ray.cells.xy - 1);
        at.slice = u32(slice_at(ray, at.s));
        at.word_index = u32(column.x) | (u32(column.y) << 16u);
        if textureLoad(dense, vec3u(vec2u(column), at.slice), 0).a != 0.0 {
            found = true;
            break;
        }
    }
    *steps = at;
    return found;
}

fn next_boundary(ray: GridRay, steps: ptr<function, Steps>) -> bool {
    if from_texture {
        return next_texel(ray, steps);
    }
    return next_boundary_voxel(ray, steps);
}

fn boundary_at(steps: Steps) -> Boundary {
    if from_texture {
        let texel = textureLoad(dense, vec3u(steps.word_index & 0xffffu, steps.word_index >> 16u, steps.slice), 0);
        return Boundary(normalize(texel.xyz), u32(round(texel.a * PART_STEPS)) - 1u, NO_TRIANGLE);
    }
    let record = record_at(VIEW, steps);
    return Boundary(unpack_unit(record.normal), record_part(record), record.triangle & RECORD_TRIANGLE_MASK);
}

// The way out of the glass, world, unit; w: 1 where there is one.
@compute @workgroup_size(8, 8)
fn march(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= settings.size) {
        return;
    }
    let path = voxel_path(id.xy);
    textureStore(exits, id.xy, vec4f(path.direction, select(0.0, 1.0, path.left_glass)));
}
