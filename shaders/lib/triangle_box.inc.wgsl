#include "lib/grid_triangle.inc.wgsl"
// Triangle against box by separating axes, solved for the cells of a column instead of tested cell by cell.
//
// The thirteen axes (Akenine-Möller 2001) are the three of the box, the triangle's normal, and nine crossed from edges
// and box axes; the nine are edge functions in the projections XY, YZ and ZX (Schwarz & Seidel 2010; RB §3.1). Each axis
// bounds a·u + b·v + c·w from both sides, so for a given column it leaves an interval of the coordinate along it. The
// intervals' ends are linear in the column's place and are worked out once a triangle. A box overlaps when it meets
// every interval, so a column's cells are those between the greatest lower end and the least upper end. That holds for
// slices of any thickness.
//
// Both sides of every axis are tested, not the inner one alone: the same for a proper triangle and right for segments
// and points. Coordinates are cells, relative to `origin`, a whole cell near the triangle, which keeps f32 errors below
// a millionth of the grid's size.

// w lies in [slope·u + lo, slope·u + hi], one interval for each edge of the triangle.
struct EdgeBounds {
    slope: vec3f,
    lo: vec3f,
    hi: vec3f,
}

// Everything that doesn't depend on the cell.
struct TriangleBox {
    origin: vec3f,          // whole cells
    v0: vec3f,              // vertices, relative to origin
    v1: vec3f,
    v2: vec3f,
    lo: vec3f,              // the triangle's own box, relative to origin
    hi: vec3f,
    x_of_y: EdgeBounds,     // XY edges: x of a row of columns
    z_of_y: EdgeBounds,     // YZ edges
    z_of_x: EdgeBounds,     // ZX edges
    plane_slope: vec2f,     // z lies in plane_slope·(x, y) + [plane_lo, plane_hi]
    plane_lo: f32,
    plane_hi: f32,
    normal: vec3f,
}

// Thin, 6-separating: the cell's diamond counts where for 26-separating its whole box does.
override thin: bool = false;

const UNBOUNDED: f32 = 1e30;

// Below this ratio an axis says nothing of w that the other axes don't.
const FLAT_RATIO: f32 = 1e-7;

// The intervals of w that follow from a·u + b·w within those of the vertices, for cells half a unit wide in u.
fn edge_bounds(a: vec3f, b: vec3f, u: vec3f, w: vec3f) -> EdgeBounds {
    let at_edge = a * u + b * w;
    let at_opposite = a * u.zxy + b * w.zxy;
    let reach = 0.5 * abs(a);
    let inverse = 1.0 / b;
    let low = (min(at_edge, at_opposite) - reach) * inverse;
    let high = (max(at_edge, at_opposite) + reach) * inverse;
    let flat = abs(b) <= FLAT_RATIO * abs(a);
    return EdgeBounds(
        select(-a * inverse, vec3f(0.0), flat),
        select(min(low, high), vec3f(-UNBOUNDED), flat),
        select(max(low, high), vec3f(UNBOUNDED), flat));
}

fn lower_end(bounds: EdgeBounds, u: f32) -> f32 {
    let ends = bounds.slope * u + bounds.lo;
    return max(ends.x, max(ends.y, ends.z));
}

fn upper_end(bounds: EdgeBounds, u: f32) -> f32 {
    let ends = bounds.slope * u + bounds.hi;
    return min(ends.x, min(ends.y, ends.z));
}

// The upper half of a float's digits: products of such halves are exact.
fn leading_digits(v: vec3f) -> vec3f {
    return bitcast<vec3f>(bitcast<vec3u>(v) & vec3u(0xfffff000u));
}

// a × b to nearly a float's precision even when the two are almost parallel, as a needle's edges are.
fn precise_cross(a: vec3f, b: vec3f) -> vec3f {
    let a_hi = leading_digits(a);
    let b_hi = leading_digits(b);
    let a_lo = a - a_hi;
    let b_lo = b - b_hi;
    return (a_hi.yzx * b_hi.zxy - a_hi.zxy * b_hi.yzx)
        + ((a_hi.yzx * b_lo.zxy - a_hi.zxy * b_lo.yzx) + (a_lo.yzx * b.zxy - a_lo.zxy * b.yzx));
}

fn triangle_box(a: vec3f, b: vec3f, c: vec3f) -> TriangleBox {
    var t: TriangleBox;
    let least = min(a, min(b, c));
    t.origin = floor(least);
    t.v0 = a - t.origin;
    t.v1 = b - t.origin;
    t.v2 = c - t.origin;
    t.lo = least - t.origin;
    t.hi = max(t.v0, max(t.v1, t.v2));
    let e0 = t.v1 - t.v0;
    let e1 = t.v2 - t.v1;
    let e2 = t.v0 - t.v2;
    let ex = vec3f(e0.x, e1.x, e2.x);
    let ey = vec3f(e0.y, e1.y, e2.y);
    let ez = vec3f(e0.z, e1.z, e2.z);
    let x = vec3f(t.v0.x, t.v1.x, t.v2.x);
    let y = vec3f(t.v0.y, t.v1.y, t.v2.y);
    let z = vec3f(t.v0.z, t.v1.z, t.v2.z);
    t.x_of_y = edge_bounds(ex, -ey, y, x);
    t.z_of_y = edge_bounds(-ez, ey, y, z);
    t.z_of_x = edge_bounds(-ez, ex, x, z);

    t.normal = precise_cross(e0, e1);
    let n = t.normal;
    let reach = 0.5 * (abs(n.x) + abs(n.y));
    let inverse = 1.0 / n.z;
    let flat = abs(n.z) <= FLAT_RATIO * max(abs(n.x), abs(n.y));
    // The same at each corner, but for a needle's, whose normal is a matter of rounding.
    let at = vec3f(dot(n, t.v0), dot(n, t.v1), dot(n, t.v2));
    let low = (min(at.x, min(at.y, at.z)) - reach) * inverse;
    let high = (max(at.x, max(at.y, at.z)) + reach) * inverse;
    t.plane_slope = select(-n.xy * inverse, vec2f(0.0), flat);
    t.plane_lo = select(min(low, high), -UNBOUNDED, flat);
    t.plane_hi = select(max(low, high), UNBOUNDED, flat);
    return t;
}

