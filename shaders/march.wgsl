#include "lib/crossing.inc.wgsl"
#include "lib/event.inc.wgsl"
#include "lib/eye_media.inc.wgsl"
#include "lib/march_settings.inc.wgsl"
#include "lib/path_store.inc.wgsl"
#include "lib/refract.inc.wgsl"
#include "lib/surface.inc.wgsl"
#include "lib/neighbors.inc.wgsl"
#include "lib/surroundings.inc.wgsl"
// Follows each pixel's ray through the glass: bent at every surface (CL §3.2.2, Eq. 4), at the first alone, or nowhere
// (CL §3.3). The first surface is rasterized; the others are where the ray crosses the planes of the grid's records.
//
// A thread takes the pixels of a short column one after the other. One turn of its loop is an event and the walk to the
// next surface, and as soon as one path ends the next begins: on machines that run several threads in step no thread
// waits for its neighbours' longest path.

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
@group(0) @binding(15) var<storage, read> neighbors: array<u32>;
@group(0) @binding(14) var<storage, read_write> questionable: array<atomic<u32>>;

// Cells by which a walk goes on behind a crossing that is none.
const PAST_CELLS: f32 = 0.03;

// Whether the eye is in the view's grid, and so may be in glass.
override eye_inside: bool = false;
// Pixels of a column that one thread takes.
override pixels_per_thread: u32 = 8u;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let eye = surroundings.eye;
    let contact = CONTACT_CELLS * grids[VIEW].cell_size;
    let row_first = settings.rows.x + id.y * pixels_per_thread;
    let row_last = select(row_first, min(row_first + pixels_per_thread, settings.rows.y), id.x < settings.size.x);
    var row = row_first;

    var eye_media = vec4u(0u);
    if eye_inside {
        eye_media = media_at_eye(eye);
    }
    let eye_part = media_ruling(eye_media);

    var running = false;
    var pixel = vec2u(0u);
    var ray: Ray;
    var path: Path;
    var ahead = no_crossing();      // what the ray meets next; at first the rasterized triangle
    var walked = false;             // or what a walk from the eye finds, where that may not be its body's surface
    loop {
        // The next pixel that sees a triangle. The others need no path.
        while !running && row < row_last {
            pixel = vec2u(id.x, row);
            row += 1u;
            let number = textureLoad(first_triangle, pixel, 0).x;
            if number != 0u {
                running = true;
                ahead = no_crossing();
                ahead.triangle = number - 1u;
                ray = ray_from_eye(eye, view_direction(picture_from_pixel(pixel, settings.size)));
                path = clear_path(eye, ray.direction);
                if eye_inside && eye_part != NO_PART {
                    ray.media = eye_media;
                    ray.ior = materials[eye_part].ior;
                    ray.sigma = select(vec3f(0.0), materials[eye_part].sigma, settings.absorb != 0u);
                }
                walked = (materials[vertices[indices[3u * ahead.triangle]].part].flags >> OPERAND_SHIFT) != 0u;
                if walked {
                    let seeker = Seeker(eye, ray.direction, 1e30, ray.media, NO_PART, false, false);
                    ahead = first_crossing(VIEW, seeker);
                    running = ahead.found;
                    if !running {
                        store_path(pixel, path);
                    }
                }
            }
        }
        if !running {
            break;
        }

        // The event.
        let is_first = path.first_part == 0u;
        let rasterized = is_first && !walked;
        let orphan = (ahead.triangle & RECORD_ORPHAN) != 0u;
        let met = triangle_met(ahead.triangle & RECORD_TRIANGLE_MASK, ray.origin, ray.direction, rasterized || orphan);
        let slack = select(PLANE_SLACK_CELLS, TRIANGLE_SLACK_CELLS, met.inside) * grids[VIEW].cell_size;
        let t_near = select(ahead.t, 1.0, rasterized);
        let t_far = select(ahead.t, 0.0, rasterized);
        var at = surface_at(met.triangle, ray.origin, ray.direction, t_near, t_far,
                            select(slack, 0.0, rasterized));
        if !rasterized {
            at.part = ahead.part;
            at.normal = select(at.normal, -at.normal, dot(at.normal, ahead.normal) < 0.0);
            at.front = ahead.front;
        }
        if orphan {
            at.t = ahead.t;
            at.normal = ahead.normal;
        }
        let strange = ahead.strange || (is_first && !at.front && !media_has(ray.media, at.part));
        var ends = false;
        let is_thin = (materials[at.part].flags & FLAG_THIN_WALL) != 0u;
        let passes_by = !rasterized && !orphan && (met.turns || (met.ends && is_thin)) && ray.t_plane > ahead.t;
        if is_first && !passes_by {
            path.first_t = at.t;
            path.first_normal = at.normal;
            path.first_part = at.part + 1u;
            // What a surface within glass mirrors is not drawn.
            path.first_front = at.front && all(ray.media == vec4u(0u));
        }
        if passes_by {
            // A record's plane goes on where its surface does not.
            pass_through(ray, &path, ahead.t);
            let on = ahead.t + PAST_CELLS * grids[VIEW].cell_size;
            ray.origin += on * ray.direction;
            ray.last_part = select(ray.last_part, NO_PART, ahead.t > DUPLICATE_CELLS * grids[VIEW].cell_size);
            ray.crossings += 1u;
            ends = ray.crossings >= MAX_CROSSINGS;
        } else if ray.t_plane < at.t - select(contact, 0.0, is_first) {
            ends = true;
            pass_through(ray, &path, ray.t_plane);
            path.first_part = select(path.first_part, 0u, is_first);
        } else {
            ends = !meet(&ray, &path, at, strange);
            path.triangle = select(path.triangle, ahead.triangle & RECORD_TRIANGLE_MASK, path.t_end >= 0.0);
        }

        // The walk to the next surface.
        if !ends {
            ray.t_plane = plane_ahead(ray.origin, ray.direction, contact);
            let seeker = Seeker(ray.origin, ray.direction, 1e30, ray.media, ray.last_part, ray.last_front, false);
            ahead = first_crossing(VIEW, seeker);
            if !ahead.found {
                ends = true;
                // Inside still: in glass that a plane cuts, or lost where the grid ends before the plane.
                if any(ray.media != vec4u(0u)) {
                    let lost = ray.t_plane > max(ahead.t, 0.0) + LOST_CELLS * grids[VIEW].cell_size;
                    path.questionable = path.questionable || lost;
                    pass_through(ray, &path, select(ray.t_plane, 0.0, lost));
                }
            }
        }
        if ends {
            running = false;
            store_path(pixel, path);
        }
    }
}
