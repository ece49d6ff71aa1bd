#include "lib/back_face.inc.wgsl"
#include "lib/crossing.inc.wgsl"
#include "lib/event.inc.wgsl"
#include "lib/path_store.inc.wgsl"
#include "lib/steps.inc.wgsl"
// Two-surface refraction (CL §3.2.1, Fig. 5, Eq. 2): bent where it enters, by T1; then as far along T1 as the body is
// thick along the *unbent* ray (Fig. 3); and bent there by the normal of the back face that the camera has there: P2 as
// projected into the voxel space.
//
// The first surface is the rasterized triangle, or the first boundary voxel by fixed steps (`first_is_voxel`).

@group(0) @binding(0) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(1) var<storage, read> indices: array<u32>;
@group(0) @binding(2) var<storage, read> materials: array<PartMaterial>;
@group(0) @binding(3) var<storage, read> occupancy: array<u32>;
@group(0) @binding(4) var<storage, read> ranks: array<u32>;
@group(0) @binding(5) var<storage, read> records: array<Record>;
@group(0) @binding(6) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(7) var<uniform> surroundings: Surroundings;
@group(0) @binding(8) var<uniform> settings: MarchSettings;
@group(0) @binding(9) var first_triangle: texture_2d<u32>;
@group(0) @binding(10) var path_place: texture_storage_2d<rgba32float, write>;
@group(0) @binding(11) var path_way: texture_storage_2d<rgba32float, write>;
@group(0) @binding(12) var path_depth: texture_storage_2d<rgba32uint, write>;
@group(0) @binding(13) var path_first: texture_storage_2d<rgba32float, write>;
@group(0) @binding(14) var<storage, read_write> questionable: array<atomic<u32>>;

override first_is_voxel: bool = false;

// Surfaces along the unbent ray that count for the thickness.
const MAX_SHEETS: u32 = 16u;

struct First {
    found: bool,
    at: Surface,
    triangle: u32,
}

fn first_surface(pixel: vec2u, ray: Ray) -> First {
    var first: First;
    if first_is_voxel {
        let line = grid_ray(VIEW, ray.origin, ray.direction);
        var steps = steps_from(line, line.s_first, 0.5);
        first.found = next_boundary_voxel(line, &steps);
        if first.found {
            let record = record_at(VIEW, steps);
            let normal = unpack_unit(record.normal);
            first.at = Surface(t_from_s(line, steps.s), normal, true, record_part(record));
            first.triangle = record.triangle & RECORD_TRIANGLE_MASK;
        }
    } else {
        let number = textureLoad(first_triangle, pixel, 0).x;
        first.found = number != 0u;
        if first.found {
            first.triangle = number - 1u;
            first.at = surface_at(first.triangle, ray.origin, ray.direction, 1.0, 0.0, 0.0);
            if (materials[first.at.part].flags >> OPERAND_SHIFT) != 0u {
                // It may not be its body's surface: that is walked to.
                let seeker = Seeker(ray.origin, ray.direction, 1e30, vec4u(0u), NO_PART, false, false);
                let hit = first_crossing(VIEW, seeker);
                first.found = hit.found;
                first.triangle = hit.triangle & RECORD_TRIANGLE_MASK;
                let slack = 0.3 * grids[VIEW].cell_size;
                let shaded = surface_at(first.triangle, ray.origin, ray.direction, hit.t, hit.t, slack).normal;
                first.at = Surface(hit.t, shaded, hit.front, hit.part);
                first.at.normal = select(shaded, -shaded, dot(shaded, hit.normal) < 0.0);
            }
        }
    }
    return first;
}

// Length inside glass along a straight ray that starts on the front of `part`, where its normal is `normal`; negative
// where it does not add up.
fn thickness_along(origin: vec3f, direction: vec3f, part: u32, normal: vec3f) -> f32 {
    var sum = 0.0;
    var inside = true;
    if first_is_voxel {
        let line = grid_ray(VIEW, origin, direction);
        var steps = steps_from(line, 0.0, 1.0);
        var last_normal = normal;
        var entered_at = 0.0;
        while next_boundary_voxel(line, &steps) {
            let normal_here = unpack_unit(record_at(VIEW, steps).normal);
            if dot(normal_here, last_normal) < settings.cos_angle_threshold {
                let t = t_from_s(line, steps.s);
                sum += select(0.0, t - entered_at, inside);
                entered_at = t;
                inside = !inside;
                last_normal = normal_here;
            }
        }
    } else {
        var at = origin;
        var last_part = part;
        var last_front = true;
        var media = media_enter(vec4u(0u), part);
        for (var i = 0u; i < MAX_SHEETS; i++) {
            let hit = first_crossing(VIEW, Seeker(at, direction, 1e30, media, last_part, last_front, false));
            if !hit.found {
                break;
            }
            sum += select(hit.t, 0.0, all(media == vec4u(0u)));
            media = select(media_leave(media, hit.part), media_enter(media, hit.part), hit.front);
            at += hit.t * direction;
            last_part = hit.part;
            last_front = hit.front;
        }
        inside = any(media != vec4u(0u));
    }
    return select(sum, -sum, inside);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let pixel = vec2u(id.x, settings.rows.x + id.y);
    if pixel.x >= settings.size.x || pixel.y >= settings.rows.y {
        return;
    }
    var ray = ray_from_eye(surroundings.eye, view_direction(picture_from_pixel(pixel, settings.size)));
    var path = clear_path(ray.origin, ray.direction);
    let first = first_surface(pixel, ray);
    if first.found && first.at.t <= ray.t_plane {
        path.first_t = first.at.t;
        path.first_normal = first.at.normal;
        path.first_part = first.at.part + 1u;
        path.first_front = true;
        let unbent = ray.direction;
        var at = first.at;
        at.front = true;
        if !meet(&ray, &path, at, false) {
            path.triangle = select(path.triangle, first.triangle, path.t_end >= 0.0);
        } else if any(ray.media != vec4u(0u)) {
            let thickness = thickness_along(ray.origin, unbent, at.part, at.normal);
            path.questionable = thickness <= 0.0;
            let place = ray.origin + abs(thickness) * ray.direction;
            let back = back_face(VIEW, place, normalize(place - surroundings.eye));
            path.questionable = path.questionable || !back.found;
            let outward = select(-back.normal, back.normal, dot(back.normal, ray.direction) > 0.0);
            meet(&ray, &path, Surface(abs(thickness), outward, false, at.part), false);
        }
    }
    store_path(pixel, path);
}