// First and last cell that a closed interval meets; touching counts.
fn cells_met(lo: f32, hi: f32, count: u32) -> vec2i {
    let limit = f32(count);
    return vec2i(i32(clamp(ceil(lo) - 1.0, 0.0, limit)), i32(clamp(floor(hi), -1.0, limit - 1.0)));
}

// Rows y of the grid that the triangle's box meets.
fn rows_met(g: Grid, t: TriangleBox) -> vec2i {
    return cells_met(t.origin.y + t.lo.y, t.origin.y + t.hi.y, g.cells.y);
}

// Columns x of row y that the triangle's projection meets.
fn columns_met(g: Grid, t: TriangleBox, row: i32) -> vec2i {
    let y = f32(row) + 0.5 - t.origin.y;
    let lo = max(t.lo.x, lower_end(t.x_of_y, y));
    let hi = min(t.hi.x, upper_end(t.x_of_y, y));
    return cells_met(t.origin.x + lo, t.origin.x + hi, g.cells.x);
}

// Slices that a closed interval of grid-space z meets.
fn slices_between(g: Grid, lo: f32, hi: f32) -> vec2i {
    if !perspective {
        return cells_met(lo, hi, g.cells.z);
    }
    // Its z has an end not far beyond the grid, where `slice_of` turns round.
    let depth = f32(g.cells.z);
    if lo > depth || hi < 0.0 {
        return vec2i(0, -1);
    }
    return cells_met(slice_of(g, lo), slice_of(g, min(hi, depth)), g.cells.z);
}

// Cells z of a column that the triangle meets, given that its projection meets the column.
fn slices_met(g: Grid, t: TriangleBox, column: vec2i) -> vec2i {
    let p = vec2f(column) + 0.5 - t.origin.xy;
    let plane = dot(t.plane_slope, p);
    let lo = max(max(t.lo.z, plane + t.plane_lo), max(lower_end(t.z_of_y, p.y), lower_end(t.z_of_x, p.x)));
    let hi = min(min(t.hi.z, plane + t.plane_hi), min(upper_end(t.z_of_y, p.y), upper_end(t.z_of_x, p.x)));
    var run = slices_between(g, t.origin.z + lo, t.origin.z + hi);
    if thin {
        // Thin cells are a run within the others.
        while run.x <= run.y && !thin_meets(g, t, vec3i(column, run.x)) {
            run.x++;
        }
        while run.x < run.y && !thin_meets(g, t, vec3i(column, run.y)) {
            run.y--;
        }
    }
    return run;
}

// Rounding of a vertex, as a fraction of the grid.
const VERTEX_ROUNDING: f32 = 1e-7;

// The thin rule (Schwarz & Seidel 2010; RB Fig. 18) for a cell that the triangle meets: the plane meets the diamond
// inscribed in the cell, and in each projection the diamond inscribed in its square reaches the inner side of each edge.
fn thin_meets(g: Grid, t: TriangleBox, cell: vec3i) -> bool {
    let b = cell_box(g, cell);
    let c = b.center - t.origin;
    let n = abs(t.normal) * b.half;
    if abs(dot(t.normal, c - t.v0)) > max(n.x, max(n.y, n.z)) {
        return false;
    }
    let rounding = VERTEX_ROUNDING * f32(max(g.cells.x, max(g.cells.y, g.cells.z)));
    let v0 = t.v0 - c;
    let v1 = t.v1 - c;
    let v2 = t.v2 - c;
    let x = vec3f(v0.x, v1.x, v2.x);
    let y = vec3f(v0.y, v1.y, v2.y);
    let z = vec3f(v0.z, v1.z, v2.z);
    return inner_sides(x, y, b.half.xy, rounding) && inner_sides(y, z, b.half.yz, rounding)
        && inner_sides(x, z, b.half.xz, rounding);
}

// Whether the diamond about 0 inscribed in a rectangle reaches the inner side of all edges of a projected triangle. An
// edge whose inner side is a matter of rounding bounds both sides.
fn inner_sides(u: vec3f, v: vec3f, half: vec2f, rounding: f32) -> bool {
    let along_u = u.yzx - u;
    let along_v = v.yzx - v;
    let reach = max(abs(along_v) * half.x, abs(along_u) * half.y);
    let at_edge = along_u * v - along_v * u;
    let width = along_u * (v.zxy - v) - along_v * (u.zxy - u);
    let unsure = rounding * (abs(along_u) + abs(along_v) + abs(u.zxy - u) + abs(v.zxy - v));
    let above = reach >= at_edge + min(width, vec3f(0.0));
    let below = reach >= -at_edge - max(width, vec3f(0.0));
    return all((above | (width < -unsure)) & (below | (width > unsure)));
}
