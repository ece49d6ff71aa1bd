#include "lib/dispatch.inc.wgsl"
#include "lib/geometry.inc.wgsl"
#include "lib/volume.inc.wgsl"
#include "lib/closest.inc.wgsl"
#include "lib/claim.inc.wgsl"
// Triangles compete for the marked voxels that they come near: the one whose closest point is nearest to a voxel's
// centre wins its slot. Each walks the columns of its box, and in each the marked voxels between its plane's ends.
//
// A key is nearness (8 bits, never 0) + triangle number (24 bits), so one atomicMax decides, in any order. A triangle
// over many columns is put in a queue and walked by many threads; if the queue is full its thread walks it alone.

@group(0) @binding(0) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(1) var<uniform> grid_index: vec4u;
@group(0) @binding(2) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(3) var<storage, read> indices: array<u32>;
@group(0) @binding(4) var<storage, read> materials: array<PartMaterial>;
@group(0) @binding(5) var<storage, read> occupancy: array<u32>;
@group(0) @binding(6) var<storage, read> ranks: array<u32>;
@group(0) @binding(7) var<storage, read_write> keys: array<atomic<u32>>;
// Workgroups in x, y, z, for the indirect dispatch, and the queue's length, which may pass its capacity.
@group(0) @binding(8) var<storage, read_write> large_dispatch: array<atomic<u32>, 4>;
// Triangle in bits 0–23, share above.
@group(0) @binding(9) var<storage, read_write> large_shares: array<u32>;

// Columns of a box above which a triangle is large.
const LARGE_COLUMNS: u32 = 64u;
// Columns that a workgroup takes of a large triangle, while shares have numbers.
const SHARE_COLUMNS: u32 = 1024u;
const MAX_SHARES: u32 = 256u;

struct Walk {
    triangle: u32,
    slot: u32,
    lo: vec3i,          // box, cells, both ends included
    hi: vec3i,
    frame: ClosestFrame,
}

// The triangle's box in the grid; empty (lo.x > hi.x) for those that have no part in it.
fn walk_of(triangle: u32) -> Walk {
    let corners = 3u * triangle;
    let v0 = indices[corners];
    let flags = materials[vertices[v0].part].flags;
    let required = grids[grid_index.x].required_flags;
    let a = grid_from_world(grids[grid_index.x], vertices[v0].position);
    let b = grid_from_world(grids[grid_index.x], vertices[indices[corners + 1u]].position);
    let c = grid_from_world(grids[grid_index.x], vertices[indices[corners + 2u]].position);
    let low = min(min(a, b), c);
    let high = max(max(a, b), c);
    let cells = vec3i(grids[grid_index.x].cells);
    var walk: Walk;
    walk.triangle = triangle;
    walk.frame = closest_frame(a, b, c);
    walk.slot = slot_of(walk.frame.normal);
    let ends = clamp(vec2f(low.z, high.z), vec2f(0.0), vec2f(f32(cells.z)));
    let z = vec2f(slice_of(grids[grid_index.x], ends.x), slice_of(grids[grid_index.x], ends.y));
    walk.lo = vec3i(clamp(floor(vec3f(low.xy, z.x) - CLAIM_GROWTH), vec3f(0.0), vec3f(cells)));
    walk.hi = vec3i(clamp(floor(vec3f(high.xy, z.y) + CLAIM_GROWTH), vec3f(-1.0), vec3f(cells - 1)));
    if (flags & required) != required || walk.frame.inverse_square.w == 0.0 || any(walk.lo > walk.hi) {
        walk.hi.x = -1;
        walk.lo.x = 0;
    }
    return walk;
}

// The ends, in slices, of the plane's way through a column.
fn depth_range(walk: Walk, column: vec2i) -> vec2i {
    let n = walk.frame.normal;
    let steep = select(n.z, select(-1e-12, 1e-12, n.z >= 0.0), abs(n.z) < 1e-12);
    let middle = vec2f(column) + 0.5 - walk.frame.a.xy;
    let center = walk.frame.a.z - dot(n.xy, middle) / steep;
    let reach = (abs(n.x) + abs(n.y)) * (0.5 + CLAIM_GROWTH) / abs(steep);
    let ends = clamp(vec2f(center - reach, center + reach), vec2f(0.0), vec2f(f32(grids[grid_index.x].cells.z)));
    let lo = slice_of(grids[grid_index.x], ends.x);
    let hi = slice_of(grids[grid_index.x], ends.y);
    return vec2i(vec2f(
        max(floor(lo - CLAIM_GROWTH), f32(walk.lo.z)),
        min(floor(hi + CLAIM_GROWTH), f32(walk.hi.z)),
    ));
}

