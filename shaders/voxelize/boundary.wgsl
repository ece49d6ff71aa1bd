#include "lib/dispatch.inc.wgsl"
#include "lib/grid.inc.wgsl"
// The boundary of a solid: its cells that have one outside among their 26 neighbours. A thread a word; cells off the grid
// are outside.

@group(0) @binding(0) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(1) var<uniform> grid_index: vec4u;
@group(0) @binding(2) var<storage, read> interior: array<u32>;
@group(0) @binding(3) var<storage, read_write> occupancy: array<u32>;

const WORKGROUP: u32 = 64u;

fn word_at(g: Grid, column: vec2i, word: i32) -> u32 {
    if any(column < vec2i(0)) || any(column >= vec2i(g.cells.xy)) || word < 0 || word >= i32(g.words_per_column) {
        return 0u;
    }
    return interior[word_index(g, vec3u(vec2u(column), 32u * u32(word)))];
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let g = grids[grid_index.x];
    let number = thread_index(id, groups, WORKGROUP);
    if number >= g.cells.x * g.cells.y * g.words_per_column {
        return;
    }
    let solid = interior[g.word_base + number];
    if solid == 0u {
        return;
    }
    let word = i32(number % g.words_per_column);
    let column = number / g.words_per_column;
    let place = vec2i(i32(column % g.cells.x), i32(column / g.cells.x));
    // Cells with no neighbour outside.
    var deep = 0xffffffffu;
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let beside = place + vec2i(x, y);
            let here = word_at(g, beside, word);
            let nearer = (here << 1u) | (word_at(g, beside, word - 1) >> 31u);
            let farther = (here >> 1u) | (word_at(g, beside, word + 1) << 31u);
            deep &= here & nearer & farther;
        }
    }
    occupancy[g.word_base + number] = solid & ~deep;
}
