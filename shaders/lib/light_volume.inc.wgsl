#include "lib/geometry.inc.wgsl"
#include "lib/grid.inc.wgsl"
#include "lib/light_record.inc.wgsl"
#include "lib/record.inc.wgsl"
#include "lib/surroundings.inc.wgsl"
// Looking up how much of a light is left at a point: the transparent shadow map, depth-resolved (CL §3.1).
//
// Bind as: var<uniform> grids: array<Grid, MAX_GRIDS>; var<uniform> surroundings: Surroundings;
//          var<storage, read> occupancy: array<u32>; ranks: array<u32>; records: array<Record>;
//          light_records: array<vec2u>; materials: array<PartMaterial>.
//
// The four columns nearest to the point are looked up each at the point's depth, and blended. In a column the last
// record before that depth says what was left at the end of its voxel and in which medium the light went on.

const SHADOW_NONE: u32 = 0u;
const SHADOW_LINEAR: u32 = 1u;
const SHADOW_BEER_LAMBERT: u32 = 2u;

// Red, green, blue by absorption alone, and what the surfaces' reflection leaves.
const ALL_LIGHT: vec4f = vec4f(1.0);

// What `length` world units of `medium` leave of `share`; a negative length goes back to where more was left.
fn light_absorbed(share: vec3f, medium: u32, length: f32) -> vec3f {
    if medium == LIGHT_NO_MEDIUM {
        return share;
    }
    let depth = materials[medium].sigma * length;
    let linear = surroundings.counts.w == SHADOW_LINEAR;
    return clamp(select(share * exp(-depth), share - depth, linear), vec3f(0.0), vec3f(1.0));
}

struct ColumnLight {
    share: vec4f,
    questionable: bool,
}

// What is left where a lamp's column has met no record yet. A lamp may stand in glass: then what comes next is a surface
// that the light leaves by.
fn light_at_start(grid: u32, cell: vec2u, slice: u32, at: f32, toward: vec3f, slice_length: f32) -> ColumnLight {
    let words = grids[grid].words_per_column;
    let base = grids[grid].word_base + (cell.y * grids[grid].cells.x + cell.x) * words;
    var mask = 0xffffffffu << (slice & 31u);
    for (var word = slice >> 5u; word < words; word++) {
        let bits = occupancy[base + word] & mask;
        mask = 0xffffffffu;
        if bits == 0u {
            continue;
        }
        let rank = ranks[base + word] + countOneBits(occupancy[base + word] & ((bits & (~bits + 1u)) - 1u));
        if rank < grids[grid].record_capacity {
            let record = records[grids[grid].record_base + rank];
            let clear = (materials[record_part(record)].flags & (FLAG_OPAQUE | FLAG_THIN_WALL)) == 0u;
            if clear && dot(unpack_unit(record.normal), toward) > 0.3 {
                let n = f32(grids[grid].cells.z);
                let before = n * grids[grid].near / (grids[grid].far - grids[grid].near);
                let left = light_absorbed(vec3f(1.0), record_part(record), (before + at) * slice_length);
                return ColumnLight(vec4f(left, 1.0), false);
            }
        }
        break;
    }
    return ColumnLight(ALL_LIGHT, false);
}

// What is left in the column `cell` of `grid` at fractional slice `at`; `p` is the point there, by which it is told on
// which side of a record in its own voxel it lies. `slice_length`: world units of the light's way in one slice.
fn column_light(grid: u32, cell: vec2u, at: f32, p: vec3f, toward: vec3f, slice_length: f32) -> ColumnLight {
    let words = grids[grid].words_per_column;
    let base = grids[grid].word_base + (cell.y * grids[grid].cells.x + cell.x) * words;
    let slice = min(u32(at), grids[grid].cells.z - 1u);
    var word = slice >> 5u;
    var mask = 0xffffffffu >> (31u - (slice & 31u));
    loop {
        let all_bits = occupancy[base + word];
        let bits = all_bits & mask;
        if bits == 0u {
            if word == 0u {
                break;
            }
            word -= 1u;
            mask = 0xffffffffu;
            continue;
        }
        let bit = firstLeadingBit(bits);
        mask = (1u << bit) - 1u;
        let rank = ranks[base + word] + countOneBits(all_bits & mask);
        if rank >= grids[grid].record_capacity {
            continue;
        }
        let found = word * 32u + bit;
        let index = grids[grid].record_base + rank;
        let left = unpack_light_record(light_records[index]);
        let beyond = (at - f32(found + 1u)) * slice_length;
        if beyond < 0.0 {
            // In the voxel itself: is the point before the surface or behind it, as the light goes?
            let record = records[index];
            let fraction = unpack_point_in_cell(record.point);
            let z = mix(slab(grids[grid], f32(found)), slab(grids[grid], f32(found + 1u)), fraction.z);
            let normal = unpack_unit(record.normal);
            let offset = p - world_from_grid(grids[grid], vec3f(vec2f(cell) + fraction.xy, z));
            if dot(offset, normal) * dot(toward, normal) < 0.0 {
                continue;
            }
        }
        return ColumnLight(vec4f(light_absorbed(left.absorption, left.medium, beyond), left.surfaces), left.questionable);
    }
    if grids[grid].projection == PERSPECTIVE {
        return light_at_start(grid, cell, slice, at, toward, slice_length);
    }
    return ColumnLight(ALL_LIGHT, false);
}

