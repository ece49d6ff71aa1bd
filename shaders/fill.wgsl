#include "lib/dispatch.inc.wgsl"
#include "lib/one_grid.inc.wgsl"
#include "lib/volume.inc.wgsl"
#include "lib/large.inc.wgsl"
#include "lib/prefix_xor.inc.wgsl"
// The interior of one grid by parity: a line runs through the centres of each column's cells; every crossing of it
// toggles the first centre beyond, and a prefix XOR down the column makes solid runs of the toggles.
//
// Parity must be exact: corners are snapped to 1/256 cell, sides are tested in integers wide enough, and a line that
// runs through a side or a corner of several triangles counts as if it ran a hair beside it, the same hair for all. So
// a closed mesh has an even number of crossings on every line, whatever the depths, which are f32.

@group(0) @binding(5) var<storage, read_write> interior: array<atomic<u32>>;
// A bit a column: crossings beyond the grid's end; after `sweep`, whether the column is odd.
@group(0) @binding(6) var<storage, read_write> chunk_sums: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> counters: array<atomic<u32>>;    // four a grid, as `GridCounters`

const SUBCELLS: i32 = 256;
// Corners further out than this, in subcells, are moved in: sides have 23 bits.
const MAX_COORDINATE: f32 = 2097152.0;

// 2^22·hi + lo, 0 ≤ lo < 2^22.
struct Wide {
    hi: i32,
    lo: i32,
}

// a.x·b.y − a.y·b.x for |a|, |b| ≤ 2^22, exactly.
fn wide_cross(a: vec2i, b: vec2i) -> Wide {
    let a1 = a >> vec2u(11u);
    let b1 = b >> vec2u(11u);
    let a0 = a & vec2i(2047);
    let b0 = b & vec2i(2047);
    let middle = a1.x * b0.y + a0.x * b1.y - a1.y * b0.x - a0.y * b1.x;
    let low = (middle & 2047) * 2048 + a0.x * b0.y - a0.y * b0.x;
    return Wide(a1.x * b1.y - a1.y * b1.x + (middle >> 11u) + (low >> 22u), low & 0x3fffff);
}

fn wide_to_f32(w: Wide) -> f32 {
    return f32(w.hi) * 4194304.0 + f32(w.lo);
}

fn is_zero(w: Wide) -> bool {
    return (w.hi | w.lo) == 0;
}

// Lines on a side count for the one of the two triangles at it that has it upward, or level and leftward.
fn covers(w: Wide, direction: vec2i) -> bool {
    let owns = direction.y > 0 || (direction.y == 0 && direction.x < 0);
    return w.hi > 0 || (w.hi == 0 && w.lo > 0) || (is_zero(w) && owns);
}

// A triangle as columns see it: corners a, b, c counterclockwise in subcells, and the columns whose lines it may meet.
struct Crossed {
    a: vec2i,
    b: vec2i,
    c: vec2i,
    depths: vec3f,
    lo: vec2i,
    hi: vec2i,
}

fn snapped(p: vec2f) -> vec2i {
    return vec2i(clamp(round(p * f32(SUBCELLS)), vec2f(-MAX_COORDINATE), vec2f(MAX_COORDINATE)));
}

fn crossed_of(a: vec3f, b: vec3f, c: vec3f) -> Crossed {
    var t = Crossed(snapped(a.xy), snapped(b.xy), snapped(c.xy), vec3f(a.z, b.z, c.z), vec2i(0), vec2i(-1));
    let area = wide_cross(t.b - t.a, t.c - t.a);
    if area.hi < 0 {
        let swap = t.b;
        t.b = t.c;
        t.c = swap;
        t.depths = t.depths.xzy;
    }
    let half_cell = vec2i(SUBCELLS / 2);
    let low = min(min(t.a, t.b), t.c) + half_cell - 1;
    let high = max(max(t.a, t.b), t.c) - half_cell;
    // Whole cells: ⌈(low − half)/256⌉ and ⌊(high − half)/256⌋.
    t.lo = max(low >> vec2u(8u), vec2i(0));
    t.hi = min(high >> vec2u(8u), vec2i(grids[grid_index.x].cells.xy) - 1);
    if is_zero(area) || any(t.lo > t.hi) {
        t.lo = vec2i(0);
        t.hi = vec2i(-1);
    }
    return t;
}

