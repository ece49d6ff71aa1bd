#include "lib/column_raster.inc.wgsl"
#include "lib/dispatch.inc.wgsl"
#include "lib/mark_triangle.inc.wgsl"
#include "lib/one_grid.inc.wgsl"
// Small triangles by threads, large ones deferred to fragments (RB §3.4, Figs. 12 and 15).
//
// On the fly `triage` runs a thread a triangle and marks it at once if it is small. Classifying first, `classify` lists
// both kinds and `mark_small` takes the one list. Either way a large triangle's number goes to `large` and adds its
// vertices to `draw`, the arguments of the indirect draw that follows. The lists' order depends on the race of threads; the
// words don't.

@group(0) @binding(6) var<uniform> options: Options;
@group(0) @binding(7) var<storage, read_write> large: array<u32>;
@group(0) @binding(8) var<storage, read_write> draw: Draw;
@group(0) @binding(9) var<storage, read> deferred: array<u32>;              // `large`, as the draw reads it
@group(0) @binding(10) var<storage, read_write> small: array<u32>;
@group(0) @binding(11) var<storage, read_write> small_dispatch: Dispatch;
@group(0) @binding(12) var<storage, read> listed: array<u32>;               // `small`, as `mark_small` reads it
@group(0) @binding(13) var<uniform> listed_count: vec4u;                    // x
@group(0) @binding(14) var<storage, read_write> classes: array<atomic<u32>>; // a bit a triangle: large
@group(0) @binding(15) var<storage, read_write> sizes: array<atomic<u32>>;  // triangles of each octave of area

struct Options {
    cutoff: f32,    // triangles of a larger size are large; in the unit of `size_measure`
}

// Arguments of an indirect draw.
struct Draw {
    vertex_count: atomic<u32>,
    instance_count: u32,
    first_vertex: u32,
    first_instance: u32,
}

// Arguments of an indirect dispatch, and how many triangles it is for.
struct Dispatch {
    groups: atomic<u32>,
    rows: u32,
    one: u32,
    count: atomic<u32>,
}

const WORKGROUP: u32 = 64u;

// What a triangle's size is (RB §3.4.1); seen along z.
const AREA: u32 = 0u;           // of the projected triangle, cells²
const DILATED_AREA: u32 = 1u;   // of T′, what is rasterized in its stead, cells²
const EXTENT_2D: u32 = 2u;      // columns of its box
const EXTENT_3D: u32 = 3u;      // cells of its box
const AREA_RATIO: u32 = 4u;     // area(T) / area(T′), 0 to 1

override size_measure: u32 = AREA;

// By how far T′ reaches beyond T: half of a pixel's diagonal (RB §3.3.2).
const DILATION: f32 = 0.70710678;

fn area_of(a: vec2f, b: vec2f, c: vec2f) -> f32 {
    let p = b - a;
    let q = c - a;
    return 0.5 * abs(p.x * q.y - p.y * q.x);
}

// T with its sides moved out is T enlarged by 1 + l·P / 2A; of a needle, its box.
fn dilated_area(area: f32, a: vec2f, b: vec2f, c: vec2f) -> f32 {
    let perimeter = length(b - a) + length(c - b) + length(a - c);
    let box = max(a, max(b, c)) - min(a, min(b, c)) + 2.0 * DILATION;
    let enlarged = area + 0.5 * DILATION * perimeter;
    return min(enlarged * enlarged / max(area, 1e-20), box.x * box.y);
}

fn cells_spanned(lo: f32, hi: f32) -> f32 {
    return floor(hi) - floor(lo) + 1.0;
}

fn size_of(t: GridTriangle) -> f32 {
    if t.pieces == 0u {
        return 0.0;
    }
    // d is c, unless the triangle is cut.
    let area = area_of(t.a.xy, t.b.xy, t.c.xy) + area_of(t.a.xy, t.c.xy, t.d.xy);
    let lo = min(min(t.a, t.b), min(t.c, t.d));
    let hi = max(max(t.a, t.b), max(t.c, t.d));
    switch size_measure {
        case DILATED_AREA: { return dilated_area(area, t.a.xy, t.b.xy, t.c.xy); }
        case EXTENT_2D: { return cells_spanned(lo.x, hi.x) * cells_spanned(lo.y, hi.y); }
        case EXTENT_3D: { return cells_spanned(lo.x, hi.x) * cells_spanned(lo.y, hi.y) * cells_spanned(lo.z, hi.z); }
        case AREA_RATIO: { return area / max(dilated_area(area, t.a.xy, t.b.xy, t.c.xy), 1e-20); }
        default: { return area; }
    }
}

