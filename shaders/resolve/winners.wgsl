#include "lib/dispatch.inc.wgsl"
#include "lib/volume.inc.wgsl"
#include "lib/closest.inc.wgsl"
#include "lib/claim.inc.wgsl"
#include "lib/large.inc.wgsl"
// Triangles compete for the marked voxels that they come near: the one whose closest point is nearest to a voxel's
// centre wins its slot. Each walks the columns of its box, and in each the marked voxels between its plane's ends.
//
// A key is nearness (8 bits, never 0) + triangle number (24 bits), so one atomicMax decides, in any order. A triangle
// over many columns is put in a queue and walked by many threads; if the queue is full its thread walks it alone.

@group(0) @binding(5) var<storage, read> occupancy: array<u32>;
@group(0) @binding(6) var<storage, read> ranks: array<u32>;
@group(0) @binding(7) var<storage, read_write> keys: array<atomic<u32>>;
// A triangle's walk through the columns of its box. Everything in grid space.
struct Walk {
    triangle: u32,
    slot: u32,
    lo: vec3i,              // the box, cells, both ends included
    hi: vec3i,
    frame: ClosestFrame,
    depth: vec3f,           // its plane: z = depth.x·x + depth.y·y + depth.z at a column's middle (x, y)
    reach: f32,             // and so much beyond, anywhere in the column
    side_ab: vec3f,         // a column may be met if side.x·x + side.y·y + side.z ≥ 0 for all three sides
    side_bc: vec3f,
    side_ca: vec3f,
}

// Columns are cut so much wider than they are: f32 may round a touching triangle away.
const COLUMN_GROWTH: f32 = 0.015625;

// A side of the triangle in columns, pushed out so that it counts for the whole square about a middle.
fn side(from_corner: vec2f, to_corner: vec2f, outward: f32) -> vec3f {
    let inward = vec2f(from_corner.y - to_corner.y, to_corner.x - from_corner.x) * outward;
    return vec3f(inward, (abs(inward.x) + abs(inward.y)) * (0.5 + COLUMN_GROWTH) - dot(inward, from_corner));
}

// The walk of one piece of a triangle; its box is empty (lo.x > hi.x) if it does not reach into the grid.
fn walk_of(triangle: u32, a: vec3f, b: vec3f, c: vec3f) -> Walk {
    let g = grid_index.x;
    let low = min(min(a, b), c);
    let high = max(max(a, b), c);
    let cells = vec3i(grids[g].cells);
    var walk: Walk;
    walk.triangle = triangle;
    walk.frame = closest_frame(a, b, c);
    let n = walk.frame.normal;
    walk.slot = slot_of(n);
    let slices = slices_of(vec2f(low.z, high.z));
    walk.lo = vec3i(clamp(floor(vec3f(low.xy - COLUMN_GROWTH, slices.x)), vec3f(0.0), vec3f(cells)));
    walk.hi = vec3i(clamp(floor(vec3f(high.xy + COLUMN_GROWTH, slices.y)), vec3f(-1.0), vec3f(cells - 1)));
    if walk.frame.inverse_square.w == 0.0 || any(walk.lo > walk.hi) {
        walk.lo = vec3i(0);
        walk.hi = vec3i(-1);
    }
    let steep = 1.0 / select(n.z, select(-1e-9, 1e-9, n.z >= 0.0), abs(n.z) < 1e-9);
    walk.depth = vec3f(-n.xy * steep, a.z + dot(n.xy, a.xy) * steep);
    walk.reach = (abs(n.x) + abs(n.y)) * (0.5 + COLUMN_GROWTH) * abs(steep);
    let outward = select(-1.0, 1.0, n.z >= 0.0);
    walk.side_ab = side(a.xy, b.xy, outward);
    walk.side_bc = side(b.xy, c.xy, outward);
    walk.side_ca = side(c.xy, a.xy, outward);
    return walk;
}

// The slices of two depths in grid space, a little apart.
fn slices_of(ends: vec2f) -> vec2f {
    let growth = vec2f(-COLUMN_GROWTH, COLUMN_GROWTH);
    if !perspective {
        return ends + growth;
    }
    let g = grid_index.x;
    let within = clamp(ends, vec2f(0.0), vec2f(f32(grids[g].cells.z)));
    return vec2f(slice_of(grids[g], within.x), slice_of(grids[g], within.y)) + growth;
}