// Toggles operands of bodies, each in words of its own, instead of all other parts in the grid's.
override by_operand: bool = false;
const NO_WORDS: u32 = 0xffffffffu;

// The first of the words that a triangle toggles.
fn toggled_words(triangle: u32) -> u32 {
    let operand = materials[vertices[indices[3u * triangle]].part].flags >> OPERAND_SHIFT;
    if by_operand {
        let g = grid_index.x;
        let count = grids[g].cells.x * grids[g].cells.y * grids[g].words_per_column;
        return select(NO_WORDS, (operand - 1u) * count, operand != 0u);
    }
    return select(NO_WORDS, grids[grid_index.x].word_base, operand == 0u);
}

fn toggle_columns(t: Crossed, walk: ColumnWalk, words: u32) {
    let g = grid_index.x;
    let across = grids[g].cells.x;
    let slices = i32(grids[g].cells.z);
    let per_column = grids[g].words_per_column;
    var column = t.lo + walk.first;
    while column.y <= t.hi.y {
        let p = column * SUBCELLS + SUBCELLS / 2;
        let at_c = wide_cross(t.b - t.a, p - t.a);
        let at_a = wide_cross(t.c - t.b, p - t.b);
        let at_b = wide_cross(t.a - t.c, p - t.c);
        if covers(at_c, t.b - t.a) && covers(at_a, t.c - t.b) && covers(at_b, t.a - t.c) {
            let weights = vec3f(wide_to_f32(at_a), wide_to_f32(at_b), wide_to_f32(at_c));
            let along = t.depths.yz - t.depths.x;
            var depth = t.depths.x + dot(weights.yz, along) / (weights.x + weights.y + weights.z);
            if perspective {
                depth = slice_of(grids[g], clamp(depth, 0.0, f32(slices)));
            }
            let first = max(i32(ceil(depth - 0.5)), 0);
            let number = u32(column.y) * across + u32(column.x);
            if first < slices {
                atomicXor(&interior[words + number * per_column + (u32(first) >> 5u)], word_bit(u32(first)));
            } else {
                atomicXor(&chunk_sums[number >> 5u], 1u << (number & 31u));
            }
        }
        column = next_column(t.lo, t.hi, column, walk.stride);
    }
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let triangle = thread_index(id, workgroups, 64u);
    if 3u * triangle + 2u >= arrayLength(&indices) {
        return;
    }
    let words = toggled_words(triangle);
    let cut = triangle_of(triangle);
    if cut.pieces == 0u || words == NO_WORDS {
        return;
    }
    let first = crossed_of(cut.a, cut.b, cut.c);
    var columns = column_count(first.lo, first.hi);
    if perspective && cut.pieces == 2u {
        let second = crossed_of(cut.a, cut.c, cut.d);
        columns = max(columns, column_count(second.lo, second.hi));
        if defer_large(triangle, columns) {
            return;
        }
        toggle_columns(second, every_column(), words);
    } else if columns == 0u || defer_large(triangle, columns) {
        return;
    }
    toggle_columns(first, every_column(), words);
}

// A workgroup a share of a large triangle.
@compute @workgroup_size(64)
fn large(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) thread: u32) {
    let share = large_shares[workgroup.x];
    let words = toggled_words(share & 0xffffffu);
    let cut = triangle_of(share & 0xffffffu);
    let first = crossed_of(cut.a, cut.b, cut.c);
    var columns = column_count(first.lo, first.hi);
    if perspective && cut.pieces == 2u {
        let second = crossed_of(cut.a, cut.c, cut.d);
        columns = max(columns, column_count(second.lo, second.hi));
        toggle_columns(second, share_of_columns(second.lo, second.hi, columns, share >> 24u, thread), words);
    }
    toggle_columns(first, share_of_columns(first.lo, first.hi, columns, share >> 24u, thread), words);
}

