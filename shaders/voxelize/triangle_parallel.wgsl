#include "lib/dispatch.inc.wgsl"
#include "lib/geometry.inc.wgsl"
#include "lib/mark_triangle.inc.wgsl"
// One thread a triangle (RB §3.2).

@group(0) @binding(0) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(1) var<uniform> grid_index: vec4u;
@group(0) @binding(2) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(3) var<storage, read> indices: array<u32>;
@group(0) @binding(4) var<storage, read> materials: array<PartMaterial>;

const WORKGROUP: u32 = 64u;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let number = thread_index(id, groups, WORKGROUP);
    if number >= arrayLength(&indices) / 3u {
        return;
    }
    let g = grids[grid_index.x];
    let v0 = vertices[indices[number * 3u]];
    if g.required_flags != 0u && (materials[v0.part].flags & g.required_flags) != g.required_flags {
        return;
    }
    mark_triangle(g, grid_triangle(
        g, v0.position, vertices[indices[number * 3u + 1u]].position, vertices[indices[number * 3u + 2u]].position));
}
