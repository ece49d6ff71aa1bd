#include "lib/dispatch.inc.wgsl"
#include "lib/geometry.inc.wgsl"
#include "lib/volume.inc.wgsl"
// Bodies that are made of other models, on the words of one grid (DO §5.2).
//
// Each operand has solid words of its own, toggled by `fill.wgsl` and swept here. An operand's surface is the body's
// where the operand decides: where the body would be another if the cell's bit of that operand were. Of an operand whose
// surface runs through the same cell the bit may be either.

struct CsgProgram {
    operand_count: u32,
    step_count: u32,
    _pad: vec2u,
    steps: array<vec4u, 32>,        // four steps each
    body_parts: array<vec4u, 8>,    // of each operand: its body's part
}

const STEP_UNION: u32 = 32u;        // below it: an operand's number
const STEP_INTERSECTION: u32 = 33u;
const STEP_DIFFERENCE: u32 = 34u;
const STEP_END: u32 = 35u;
const MAX_OPERANDS: u32 = 32u;

@group(0) @binding(0) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(1) var<uniform> grid_index: vec4u;
@group(0) @binding(2) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(3) var<storage, read> indices: array<u32>;
@group(0) @binding(4) var<storage, read> materials: array<PartMaterial>;
@group(0) @binding(5) var<storage, read_write> occupancy: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read> ranks: array<u32>;
@group(0) @binding(7) var<storage, read_write> records: array<Record>;
@group(0) @binding(8) var<storage, read_write> keys: array<u32>;
@group(0) @binding(9) var<storage, read> voxel_dispatch: array<VoxelDispatch, 3>;
@group(0) @binding(10) var<storage, read_write> solids: array<u32>;     // operand after operand, a grid's words each
@group(0) @binding(11) var<storage, read_write> interior: array<u32>;
@group(0) @binding(12) var<uniform> csg: CsgProgram;

fn word_count() -> u32 {
    let g = grid_index.x;
    return grids[g].cells.x * grids[g].cells.y * grids[g].words_per_column;
}

fn step_at(i: u32) -> u32 {
    return csg.steps[i / 4u][i % 4u];
}

// A thread a column of an operand: toggles into runs.
@compute @workgroup_size(64)
fn sweep(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let g = grid_index.x;
    let number = thread_index(id, workgroups, 64u);
    if number >= grids[g].cells.x * grids[g].cells.y * csg.operand_count {
        return;
    }
    let first = number * grids[g].words_per_column;
    let slices = grids[g].cells.z;
    var inside = 0u;
    for (var w = 0u; w < grids[g].words_per_column; w++) {
        var bits = solids[first + w];
        bits ^= bits << 1u;
        bits ^= bits << 2u;
        bits ^= bits << 4u;
        bits ^= bits << 8u;
        bits ^= bits << 16u;
        bits ^= inside;
        inside = select(0u, 0xffffffffu, (bits & 0x80000000u) != 0u);
        solids[first + w] = bits & (0xffffffffu >> (32u - min(slices - 32u * w, 32u)));
    }
}

// A thread a word: what all bodies make of 32 cells, added to the interior.
@compute @workgroup_size(64)
fn combine(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let word = thread_index(id, workgroups, 64u);
    let count = word_count();
    if word >= count {
        return;
    }
    var stack: array<u32, MAX_OPERANDS>;
    var top = 0u;
    var all_bodies = 0u;
    for (var i = 0u; i < csg.step_count; i++) {
        let step = step_at(i);
        if step < MAX_OPERANDS {
            stack[top] = solids[step * count + word];
            top++;
        } else if step == STEP_END {
            top = 0u;
            all_bodies |= stack[0];
        } else {
            top--;
            let a = stack[top - 1u];
            let b = stack[top];
            stack[top - 1u] = select(select(a & ~b, a & b, step == STEP_INTERSECTION), a | b, step == STEP_UNION);
        }
    }
    interior[grids[grid_index.x].word_base + word] |= all_bodies;
}