// A thread a column: toggles into runs.
@compute @workgroup_size(64)
fn sweep(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let g = grid_index.x;
    let number = thread_index(id, workgroups, 64u);
    if number >= grids[g].cells.x * grids[g].cells.y {
        return;
    }
    let first = grids[g].word_base + number * grids[g].words_per_column;
    let slices = grids[g].cells.z;
    var inside = 0u;
    for (var w = 0u; w < grids[g].words_per_column; w++) {
        let bits = prefix_xor(atomicLoad(&interior[first + w])) ^ inside;
        inside = select(0u, 0xffffffffu, (bits & 0x80000000u) != 0u);
        let valid = min(slices - 32u * w, 32u);
        atomicStore(&interior[first + w], bits & (0xffffffffu >> (32u - valid)));
    }
    if inside != 0u {
        atomicXor(&chunk_sums[number >> 5u], 1u << (number & 31u));
    }
    if is_odd(number) {
        atomicAdd(&counters[4u * g + 2u], 1u);
    }
}

fn is_odd(number: u32) -> bool {
    return (atomicLoad(&chunk_sums[number >> 5u]) & (1u << (number & 31u))) != 0u;
}

// How far an odd column looks for an even one, in columns.
const MAX_REACH: i32 = 64;

// A thread a column: an odd one takes, slice by slice, what most of the nearest even columns in eight directions have.
// Beyond the grid there is nothing. Only columns that are even already are asked, so the order of threads can't be seen.
@compute @workgroup_size(64)
fn mend(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let g = grid_index.x;
    let number = thread_index(id, workgroups, 64u);
    if atomicLoad(&counters[4u * g + 2u]) == 0u || number >= grids[g].cells.x * grids[g].cells.y || !is_odd(number) {
        return;
    }
    let size = vec2i(grids[g].cells.xy);
    let column = vec2i(vec2u(number % grids[g].cells.x, number / grids[g].cells.x));
    let per_column = grids[g].words_per_column;
    for (var w = 0u; w < per_column; w++) {
        // A counter a slice, one bit of it a word: no more than eight vote.
        var ones = 0u;
        var twos = 0u;
        var fours = 0u;
        var eights = 0u;
        var voters = 0u;
        for (var i = 0; i < 9; i++) {
            let direction = vec2i(i % 3, i / 3) - 1;
            var reach = select(1, MAX_REACH, i == 4);
            var beside = column + direction;
            while reach < MAX_REACH && all(beside >= vec2i(0)) && all(beside < size)
                && is_odd(u32(beside.y * size.x + beside.x)) {
                beside += direction;
                reach++;
            }
            if reach == MAX_REACH {
                continue;
            }
            voters++;
            if any(beside < vec2i(0)) || any(beside >= size) {
                continue;
            }
            let first = grids[g].word_base + u32(beside.y * size.x + beside.x) * per_column;
            let vote = atomicLoad(&interior[first + w]);
            let carry = ones & vote;
            let carry_2 = twos & carry;
            eights |= fours & carry_2;
            fours ^= carry_2;
            twos ^= carry;
            ones ^= vote;
        }
        let majority = voters / 2u + 1u;
        var solid = 0u;
        for (var slice = 0u; slice < 32u; slice++) {
            let votes = ((ones >> slice) & 1u) + 2u * ((twos >> slice) & 1u) + 4u * ((fours >> slice) & 1u)
                + 8u * ((eights >> slice) & 1u);
            solid |= select(0u, 1u << slice, votes >= majority);
        }
        atomicStore(&interior[grids[g].word_base + number * per_column + w], solid);
    }
}
