#include "lib/compose_settings.inc.wgsl"
#include "lib/difference.inc.wgsl"
#include "lib/grid.inc.wgsl"
#include "lib/record.inc.wgsl"
#include "lib/surroundings.inc.wgsl"
// The view grid's voxels as cubes: walks each pixel's ray from cell to cell and shows the first occupied one, coloured
// by its record's normal, its faces shaded and its edges drawn. Held against the true voxels, those that are missing are
// shown too, in a colour of their own, as the spurious ones are.

@group(0) @binding(0) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(1) var<uniform> surroundings: Surroundings;
@group(0) @binding(2) var<storage, read> occupancy: array<u32>;
@group(0) @binding(3) var<storage, read> ranks: array<u32>;
@group(0) @binding(4) var<storage, read> records: array<Record>;
@group(0) @binding(6) var<storage, read> large_triangles: array<u32>;   // a bit a triangle
@group(0) @binding(5) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(7) var<uniform> compose_settings: ComposeSettings;
@group(0) @binding(8) var<storage, read> truth: array<u32>;

const VIEW: u32 = 0u;
const EMPTY: vec3f = vec3f(0.13, 0.13, 0.15);
const SMALL: vec3f = vec3f(1.0, 0.72, 0.30);
const LARGE: vec3f = vec3f(0.32, 0.56, 1.0);
const UNRESOLVED: vec3f = vec3f(0.8, 0.1, 0.5);

// Part of a ray where a + t·b ≥ 0.
fn clipped(range: vec2f, a: f32, b: f32) -> vec2f {
    if abs(b) < 1e-12 {
        return select(vec2f(1.0, 0.0), range, a >= 0.0);
    }
    let t = -a / b;
    return select(vec2f(range.x, min(range.y, t)), vec2f(max(range.x, t), range.y), b > 0.0);
}

// A cube's record; none at or above the capacity.
fn rank_of(cell: vec3i) -> u32 {
    let word = word_index(grids[VIEW], vec3u(cell));
    return ranks[word] + countOneBits(occupancy[word] & (word_bit(u32(cell.z)) - 1u));
}

fn is_marked(cell: vec3i) -> bool {
    return (occupancy[word_index(grids[VIEW], vec3u(cell))] & word_bit(u32(cell.z))) != 0u;
}

fn is_true(cell: vec3i) -> bool {
    let word = word_index(grids[VIEW], vec3u(cell)) - grids[VIEW].word_base;
    return compose_settings.compares != 0u && (truth[word] & word_bit(u32(cell.z))) != 0u;
}

fn normal_color(cell: vec3i) -> vec3f {
    let rank = rank_of(cell);
    var color = UNRESOLVED;
    if rank < grids[VIEW].record_capacity {
        color = 0.5 + 0.5 * unpack_unit(records[grids[VIEW].record_base + rank].normal);
    }
    if compose_settings.compares != 0u {
        color = difference_color(is_marked(cell), is_true(cell), color);
    }
    return color;
}

fn class_color(cell: vec3i) -> vec3f {
    let rank = rank_of(cell);
    if rank >= grids[VIEW].record_capacity {
        return UNRESOLVED;
    }
    let record = records[grids[VIEW].record_base + rank];
    if (record.triangle & RECORD_ORPHAN) != 0u {
        return UNRESOLVED;
    }
    let triangle = record_triangle(record);
    return select(SMALL, LARGE, (large_triangles[triangle >> 5u] >> (triangle & 31u) & 1u) != 0u);
}

// A cube's colour where a ray meets it, its faces shaded and its edges drawn.
fn shaded(color: vec3f, cell: vec3i, axis: u32, p: vec3f) -> vec3f {
    let low = vec3f(vec2f(cell.xy), slab(grids[VIEW], f32(cell.z)));
    let high = vec3f(vec2f(cell.xy) + 1.0, slab(grids[VIEW], f32(cell.z) + 1.0));
    var inset = min((p - low) / (high - low), (high - p) / (high - low));
    inset[axis] = 0.5;
    let edge = smoothstep(0.0, 0.09, min(inset.x, min(inset.y, inset.z)));
    let shade = select(select(0.95, 0.82, axis == 1u), 0.66, axis == 0u);
    return color * shade * mix(0.6, 1.0, edge);
}

// The first cube that a ray meets.
struct Cube {
    cell: vec3i,
    axis: u32,      // of the face that it is met by
    p: vec3f,       // grid space
    is_met: bool,
}

fn first_cube(direction: vec3f) -> Cube {
    let none = Cube(vec3i(0), 0u, vec3f(0.0), false);
    // The ray in homogeneous grid space; lines stay straight.
    let a = grids[VIEW].grid_from_world * vec4f(surroundings.eye, 1.0);
    let b = grids[VIEW].grid_from_world * vec4f(direction, 0.0);
    let top = vec3f(vec2f(grids[VIEW].cells.xy), slab(grids[VIEW], f32(grids[VIEW].cells.z)));
    var range = clipped(vec2f(1e-4, 1e6), a.w - 1e-6, b.w);
    for (var i = 0u; i < 3u; i++) {
        range = clipped(range, a[i], b[i]);
        range = clipped(range, top[i] * a.w - a[i], top[i] * b.w - b[i]);
    }
    if range.x >= range.y {
        return none;
    }
    let h0 = a + range.x * b;
    let h1 = a + range.y * b;
    let start = h0.xyz / h0.w;
    let along = h1.xyz / h1.w - start;
    let last = vec3i(grids[VIEW].cells) - 1;
    let first = vec3f(start.xy, slice_of(grids[VIEW], start.z));
    var cell = clamp(vec3i(floor(first)), vec3i(0), last);
    let step = select(vec3i(-1), vec3i(1), along >= vec3f(0.0));
    // The face by which the ray comes into the grid.
    let outside = min(start, top - start);
    var axis = select(select(2u, 1u, outside.y <= outside.z), 0u, outside.x <= min(outside.y, outside.z));
    var u = 0.0;
    let most = grids[VIEW].cells.x + grids[VIEW].cells.y + grids[VIEW].cells.z;
    for (var i = 0u; i < most; i++) {
        if is_marked(cell) || is_true(cell) {
            return Cube(cell, axis, start + u * along, true);
        }
        let face = vec3f(vec2f(cell.xy + max(step.xy, vec2i(0))), slab(grids[VIEW], f32(cell.z + max(step.z, 0))));
        let next = select((face - start) / along, vec3f(2.0), abs(along) < vec3f(1e-9));
        axis = select(select(2u, 1u, next.y <= next.z), 0u, next.x <= min(next.y, next.z));
        u = next[axis];
        cell[axis] += step[axis];
        if u > 1.0 || !in_grid(grids[VIEW], cell) {
            break;
        }
    }
    return none;
}

fn ray_of(pixel: vec2u) -> vec3f {
    return view_direction((vec2f(pixel) + 0.5) / vec2f(textureDimensions(picture)));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(picture)) {
        return;
    }
    let cube = first_cube(ray_of(id.xy));
    var color = EMPTY;
    if cube.is_met {
        color = shaded(normal_color(cube.cell), cube.cell, cube.axis, cube.p);
    }
    textureStore(picture, id.xy, vec4f(color, 1.0));
}

// The same by the way that a cube's triangle was marked.
@compute @workgroup_size(8, 8)
fn classes(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(picture)) {
        return;
    }
    let cube = first_cube(ray_of(id.xy));
    var color = EMPTY;
    if cube.is_met {
        color = shaded(class_color(cube.cell), cube.cell, cube.axis, cube.p);
    }
    textureStore(picture, id.xy, vec4f(color, 1.0));
}
