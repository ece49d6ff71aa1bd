#include "lib/grid.inc.wgsl"
// Marking: sets bits of `occupancy`. Bits of one word go in one atomic; the order of threads can't be seen.
//
// Bind as: var<storage, read_write> occupancy: array<atomic<u32>>; only shaders that mark include this file.

@group(0) @binding(5) var<storage, read_write> occupancy: array<atomic<u32>>;

// Marks cells z_first … z_last (both within the grid, or none if z_last < z_first) of one column.
fn mark_run(g: Grid, column: vec2u, z_first: i32, z_last: i32) {
    if z_last < z_first {
        return;
    }
    let base = word_index(g, vec3u(column, 0u));
    let first = u32(z_first) >> 5u;
    let last = u32(z_last) >> 5u;
    var mask = 0xffffffffu << (u32(z_first) & 31u);
    for (var word = first; word < last; word++) {
        atomicOr(&occupancy[base + word], mask);
        mask = 0xffffffffu;
    }
    atomicOr(&occupancy[base + last], mask & (0xffffffffu >> (31u - (u32(z_last) & 31u))));
}
