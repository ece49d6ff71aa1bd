#include "lib/ray.inc.wgsl"
#include "lib/record.inc.wgsl"
// The back face behind a point: along the line of sight through it, whichever comes nearest before it or beyond it.
//
// Bind as: what `lib/ray.inc.wgsl` asks for; var<storage, read> ranks: array<u32>; records: array<Record>.

struct BackFace {
    found: bool,
    distance: f32,      // world units
    normal: vec3f,      // outward, world
}

// The first voxel along `direction` with a sheet that faces away along `view`.
fn back_face_along(grid: u32, p: vec3f, direction: vec3f, view: vec3f) -> BackFace {
    let ray = grid_ray(grid, p, direction);
    if ray.s_first >= ray.s_last {
        return BackFace(false, 0.0, view);
    }
    var walk = walk_start(ray);
    loop {
        if !next_occupied(ray, &walk) {
            break;
        }
        let below = walk.word & ((1u << (u32(walk.slice) & 31u)) - 1u);
        let rank = ranks[walk.word_index] + countOneBits(below);
        if rank < grids[grid].record_capacity {
            let first = records[grids[grid].record_base + rank];
            var record = first;
            for (var i = 0u; i <= record_extra_count(first); i++) {
                let normal = unpack_unit(record.normal);
                if dot(normal, view) > 0.0 {
                    let away = world_from_grid(grids[grid], vec3f(vec2f(walk.column) + 0.5, ray_slab(ray, f32(walk.slice) + 0.5)));
                    return BackFace(true, distance(away, p), normal);
                }
                record = records[grids[grid].extra_base + record_extra_first(first) + min(i, record_extra_count(first) - 1u)];
            }
        }
        walk_on(ray, &walk);
    }
    return BackFace(false, 0.0, view);
}

// `view` is the way of the line of sight, unit.
fn back_face(grid: u32, p: vec3f, view: vec3f) -> BackFace {
    let beyond = back_face_along(grid, p, view, view);
    let before = back_face_along(grid, p, -view, view);
    if before.found && (!beyond.found || before.distance < beyond.distance) {
        return before;
    }
    return beyond;
}