fn begin_draw(number: u32) {
    if number == 0u {
        draw.instance_count = select(1u, 2u, perspective);
    }
}

fn defer(number: u32) {
    large[atomicAdd(&draw.vertex_count, OUTLINE_VERTICES) / OUTLINE_VERTICES] = number;
}

@compute @workgroup_size(WORKGROUP)
fn triage(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let number = thread_index(id, groups, WORKGROUP);
    if number >= arrayLength(&indices) / 3u {
        return;
    }
    begin_draw(number);
    let t = triangle_of(number);
    if size_of(t) > options.cutoff {
        defer(number);
    } else {
        mark_triangle(grids[grid_index.x], t);
    }
}

@compute @workgroup_size(WORKGROUP)
fn classify(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let number = thread_index(id, groups, WORKGROUP);
    if number >= arrayLength(&indices) / 3u {
        return;
    }
    begin_draw(number);
    let t = triangle_of(number);
    if size_of(t) > options.cutoff {
        defer(number);
    } else if t.pieces > 0u {
        let slot = atomicAdd(&small_dispatch.count, 1u);
        small[slot] = number;
        // As many workgroups as the list has; beyond a row's end, as many rows.
        atomicMax(&small_dispatch.groups, min(slot / WORKGROUP + 1u, MOST_GROUPS));
    }
    if number == 0u {
        small_dispatch.rows = (arrayLength(&indices) / 3u + WORKGROUP * MOST_GROUPS - 1u) / (WORKGROUP * MOST_GROUPS);
        small_dispatch.one = 1u;
    }
}

// Workgroups in a row of a dispatch.
const MOST_GROUPS: u32 = 65535u;

// A thread a listed triangle.
@compute @workgroup_size(WORKGROUP)
fn mark_small(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let entry = thread_index(id, groups, WORKGROUP);
    if entry < listed_count.x {
        mark_triangle(grids[grid_index.x], triangle_of(listed[entry]));
    }
}

@vertex
fn outline(@builtin(vertex_index) vertex: u32, @builtin(instance_index) piece: u32) -> ColumnTriangle {
    let t = triangle_of(deferred[vertex / OUTLINE_VERTICES]);
    return outline_vertex(grids[grid_index.x], t, piece, vertex % OUTLINE_VERTICES);
}

@fragment
fn mark(in: ColumnTriangle) {
    mark_fragment(grids[grid_index.x], in);
}

// Which triangles go which way, to be looked at.
@compute @workgroup_size(WORKGROUP)
fn show_classes(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let number = thread_index(id, groups, WORKGROUP);
    if number < arrayLength(&indices) / 3u && size_of(triangle_of(number)) > options.cutoff {
        atomicOr(&classes[number >> 5u], 1u << (number & 31u));
    }
}

// How many triangles there are of each octave of area, from 2^LEAST_OCTAVE cells² on, smaller ones in the first.
const LEAST_OCTAVE: i32 = -2;
const OCTAVES: i32 = 24;

var<workgroup> group_sizes: array<atomic<u32>, OCTAVES>;

@compute @workgroup_size(WORKGROUP)
fn survey(
    @builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    let number = thread_index(id, groups, WORKGROUP);
    if number < arrayLength(&indices) / 3u {
        let t = triangle_of(number);
        if t.pieces > 0u {
            let area = area_of(t.a.xy, t.b.xy, t.c.xy) + area_of(t.a.xy, t.c.xy, t.d.xy);
            let octave = i32(clamp(floor(log2(max(area, 1e-20))), f32(LEAST_OCTAVE), f32(LEAST_OCTAVE + OCTAVES - 1)));
            atomicAdd(&group_sizes[octave - LEAST_OCTAVE], 1u);
        }
    }
    workgroupBarrier();
    if thread < u32(OCTAVES) {
        let count = atomicLoad(&group_sizes[thread]);
        if count > 0u {
            atomicAdd(&sizes[thread], count);
        }
    }
}