// The operands that decide about their body in a cell where the operands `inside` are, and those of `either` may be.
fn deciding(inside: u32, either: u32) -> u32 {
    var stack: array<vec3u, MAX_OPERANDS>;  // may be out, may be in, operands that decide
    var top = 0u;
    var result = 0u;
    for (var i = 0u; i < csg.step_count; i++) {
        let step = step_at(i);
        if step < MAX_OPERANDS {
            let bit = 1u << step;
            let open = u32((either & bit) != 0u);
            let there = u32((inside & bit) != 0u);
            stack[top] = vec3u((1u - there) | open, there | open, bit);
            top++;
        } else if step == STEP_END {
            top = 0u;
            result |= stack[0].z;
        } else {
            top--;
            let a = stack[top - 1u];
            let b = stack[top];
            // Where the other one leaves the choice.
            let a_counts = select(b.x, b.y, step == STEP_INTERSECTION) != 0u;
            let b_counts = select(a.y, a.x, step == STEP_UNION) != 0u;
            let decide = select(0u, a.z, a_counts) | select(0u, b.z, b_counts);
            var out_in = vec2u(a.x & b.x, a.y | b.y);
            if step == STEP_INTERSECTION {
                out_in = vec2u(a.x | b.x, a.y & b.y);
            } else if step == STEP_DIFFERENCE {
                out_in = vec2u(a.x | b.y, a.y & b.x);
            }
            stack[top - 1u] = vec3u(out_in, decide);
        }
    }
    return result;
}

// The operands that a cell's centre is inside of.
fn operands_around(cell: vec3u) -> u32 {
    let g = grid_index.x;
    let word = (cell.y * grids[g].cells.x + cell.x) * grids[g].words_per_column + (cell.z >> 5u);
    let count = word_count();
    var inside = 0u;
    for (var i = 0u; i < csg.operand_count; i++) {
        inside |= ((solids[i * count + word] >> (cell.z & 31u)) & 1u) << i;
    }
    return inside;
}

fn operand_of_part(part: u32) -> u32 {
    return materials[part].flags >> OPERAND_SHIFT;
}

// The winners among whom a voxel's sheets are chosen: those that are no body's surface lose. The first time, voxels that
// have no other are unmarked and all winners go, since the ranks change; the second time the hidden ones alone do.
override unmarks: bool = false;

@compute @workgroup_size(64)
fn prune(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let g = grid_index.x;
    let rank = thread_index(id, workgroups, 64u);
    if rank >= voxel_dispatch[DISPATCH_RECORDS].voxels {
        return;
    }
    let cell = unpack_cell(records[grids[g].record_base + rank].point);
    var operands: array<u32, 6>;
    var here = 0u;
    var others = false;
    for (var slot = 0u; slot < 6u; slot++) {
        let key = keys[6u * rank + slot];
        operands[slot] = 0u;
        if key != 0u {
            let operand = operand_of_part(vertices[indices[3u * (key & RECORD_TRIANGLE_MASK)]].part);
            operands[slot] = operand;
            others = others || operand == 0u;
            here |= select(0u, 1u << ((operand - 1u) & 31u), operand != 0u);
        }
    }
    var shown = 0u;
    if here != 0u {
        shown = deciding(operands_around(cell), here) & here;
    }
    for (var slot = 0u; slot < 6u; slot++) {
        let hidden = operands[slot] != 0u && (shown & (1u << ((operands[slot] - 1u) & 31u))) == 0u;
        if unmarks || hidden {
            keys[6u * rank + slot] = 0u;
        }
    }
    if unmarks && here != 0u && shown == 0u && !others {
        atomicAnd(&occupancy[word_index(grids[g], cell)], ~(1u << (cell.z & 31u)));
    }
}

// Cells by which a sheet's point is to lie beyond another's plane, on the side where it is the body's surface.
const CLEAR_CELLS: f32 = 0.1;

