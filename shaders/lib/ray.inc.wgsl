#include "lib/grid.inc.wgsl"
// A straight ray in grid space, and the walk along it from one occupied voxel to the next.
//
// Bind as: var<uniform> grids: array<Grid, MAX_GRIDS>; var<storage, read> occupancy: array<u32>;
//
// A ray origin + t·direction (world) is start + s·along in grid space, in a perspective grid too, where
// s = t·w / (w + t·w_along): the map is projective. Slices are where z_grid = k·a / (b + k·c): `slab` in one formula
// for both projections (a = b = 1, c = 0 when orthographic), so that nothing here branches.
//
// Where all columns of a perspective grid meet there is no grid space: a ray that comes from there (the eye's own rays do)
// has its start moved on by `skipped`.

// Whether rays may go through a perspective grid. Shaders that know that none does leave out its divisions.
override perspective_rays: bool = true;

struct GridRay {
    start: vec3f,       // grid space
    skipped: f32,       // t of the start
    w: f32,
    along: vec3f,       // grid space for each unit of s
    w_along: f32,
    slab: vec3f,        // a, b, c
    tolerance: f32,     // Grid.tolerance, in s
    s_first: f32,       // where the ray enters the grid, or 0
    s_last: f32,        // where it leaves; less than s_first where it misses
    cells: vec3i,
    word_base: u32,
    words_per_column: u32,
}

// Where a walk stands: in a column, at a slice.
struct Walk {
    column: vec2i,
    slice: i32,
    s_in: f32,          // where the ray entered the column
    s_next: vec2f,      // where it meets the next column boundary of each axis
    word: u32,          // the last word looked at
    word_index: u32,    // its number
}

fn grid_ray(grid: u32, origin: vec3f, direction: vec3f) -> GridRay {
    let near = grids[grid].near;
    let far = grids[grid].far;
    let d = grids[grid].grid_from_world * vec4f(direction, 0.0);
    var o = grids[grid].grid_from_world * vec4f(origin, 1.0);
    var ray: GridRay;
    // Half way to the first slice, in depth.
    let in_perspective = perspective_rays & (grids[grid].projection == PERSPECTIVE);
    let comes_from_apex = in_perspective & (o.w < 0.5 * near) & (d.w > 1e-6);
    ray.skipped = select(0.0, (0.5 * near - o.w) / d.w, comes_from_apex);
    o += ray.skipped * d;
    ray.start = select(o.xyz, o.xyz / o.w, perspective_rays);
    ray.w = o.w;
    ray.w_along = d.w;
    let along = select(d.xyz, (d.xyz * o.w - o.xyz * d.w) / (o.w * o.w), perspective_rays);
    // No component is exactly zero, so that divisions by them stay finite.
    ray.along = select(along, vec3f(1e-9), abs(along) < vec3f(1e-9));
    ray.cells = vec3i(grids[grid].cells);
    ray.word_base = grids[grid].word_base;
    ray.words_per_column = grids[grid].words_per_column;
    // No `if` on what is uniform alone: lavapipe would compile the pass anew at every dispatch, to fold it.
    let slab = vec3f(far, near, (far - near) / f32(ray.cells.z));
    ray.slab = select(vec3f(1.0, 1.0, 0.0), slab, grids[grid].projection == PERSPECTIVE);
    let cells_per_s = max(abs(ray.along.x), max(abs(ray.along.y), abs(ray.along.z)));
    ray.tolerance = grids[grid].tolerance / cells_per_s;
    let size = vec3f(ray.cells);
    let t0 = -ray.start / ray.along;
    let t1 = (size - ray.start) / ray.along;
    let lo = min(t0, t1);
    let hi = max(t0, t1);
    // A hair inside, so that rounding never walks into a column beyond the grid.
    let hair = 1e-3 / cells_per_s;
    ray.s_first = max(max(lo.x, lo.y), max(lo.z, -hair)) + hair;
    ray.s_last = min(min(hi.x, hi.y), hi.z) - hair;
    return ray;
}

