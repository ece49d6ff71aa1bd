#include "lib/dispatch.inc.wgsl"
#include "lib/volume.inc.wgsl"
#include "lib/claim.inc.wgsl"
// Works out the records of one grid, a thread a voxel: up to three sheets among the six winners, the nearest first.

@group(0) @binding(5) var<storage, read_write> keys: array<u32>;
@group(0) @binding(6) var<storage, read_write> records: array<Record>;
@group(0) @binding(7) var<storage, read_write> chunk_sums: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> counters: array<atomic<u32>>;   // four a grid, as `GridCounters`
@group(0) @binding(11) var<storage, read> voxel_dispatch: array<VoxelDispatch, 3>;
@group(0) @binding(9) var<storage, read> occupancy: array<u32>;
@group(0) @binding(10) var<storage, read> ranks: array<u32>;

const MAX_SHEETS: u32 = 3u;
const MAX_EXTRA_FIRST: u32 = 0xfffffu;
// Sheets differ if their normals are further apart than this (30°) …
const SAME_SHEET_COSINE: f32 = 0.866;
// … or their planes are, in half cells at the voxel.
const SAME_SHEET_DISTANCE: f32 = 1.0;

struct Sheet {
    key: u32,
    part: u32,
    normal: vec3f,      // world, unit, outward
    grid_normal: vec3f, // of the plane in half cells about the voxel's centre, unit
    offset: vec3f,      // its point there
}

fn sheet_of(key: u32, cell: vec3i) -> Sheet {
    let corners = 3u * (key & RECORD_TRIANGLE_MASK);
    let v0 = indices[corners];
    let a = vertices[v0].position;
    let b = vertices[indices[corners + 1u]].position;
    let c = vertices[indices[corners + 2u]].position;
    let area = cross(b - a, c - a);
    let normal = normalize(select(area, -area, vertices[v0].mirrored != 0u));
    let g = grid_index.x;
    var offset: vec3f;
    var plane: vec3f;
    if !perspective {
        let frame =
            closest_frame(grid_from_world(grids[g], a), grid_from_world(grids[g], b), grid_from_world(grids[g], c));
        offset = claim_of(frame, cell).offset;
        plane = frame.normal;
    } else {
        let cut = grid_triangle(grids[g], a, b, c);
        let frame = closest_frame(cut.a, cut.b, cut.c);
        offset = claim_of(frame, cell).offset;
        if cut.pieces == 2u {
            let other = claim_of(closest_frame(cut.a, cut.c, cut.d), cell).offset;
            offset = select(offset, other, dot(other, other) < dot(offset, offset));
        }
        let slabs = slabs_of(cell.z);
        plane = frame.normal * vec3f(1.0, 1.0, slabs.y - slabs.x);
    }
    return Sheet(key, vertices[v0].part, normal, normalize(plane), offset);
}

fn differs(a: Sheet, b: Sheet) -> bool {
    return dot(a.normal, b.normal) < SAME_SHEET_COSINE
        || abs(dot(a.offset - b.offset, a.grid_normal)) > SAME_SHEET_DISTANCE;
}

// The largest of six keys below `limit`, 0 if there is none. No two winners are the same triangle.
fn largest_below(low: vec3u, high: vec3u, limit: u32) -> u32 {
    let one = max(select(vec3u(0u), low, low < vec3u(limit)), select(vec3u(0u), high, high < vec3u(limit)));
    return max(max(one.x, one.y), one.z);
}

fn flagged_triangle(sheet: Sheet) -> u32 {
    let opaque_part = (materials[sheet.part].flags & FLAG_OPAQUE) != 0u;
    return (sheet.key & RECORD_TRIANGLE_MASK) | select(0u, RECORD_OPAQUE, opaque_part);
}

fn packed_point(sheet: Sheet) -> u32 {
    return pack_point_in_cell(0.5 + 0.5 * sheet.offset);
}

