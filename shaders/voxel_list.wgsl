#include "lib/dispatch.inc.wgsl"
#include "lib/geometry.inc.wgsl"
#include "lib/surface.inc.wgsl"
#include "lib/texel.inc.wgsl"
#include "lib/volume.inc.wgsl"
// The voxel list (RB §3.5) by rank: a thread a word of the occupancy writes its voxels where their ranks say, each with
// what its nearest triangle is like at the point of it that is closest to the voxel's centre (RB §3.6).

@group(0) @binding(0) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(1) var<uniform> grid_index: vec4u;
@group(0) @binding(2) var<storage, read> occupancy: array<u32>;
@group(0) @binding(3) var<storage, read> ranks: array<u32>;
@group(0) @binding(4) var<storage, read> records: array<Record>;
@group(0) @binding(5) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(6) var<storage, read> indices: array<u32>;
@group(0) @binding(7) var<storage, read> rest_vertices: array<RestVertex>;
@group(0) @binding(8) var<storage, read> materials: array<PartMaterial>;
@group(0) @binding(9) var<storage, read_write> listed: array<ListedVoxel>;
@group(0) @binding(10) var textures: texture_2d_array<f32>;
@group(0) @binding(11) var texture_sampler: sampler;

struct ListedVoxel {
    position: vec3f,    // of the surface, world
    cell: u32,          // `unpack_cell`
    normal: vec3f,      // smooth, world, unit
    triangle: u32,      // NO_TRIANGLE for an orphan
    color: vec3f,       // linear: what an opaque part reflects, what a clear one's surface lets through
    part: u32,
}

fn orphan(g: u32, record: Record, cell: vec3u) -> ListedVoxel {
    let middle = 0.5 * (slab(grids[g], f32(cell.z)) + slab(grids[g], f32(cell.z) + 1.0));
    let position = world_from_grid(grids[g], vec3f(vec2f(cell.xy) + 0.5, middle));
    let part = record_part(record);
    return ListedVoxel(position, pack_cell(cell), unpack_unit(record.normal), NO_TRIANGLE, materials[part].base_color, part);
}

// Where in the grid the record's point lies: the triangle's closest to the cell's centre, as `resolve` found it.
fn point_in_grid(g: u32, record: Record, cell: vec3u) -> vec3f {
    let fraction = unpack_point_in_cell(record.point);
    let low = slab(grids[g], f32(cell.z));
    let high = slab(grids[g], f32(cell.z) + 1.0);
    return vec3f(vec2f(cell.xy) + fraction.xy, mix(low, high, fraction.z));
}

fn voxel_at(g: u32, record: Record, cell: vec3u) -> ListedVoxel {
    if (record.triangle & RECORD_ORPHAN) != 0u {
        return orphan(g, record, cell);
    }
    let triangle = record_triangle(record);
    let at = barycentric_at(triangle, world_from_grid(grids[g], point_in_grid(g, record, cell)));
    // The point was packed: weights are brought back into the triangle, so that nothing is extrapolated.
    let within = max(at.weights, vec3f(0.0));
    let b = within / (within.x + within.y + within.z);
    let v0 = vertices[at.corner.x];
    let v1 = vertices[at.corner.y];
    let v2 = vertices[at.corner.z];
    let smooth_normal = b.x * v0.normal + b.y * v1.normal + b.z * v2.normal;
    let normal = select(unpack_unit(record.normal), smooth_normal, dot(smooth_normal, smooth_normal) > 1e-12);
    let flags = materials[v0.part].flags;
    var color = materials[v0.part].base_color;
    let uv0 = vec2f(rest_vertices[at.corner.x].u, rest_vertices[at.corner.x].v);
    let uv1 = vec2f(rest_vertices[at.corner.y].u, rest_vertices[at.corner.y].v);
    let uv2 = vec2f(rest_vertices[at.corner.z].u, rest_vertices[at.corner.z].v);
    if (flags & FLAG_VERTEX_COLOR) != 0u {
        color *= b.x * color_from_uv(uv0) + b.y * color_from_uv(uv1) + b.z * color_from_uv(uv2);
    } else if materials[v0.part].base_color_layer >= 0 {
        let uv = b.x * uv0 + b.y * uv1 + b.z * uv2;
        color *= texel(materials[v0.part].base_color_layer, uv, 0.0, (flags >> BASE_COLOR_SAMPLING_SHIFT) & SAMPLING_MASK);
    }
    let position = b.x * v0.position + b.y * v1.position + b.z * v2.position;
    return ListedVoxel(position, pack_cell(cell), normalize(normal), triangle, color, v0.part);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let g = grid_index.x;
    let word = thread_index(id, workgroups, 64u);
    let per_column = grids[g].words_per_column;
    let across = grids[g].cells.x;
    if word >= across * grids[g].cells.y * per_column {
        return;
    }
    let index = grids[g].word_base + word;
    let column = word / per_column;
    let corner = vec3u(column % across, column / across, (word % per_column) * 32u);
    var bits = occupancy[index];
    var rank = ranks[index];
    while bits != 0u && rank < min(grids[g].record_capacity, arrayLength(&listed)) {
        let cell = corner + vec3u(0u, 0u, countTrailingZeros(bits));
        listed[rank] = voxel_at(g, records[grids[g].record_base + rank], cell);
        bits &= bits - 1u;
        rank++;
    }
}
