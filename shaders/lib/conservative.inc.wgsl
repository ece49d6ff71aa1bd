#include "lib/geometry.inc.wgsl"
#include "lib/grid.inc.wgsl"
#include "lib/grid_triangle.inc.wgsl"
#include "lib/triangle_box.inc.wgsl"
// What a rasterizing method draws in a triangle's stead, seen along z, so that it reaches every column that the triangle
// touches, and the depths at which it reaches them.
//
// The raster has a pixel a column; a pixel's middle is the column's middle line. Three shapes (Hasselgren et al. 2005 in
// TR §1.4.5; Hertel et al. 2009 in RB §3.3.2), for a triangle T and a column's square S of side 1:
//
//   polygon   T + S, a polygon of up to nine corners
//   box       the triangle whose sides are T's, moved out until they touch T + S; clipped by T + S's box. The same set:
//             the sum's sides are parallel to T's or to the box's
//   dilated   the triangle whose sides are T's, moved out by half of S's diagonal; clipped by that box. A larger set
//
// Rasterizers move corners by up to 1/256 pixel, and a needle's corners fly off: what is drawn is a little larger, or the
// box, and the fragment decides by the shape itself. `hardware` draws T and decides as `polygon` does.

const CONSERVATIVE_NONE: u32 = 0u;
const CONSERVATIVE_POLYGON: u32 = 1u;
const CONSERVATIVE_BOX: u32 = 2u;
const CONSERVATIVE_DILATED: u32 = 3u;
const CONSERVATIVE_HARDWARE: u32 = 4u;

override conservative: u32 = CONSERVATIVE_NONE;

// Every slice between the least and the greatest depth of the triangle's plane over a column, within the triangle's own.
override conservative_depth: bool = false;

// Vertices that are drawn for a triangle; the host's twin is `Variant::footprint_vertices`.
const POLYGON_VERTICES: u32 = 21u;
const TRIANGLE_VERTICES: u32 = 3u;

// What rasterizers and f32 may take away.
const FOOTPRINT_SLACK: f32 = 1.0 / 32.0;

const HALF_DIAGONAL: f32 = 0.70710678;

// Sides that meet at less than this sine leave a spike too long to be drawn well.
const SHARPEST: f32 = 1.0 / 64.0;

// Heights below this, columns, leave the inner side of a triangle's sides unsure.
const FLATTEST: f32 = 1e-4;

// Columns beyond the raster where corners are too far for the rasterizer.
const FOOTPRINT_FARTHEST: f32 = 4096.0;

// A vertex of what is drawn; the triangle travels with it.
struct Footprint {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat, either) a: vec3f,   // grid space
    @location(1) @interpolate(flat, either) b: vec3f,
    @location(2) @interpolate(flat, either) c: vec3f,
    @location(3) @interpolate(flat, either) slice: u32, // the method's own
}

fn footprint_vertices() -> u32 {
    return select(TRIANGLE_VERTICES, POLYGON_VERTICES, conservative == CONSERVATIVE_POLYGON);
}

// The outer normal of the side from `a` to `b` of a triangle whose corners run anticlockwise; not unit.
fn outer_normal(a: vec2f, b: vec2f) -> vec2f {
    return vec2f(b.y - a.y, a.x - b.x);
}

fn quadrant(n: vec2f) -> vec2f {
    return select(vec2f(-1.0), vec2f(1.0), n >= vec2f(0.0));
}

// Corner `turn` of the up to three of T + S that belong to T's corner `at`: S's corners in the quadrants of the two
// sides' normals, and the one between where these are opposite (TR Fig. 1.10).
fn polygon_corner(before: vec2f, at: vec2f, after: vec2f, turn: u32) -> vec2f {
    let first = quadrant(outer_normal(before, at));
    let last = quadrant(outer_normal(at, after));
    var corner = select(first, last, turn == 2u);
    if turn == 1u && all(first == -last) {
        corner = vec2f(-first.y, first.x);
    }
    return at + corner * (0.5 + FOOTPRINT_SLACK);
}

// Where the two sides at corner `at` meet once they are moved out.
fn moved_corner(before: vec2f, at: vec2f, after: vec2f) -> vec2f {
    let first = normalize(outer_normal(before, at));
    let last = normalize(outer_normal(at, after));
    var reach = vec2f(HALF_DIAGONAL);
    if conservative == CONSERVATIVE_BOX {
        reach = 0.5 * vec2f(abs(first.x) + abs(first.y), abs(last.x) + abs(last.y));
    }
    reach += FOOTPRINT_SLACK;
    let sine = first.x * last.y - first.y * last.x;
    return at + vec2f(reach.x * last.y - reach.y * first.y, reach.y * first.x - reach.x * last.x) / sine;
}

