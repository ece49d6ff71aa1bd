#include "lib/dispatch.inc.wgsl"
#include "lib/geometry.inc.wgsl"
#include "lib/grid_triangle.inc.wgsl"
#include "lib/triangle_box.inc.wgsl"
#include "lib/volume.inc.wgsl"
// The voxel list as RB §3.5 makes it: while triangles mark, a lock a voxel lets one thread alone append the voxel to a
// list behind an atomic counter. The lock is the voxel's occupancy bit: `atomicOr` tells which bits were still clear.

@group(0) @binding(0) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(1) var<uniform> grid_index: vec4u;
@group(0) @binding(2) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(3) var<storage, read> indices: array<u32>;
@group(0) @binding(4) var<storage, read> materials: array<PartMaterial>;
@group(0) @binding(5) var<storage, read_write> occupancy: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> listed_cells: array<u32>;
@group(0) @binding(7) var<storage, read_write> listed_count: array<atomic<u32>>;

// Appends those of a word's bits that this thread is the first to set.
fn append(word: u32, mask: u32, corner: vec3u) {
    var bits = mask & ~atomicOr(&occupancy[word], mask);
    if bits == 0u {
        return;
    }
    var place = atomicAdd(&listed_count[0], countOneBits(bits));
    while bits != 0u {
        if place < arrayLength(&listed_cells) {
            listed_cells[place] = pack_cell(corner + vec3u(0u, 0u, countTrailingZeros(bits)));
        }
        bits &= bits - 1u;
        place++;
    }
}

fn append_box(g: Grid, t: TriangleBox) {
    let rows = rows_met(g, t);
    for (var y = rows.x; y <= rows.y; y++) {
        let columns = columns_met(g, t, y);
        for (var x = columns.x; x <= columns.y; x++) {
            let slices = slices_met(g, t, vec2i(x, y));
            for (var z = slices.x; z <= slices.y; z = (z | 31) + 1) {
                let last = min(slices.y, z | 31);
                let mask = (0xffffffffu << u32(z & 31)) & (0xffffffffu >> u32(31 - (last & 31)));
                let corner = vec3u(vec3i(x, y, z & ~31));
                append(word_index(g, corner), mask, corner);
            }
        }
    }
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let number = thread_index(id, workgroups, 64u);
    if 3u * number + 2u >= arrayLength(&indices) {
        return;
    }
    let g = grids[grid_index.x];
    let v0 = vertices[indices[3u * number]];
    if g.required_flags != 0u && (materials[v0.part].flags & g.required_flags) != g.required_flags {
        return;
    }
    let t = grid_triangle(
        g, v0.position, vertices[indices[3u * number + 1u]].position, vertices[indices[3u * number + 2u]].position);
    for (var piece = 0u; piece < t.pieces; piece++) {
        append_box(g, triangle_box(t.a, select(t.c, t.b, piece == 0u), select(t.d, t.c, piece == 0u)));
    }
}