// What is left at `p` in one grid of a light, at grid position `p_grid`. `toward` is the way the light travels, unit.
fn grid_light(grid: u32, p: vec3f, p_grid: vec3f, toward: vec3f) -> vec4f {
    var slice_length = grids[grid].cell_size;
    if grids[grid].projection == PERSPECTIVE {
        let begin = world_from_grid(grids[grid], vec3f(p_grid.xy, 0.0));
        let end = world_from_grid(grids[grid], vec3f(p_grid.xy, slab(grids[grid], f32(grids[grid].cells.z))));
        slice_length = distance(begin, end) / f32(grids[grid].cells.z);
    }
    return columns_light(grid, p_grid.xy, slice_of(grids[grid], p_grid.z), p, toward, slice_length);
}

// The same at `across` (cells) and at fractional slice `at`: the four nearest columns, blended.
fn columns_light(grid: u32, across: vec2f, at: f32, p: vec3f, toward: vec3f, slice_length: f32) -> vec4f {
    if at <= 0.0 {
        return ALL_LIGHT;
    }
    let cells = vec2i(grids[grid].cells.xy);
    let corner = floor(across - 0.5);
    let f = across - 0.5 - corner;
    var sum = vec4f(0.0);
    var weights = 0.0;
    var doubtful_sum = vec4f(0.0);
    for (var i = 0; i < 4; i++) {
        let step = vec2i(i & 1, i >> 1u);
        let weight = select(1.0 - f.x, f.x, step.x == 1) * select(1.0 - f.y, f.y, step.y == 1);
        let cell = clamp(vec2i(corner) + step, vec2i(0), cells - 1);
        let here = column_light(grid, vec2u(cell), at, p, toward, slice_length);
        // Columns whose crossings don't pair up count only where there are no better ones.
        let good = select(weight, 0.0, here.questionable);
        sum += good * here.share;
        weights += good;
        doubtful_sum += weight * here.share;
    }
    if weights < 0.05 {
        return doubtful_sum;
    }
    return sum / weights;
}

// World size of a cell near `p`.
fn cell_size_at(grid: u32, p: vec3f) -> f32 {
    if grids[grid].projection == ORTHOGRAPHIC {
        return grids[grid].cell_size;
    }
    let depth = (grids[grid].grid_from_world * vec4f(p, 1.0)).w;
    return grids[grid].cell_size * depth / (0.5 * (grids[grid].near + grids[grid].far));
}

const NO_GRID: u32 = 0xffffffffu;

// Where a light's grids hold a point.
struct LightPlace {
    grid: u32,          // or NO_GRID: nothing shadows it
    p: vec3f,           // the point, clear of its own surface
    p_grid: vec3f,      // the same in the grid's space; across it lies within
}

fn light_place(light: u32, p: vec3f, n: vec3f) -> LightPlace {
    let first = surroundings.lights[light].first_grid;
    for (var i = 0u; i < surroundings.lights[light].grid_count; i++) {
        // Clear of the surface's own voxels: as far as the blended columns may lie beside the point.
        let cosine = dot(n, light_travel(light, p));
        let slant = sqrt(max(1.0 - cosine * cosine, 0.0));
        let q = p + n * (cell_size_at(first + i, p) * (0.4 + 1.2 * slant));
        let h = grids[first + i].grid_from_world * vec4f(q, 1.0);
        let q_grid = h.xyz / h.w;
        let inside = q_grid.xy >= vec2f(0.0) & q_grid.xy <= vec2f(grids[first + i].cells.xy);
        if h.w > 0.0 && all(inside) {
            return LightPlace(first + i, q, q_grid);
        }
    }
    return LightPlace(NO_GRID, p, vec3f(0.0));
}

// The way a light travels at `p`, unit.
fn light_travel(light: u32, p: vec3f) -> vec3f {
    if surroundings.lights[light].kind == LIGHT_DIRECTIONAL {
        return surroundings.lights[light].direction;
    }
    return normalize(p - surroundings.lights[light].position);
}

// What is left of light number `light` at `p`: RGB by absorption alone, and what the surfaces leave.
fn light_left(light: u32, p: vec3f, n: vec3f) -> vec4f {
    if surroundings.counts.w == SHADOW_NONE {
        return ALL_LIGHT;
    }
    let place = light_place(light, p, n);
    if place.grid == NO_GRID {
        return ALL_LIGHT;
    }
    return grid_light(place.grid, place.p, place.p_grid, light_travel(light, place.p));
}

// What is left of light number `light` at `p`, RGB: absorption and the surfaces' reflection. `n` is the surface's
// normal on the side to be lit, by which an opaque surface keeps clear of its own voxels; zero for what is in no grid.
fn light_transmittance(light: u32, p: vec3f, n: vec3f) -> vec3f {
    let left = light_left(light, p, n);
    return left.rgb * left.a;
}

// As `light_transmittance`, absorption alone: what the channel `ground-light` shows.
fn light_absorption(light: u32, p: vec3f, n: vec3f) -> vec3f {
    return light_left(light, p, n).rgb;
}
