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

// Arguments of the indirect dispatches over the voxels of one grid, a thread each, and their number.
struct VoxelDispatch {
    workgroups: u32,
    rows: u32,
    one: u32,
    voxels: u32,
}

const VOXEL_WORKGROUP: u32 = 64u;
const DISPATCH_RECORDS: u32 = 0u;   // all voxels that have a record
const DISPATCH_SHEETS: u32 = 1u;    // the same, if some have further sheets
const DISPATCH_MEND: u32 = 2u;      // the same, if some are orphans or have sheets that found no room

// While the winners compete, a record's place holds its cell, in `point`.
fn pack_cell(cell: vec3u) -> u32 {
    return cell.x | (cell.y << 10u) | (cell.z << 20u);
}

fn unpack_cell(bits: u32) -> vec3u {
    return vec3u(bits & 1023u, (bits >> 10u) & 1023u, bits >> 20u);
}