fn t_from_s(ray: GridRay, s: f32) -> f32 {
    return select(s, ray.skipped + s * ray.w / (ray.w - s * ray.w_along), perspective_rays);
}

fn s_from_t(ray: GridRay, t: f32) -> f32 {
    let from_start = t - ray.skipped;
    return select(t, from_start * ray.w / (ray.w + from_start * ray.w_along), perspective_rays);
}

// Grid-space z of the boundary below slice k.
fn ray_slab(ray: GridRay, k: f32) -> f32 {
    return select(k, k * ray.slab.x / (ray.slab.y + k * ray.slab.z), perspective_rays);
}

// The slice that the ray is in at s, kept within the grid.
fn slice_at(ray: GridRay, s: f32) -> i32 {
    let z = ray.start.z + s * ray.along.z;
    let k = select(z, z * ray.slab.y / (ray.slab.x - z * ray.slab.z), perspective_rays);
    return clamp(i32(floor(k)), 0, ray.cells.z - 1);
}

// The walk at the ray's first point in the grid. Only where s_first < s_last.
fn walk_start(ray: GridRay) -> Walk {
    var walk: Walk;
    let p = ray.start.xy + ray.s_first * ray.along.xy;
    walk.column = clamp(vec2i(floor(p)), vec2i(0), ray.cells.xy - 1);
    walk.slice = slice_at(ray, ray.s_first);
    walk.s_in = ray.s_first;
    let boundary = vec2f(walk.column) + select(vec2f(0.0), vec2f(1.0), ray.along.xy > vec2f(0.0));
    walk.s_next = (boundary - ray.start.xy) / ray.along.xy;
    walk.word = 0u;
    walk.word_index = 0u;
    return walk;
}

// Moves on to the first occupied voxel at or after the walk's slice and returns true, or false where the ray leaves the
// grid first. A word's worth of a column (32 slices) is looked at in one step.
fn next_occupied(ray: GridRay, walk: ptr<function, Walk>) -> bool {
    let up = ray.along.z > 0.0;
    let step = select(vec2i(-1), vec2i(1), ray.along.xy > vec2f(0.0));
    let s_step = abs(1.0 / ray.along.xy);
    var w = *walk;
    var found = false;
    loop {
        let s_out = min(min(w.s_next.x, w.s_next.y), ray.s_last);
        let slice_out = slice_at(ray, s_out);
        let number = w.slice >> 5u;
        let base = number << 5u;
        let lo = max(min(w.slice, slice_out), base);
        let hi = min(max(w.slice, slice_out), base + 31);
        let passed = select(slice_out > w.slice, slice_out < w.slice, up);
        let mask = (0xffffffffu << u32(lo - base)) & (0xffffffffu >> u32(31 + base - hi));
        w.word_index = ray.word_base + u32(w.column.y * ray.cells.x + w.column.x) * ray.words_per_column + u32(number);
        w.word = occupancy[w.word_index];
        let bits = select(w.word & mask, 0u, passed);
        if bits != 0u {
            w.slice = base + i32(select(firstLeadingBit(bits), firstTrailingBit(bits), up));
            found = true;
            break;
        }
        if !passed && (slice_out >> 5u) != number {
            w.slice = select(base - 1, base + 32, up);
        } else {
            if s_out >= ray.s_last {
                break;
            }
            let x_first = w.s_next.x <= w.s_next.y;
            w.column += select(vec2i(0, step.y), vec2i(step.x, 0), x_first);
            w.s_next += select(vec2f(0.0, s_step.y), vec2f(s_step.x, 0.0), x_first);
            w.s_in = s_out;
            w.slice = slice_out;
        }
    }
    *walk = w;
    return found;
}

// Leaves the voxel that the walk found.
fn walk_on(ray: GridRay, walk: ptr<function, Walk>) {
    (*walk).slice += select(-1, 1, ray.along.z > 0.0);
}