// Leaves further sheets in the voxel's keys, three words each, for `place_sheets`, and clears the rest of them.
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let g = grid_index.x;
    let rank = thread_index(id, workgroups, 64u);
    if rank >= voxel_dispatch[DISPATCH_RECORDS].voxels {
        return;
    }
    let index = grids[g].record_base + rank;
    let cell_bits = records[index].point;
    let cell = vec3i(unpack_cell(cell_bits));

    let at = 6u * rank;
    let low = vec3u(keys[at], keys[at + 1u], keys[at + 2u]);
    let high = vec3u(keys[at + 3u], keys[at + 4u], keys[at + 5u]);
    var key = largest_below(low, high, 0xffffffffu);
    if key == 0u {
        // `mend` gathers the rest.
        records[index] = Record(RECORD_ORPHAN, 0u, cell_bits, 0u);
        atomicAdd(&counters[4u * grid_index.x + 3u], 1u);
        return;
    }
    let first = sheet_of(key, cell);
    var second: Sheet;
    var sheets = 1u;
    // The other winners, nearest first. Their places in `keys` take further sheets.
    loop {
        key = largest_below(low, high, key);
        if key == 0u || sheets == MAX_SHEETS {
            break;
        }
        let sheet = sheet_of(key, cell);
        if differs(first, sheet) && (sheets == 1u || differs(second, sheet)) {
            let place = at + 3u * (sheets - 1u);
            keys[place] = flagged_triangle(sheet);
            keys[place + 1u] = pack_unit(sheet.normal);
            keys[place + 2u] = packed_point(sheet);
            second = sheet;
            sheets++;
        }
    }
    if sheets < 2u {
        keys[at] = 0u;
        keys[at + 1u] = 0u;
        keys[at + 2u] = 0u;
    }
    if sheets < 3u {
        keys[at + 3u] = 0u;
        keys[at + 4u] = 0u;
        keys[at + 5u] = 0u;
    }
    let extras = sheets - 1u;
    records[index] = Record(flagged_triangle(first), pack_unit(first.normal), packed_point(first) | (extras << 30u), first.part);
    if extras != 0u {
        atomicAdd(&chunk_sums[rank / CHUNK], extras);
    }
}

// Moves further sheets to their place, in the order of the voxels.
@compute @workgroup_size(64)
fn place_sheets(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let g = grid_index.x;
    let rank = thread_index(id, workgroups, 64u);
    if rank >= voxel_dispatch[DISPATCH_RECORDS].voxels {
        return;
    }
    let index = grids[g].record_base + rank;
    let point = records[index].point;
    let count = point >> 30u;
    if count == 0u {
        return;
    }
    var place = atomicLoad(&chunk_sums[rank / CHUNK]);
    for (var r = rank - rank % CHUNK; r < rank; r++) {
        place += records[grids[g].record_base + r].point >> 30u;
    }
    for (var s = 0u; s < count; s++) {
        let from_key = 6u * rank + 3u * s;
        let triangle = keys[from_key];
        if place + s < grids[g].extra_capacity {
            let part = vertices[indices[3u * (triangle & RECORD_TRIANGLE_MASK)]].part;
            records[grids[g].extra_base + place + s] = Record(triangle, keys[from_key + 1u], keys[from_key + 2u], part);
        }
        keys[from_key] = 0u;
        keys[from_key + 1u] = 0u;
        keys[from_key + 2u] = 0u;
    }
    records[index].medium |= min(place, MAX_EXTRA_FIRST) << 12u;
}

// Drops further sheets that had no room, and gives orphans the mean normal and the nearest part of their neighbours.
@compute @workgroup_size(64)
fn mend(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let g = grid_index.x;
    let rank = thread_index(id, workgroups, 64u);
    if rank >= voxel_dispatch[DISPATCH_RECORDS].voxels {
        return;
    }
    let index = grids[g].record_base + rank;
    let record = records[index];
    if (record.triangle & RECORD_ORPHAN) == 0u {
        let first = record.medium >> 12u;
        let count = record.point >> 30u;
        let placed = min(first + count, max(grids[g].extra_capacity, first)) - first;
        if placed != count {
            records[index].point = (record.point & 0x3fffffffu) | (placed << 30u);
        }
        return;
    }
    let cell = vec3i(unpack_cell(record.point));
    var sum = vec3f(0.0);
    var nearest = 4;
    var part = 0u;
    var triangle = 0u;
    for (var i = 0; i < 27; i++) {
        let step = vec3i(i % 3, (i / 3) % 3, i / 9) - 1;
        let beside = cell + step;
        if !in_grid(grids[g], beside) {
            continue;
        }
        let word = word_index(grids[g], vec3u(beside));
        let bit = word_bit(u32(beside.z));
        let bits = occupancy[word];
        let there = ranks[word] + countOneBits(bits & (bit - 1u));
        if (bits & bit) == 0u || there >= grids[g].record_capacity {
            continue;
        }
        let other = grids[g].record_base + there;
        if (records[other].triangle & RECORD_ORPHAN) != 0u {
            continue;
        }
        let distance_squared = dot(step, step);
        sum += unpack_unit(records[other].normal) / f32(distance_squared);
        if distance_squared < nearest {
            nearest = distance_squared;
            part = record_part(records[other]);
            triangle = records[other].triangle;
        }
    }
    // With no neighbour to ask, the side that columns are walked from.
    let toward = world_from_grid(grids[g], vec3f(cell)) - world_from_grid(grids[g], vec3f(cell + vec3i(0, 0, 1)));
    records[index].normal = pack_unit(normalize(select(toward, sum, dot(sum, sum) > 1e-6)));
    // Its colours run on from the nearest neighbour's triangle.
    records[index].triangle = triangle | RECORD_ORPHAN;
    records[index].medium = part;
    records[index].point = pack_point_in_cell(vec3f(0.5));
}
