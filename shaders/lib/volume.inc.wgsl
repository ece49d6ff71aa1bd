#include "lib/grid.inc.wgsl"
#include "lib/record.inc.wgsl"
// What a grid holds, counted by the device; `GridCounters` of `volume.rs`.
struct GridCounters {
    occupied: u32,
    extras: u32,
    odd_columns: u32,
    orphans: u32,
}

// Prefix sums go over chunks of so many items: a thread adds up one chunk, one workgroup scans the chunks' sums.
const CHUNK: u32 = 32u;

// While the winners compete, a record's place holds its cell, in `point`.
fn pack_cell(cell: vec3u) -> u32 {
    return cell.x | (cell.y << 10u) | (cell.z << 20u);
}

fn unpack_cell(bits: u32) -> vec3u {
    return vec3u(bits & 1023u, (bits >> 10u) & 1023u, bits >> 20u);
}