fn place_of(cell: vec3u, fraction: vec3f) -> vec3f {
    let g = grid_index.x;
    let z = mix(slab(grids[g], f32(cell.z)), slab(grids[g], f32(cell.z + 1u)), fraction.z);
    return world_from_grid(grids[g], vec3f(vec2f(cell.xy) + fraction.xy, z));
}

fn fraction_of(cell: vec3u, p: vec3f) -> vec3f {
    let g = grid_index.x;
    let at = grid_from_world(grids[g], p);
    let below = slab(grids[g], f32(cell.z));
    return vec3f(at.xy - vec2f(cell.xy), (at.z - below) / (slab(grids[g], f32(cell.z + 1u)) - below));
}

// A thread a word: gives operands' records their body's part, turns those that are taken away, and moves their points to
// where they are seen, by which `lib/crossing.inc.wgsl` tells ridges from grooves.
@compute @workgroup_size(64)
fn turn(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let g = grid_index.x;
    let word = thread_index(id, workgroups, 64u);
    if word >= word_count() {
        return;
    }
    let base = grids[g].word_base;
    let column = word / grids[g].words_per_column;
    let across = grids[g].cells.x;
    var bits = atomicLoad(&occupancy[base + word]);
    var rank = ranks[base + word];
    while bits != 0u && rank < grids[g].record_capacity {
        let slice = 32u * (word % grids[g].words_per_column) + countTrailingZeros(bits);
        let cell = vec3u(column % across, column / across, slice);
        bits &= bits - 1u;
        let first = grids[g].record_base + rank;
        rank++;
        let count = 1u + record_extra_count(records[first]);
        let further = grids[g].extra_base + record_extra_first(records[first]);
        var place: array<vec3f, 4>;
        var normal: array<vec3f, 4>;
        var operand: array<u32, 4>;
        var here = 0u;
        for (var s = 0u; s < count; s++) {
            let record = records[select(further + s - 1u, first, s == 0u)];
            operand[s] = operand_of_part(record_part(record));
            if (record.triangle & RECORD_ORPHAN) != 0u {
                operand[s] = 0u;
            }
            here |= select(0u, 1u << ((operand[s] - 1u) & 31u), operand[s] != 0u);
            place[s] = place_of(cell, unpack_point_in_cell(record.point));
            normal[s] = unpack_unit(record.normal);
        }
        if here == 0u {
            continue;
        }
        let inside = operands_around(cell);
        for (var s = 0u; s < count; s++) {
            if operand[s] == 0u {
                continue;
            }
            let number = operand[s] - 1u;
            var p = place[s];
            for (var o = 0u; o < count; o++) {
                let other = operand[o];
                if other == 0u || other == operand[s] {
                    continue;
                }
                let bit = 1u << (other - 1u);
                let when_in = (deciding(inside | bit, here & ~bit) >> number) & 1u;
                let when_out = (deciding(inside & ~bit, here & ~bit) >> number) & 1u;
                if when_in == when_out {
                    continue;
                }
                let side = select(-1.0, 1.0, when_out != 0u);
                let cosine = dot(normal[o], normal[s]);
                let off = dot(normal[o], p - place[o]);
                let short = side * CLEAR_CELLS * grids[g].cell_size - off;
                if short * side > 0.0 && abs(cosine) < 0.995 {
                    p += (normal[o] - cosine * normal[s]) * (short / (1.0 - cosine * cosine));
                }
            }
            let at = select(further + s - 1u, first, s == 0u);
            let part = csg.body_parts[number / 4u][number % 4u];
            let turned = (materials[record_part(records[at])].flags & FLAG_TURNED) != 0u;
            records[at].point = pack_point_in_cell(fraction_of(cell, p)) | (records[at].point & 0xc0000000u);
            records[at].normal = pack_unit(select(normal[s], -normal[s], turned));
            records[at].medium = (records[at].medium & ~0xfffu) | part;
        }
    }
}
