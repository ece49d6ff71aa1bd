#include "lib/dispatch.inc.wgsl"
#include "lib/grid_triangle.inc.wgsl"
#include "lib/occupancy.inc.wgsl"
#include "lib/triangle_box.inc.wgsl"
// One thread a triangle: its rows, each row's columns, each column's cells (RB §3.2, Fig. 17).

@group(0) @binding(0) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(1) var<uniform> grid_index: vec4u;
@group(0) @binding(2) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(3) var<storage, read> indices: array<u32>;
@group(0) @binding(4) var<storage, read> materials: array<PartMaterial>;

const WORKGROUP: u32 = 64u;

fn mark_triangle(g: Grid, a: vec3f, b: vec3f, c: vec3f) {
    let t = triangle_box(a, b, c);
    let rows = rows_met(g, t);
    for (var y = rows.x; y <= rows.y; y++) {
        let columns = columns_met(g, t, y);
        for (var x = columns.x; x <= columns.y; x++) {
            let slices = slices_met(g, t, vec2i(x, y));
            mark_run(g, vec2u(vec2i(x, y)), slices.x, slices.y);
        }
    }
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let number = thread_index(id, groups, WORKGROUP);
    if number >= arrayLength(&indices) / 3u {
        return;
    }
    let g = grids[grid_index.x];
    let i0 = indices[number * 3u];
    if g.required_flags != 0u && (materials[vertices[i0].part].flags & g.required_flags) != g.required_flags {
        return;
    }
    let t = grid_triangle(
        g, vertices[i0].position, vertices[indices[number * 3u + 1u]].position,
        vertices[indices[number * 3u + 2u]].position);
    for (var piece = 0u; piece < t.pieces; piece++) {
        mark_triangle(g, t.a, select(t.c, t.b, piece == 0u), select(t.d, t.c, piece == 0u));
    }
}
