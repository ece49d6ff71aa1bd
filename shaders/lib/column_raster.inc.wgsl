#include "lib/geometry.inc.wgsl"
#include "lib/grid_triangle.inc.wgsl"
#include "lib/occupancy.inc.wgsl"
#include "lib/triangle_box.inc.wgsl"
// A fragment a column: rasterizes the columns that a triangle may meet, seen along z, and solves each for its cells.
//
// The raster has a pixel a column. What is drawn is a hexagon, the hull of three squares about the projected triangle's
// corners, turned along its longest side: it holds every column that the triangle touches, has no spikes where the
// triangle is a needle, and stays an area where it is a line. Rasterizers move vertices by up to 1/256 pixel, so it is a
// little larger than it would have to be; the fragment decides.

// Vertices of the hexagon as drawn: four triangles.
const OUTLINE_VERTICES: u32 = 12u;

// Beyond half a pixel's diagonal: what rasterizers and f32 may take away.
const OUTLINE_SLACK: f32 = 1.0 / 32.0;

// Where a corner would lie farther than this many columns off the raster, the outline is the triangle's box within it.
const OUTLINE_FARTHEST: f32 = 4096.0;

struct ColumnTriangle {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat, either) a: vec3f,   // grid space
    @location(1) @interpolate(flat, either) b: vec3f,
    @location(2) @interpolate(flat, either) c: vec3f,
}

// A vertex of what is not to be drawn: all of it off the raster.
const NOT_DRAWN: ColumnTriangle = ColumnTriangle(vec4f(2.0, 2.0, 2.0, 1.0), vec3f(0.0), vec3f(0.0), vec3f(0.0));

// Place of a corner of the outline, columns. Corners run around the hexagon; the shortest way to draw it is a fan.
fn outline_corner(g: Grid, a: vec2f, b: vec2f, c: vec2f, corner: u32) -> vec2f {
    let lo = min(a, min(b, c));
    let hi = max(a, max(b, c));
    let cells = vec2f(g.cells.xy);
    if any(lo < vec2f(-OUTLINE_FARTHEST)) || any(hi > cells + OUTLINE_FARTHEST) {
        let within_lo = clamp(lo - 1.0, vec2f(-1.0), cells + 1.0);
        let within_hi = clamp(hi + 1.0, vec2f(-1.0), cells + 1.0);
        // Four corners of a box; two of the hexagon's fall together.
        return select(within_lo, within_hi, vec2<bool>(corner >= 1u && corner <= 3u, corner >= 2u));
    }
    let ab = b - a;
    let bc = c - b;
    let ca = a - c;
    let longest = max(dot(ab, ab), max(dot(bc, bc), dot(ca, ca)));
    var start = a;
    var end = b;
    var apex = c;
    if dot(bc, bc) == longest {
        start = b; end = c; apex = a;
    } else if dot(ca, ca) == longest {
        start = c; end = a; apex = b;
    }
    let length = sqrt(longest);
    let along = select(vec2f(1.0, 0.0), (end - start) / max(length, 1e-20), length > 1e-6);
    let left = vec2f(-along.y, along.x);
    let height = dot(apex - start, left);
    let up = select(-left, left, height >= 0.0);
    let foot = clamp(dot(apex - start, along), 0.0, length);
    // Half the extent of a column's square along either direction.
    let reach = 0.5 * (abs(along.x) + abs(along.y)) + OUTLINE_SLACK;
    var p = vec2f(-reach, -reach);
    switch corner {
        case 1u: { p = vec2f(length + reach, -reach); }
        case 2u: { p = vec2f(length + reach, reach); }
        case 3u: { p = vec2f(foot + reach, abs(height) + reach); }
        case 4u: { p = vec2f(foot - reach, abs(height) + reach); }
        case 5u: { p = vec2f(-reach, reach); }
        default: {}
    }
    return start + along * p.x + up * p.y;
}

// Vertex `vertex` of the outline of a triangle's piece; all the same, off the raster, for a piece that isn't.
fn outline_vertex(g: Grid, t: GridTriangle, piece: u32, vertex: u32) -> ColumnTriangle {
    if piece >= t.pieces {
        return NOT_DRAWN;
    }
    let b = select(t.c, t.b, piece == 0u);
    let c = select(t.d, t.c, piece == 0u);
    // A fan: 0 1 2, 0 2 3, 0 3 4, 0 4 5.
    let corner = select(vertex / 3u + vertex % 3u, 0u, vertex % 3u == 0u);
    let p = outline_corner(g, t.a.xy, b.xy, c.xy, corner) / vec2f(g.cells.xy);
    return ColumnTriangle(vec4f(2.0 * p.x - 1.0, 1.0 - 2.0 * p.y, 0.5, 1.0), t.a, b, c);
}

// Marks the fragment's column.
fn mark_fragment(g: Grid, in: ColumnTriangle) {
    let column = vec2i(in.position.xy);
    let t = triangle_box(in.a, in.b, in.c);
    let rows = rows_met(g, t);
    let columns = columns_met(g, t, column.y);
    if column.y < rows.x || column.y > rows.y || column.x < columns.x || column.x > columns.y {
        return;
    }
    let slices = slices_met(g, t, column);
    mark_run(g, vec2u(column), slices.x, slices.y);
}
