#include "lib/geometry.inc.wgsl"
#include "lib/grid_triangle.inc.wgsl"
// What passes over the triangles of one grid share: its bindings 0–4, the triangles in its space.
@group(0) @binding(0) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(1) var<uniform> grid_index: vec4u;
@group(0) @binding(2) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(3) var<storage, read> indices: array<u32>;
@group(0) @binding(4) var<storage, read> materials: array<PartMaterial>;

// A triangle in grid space, cut at the eye; no pieces if its part does not belong in this grid.
fn triangle_of(triangle: u32) -> GridTriangle {
    let g = grid_index.x;
    let v0 = indices[3u * triangle];
    let a = vertices[v0].position;
    let b = vertices[indices[3u * triangle + 1u]].position;
    let c = vertices[indices[3u * triangle + 2u]].position;
    var cut = grid_triangle(grids[g], a, b, c);
    let required = grids[g].required_flags;
    if required != 0u && (materials[vertices[v0].part].flags & required) != required {
        cut.pieces = 0u;
    }
    return cut;
}

// The depths in grid space between which the cells of a slice lie.
fn slabs_of(slice: i32) -> vec2f {
    if !perspective {
        return vec2f(0.0, 1.0) + f32(slice);
    }
    return vec2f(slab(grids[grid_index.x], f32(slice)), slab(grids[grid_index.x], f32(slice) + 1.0));
}