fn compete(walk: Walk, cell: vec3i, rank: u32) {
    let g = grid_index.x;
    let claim = claim_of(grids[g], walk.frame, cell);
    if claim.nearness != 0u && rank < grids[g].record_capacity {
        atomicMax(&keys[6u * rank + walk.slot], (claim.nearness << 24u) | walk.triangle);
    }
}

// Walks the columns `first`, `first + stride`, … of the box.
fn walk_columns(walk: Walk, first: u32, stride: u32) {
    let size = vec2u(walk.hi.xy - walk.lo.xy + 1);
    let columns = size.x * size.y;
    let per_column = grids[grid_index.x].words_per_column;
    var next_column = first;
    var column = vec2i(0);
    var column_word = 0u;       // of the column's first word
    var word = 1u;              // within the column
    var last_word = 0u;
    var ends = vec2i(0);
    var bits = 0u;
    var rank = 0u;
    loop {
        // Step to the next marked voxel …
        loop {
            if bits != 0u {
                break;
            }
            if word >= last_word {
                if next_column >= columns {
                    break;
                }
                column = walk.lo.xy + vec2i(vec2u(next_column % size.x, next_column / size.x));
                next_column += stride;
                ends = depth_range(walk, column);
                column_word = grids[grid_index.x].word_base
                    + (u32(column.y) * grids[grid_index.x].cells.x + u32(column.x)) * per_column;
                if ends.x > ends.y {
                    word = 1u;
                    last_word = 0u;
                    continue;
                }
                word = u32(ends.x) >> 5u;
                last_word = u32(ends.y) >> 5u;
            } else {
                word++;
            }
            let whole = occupancy[column_word + word];
            let first_slice = i32(word * 32u);
            let from_slice = u32(max(ends.x - first_slice, 0));
            let to_slice = u32(min(ends.y - first_slice, 31));
            bits = whole & (0xffffffffu << from_slice) & (0xffffffffu >> (31u - to_slice));
            rank = ranks[column_word + word] + countOneBits(whole & ~(0xffffffffu << from_slice));
        }
        if bits == 0u {
            break;
        }
        // … then compete for it.
        compete(walk, vec3i(column, i32(word * 32u + countTrailingZeros(bits))), rank);
        bits &= bits - 1u;
        rank++;
    }
}

fn column_count(walk: Walk) -> u32 {
    let size = vec2u(walk.hi.xy - walk.lo.xy + 1);
    return size.x * size.y;
}

fn share_count(walk: Walk) -> u32 {
    return min((column_count(walk) + SHARE_COLUMNS - 1u) / SHARE_COLUMNS, MAX_SHARES);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let triangle = thread_index(id, workgroups, 64u);
    if 3u * triangle + 2u >= arrayLength(&indices) {
        return;
    }
    let walk = walk_of(triangle);
    if walk.hi.x < walk.lo.x {
        return;
    }
    if column_count(walk) > LARGE_COLUMNS {
        let shares = share_count(walk);
        let place = atomicAdd(&large_dispatch[3], shares);
        if place + shares <= arrayLength(&large_shares) {
            for (var share = 0u; share < shares; share++) {
                large_shares[place + share] = triangle | (share << 24u);
            }
            atomicMax(&large_dispatch[0], place + shares);
            return;
        }
    }
    walk_columns(walk, 0u, 1u);
}

// A workgroup a share of a large triangle.
@compute @workgroup_size(64)
fn large(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) thread: u32) {
    let share = large_shares[workgroup.x];
    let walk = walk_of(share & 0xffffffu);
    walk_columns(walk, (share >> 24u) * 64u + thread, share_count(walk) * 64u);
}
