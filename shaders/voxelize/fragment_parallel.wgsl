#include "lib/column_raster.inc.wgsl"
// A fragment for each column that a triangle may meet (RB §3.3). Instances are the pieces of a triangle cut at the eye.

@group(0) @binding(0) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(1) var<uniform> grid_index: vec4u;
@group(0) @binding(2) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(3) var<storage, read> indices: array<u32>;
@group(0) @binding(4) var<storage, read> materials: array<PartMaterial>;

@vertex
fn outline(@builtin(vertex_index) vertex: u32, @builtin(instance_index) piece: u32) -> ColumnTriangle {
    let g = grids[grid_index.x];
    let number = vertex / OUTLINE_VERTICES;
    let v0 = vertices[indices[number * 3u]];
    var t = grid_triangle(
        g, v0.position, vertices[indices[number * 3u + 1u]].position, vertices[indices[number * 3u + 2u]].position);
    if g.required_flags != 0u && (materials[v0.part].flags & g.required_flags) != g.required_flags {
        t.pieces = 0u;
    }
    return outline_vertex(g, t, piece, vertex % OUTLINE_VERTICES);
}

@fragment
fn mark(in: ColumnTriangle) {
    mark_fragment(grids[grid_index.x], in);
}
