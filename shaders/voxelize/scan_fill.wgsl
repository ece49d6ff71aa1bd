#include "lib/dispatch.inc.wgsl"
#include "lib/grid.inc.wgsl"
#include "lib/prefix_xor.inc.wgsl"
// The interior by scan filling along three axes (DO §3.3): along a line a flag turns whenever a run of surface voxels is
// passed, and what lies between is inside; a voxel is inside that is so along all three axes. A line that grazes the
// surface turns its flag for nothing and is wrong as far as the next run ("singular points"); the other two axes rarely
// are wrong there too. The surface belongs to the solid.

@group(0) @binding(0) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(1) var<uniform> grid_index: vec4u;
@group(0) @binding(2) var<storage, read> occupancy: array<u32>;
@group(0) @binding(3) var<storage, read_write> interior: array<u32>;

const WORKGROUP: u32 = 64u;

// A thread a column.
@compute @workgroup_size(WORKGROUP)
fn along_z(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let number = thread_index(id, groups, WORKGROUP);
    let per_column = grids[grid_index.x].words_per_column;
    if number >= grids[grid_index.x].cells.x * grids[grid_index.x].cells.y {
        return;
    }
    let first = grids[grid_index.x].word_base + number * per_column;
    var before = 0u;
    var flag = 0u;
    for (var w = 0u; w < per_column; w++) {
        let surface = occupancy[first + w];
        let inside = prefix_xor((surface << 1u | before) & ~surface) ^ flag;
        flag = select(0u, 0xffffffffu, (inside & 0x80000000u) != 0u);
        before = surface >> 31u;
        let valid = min(grids[grid_index.x].cells.z - 32u * w, 32u);
        interior[first + w] = inside & ~surface & (0xffffffffu >> (32u - valid));
    }
}

// 32 lines at once, one word after the other: what is inside along them, of what was inside before, and the surface.
fn scan(first: u32, stride: u32, count: u32, surface_mask: u32) {
    var before = 0u;
    var flags = 0u;
    for (var i = 0u; i < count; i++) {
        let word = first + i * stride;
        let surface = occupancy[word];
        flags ^= before & ~surface;
        before = surface;
        interior[word] = (interior[word] & flags & ~surface) | (surface & surface_mask);
    }
}

// A thread a row's 32 slices.
@compute @workgroup_size(WORKGROUP)
fn along_x(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let number = thread_index(id, groups, WORKGROUP);
    let cells = grids[grid_index.x].cells;
    let per_column = grids[grid_index.x].words_per_column;
    if number >= cells.y * per_column {
        return;
    }
    let row = number / per_column * cells.x * per_column;
    scan(grids[grid_index.x].word_base + row + number % per_column, per_column, cells.x, 0u);
}

// The same across the rows, and last: the surface is put in.
@compute @workgroup_size(WORKGROUP)
fn along_y(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let number = thread_index(id, groups, WORKGROUP);
    let cells = grids[grid_index.x].cells;
    let per_column = grids[grid_index.x].words_per_column;
    if number >= cells.x * per_column {
        return;
    }
    scan(grids[grid_index.x].word_base + number, cells.x * per_column, cells.y, 0xffffffffu);
}
