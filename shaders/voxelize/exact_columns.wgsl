#include "lib/column_raster.inc.wgsl"
// A fragment for each column of a triangle's bounding rectangle; it tests every cell of the triangle's depth range by
// separating axes (TR ch. 2). Instances are the pieces of a triangle cut at the eye.

@group(0) @binding(0) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(1) var<uniform> grid_index: vec4u;
@group(0) @binding(2) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(3) var<storage, read> indices: array<u32>;
@group(0) @binding(4) var<storage, read> materials: array<PartMaterial>;

// TR ch. 5: two loops, from the middle of the depth range towards its ends.
override two_ended: bool = false;

// Vertices of a rectangle as drawn: two triangles.
const RECTANGLE_VERTICES: u32 = 6u;

// A bit a vertex: which lie at the higher end.
const HIGH_X: u32 = 0x32u;
const HIGH_Y: u32 = 0x2cu;

// TR grows by half a pixel; rasterizers move vertices by up to 1/256 pixel more.
const GROWTH: f32 = 0.5 + OUTLINE_SLACK;

@vertex
fn rectangle(@builtin(vertex_index) vertex: u32, @builtin(instance_index) piece: u32) -> ColumnTriangle {
    let g = grids[grid_index.x];
    let number = vertex / RECTANGLE_VERTICES;
    let v0 = vertices[indices[number * 3u]];
    let t = grid_triangle(
        g, v0.position, vertices[indices[number * 3u + 1u]].position, vertices[indices[number * 3u + 2u]].position);
    if piece >= t.pieces
        || (g.required_flags != 0u && (materials[v0.part].flags & g.required_flags) != g.required_flags) {
        return NOT_DRAWN;
    }
    let b = select(t.c, t.b, piece == 0u);
    let c = select(t.d, t.c, piece == 0u);
    let cells = vec2f(g.cells.xy);
    let lo = clamp(min(t.a.xy, min(b.xy, c.xy)) - GROWTH, vec2f(-1.0), cells + 1.0);
    let hi = clamp(max(t.a.xy, max(b.xy, c.xy)) + GROWTH, vec2f(-1.0), cells + 1.0);
    let corner = vertex % RECTANGLE_VERTICES;
    let is_high = vec2<bool>((HIGH_X >> corner & 1u) != 0u, (HIGH_Y >> corner & 1u) != 0u);
    let p = select(lo, hi, is_high) / cells;
    return ColumnTriangle(vec4f(2.0 * p.x - 1.0, 1.0 - 2.0 * p.y, 0.5, 1.0), t.a, b, c);
}

// Whether one of the axes that an edge makes with the box's own parts the triangle from a box about the origin. A cross
// product with the edge holds a point's places along all three; of the triangle's corners two places differ.
fn is_parted(edge: vec3f, at_edge: vec3f, opposite: vec3f, half: vec3f) -> bool {
    let p = cross(edge, at_edge);
    let q = cross(edge, opposite);
    let reach = abs(edge).yzx * half.zxy + abs(edge).zxy * half.yzx;
    return any(min(p, q) > reach) || any(max(p, q) < -reach);
}

// Triangle against cell by the thirteen axes (TR §1.4.1); touching counts. The column's own axis first, at which most
// cells fail (TR §2.3).
fn is_met(g: Grid, t: TriangleBox, cell: vec3i) -> bool {
    let b = cell_box(g, cell);
    let center = b.center - t.origin;
    let lo = t.lo - center;
    let hi = t.hi - center;
    if lo.z > b.half.z || hi.z < -b.half.z || any(lo.xy > b.half.xy) || any(hi.xy < -b.half.xy) {
        return false;
    }
    let v0 = t.v0 - center;
    let v1 = t.v1 - center;
    let v2 = t.v2 - center;
    // The same at each corner, but for a needle's, whose normal is a matter of rounding.
    let on_normal = vec3f(dot(t.normal, v0), dot(t.normal, v1), dot(t.normal, v2));
    let reach = dot(abs(t.normal), b.half);
    if all(on_normal > vec3f(reach)) || all(on_normal < vec3f(-reach)) || is_parted(v1 - v0, v0, v2, b.half)
        || is_parted(v2 - v1, v1, v0, b.half) || is_parted(v0 - v2, v2, v1, b.half) {
        return false;
    }
    return !thin || thin_meets(g, t, cell);
}

// The cells of a column that the triangle meets, of those from `range.x` to `range.y`. Box and triangle are convex, so
// they are a run.
fn run_met(g: Grid, t: TriangleBox, column: vec2i, range: vec2i) -> vec2i {
    var run = vec2i(range.y + 1, range.x - 1);
    for (var z = range.x; z <= range.y; z++) {
        if is_met(g, t, vec3i(column, z)) {
            run = vec2i(min(run.x, z), z);
        }
    }
    return run;
}

// The same from the middle outwards. A loop that has left the run is over; one that has not come to it is over once the
// other has, as the run would have to hold the middle to reach both.
fn run_met_two_ended(g: Grid, t: TriangleBox, column: vec2i, range: vec2i) -> vec2i {
    var run = vec2i(range.y + 1, range.x - 1);
    var down = (range.x + range.y) >> 1u;
    var up = down + 1;
    var down_met = false;
    var up_met = false;
    while down >= range.x || up <= range.y {
        let meets_down = down >= range.x && is_met(g, t, vec3i(column, down));
        let meets_up = up <= range.y && is_met(g, t, vec3i(column, up));
        run.x = select(run.x, min(run.x, select(up, down, meets_down)), meets_down || meets_up);
        run.y = select(run.y, max(run.y, select(down, up, meets_up)), meets_down || meets_up);
        down_met |= meets_down;
        up_met |= meets_up;
        let down_ends = (down_met || up_met) && !meets_down;
        let up_ends = (down_met || up_met) && !meets_up;
        down = select(down - 1, range.x - 1, down_ends);
        up = select(up + 1, range.y + 1, up_ends);
    }
    return run;
}

@fragment
fn mark(in: ColumnTriangle) {
    let g = grids[grid_index.x];
    let column = vec2i(in.position.xy);
    let t = triangle_box(in.a, in.b, in.c);
    let range = slices_between(g, t.origin.z + t.lo.z, t.origin.z + t.hi.z);
    var run = vec2i(0, -1);
    if two_ended {
        run = run_met_two_ended(g, t, column, range);
    } else {
        run = run_met(g, t, column, range);
    }
    mark_run(g, vec2u(column), run.x, run.y);
}
