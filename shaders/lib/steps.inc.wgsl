#include "lib/ray.inc.wgsl"
#include "lib/record.inc.wgsl"
// The paper's way through the volume: fixed steps of one voxel along the ray's dominant axis (CL Eq. 3, thickness/cos θ),
// and the voxel at each step's end.
//
// Bind as: what `lib/ray.inc.wgsl` asks for; var<storage, read> ranks: array<u32>; records: array<Record>.

struct Steps {
    s: f32,             // of the last sample
    s_step: f32,
    word: u32,          // of the voxel found
    word_index: u32,
    slice: u32,
}

// `s_begin` is where the steps start from: the first sample is `share` of a step further.
fn steps_from(ray: GridRay, s_begin: f32, share: f32) -> Steps {
    // In perspective the last slice is the thinnest, by near / far.
    let slices_per_s = abs(ray.along.z) * ray.slab.x / ray.slab.y;
    let s_step = 1.0 / max(abs(ray.along.x), max(abs(ray.along.y), slices_per_s));
    return Steps(s_begin + (share - 1.0) * s_step, s_step, 0u, 0u, 0u);
}

// Steps until a sample lies in an occupied voxel; false where the ray leaves the grid first.
fn next_boundary_voxel(ray: GridRay, steps: ptr<function, Steps>) -> bool {
    var at = *steps;
    var found = false;
    loop {
        at.s += at.s_step;
        if at.s > ray.s_last {
            break;
        }
        let column = clamp(vec2i(floor(ray.start.xy + at.s * ray.along.xy)), vec2i(0), ray.cells.xy - 1);
        at.slice = u32(slice_at(ray, at.s));
        at.word_index = ray.word_base + u32(column.y * ray.cells.x + column.x) * ray.words_per_column + (at.slice >> 5u);
        at.word = occupancy[at.word_index];
        if (at.word & (1u << (at.slice & 31u))) != 0u {
            found = true;
            break;
        }
    }
    *steps = at;
    return found;
}

// The first record of the voxel that the steps found.
fn record_at(grid: u32, steps: Steps) -> Record {
    let below = (1u << (steps.slice & 31u)) - 1u;
    let rank = ranks[steps.word_index] + countOneBits(steps.word & below);
    return records[grids[grid].record_base + min(rank, grids[grid].record_capacity - 1u)];
}
