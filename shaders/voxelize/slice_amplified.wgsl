#include "lib/conservative.inc.wgsl"
#include "lib/dispatch.inc.wgsl"
#include "lib/geometry.inc.wgsl"
#include "lib/grid_triangle.inc.wgsl"
#include "lib/occupancy.inc.wgsl"
// Every triangle once for each slice that it may meet, clipped to the slice (CL §2.2, Fig. 2).
//
// `amplify` runs a thread a triangle and lists a (triangle, slice) for each copy; one indirect draw rasterizes them all,
// near and far plane set to the slice. A triangle that finds the list full goes to `rest`, where it stands for a copy in
// every slice of the grid; those it doesn't meet clip away. So a full list costs time, not voxels.

@group(0) @binding(0) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(1) var<uniform> grid_index: vec4u;
@group(0) @binding(2) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(3) var<storage, read> indices: array<u32>;
@group(0) @binding(4) var<storage, read> materials: array<PartMaterial>;
@group(0) @binding(6) var<uniform> options: Options;
@group(0) @binding(7) var<storage, read_write> copies: array<vec2u>;    // triangle, slice
@group(0) @binding(8) var<storage, read_write> rest: array<u32>;        // triangles
@group(0) @binding(9) var<storage, read_write> draw: Draw;
@group(0) @binding(10) var<storage, read> drawn_copies: array<vec2u>;   // as the draw reads them
@group(0) @binding(11) var<storage, read> drawn_rest: array<u32>;
@group(0) @binding(12) var<uniform> drawn: vec4u;                       // x: `draw.listed`

struct Options {
    overlap: f32,       // of a slice, at either end
    capacity: u32,      // entries of `copies`
}

// Arguments of an indirect draw, and where the next copy and triangle go.
struct Draw {
    vertex_count: atomic<u32>,
    instance_count: u32,
    first_vertex: u32,
    first_instance: u32,
    listed: atomic<u32>,
    resting: atomic<u32>,
}

const WORKGROUP: u32 = 64u;
const NONE: u32 = 0xffffffffu;

// Slices that reach into grid-space z from lo to hi; none if x > y.
fn slices_reached(g: Grid, lo: f32, hi: f32) -> vec2i {
    let depth = f32(g.cells.z);
    if lo > depth || hi < 0.0 {
        return vec2i(0, -1);
    }
    let first = ceil(slice_of(g, max(lo, 0.0)) - 1.0 - options.overlap);
    let last = floor(slice_of(g, min(hi, depth)) + options.overlap);
    return vec2i(i32(max(first, 0.0)), i32(min(last, depth - 1.0)));
}

@compute @workgroup_size(WORKGROUP)
fn amplify(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let number = thread_index(id, groups, WORKGROUP);
    if number >= arrayLength(&indices) / 3u {
        return;
    }
    let g = grids[grid_index.x];
    if number == 0u {
        draw.instance_count = select(1u, 2u, perspective);
    }
    let v0 = vertices[indices[number * 3u]];
    if g.required_flags != 0u && (materials[v0.part].flags & g.required_flags) != g.required_flags {
        return;
    }
    let t = grid_triangle(
        g, v0.position, vertices[indices[number * 3u + 1u]].position, vertices[indices[number * 3u + 2u]].position);
    let slices = slices_reached(g, min(min(t.a.z, t.b.z), min(t.c.z, t.d.z)), max(max(t.a.z, t.b.z), max(t.c.z, t.d.z)));
    if t.pieces == 0u || slices.x > slices.y {
        return;
    }
    let count = u32(slices.y - slices.x) + 1u;
    // A full list is not counted on, so that the counter can't run over.
    var first = options.capacity;
    if atomicLoad(&draw.listed) < options.capacity {
        first = atomicAdd(&draw.listed, count);
    }
    let fits = first < options.capacity && count <= options.capacity - first;
    for (var i = 0u; i < count && first + i < options.capacity; i++) {
        copies[first + i] = vec2u(select(NONE, number, fits), u32(slices.x) + i);
    }
    if first < options.capacity {
        atomicAdd(&draw.vertex_count, footprint_vertices() * min(count, options.capacity - first));
    }
    if !fits {
        rest[atomicAdd(&draw.resting, 1u)] = number;
        atomicAdd(&draw.vertex_count, footprint_vertices() * g.cells.z);
    }
}

// Grid-space depths of a slice's ends, moved apart by the overlap.
fn planes_of(g: Grid, slice: u32) -> vec2f {
    return vec2f(slab(g, f32(slice) - options.overlap), slab(g, f32(slice) + 1.0 + options.overlap));
}

@vertex
fn slice(@builtin(vertex_index) vertex: u32, @builtin(instance_index) piece: u32) -> Footprint {
    let g = grids[grid_index.x];
    let entry = vertex / footprint_vertices();
    let listed = min(drawn.x, options.capacity);
    var copy = vec2u(NONE, 0u);
    if entry < listed {
        copy = drawn_copies[entry];
    } else {
        copy = vec2u(drawn_rest[(entry - listed) / g.cells.z], (entry - listed) % g.cells.z);
    }
    let number = min(copy.x, arrayLength(&indices) / 3u - 1u);
    let t = grid_triangle(
        g, vertices[indices[number * 3u]].position, vertices[indices[number * 3u + 1u]].position,
        vertices[indices[number * 3u + 2u]].position);
    if copy.x == NONE || piece >= t.pieces {
        return no_footprint();
    }
    let b = select(t.c, t.b, piece == 0u);
    let c = select(t.d, t.c, piece == 0u);
    var drawn = footprint_vertex(g, t.a, b, c, vertex % footprint_vertices(), copy.y);
    if !cut_by_fragment() {
        var depths = array<f32, 3>(t.a.z, b.z, c.z);
        let planes = planes_of(g, copy.y);
        drawn.position.z = (depths[vertex % 3u] - planes.x) / (planes.y - planes.x);
    }
    return drawn;
}

// Whether the fragment cuts the triangle at its slice, not the rasterizer's clipper.
fn cut_by_fragment() -> bool {
    return conservative != CONSERVATIVE_NONE || conservative_depth;
}

@fragment
fn mark(in: Footprint) {
    let g = grids[grid_index.x];
    let column = vec2i(in.position.xy);
    if cut_by_fragment() {
        let t = triangle_box(in.a, in.b, in.c);
        let depths = depths_over(t, column);
        let planes = planes_of(g, in.slice);
        if !footprint_holds(g, t, column) || depths.y < planes.x || depths.x > planes.y {
            return;
        }
    }
    mark_run(g, vec2u(column), i32(in.slice), i32(in.slice));
}
