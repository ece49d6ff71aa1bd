#include "lib/grid.inc.wgsl"
#include "lib/record.inc.wgsl"
// The occupied voxel nearest to a point.
//
// Bind as: var<uniform> grids: array<Grid, MAX_GRIDS>; var<storage, read> occupancy: array<u32>; ranks: array<u32>;
//          records: array<Record>;

struct NearRecord {
    found: bool,
    record: Record,
}

// Columns within so many cells to each side are looked at, and in each as many slices up and down.
const NEAR_CELLS: i32 = 3;

fn nearest_record(grid: u32, p: vec3f) -> NearRecord {
    let p_grid = grid_from_world(grids[grid], p);
    let size = vec3i(grids[grid].cells);
    let at = vec3i(vec2i(floor(p_grid.xy)), i32(floor(slice_of(grids[grid], p_grid.z))));
    let lo = max(at - NEAR_CELLS, vec3i(0));
    let hi = min(at + NEAR_CELLS, size - 1);
    var nearest = 1 << 20u;
    var index = 0u;
    for (var y = lo.y; y <= hi.y; y++) {
        for (var x = lo.x; x <= hi.x; x++) {
            for (var z = lo.z; z <= hi.z; z++) {
                let cell = vec3u(vec3i(x, y, z));
                let word = word_index(grids[grid], cell);
                let away = vec3i(x, y, z) - at;
                let distance2 = dot(away, away);
                let bits = occupancy[word];
                if (bits & word_bit(cell.z)) != 0u && distance2 < nearest {
                    let rank = ranks[word] + countOneBits(bits & (word_bit(cell.z) - 1u));
                    nearest = select(nearest, distance2, rank < grids[grid].record_capacity);
                    index = rank;
                }
            }
        }
    }
    let found = nearest < (1 << 20u);
    return NearRecord(found, records[grids[grid].record_base + select(0u, index, found)]);
}
