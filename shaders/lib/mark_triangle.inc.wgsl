#include "lib/grid_triangle.inc.wgsl"
#include "lib/occupancy.inc.wgsl"
#include "lib/triangle_box.inc.wgsl"
// One thread marks a whole triangle: its rows, each row's columns, each column's cells.

fn mark_box(g: Grid, t: TriangleBox) {
    let rows = rows_met(g, t);
    for (var y = rows.x; y <= rows.y; y++) {
        let columns = columns_met(g, t, y);
        for (var x = columns.x; x <= columns.y; x++) {
            let slices = slices_met(g, t, vec2i(x, y));
            mark_run(g, vec2u(vec2i(x, y)), slices.x, slices.y);
        }
    }
}

fn mark_triangle(g: Grid, t: GridTriangle) {
    for (var piece = 0u; piece < t.pieces; piece++) {
        mark_box(g, triangle_box(t.a, select(t.c, t.b, piece == 0u), select(t.d, t.c, piece == 0u)));
    }
}
