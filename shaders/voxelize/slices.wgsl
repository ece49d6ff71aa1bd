#include "lib/conservative.inc.wgsl"
#include "lib/occupancy.inc.wgsl"
#include "lib/one_grid.inc.wgsl"
// All triangles once a slice (Fang & Chen 2000). Instances are the pieces of a triangle cut at the eye, slice by slice.
//
// `mark` marks the slice. For the interior `toggle` toggles the first cell whose centre lies beyond a crossing, and
// `carry` hands on what the slice before holds: after it, a cell is inside if an odd number of surfaces lie before it.

@group(0) @binding(6) var<storage, read_write> interior: array<atomic<u32>>;

// By how many slices the planes stand nearer than the slice's own.
override nearer_slices: f32 = 0.0;

// Slices by which the vertex shader leaves a doubtful triangle to its fragments.
const PLANE_SLACK: f32 = 1.0 / 64.0;

const PIECES_ORTHOGRAPHIC: u32 = 1u;
const PIECES_PERSPECTIVE: u32 = 2u;

fn piece_count() -> u32 {
    return select(PIECES_ORTHOGRAPHIC, PIECES_PERSPECTIVE, perspective);
}

@vertex
fn slab_of(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Footprint {
    let g = grids[grid_index.x];
    let slice = instance / piece_count();
    let piece = instance % piece_count();
    let t = triangle_of(vertex / footprint_vertices());
    let b = select(t.c, t.b, piece == 0u);
    let c = select(t.d, t.c, piece == 0u);
    let lo = min(t.a.z, min(b.z, c.z));
    let hi = max(t.a.z, max(b.z, c.z));
    // The first slice takes what lies before the grid.
    let near = select(slab(g, f32(slice) - nearer_slices - PLANE_SLACK), lo, slice == 0u);
    let far = slab(g, f32(slice) + 1.0 - nearer_slices + PLANE_SLACK);
    if piece >= t.pieces || hi < near || lo > far {
        return no_footprint();
    }
    return footprint_vertex(g, t.a, b, c, vertex % footprint_vertices(), slice);
}

@fragment
fn mark(in: Footprint) {
    let g = grids[grid_index.x];
    let column = vec2i(in.position.xy);
    let t = triangle_box(in.a, in.b, in.c);
    let slices = slices_over(g, t, column);
    let slice = i32(in.slice);
    if footprint_holds(g, t, column) && slices.x <= slice && slice <= slices.y {
        mark_run(g, vec2u(column), slice, slice);
    }
}

@fragment
fn toggle(in: Footprint) {
    let g = grids[grid_index.x];
    let column = vec2i(in.position.xy);
    if centers_before(g, depths_over(triangle_box(in.a, in.b, in.c), column).x) == in.slice {
        atomicXor(&interior[word_index(g, vec3u(vec2u(column), in.slice))], word_bit(in.slice));
    }
}

struct Whole {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat, either) slice: u32,
}

// A triangle over the whole raster.
@vertex
fn whole(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Whole {
    let place = vec2f(vec2<bool>(vertex == 1u, vertex == 2u)) * 4.0 - 1.0;
    let drawn = instance % piece_count() == 0u;
    return Whole(vec4f(select(vec2f(2.0), place, drawn), 0.5, 1.0), instance / piece_count());
}

@fragment
fn carry(in: Whole) {
    let g = grids[grid_index.x];
    let column = vec2u(in.position.xy);
    let before = vec3u(column, in.slice - 1u);
    if (atomicLoad(&interior[word_index(g, before)]) & word_bit(before.z)) != 0u {
        atomicXor(&interior[word_index(g, vec3u(column, in.slice))], word_bit(in.slice));
    }
}
