#include "lib/conservative.inc.wgsl"
#include "lib/one_grid.inc.wgsl"
// A fragment a column, toggling every cell whose centre lies in front of it (Eisemann & Décoret 2008). Instances are the
// pieces of a triangle cut at the eye.

@group(0) @binding(5) var<storage, read_write> interior: array<atomic<u32>>;

@vertex
fn project(@builtin(vertex_index) vertex: u32, @builtin(instance_index) piece: u32) -> Footprint {
    let t = triangle_of(vertex / TRIANGLE_VERTICES);
    if piece >= t.pieces {
        return no_footprint();
    }
    let g = grids[grid_index.x];
    return footprint_vertex(
        g, t.a, select(t.c, t.b, piece == 0u), select(t.d, t.c, piece == 0u), vertex % TRIANGLE_VERTICES, 0u);
}

@fragment
fn toggle(in: Footprint) {
    let g = grids[grid_index.x];
    let column = vec2i(in.position.xy);
    let count = centers_before(g, depths_over(triangle_box(in.a, in.b, in.c), column).x);
    let base = word_index(g, vec3u(vec2u(column), 0u));
    let whole = count >> 5u;
    for (var word = 0u; word < whole; word++) {
        atomicXor(&interior[base + word], 0xffffffffu);
    }
    if (count & 31u) != 0u {
        atomicXor(&interior[base + whole], (1u << (count & 31u)) - 1u);
    }
}
