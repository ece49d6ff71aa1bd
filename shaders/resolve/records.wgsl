#include "lib/dispatch.inc.wgsl"
#include "lib/geometry.inc.wgsl"
#include "lib/volume.inc.wgsl"
#include "lib/claim.inc.wgsl"
// Works out the records of one grid, a thread a voxel: up to three sheets among the six winners, the nearest first.

@group(0) @binding(0) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(1) var<uniform> grid_index: vec4u;
@group(0) @binding(2) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(3) var<storage, read> indices: array<u32>;
@group(0) @binding(4) var<storage, read> materials: array<PartMaterial>;
@group(0) @binding(5) var<storage, read_write> keys: array<u32>;
@group(0) @binding(6) var<storage, read_write> records: array<Record>;
@group(0) @binding(7) var<storage, read_write> chunk_sums: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> counters: array<atomic<u32>>;   // four a grid, as `GridCounters`
@group(0) @binding(9) var<storage, read> occupancy: array<u32>;
@group(0) @binding(10) var<storage, read> ranks: array<u32>;

const MAX_SHEETS: u32 = 3u;
const MAX_EXTRA_FIRST: u32 = 0xfffffu;
// Sheets differ if their normals are further apart than this (30°) …
const SAME_SHEET_COSINE: f32 = 0.866;
// … or their planes are, in half cells at the voxel.
const SAME_SHEET_DISTANCE: f32 = 1.0;

// Voxels of the grid that have a record.
fn voxel_count(g: u32) -> u32 {
    return min(atomicLoad(&counters[4u * g]), grids[g].record_capacity);
}

struct Sheet {
    key: u32,
    part: u32,
    normal: vec3f,      // world, unit, outward
    grid_normal: vec3f, // of the plane in half cells about the voxel's centre, unit
    offset: vec3f,      // its point there
}

fn sheet_of(key: u32, cell: vec3i) -> Sheet {
    let corners = 3u * (key & RECORD_TRIANGLE_MASK);
    let v0 = vertices[indices[corners]];
    let v1 = vertices[indices[corners + 1u]];
    let v2 = vertices[indices[corners + 2u]];
    var normal = normalize(cross(v1.position - v0.position, v2.position - v0.position));
    // A mesh may be wound inward: its vertex normals know which way is out.
    normal = select(normal, -normal, dot(normal, v0.normal + v1.normal + v2.normal) < 0.0);
    let g = grid_index.x;
    let frame = closest_frame(
        grid_from_world(grids[g], v0.position),
        grid_from_world(grids[g], v1.position),
        grid_from_world(grids[g], v2.position),
    );
    let half = cell_box(grids[g], cell).half;
    return Sheet(key, v0.part, normal, normalize(frame.normal * half), claim_of(grids[g], frame, cell).offset);
}

fn differs(a: Sheet, b: Sheet) -> bool {
    return dot(a.normal, b.normal) < SAME_SHEET_COSINE
        || abs(dot(a.offset - b.offset, a.grid_normal)) > SAME_SHEET_DISTANCE;
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
    if rank >= voxel_count(g) {
        return;
    }
    let index = grids[g].record_base + rank;
    let cell_bits = records[index].point;
    let cell = vec3i(unpack_cell(cell_bits));

    // The winners, nearest first: a short insertion sort.
    var sorted = array<u32, 6>(0u, 0u, 0u, 0u, 0u, 0u);
    var count = 0u;
    for (var slot = 0u; slot < 6u; slot++) {
        let key = keys[6u * rank + slot];
        if key != 0u {
            keys[6u * rank + slot] = 0u;
            var place = count;
            while place > 0u && sorted[place - 1u] < key {
                sorted[place] = sorted[place - 1u];
                place--;
            }
            sorted[place] = key;
            count++;
        }
    }
    if count == 0u {
        // `orphans` gathers the rest.
        records[index] = Record(RECORD_ORPHAN, 0u, cell_bits, 0u);
        atomicAdd(&counters[4u * g + 3u], 1u);
        return;
    }

    let first = sheet_of(sorted[0], cell);
    var second: Sheet;
    var sheets = 1u;
    for (var i = 1u; i < count; i++) {
        let sheet = sheet_of(sorted[i], cell);
        if differs(first, sheet) && (sheets == 1u || differs(second, sheet)) {
            let at = 6u * rank + 3u * (sheets - 1u);
            keys[at] = flagged_triangle(sheet);
            keys[at + 1u] = pack_unit(sheet.normal);
            keys[at + 2u] = packed_point(sheet);
            second = sheet;
            sheets++;
            if sheets == MAX_SHEETS {
                break;
            }
        }
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
    if rank >= voxel_count(g) {
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
fn finish(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let g = grid_index.x;
    let rank = thread_index(id, workgroups, 64u);
    if rank >= voxel_count(g) {
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
        }
    }
    // With no neighbour to ask, the side that columns are walked from.
    let toward = world_from_grid(grids[g], vec3f(cell)) - world_from_grid(grids[g], vec3f(cell + vec3i(0, 0, 1)));
    records[index].normal = pack_unit(normalize(select(toward, sum, dot(sum, sum) > 1e-6)));
    records[index].medium = part;
    records[index].point = pack_point_in_cell(vec3f(0.5));
}
