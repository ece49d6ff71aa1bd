#include "lib/light_volume.inc.wgsl"
#include "lib/surroundings.inc.wgsl"
// A light on an analytic plane: one texel where each column of the light's grid meets the plane. `project` looks up what
// is left there; `spread_x` and `spread_y` widen each texel's shadow by the light's size and by how far the shadow has
// come, so that shadows are crisp at a body's foot and soft far from it.

@group(0) @binding(0) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(1) var<uniform> surroundings: Surroundings;
@group(0) @binding(2) var<uniform> plane_light_task: PlaneLightTask;
@group(0) @binding(3) var<storage, read> occupancy: array<u32>;
@group(0) @binding(4) var<storage, read> ranks: array<u32>;
@group(0) @binding(5) var<storage, read> records: array<Record>;
@group(0) @binding(6) var<storage, read> light_records: array<vec2u>;
@group(0) @binding(7) var<storage, read> materials: array<PartMaterial>;
// Darkness (what is missing) RGB and spread, in 16 bits each.
@group(0) @binding(8) var<storage, read_write> projected: array<vec2u>;
@group(0) @binding(9) var<storage, read_write> spread: array<vec2u>;
@group(0) @binding(10) var plane_light_layer: texture_storage_2d<rgba16float, write>;

struct PlaneLightTask {
    light: u32,
    grid: u32,
    plane: u32,
    _pad: u32,
}

// Reach of the spreading, texels to each side; and the largest standard deviation that it holds.
const REACH: i32 = 10;
const MAX_SPREAD: f32 = 3.5;
// A texel's own width: what makes a shadow's edge smooth where it is not soft.
const LEAST_SPREAD: f32 = 0.5;

fn pack_dark(dark: vec3f, spread_texels: f32) -> vec2u {
    return vec2u(pack2x16unorm(dark.rg), pack2x16unorm(vec2f(dark.b, spread_texels / MAX_SPREAD)));
}

// RGB, and the spread in texels.
fn unpack_dark(bits: vec2u) -> vec4f {
    return vec4f(unpack2x16unorm(bits.x), unpack2x16unorm(bits.y) * vec2f(1.0, MAX_SPREAD));
}

// World units since the light last met a record before fractional slice `at` of a column; 0 if it met none.
fn since_last_record(grid: u32, cell: vec2u, at: f32, slice_length: f32) -> f32 {
    let base = word_index(grids[grid], vec3u(cell, 0u));
    let slice = min(u32(max(at, 0.0)), grids[grid].cells.z - 1u);
    var mask = 0xffffffffu >> (31u - (slice & 31u));
    for (var word = i32(slice >> 5u); word >= 0; word--) {
        let bits = occupancy[base + u32(word)] & mask;
        if bits != 0u {
            return max(at - f32(u32(word) * 32u + firstLeadingBit(bits)), 0.0) * slice_length;
        }
        mask = 0xffffffffu;
    }
    return 0.0;
}

@compute @workgroup_size(8, 8)
fn project(@builtin(global_invocation_id) id: vec3u) {
    let grid = plane_light_task.grid;
    let cells = grids[grid].cells;
    if any(id.xy >= cells.xy) {
        return;
    }
    let center = vec2f(id.xy) + 0.5;
    let begin = world_from_grid(grids[grid], vec3f(center, 0.0));
    let along = world_from_grid(grids[grid], vec3f(center, slab(grids[grid], f32(cells.z)))) - begin;
    let slice_length = length(along) / f32(cells.z);
    let toward = along / length(along);
    // The plane is y = 0 of its own space.
    let o = (surroundings.planes[plane_light_task.plane].local_from_world * vec4f(begin, 1.0)).y;
    let d = (surroundings.planes[plane_light_task.plane].local_from_world * vec4f(toward, 0.0)).y;
    let t = -o / d;
    var dark = vec3f(0.0);
    var soft = LEAST_SPREAD;
    if t > 0.0 && t < 1e9 {
        let p = begin + t * toward;
        let at = t / slice_length;
        let left = select(ALL_LIGHT, column_light(grid, id.xy, at, p, toward, slice_length).share, vec4<bool>(at > 0.0));
        let radius = since_last_record(grid, id.xy, at, slice_length)
            * surroundings.lights[plane_light_task.light].angular_radius / cell_size_at(grid, p);
        dark = 1.0 - left.rgb * left.a;
        // A disc's standard deviation along one axis is half its radius.
        soft = clamp(0.5 * radius, LEAST_SPREAD, MAX_SPREAD);
    }
    projected[id.y * cells.x + id.x] = pack_dark(dark, soft);
}

// Darkness that reaches a texel from its row or column, each neighbour spread by its own measure; every bell sums to 1,
// so that no light is made or lost.
struct Gathered {
    dark: vec3f,
    spread: f32,        // of what arrived, weighted by its darkness
    weight: f32,
}

fn gather(sum: ptr<function, Gathered>, dark: vec4f, offset: i32) {
    let narrow = 1.0 / max(dark.a, LEAST_SPREAD);
    let x = f32(offset) * narrow;
    let share = 0.39894228 * narrow * exp(-0.5 * x * x);
    (*sum).dark += share * dark.rgb;
    let weight = share * (dark.r + dark.g + dark.b);
    (*sum).spread += weight * dark.a;
    (*sum).weight += weight;
}

@compute @workgroup_size(64)
fn spread_x(@builtin(global_invocation_id) id: vec3u) {
    let cells = vec2i(grids[plane_light_task.grid].cells.xy);
    let at = vec2i(id.xy);
    if any(at >= cells) {
        return;
    }
    var sum = Gathered(vec3f(0.0), 0.0, 0.0);
    for (var x = max(at.x - REACH, 0); x <= min(at.x + REACH, cells.x - 1); x++) {
        gather(&sum, unpack_dark(projected[at.y * cells.x + x]), x - at.x);
    }
    let spread_here = sum.spread / max(sum.weight, 1e-6);
    spread[at.y * cells.x + at.x] = pack_dark(sum.dark, spread_here);
}

@compute @workgroup_size(64)
fn spread_y(@builtin(global_invocation_id) id: vec3u) {
    let cells = vec2i(grids[plane_light_task.grid].cells.xy);
    let at = vec2i(id.xy);
    if any(at >= cells) {
        return;
    }
    var sum = Gathered(vec3f(0.0), 0.0, 0.0);
    for (var y = max(at.y - REACH, 0); y <= min(at.y + REACH, cells.y - 1); y++) {
        gather(&sum, unpack_dark(spread[y * cells.x + at.x]), y - at.y);
    }
    textureStore(plane_light_layer, at, vec4f(clamp(1.0 - sum.dark, vec3f(0.0), vec3f(1.0)), 1.0));
}
