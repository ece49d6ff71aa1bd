#include "lib/column_raster.inc.wgsl"
#include "lib/dispatch.inc.wgsl"
#include "lib/mark_triangle.inc.wgsl"
// Small triangles at once, large ones deferred to fragments (RB §3.4, Fig. 15).
//
// `triage` runs a thread a triangle. A large triangle's number goes to `large` and adds a triangle's vertices to `draw`,
// the arguments of the indirect draw that follows. The list's order depends on the race of threads; the words don't. A
// triangle that finds the list full is marked at once, as if it were small: slower, the same words.

@group(0) @binding(0) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(1) var<uniform> grid_index: vec4u;
@group(0) @binding(2) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(3) var<storage, read> indices: array<u32>;
@group(0) @binding(4) var<storage, read> materials: array<PartMaterial>;
@group(0) @binding(6) var<uniform> options: Options;
@group(0) @binding(7) var<storage, read_write> large: array<u32>;
@group(0) @binding(8) var<storage, read_write> draw: Draw;
@group(0) @binding(9) var<storage, read> deferred: array<u32>;   // `large`, as the draw reads it

struct Options {
    cutoff_cells2: f32,     // triangles of more projected area than this are large
    capacity: u32,          // entries of `large`
}

// Arguments of an indirect draw, and how many triangles wanted to be in it.
struct Draw {
    vertex_count: atomic<u32>,
    instance_count: u32,
    first_vertex: u32,
    first_instance: u32,
    wanted: atomic<u32>,
}

const WORKGROUP: u32 = 64u;

fn triangle_of(g: Grid, number: u32) -> GridTriangle {
    return grid_triangle(
        g, vertices[indices[number * 3u]].position, vertices[indices[number * 3u + 1u]].position,
        vertices[indices[number * 3u + 2u]].position);
}

// Area of the triangle seen along z, cells².
fn projected_area(t: GridTriangle) -> f32 {
    if t.pieces == 0u {
        return 0.0;
    }
    let p = t.b.xy - t.a.xy;
    let q = t.c.xy - t.a.xy;
    let r = t.d.xy - t.a.xy;
    return 0.5 * (abs(p.x * q.y - p.y * q.x) + abs(q.x * r.y - q.y * r.x));
}

@compute @workgroup_size(WORKGROUP)
fn triage(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let number = thread_index(id, groups, WORKGROUP);
    if number >= arrayLength(&indices) / 3u {
        return;
    }
    let g = grids[grid_index.x];
    if number == 0u {
        draw.instance_count = select(2u, 1u, g.projection == ORTHOGRAPHIC);
    }
    if g.required_flags != 0u {
        let flags = materials[vertices[indices[number * 3u]].part].flags;
        if (flags & g.required_flags) != g.required_flags {
            return;
        }
    }
    let t = triangle_of(g, number);
    if projected_area(t) > options.cutoff_cells2 {
        let slot = atomicAdd(&draw.wanted, 1u);
        if slot < options.capacity {
            large[slot] = number;
            atomicAdd(&draw.vertex_count, OUTLINE_VERTICES);
            return;
        }
    }
    mark_triangle(g, t);
}

@vertex
fn outline(@builtin(vertex_index) vertex: u32, @builtin(instance_index) piece: u32) -> ColumnTriangle {
    let g = grids[grid_index.x];
    return outline_vertex(g, triangle_of(g, deferred[vertex / OUTLINE_VERTICES]), piece, vertex % OUTLINE_VERTICES);
}

@fragment
fn mark(in: ColumnTriangle) {
    mark_fragment(grids[grid_index.x], in);
}