fn walk_columns(walk: Walk, columns: ColumnWalk) {
    let g = grid_index.x;
    let capacity = grids[g].record_capacity;
    let per_column = grids[g].words_per_column;
    let across = grids[g].cells.x;
    let word_base = grids[g].word_base;
    var column = walk.lo.xy + columns.first;
    var before = true;          // the column is still to be looked at
    var word = 0u;
    var last_word = 0u;
    var ends = vec2i(0);
    var bits = 0u;
    var rank = 0u;
    loop {
        if bits == 0u {
            if before {
                // The next column that the triangle may meet …
                while column.y <= walk.hi.y {
                    let middle = vec3f(vec2f(column) + 0.5, 1.0);
                    let depth = dot(walk.depth, middle);
                    let slices = slices_of(vec2f(depth - walk.reach, depth + walk.reach));
                    ends = vec2i(floor(vec2f(max(slices.x, f32(walk.lo.z)), min(slices.y, f32(walk.hi.z)))));
                    let met = min(min(dot(walk.side_ab, middle), dot(walk.side_bc, middle)), dot(walk.side_ca, middle));
                    if met >= 0.0 && ends.x <= ends.y {
                        break;
                    }
                    column = next_column(walk.lo.xy, walk.hi.xy, column, columns.stride);
                }
                if column.y > walk.hi.y {
                    break;
                }
                word = u32(ends.x) >> 5u;
                last_word = u32(ends.y) >> 5u;
            }
            // … and what is marked in its next word …
            let index = word_base + (u32(column.y) * across + u32(column.x)) * per_column + word;
            let whole = occupancy[index];
            let first_slice = i32(word * 32u);
            let from_slice = u32(max(ends.x - first_slice, 0));
            let to_slice = u32(min(ends.y - first_slice, 31));
            bits = whole & (0xffffffffu << from_slice) & (0xffffffffu >> (31u - to_slice));
            rank = ranks[index] + countOneBits(whole & ~(0xffffffffu << from_slice));
        }
        if bits != 0u {
            // … to compete for.
            let cell = vec3i(column, i32(word * 32u + countTrailingZeros(bits)));
            let claim = claim_of(walk.frame, cell);
            if claim.nearness != 0u && rank < capacity {
                atomicMax(&keys[6u * rank + walk.slot], (claim.nearness << 24u) | walk.triangle);
            }
            bits &= bits - 1u;
            rank++;
        }
        if bits == 0u {
            before = word == last_word;
            word++;
            if before {
                column = next_column(walk.lo.xy, walk.hi.xy, column, columns.stride);
            }
        }
    }
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let triangle = thread_index(id, workgroups, 64u);
    if 3u * triangle + 2u >= arrayLength(&indices) {
        return;
    }
    let cut = triangle_of(triangle);
    if cut.pieces == 0u {
        return;
    }
    let first = walk_of(triangle, cut.a, cut.b, cut.c);
    var columns = column_count(first.lo.xy, first.hi.xy);
    if perspective && cut.pieces == 2u {
        let second = walk_of(triangle, cut.a, cut.c, cut.d);
        columns = max(columns, column_count(second.lo.xy, second.hi.xy));
        if defer_large(triangle, columns) {
            return;
        }
        walk_columns(second, every_column());
    } else if columns == 0u || defer_large(triangle, columns) {
        return;
    }
    walk_columns(first, every_column());
}

// A workgroup a share of a large triangle.
@compute @workgroup_size(64)
fn large(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) thread: u32) {
    let triangle = large_shares[workgroup.x] & 0xffffffu;
    let share = large_shares[workgroup.x] >> 24u;
    let cut = triangle_of(triangle);
    let first = walk_of(triangle, cut.a, cut.b, cut.c);
    var columns = column_count(first.lo.xy, first.hi.xy);
    if perspective && cut.pieces == 2u {
        let second = walk_of(triangle, cut.a, cut.c, cut.d);
        columns = max(columns, column_count(second.lo.xy, second.hi.xy));
        walk_columns(second, share_of_columns(second.lo.xy, second.hi.xy, columns, share, thread));
    }
    walk_columns(first, share_of_columns(first.lo.xy, first.hi.xy, columns, share, thread));
}
