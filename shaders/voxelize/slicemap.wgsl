#include "lib/conservative.inc.wgsl"
#include "lib/occupancy.inc.wgsl"
#include "lib/one_grid.inc.wgsl"
// A fragment a column, a bit by linear eye depth (Eisemann & Décoret 2006). Instances are the pieces of a triangle cut
// at the eye.

@vertex
fn project(@builtin(vertex_index) vertex: u32, @builtin(instance_index) piece: u32) -> Footprint {
    let t = triangle_of(vertex / footprint_vertices());
    if piece >= t.pieces {
        return no_footprint();
    }
    let g = grids[grid_index.x];
    return footprint_vertex(
        g, t.a, select(t.c, t.b, piece == 0u), select(t.d, t.c, piece == 0u), vertex % footprint_vertices(), 0u);
}

@fragment
fn mark(in: Footprint) {
    let g = grids[grid_index.x];
    let column = vec2i(in.position.xy);
    let t = triangle_box(in.a, in.b, in.c);
    if footprint_holds(g, t, column) {
        let slices = slices_over(g, t, column);
        mark_run(g, vec2u(column), slices.x, slices.y);
    }
}
