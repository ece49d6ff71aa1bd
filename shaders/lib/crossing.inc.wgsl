#include "lib/ray.inc.wgsl"
#include "lib/record.inc.wgsl"
#include "lib/media.inc.wgsl"
// Where a ray crosses the surface in a voxel: the planes of the voxel's records.
//
// Bind as: what `lib/ray.inc.wgsl` and `lib/media.inc.wgsl` ask for;
//          var<storage, read> ranks: array<u32>; var<storage, read> records: array<Record>;

// What the ray comes from and what it looks for.
struct Seeker {
    origin: vec3f,      // world
    direction: vec3f,   // world, unit
    t_max: f32,
    media: vec4u,
    last_part: u32,     // of the last event, at the origin
    last_front: bool,   // from which side that surface would be met again
    opaque_only: bool,
}

struct Crossing {
    found: bool,
    t: f32,             // world units from the origin
    triangle: u32,      // with the record's flags
    part: u32,
    normal: vec3f,      // the plane's, world
    front: bool,        // met from the front: the ray enters
    strange: bool,      // leaves a part that it was not in
}

// Within this many cells a second crossing of the same part from the same side is the same surface again.
const DUPLICATE_CELLS: f32 = 1.5;
// Cells within which surfaces are in one place, before the ray's origin or behind it: bodies that touch.
const TOUCHING_CELLS: f32 = 0.02;
// Cells by which a hit may lie beyond another sheet of its voxel that bounds it.
const SHEET_CELLS: f32 = 0.05;

fn no_crossing() -> Crossing {
    return Crossing(false, 0.0, 0u, 0u, vec3f(0.0), false, false);
}

// World point from fractions of a cell.
fn point_in_cell(grid: u32, ray: GridRay, walk: Walk, fraction: vec3f) -> vec3f {
    let below = ray_slab(ray, f32(walk.slice));
    let above = ray_slab(ray, f32(walk.slice + 1));
    let p = vec3f(vec2f(walk.column) + fraction.xy, mix(below, above, fraction.z));
    let h = grids[grid].world_from_grid * vec4f(p, 1.0);
    return select(h.xyz, h.xyz / h.w, perspective_rays);
}

// The crossing in the voxel where the walk stands. Of several sheets of one part a hit must lie on the solid's surface:
// within the others where they meet as a ridge, outside them where they meet as a groove (their points tell which).
// Of several hits one that fits the media comes before one that does not, then the nearest; of those in one place, one
// that enters, so that no air opens between bodies that touch.
//
// One loop: for each sheet, its own plane and then every other sheet as a bound; a voxel with one sheet takes one turn.
fn voxel_crossing(grid: u32, ray: GridRay, walk: Walk, seeker: Seeker) -> Crossing {
    var best = no_crossing();
    let bit = u32(walk.slice) & 31u;
    let rank = ranks[walk.word_index] + countOneBits(walk.word & ((1u << bit) - 1u));
    if rank >= grids[grid].record_capacity {
        return best;
    }
    let cell_size = grids[grid].cell_size;
    let touching = TOUCHING_CELLS * cell_size;
    let z0 = (ray_slab(ray, f32(walk.slice)) - ray.start.z) / ray.along.z;
    let z1 = (ray_slab(ray, f32(walk.slice + 1)) - ray.start.z) / ray.along.z;
    let s_in = max(walk.s_in, min(z0, z1)) - ray.tolerance;
    let s_out = min(min(walk.s_next.x, walk.s_next.y), max(z0, z1)) + ray.tolerance;
    let center = point_in_cell(grid, ray, walk, vec3f(0.5));

    let first = grids[grid].record_base + rank;
    var count = 1u;
    var further = 0u;
    var sheet = 0u;
    var turn = 0u;
    var hit = no_crossing();
    var hit_point = vec3f(0.0);
    loop {
        let number = (sheet + turn) % count;
        let record = records[select(further + number - 1u, first, number == 0u)];
        if number == 0u {
            count = 1u + record_extra_count(record);
            further = grids[grid].extra_base + record_extra_first(record);
        }
        let normal = unpack_unit(record.normal);
        let point = point_in_cell(grid, ray, walk, unpack_point_in_cell(record.point));
        let part = record_part(record);
        if turn == 0u {
            let cosine = dot(normal, seeker.direction);
            let front = cosine < 0.0;
            let t = dot(normal, point - seeker.origin) / cosine;
            let s = s_from_t(ray, t);
            let is_opaque = (record.triangle & RECORD_OPAQUE) != 0u;
            let within = s >= s_in && s <= s_out && t < seeker.t_max && t > -touching;
            let same = part == seeker.last_part && front == seeker.last_front && t < DUPLICATE_CELLS * cell_size;
            // Where the ray is now it has entered or left this part already.
            let is_done = t < touching && !is_opaque && front == media_has(seeker.media, part);
            let orphan = (record.triangle & RECORD_ORPHAN) != 0u;
            let wanted = select(!seeker.opaque_only, !orphan, is_opaque);
            hit.found = within && wanted && !same && !is_done;
            hit.t = t;
            hit.triangle = record.triangle;
            hit.part = part;
            hit.normal = normal;
            hit.front = front;
            hit.strange = !front && !is_opaque && !media_has(seeker.media, part);
            hit_point = point;
        } else if part == hit.part {
            let apart = point - hit_point;
            var ridge = dot(normal - hit.normal, apart);
            if abs(ridge) < SHEET_CELLS * cell_size {
                ridge = dot(hit.normal, center - hit_point) + dot(normal, center - point);
            }
            let beyond = dot(normal, seeker.origin + hit.t * seeker.direction - point);
            hit.found = hit.found && select(-beyond, beyond, ridge > 0.0) < SHEET_CELLS * cell_size;
        }
        turn += 1u;
        if turn >= count {
            let fits_better = !hit.strange && best.strange;
            let lead = touching * (f32(hit.front) - f32(best.front));
            let as_well = hit.strange == best.strange && hit.t - lead < best.t;
            if hit.found && (!best.found || fits_better || as_well) {
                best = hit;
            }
            turn = 0u;
            sheet += 1u;
            if sheet >= count {
                break;
            }
        }
    }
    return best;
}

// The first crossing along the ray; where there is none, `t` is where the ray leaves the grid.
fn first_crossing(grid: u32, seeker: Seeker) -> Crossing {
    let ray = grid_ray(grid, seeker.origin, seeker.direction);
    var hit = no_crossing();
    if ray.s_first < ray.s_last {
        var walk = walk_start(ray);
        loop {
            if !next_occupied(ray, &walk) {
                break;
            }
            hit = voxel_crossing(grid, ray, walk, seeker);
            if hit.found {
                break;
            }
            walk_on(ray, &walk);
        }
    }
    hit.t = select(t_from_s(ray, ray.s_last), hit.t, hit.found);
    return hit;
}