// Place of vertex `vertex` of the footprint, columns.
fn footprint_place(g: Grid, a: vec2f, p1: vec2f, p2: vec2f, vertex: u32) -> vec2f {
    let twice_area = (p1.x - a.x) * (p2.y - a.y) - (p1.y - a.y) * (p2.x - a.x);
    let b = select(p2, p1, twice_area >= 0.0);
    let c = select(p1, p2, twice_area >= 0.0);
    let cells = vec2f(g.cells.xy);
    let lo = min(a, min(b, c)) - 0.5 - FOOTPRINT_SLACK;
    let hi = max(a, max(b, c)) + 0.5 + FOOTPRINT_SLACK;
    let sides = vec3f(length(b - a), length(c - b), length(a - c));
    // The least sine of the corners; the least height.
    let sharp = abs(twice_area) / max(max(sides.x * sides.y, sides.y * sides.z), max(sides.z * sides.x, 1e-30));
    let flat = abs(twice_area) / max(max(sides.x, max(sides.y, sides.z)), 1e-30);
    let far = any(lo < vec2f(-FOOTPRINT_FARTHEST)) || any(hi > cells + FOOTPRINT_FARTHEST);
    let within_lo = clamp(lo, vec2f(-1.0), cells + 1.0);
    let within_hi = clamp(hi, vec2f(-1.0), cells + 1.0);
    if conservative == CONSERVATIVE_POLYGON {
        // A fan: 0 1 2, 0 2 3, …, 0 7 8.
        let corner = select(vertex / 3u + vertex % 3u, 0u, vertex % 3u == 0u);
        if far || flat < FLATTEST {
            return select(within_lo, within_hi, vec2<bool>(corner >= 1u && corner <= 4u, corner >= 3u));
        }
        switch corner / 3u {
            case 0u: { return polygon_corner(c, a, b, corner % 3u); }
            case 1u: { return polygon_corner(a, b, c, corner % 3u); }
            default: { return polygon_corner(b, c, a, corner % 3u); }
        }
    }
    if far || flat < FLATTEST || sharp < SHARPEST {
        // A right triangle of twice the box's sides.
        return within_lo + 2.0 * (within_hi - within_lo) * vec2f(vec2<bool>(vertex == 1u, vertex == 2u));
    }
    switch vertex {
        case 0u: { return moved_corner(c, a, b); }
        case 1u: { return moved_corner(a, b, c); }
        default: { return moved_corner(b, c, a); }
    }
}

// A vertex that draws nothing.
fn no_footprint() -> Footprint {
    return Footprint(vec4f(2.0, 2.0, 2.0, 1.0), vec3f(0.0), vec3f(0.0), vec3f(0.0), 0u);
}

// Vertex `vertex` of the footprint of a triangle in grid space.
fn footprint_vertex(g: Grid, a: vec3f, b: vec3f, c: vec3f, vertex: u32, slice: u32) -> Footprint {
    var corners = array<vec2f, 3>(a.xy, b.xy, c.xy);
    var place = corners[vertex % 3u];
    if conservative != CONSERVATIVE_NONE && conservative != CONSERVATIVE_HARDWARE {
        place = footprint_place(g, a.xy, b.xy, c.xy, vertex);
    }
    let p = 2.0 * place / vec2f(g.cells.xy) - 1.0;
    return Footprint(vec4f(p.x, -p.y, 0.5, 1.0), a, b, c, slice);
}

// Whether the shape holds the column's middle: what the fragment has to ask.
fn footprint_holds(g: Grid, t: TriangleBox, column: vec2i) -> bool {
    if conservative == CONSERVATIVE_NONE {
        return true;
    }
    let rows = rows_met(g, t);
    if column.y < rows.x || column.y > rows.y {
        return false;
    }
    if conservative == CONSERVATIVE_DILATED {
        let columns = cells_met(t.origin.x + t.lo.x, t.origin.x + t.hi.x, g.cells.x);
        let p = vec2f(column) + 0.5 - t.origin.xy;
        return column.x >= columns.x && column.x <= columns.y && within_side(p, t.v0.xy, t.v1.xy, t.v2.xy)
            && within_side(p, t.v1.xy, t.v2.xy, t.v0.xy) && within_side(p, t.v2.xy, t.v0.xy, t.v1.xy);
    }
    let columns = columns_met(g, t, column.y);
    return column.x >= columns.x && column.x <= columns.y;
}

// Whether `p` lies no farther than half a diagonal beyond the side from `a` to `b`, seen from the inner side, where
// `opposite` is; on either side if that is unsure.
fn within_side(p: vec2f, a: vec2f, b: vec2f, opposite: vec2f) -> bool {
    let side = outer_normal(a, b);
    let n = side / max(length(side), 1e-20);
    let height = dot(n, opposite - a);
    let beyond = dot(n, p - a) * select(1.0, -1.0, height > 0.0);
    return beyond <= HALF_DIAGONAL && (abs(height) >= FLATTEST || beyond >= -HALF_DIAGONAL);
}

// Least and greatest depth, grid-space z, at which the triangle reaches a column of its footprint: that of its plane on
// the middle line, or with `conservative_depth` over the whole column; within its own either way (TR §1.4.5.3).
fn depths_over(t: TriangleBox, column: vec2i) -> vec2f {
    let plane = dot(t.plane_slope, vec2f(column) + 0.5 - t.origin.xy);
    var ends = vec2f(t.plane_lo, t.plane_hi);
    if !conservative_depth {
        ends = vec2f(0.5 * (t.plane_lo + t.plane_hi));
    }
    return t.origin.z + clamp(plane + ends, vec2f(t.lo.z), vec2f(t.hi.z));
}

// First and last slice at which the triangle reaches a column of its footprint; none if x > y.
fn slices_over(g: Grid, t: TriangleBox, column: vec2i) -> vec2i {
    let depths = depths_over(t, column);
    let depth = f32(g.cells.z);
    if depths.x > depth || depths.y < 0.0 {
        return vec2i(0, -1);
    }
    let first = slice_of(g, max(depths.x, 0.0));
    if !conservative_depth {
        return vec2i(min(i32(first), i32(g.cells.z) - 1));
    }
    return cells_met(first, slice_of(g, min(depths.y, depth)), g.cells.z);
}

// How many cells of a column have their centre before a depth, grid-space z: the first whose centre lies beyond.
fn centers_before(g: Grid, z: f32) -> u32 {
    let depth = f32(g.cells.z);
    return u32(clamp(ceil(slice_of(g, clamp(z, 0.0, depth)) - 0.5), 0.0, depth));
}
