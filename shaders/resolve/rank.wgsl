#include "lib/dispatch.inc.wgsl"
#include "lib/volume.inc.wgsl"
// Numbers the occupied voxels of one grid, column by column: an exclusive prefix sum over the words' bit counts.

@group(0) @binding(0) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(1) var<uniform> grid_index: vec4u;
@group(0) @binding(2) var<storage, read> occupancy: array<u32>;
@group(0) @binding(3) var<storage, read_write> ranks: array<u32>;
@group(0) @binding(4) var<storage, read_write> chunk_sums: array<u32>;
@group(0) @binding(5) var<storage, read_write> counters: array<GridCounters>;
@group(0) @binding(6) var<storage, read_write> records: array<Record>;
@group(0) @binding(7) var<storage, read_write> voxel_dispatch: array<VoxelDispatch, 3>;

fn word_count(g: Grid) -> u32 {
    return g.cells.x * g.cells.y * g.words_per_column;
}

// A thread a chunk: its bits.
@compute @workgroup_size(64)
fn reduce(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let chunk = thread_index(id, workgroups, 64u);
    let first = chunk * CHUNK;
    let count = word_count(grids[grid_index.x]);
    if first >= count {
        return;
    }
    let base = grids[grid_index.x].word_base;
    let end = base + min(first + CHUNK, count);
    var sum = 0u;
    for (var w = base + first; w < end; w++) {
        sum += countOneBits(occupancy[w]);
    }
    chunk_sums[chunk] = sum;
}

// A thread a chunk: bits before each word.
@compute @workgroup_size(64)
fn spread(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let chunk = thread_index(id, workgroups, 64u);
    let first = chunk * CHUNK;
    let count = word_count(grids[grid_index.x]);
    if first >= count {
        return;
    }
    let base = grids[grid_index.x].word_base;
    let end = base + min(first + CHUNK, count);
    var rank = chunk_sums[chunk];
    for (var w = base + first; w < end; w++) {
        ranks[w] = rank;
        rank += countOneBits(occupancy[w]);
    }
}

// A thread a word: leaves each voxel's cell in its record's place.
@compute @workgroup_size(64)
fn list(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let word = thread_index(id, workgroups, 64u);
    if word >= word_count(grids[grid_index.x]) {
        return;
    }
    let base = grids[grid_index.x].word_base;
    var bits = occupancy[base + word];
    if bits == 0u {
        return;
    }
    let per_column = grids[grid_index.x].words_per_column;
    let across = grids[grid_index.x].cells.x;
    let capacity = grids[grid_index.x].record_capacity;
    let record_base = grids[grid_index.x].record_base;
    let column = word / per_column;
    let corner = pack_cell(vec3u(column % across, column / across, (word % per_column) * 32u));
    var rank = ranks[base + word];
    while bits != 0u && rank < capacity {
        records[record_base + rank].point = corner + (countTrailingZeros(bits) << 20u);
        bits &= bits - 1u;
        rank++;
    }
}

// The scan of the chunks' sums, for `reduce` and for the further sheets of `records.wgsl`: one workgroup.
const SCANNERS: u32 = 256u;
var<workgroup> run_sums: array<u32, SCANNERS>;

fn scan(thread: u32, chunks: u32) -> u32 {
    let run = (chunks + SCANNERS - 1u) / SCANNERS;
    let first = min(thread * run, chunks);
    let end = min(first + run, chunks);
    var sum = 0u;
    for (var c = first; c < end; c++) {
        sum += chunk_sums[c];
    }
    run_sums[thread] = sum;
    workgroupBarrier();
    var before = 0u;
    for (var t = 0u; t < thread; t++) {
        before += run_sums[t];
    }
    for (var c = first; c < end; c++) {
        let here = chunk_sums[c];
        chunk_sums[c] = before;
        before += here;
    }
    return before;
}

fn dispatch_of(voxels: u32) -> VoxelDispatch {
    let groups = (voxels + VOXEL_WORKGROUP - 1u) / VOXEL_WORKGROUP;
    let rows = (groups + 65534u) / 65535u;
    return VoxelDispatch((groups + max(rows, 1u) - 1u) / max(rows, 1u), rows, 1u, voxels);
}

@compute @workgroup_size(256)
fn scan_words(@builtin(local_invocation_index) thread: u32) {
    let total = scan(thread, (word_count(grids[grid_index.x]) + CHUNK - 1u) / CHUNK);
    if thread == SCANNERS - 1u {
        // Bodies made of others are ranked twice: room is needed for all voxels that their operands mark.
        counters[grid_index.x].occupied = max(counters[grid_index.x].occupied, total);
        let voxels = min(total, grids[grid_index.x].record_capacity);
        voxel_dispatch[DISPATCH_RECORDS] = dispatch_of(voxels);
    }
}

@compute @workgroup_size(256)
fn scan_sheets(@builtin(local_invocation_index) thread: u32) {
    let voxels = voxel_dispatch[DISPATCH_RECORDS].voxels;
    let total = scan(thread, (voxels + CHUNK - 1u) / CHUNK);
    if thread == SCANNERS - 1u {
        counters[grid_index.x].extras = total;
        let amiss = counters[grid_index.x].orphans != 0u || total > grids[grid_index.x].extra_capacity;
        voxel_dispatch[DISPATCH_SHEETS] = dispatch_of(select(0u, voxels, total != 0u));
        voxel_dispatch[DISPATCH_MEND] = dispatch_of(select(0u, voxels, amiss));
    }
}
