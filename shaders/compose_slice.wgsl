#include "lib/compose_settings.inc.wgsl"
#include "lib/difference.inc.wgsl"
#include "lib/light_volume.inc.wgsl"
#include "lib/surroundings.inc.wgsl"
#include "lib/tone_map.inc.wgsl"
// One slice of a grid, flat: occupancy and interior of the view's grid (`main`), what is left of light 0 (`light`). The
// interior is that of the fill where it ran, else as the column's last record tells. Held against the true voxels, what
// is missing or spurious has a colour of its own.

@group(0) @binding(0) var<uniform> compose_settings: ComposeSettings;
@group(0) @binding(1) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(2) var<uniform> surroundings: Surroundings;
@group(0) @binding(3) var<storage, read> occupancy: array<u32>;
@group(0) @binding(4) var<storage, read> ranks: array<u32>;
@group(0) @binding(5) var<storage, read> records: array<Record>;
@group(0) @binding(6) var<storage, read> light_records: array<vec2u>;
@group(0) @binding(7) var<storage, read> materials: array<PartMaterial>;
@group(0) @binding(8) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(9) var<storage, read> interior: array<u32>;
@group(0) @binding(10) var<storage, read> truth: array<u32>;

const OUTSIDE: vec3f = vec3f(0.05, 0.05, 0.06);
const AIR: vec3f = vec3f(0.13, 0.13, 0.15);
const INTERIOR: vec3f = vec3f(0.20, 0.33, 0.45);

// The point of the slice, in cells, that a pixel shows; the slice fits the picture.
struct SlicePoint {
    cell: vec3f,        // x, y in cells, z in slices
    in_slice: bool,
    pixels: f32,        // that a cell is wide
}

fn slice_point(grid: u32, axis: u32, position: f32, pixel: vec2u, size: vec2u) -> SlicePoint {
    let cells = vec3f(grids[grid].cells);
    let across = select(select(cells.xy, cells.xz, axis == 1u), cells.zy, axis == 0u);
    let pixels = min(f32(size.x) / across.x, f32(size.y) / across.y);
    let at = (vec2f(pixel) + 0.5 - 0.5 * vec2f(size)) / pixels + 0.5 * across;
    let depth = clamp(position, 0.0, 1.0) * cells[axis];
    var cell = vec3f(at, depth);
    if axis == 1u {
        cell = vec3f(at.x, depth, at.y);
    } else if axis == 0u {
        cell = vec3f(depth, at.y, at.x);
    }
    cell[axis] = min(cell[axis], cells[axis] - 0.5);
    return SlicePoint(cell, all(at >= vec2f(0.0)) && all(at < across), pixels);
}

// The record of the last occupied cell at or before `cell` in its column, and whether that is the cell itself.
struct Nearest {
    record: u32,        // index, or 0xffffffff
    here: bool,
    occupied: bool,
}

fn nearest_before(grid: u32, cell: vec3u) -> Nearest {
    let base = word_index(grids[grid], vec3u(cell.xy, 0u));
    var word = cell.z >> 5u;
    var mask = 0xffffffffu >> (31u - (cell.z & 31u));
    loop {
        let bits = occupancy[base + word] & mask;
        if bits != 0u {
            let bit = firstLeadingBit(bits);
            let rank = ranks[base + word] + countOneBits(occupancy[base + word] & ((1u << bit) - 1u));
            let known = rank < grids[grid].record_capacity;
            let record = select(0xffffffffu, grids[grid].record_base + rank, known);
            return Nearest(record, word * 32u + bit == cell.z, true);
        }
        if word == 0u {
            return Nearest(0xffffffffu, false, false);
        }
        word -= 1u;
        mask = 0xffffffffu;
    }
    return Nearest(0xffffffffu, false, false);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(picture);
    if any(id.xy >= size) {
        return;
    }
    let point = slice_point(0u, compose_settings.axis, compose_settings.position, id.xy, size);
    var color = OUTSIDE;
    if point.in_slice {
        let cell = vec3u(point.cell);
        let nearest = nearest_before(0u, cell);
        let word = word_index(grids[0], cell);
        let bit = word_bit(cell.z);
        var inside = compose_settings.filled != 0u && (interior[word] & bit) != 0u;
        var surface = vec3f(1.0);
        if nearest.record != 0xffffffffu {
            let normal = unpack_unit(records[nearest.record].normal);
            surface = 0.5 + 0.5 * normal;
            if compose_settings.filled == 0u {
                // The column goes into a body where the last surface that it met faced it.
                let z0 = world_from_grid(grids[0], vec3f(point.cell.xy, 0.0));
                let z1 = world_from_grid(grids[0], vec3f(point.cell.xy, slab(grids[0], 1.0)));
                inside = dot(normal, z1 - z0) < 0.0;
            }
        }
        color = select(select(AIR, INTERIOR, inside), surface, nearest.here);
        if compose_settings.compares != 0u {
            let is_true = (truth[word - grids[0].word_base] & bit) != 0u;
            if nearest.here || is_true {
                color = difference_color(nearest.here, is_true, surface);
            }
        }
        if point.pixels >= 6.0 {
            let line = min(fract(point.cell), 1.0 - fract(point.cell)) * point.pixels;
            let across = select(line, vec3f(9.0), vec3u(0u, 1u, 2u) == vec3u(compose_settings.axis));
            color *= select(1.0, 0.75, min(across.x, min(across.y, across.z)) < 0.5);
        }
    }
    textureStore(picture, id.xy, vec4f(color, 1.0));
}

@compute @workgroup_size(8, 8)
fn light(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(picture);
    if any(id.xy >= size) {
        return;
    }
    var color = OUTSIDE;
    let grid = surroundings.lights[0].first_grid;
    if surroundings.counts.x > 0u && surroundings.lights[0].grid_count > 0u {
        let point = slice_point(grid, 2u, compose_settings.position, id.xy, size);
        if point.in_slice {
            let p_grid = vec3f(point.cell.xy, slab(grids[grid], point.cell.z));
            let p = world_from_grid(grids[grid], p_grid);
            let ahead = world_from_grid(grids[grid], vec3f(point.cell.xy, slab(grids[grid], point.cell.z + 1.0)));
            let left = grid_light(grid, p, p_grid, normalize(ahead - p));
            color = srgb_encode(left.rgb * left.a);
        }
    }
    textureStore(picture, id.xy, vec4f(color, 1.0));
}
