#include "lib/crossing.inc.wgsl"
#include "lib/march_settings.inc.wgsl"
#include "lib/path.inc.wgsl"
#include "lib/refract.inc.wgsl"
#include "lib/surface.inc.wgsl"
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

// How many surfaces bend the ray: 0, 1 or all.
override bends: u32 = 2u;
// Pixels of a column that one thread takes.
override pixels_per_thread: u32 = 8u;

const VIEW: u32 = 0u;
// A plane this many cells before a crossing counts as behind it: bodies that stand on a floor.
const CONTACT_CELLS: f32 = 0.25;
// A plane this many cells beyond the grid does not end the glass in it.
const LOST_CELLS: f32 = 0.5;
// More surfaces than this end a path, bent or not.
const MAX_CROSSINGS: u32 = 96u;

struct Ray {
    origin: vec3f,
    direction: vec3f,
    t_plane: f32,           // where it meets an analytic plane
    media: vec4u,
    sigma: vec3f,           // of the ruling medium
    ior: f32,
    last_part: u32,
    last_front: bool,
    crossings: u32,
}

fn plane_ahead(origin: vec3f, direction: vec3f, back: f32) -> f32 {
    return nearest_plane(origin - back * direction, direction, 1e30).t - back;
}

// What is absorbed and how far it is inside, over a stretch of t.
fn pass_through(ray: Ray, path: ptr<function, Path>, t: f32) {
    let stretch = select(max(t, 0.0), 0.0, all(ray.media == vec4u(0u)));
    (*path).thickness += stretch;
    (*path).optical_depth += ray.sigma * stretch;
}

// Moves the ray to the surface that it meets and bends it there. False where the path ends.
fn meet(ray: ptr<function, Ray>, path: ptr<function, Path>, at: Surface, strange: bool) -> bool {
    var r = *ray;
    let material_flags = materials[at.part].flags;
    pass_through(r, path, at.t);
    let place = r.origin + at.t * r.direction;
    if (material_flags & FLAG_OPAQUE) != 0u {
        // The path's place and direction stay those of where it last left glass.
        (*path).place = r.origin;
        (*path).t_end = max(at.t, 0.0);
        return false;
    }
    let is_thin = (material_flags & FLAG_THIN_WALL) != 0u;
    (*path).questionable = (*path).questionable || (strange && !is_thin);

    let entered = media_enter(r.media, at.part);
    let left = media_leave(r.media, at.part);
    var media = select(left, entered, at.front);
    media = select(media, r.media, is_thin);
    let ruling = media_ruling(media);
    let outside = ruling == NO_PART;
    let behind = select(ruling, at.part, outside);
    let ior = select(materials[behind].ior, 1.0, outside);
    let sigma = select(materials[behind].sigma, vec3f(0.0), outside || settings.absorb == 0u);

    let bend = bend_at(r.direction, facing(select(-at.normal, at.normal, at.front), r.direction), r.ior / ior);
    let optical = ior != r.ior;
    let bends_here = optical && (*path).events < bends_limit();
    let mirrored = bends_here && bend.total;
    if bends_here && (*path).events >= settings.max_events {
        (*path).questionable = true;
        (*path).place = place;
        return false;
    }
    (*path).events += u32(bends_here);
    if optical && !bend.total && settings.reflect != 0u && (bends_here || r.crossings == 0u) {
        (*path).throughput *= 1.0 - bend.reflectance;
    }
    if at.front && settings.absorb != 0u {
        (*path).optical_depth -= log(max(materials[at.part].base_color, vec3f(1e-4)));
    }
    r.direction = select(r.direction, bend.direction, bends_here);
    r.origin = place;
    r.last_part = at.part;
    // Seen from where the ray goes now the surface lies behind it, and would be met from this side again.
    r.last_front = at.front != mirrored;
    r.media = select(media, r.media, mirrored);
    r.ior = select(ior, r.ior, mirrored);
    r.sigma = select(sigma, r.sigma, mirrored);
    r.crossings += 1u;
    if all(r.media == vec4u(0u)) && !at.front {
        (*path).left_glass = true;
    } else {
        (*path).left_glass = false;
    }
    (*path).place = place;
    (*path).direction = r.direction;
    *ray = r;
    return r.crossings < MAX_CROSSINGS;
}

fn bends_limit() -> u32 {
    return select(bends, 0xffffffffu, bends >= 2u);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let eye = surroundings.eye;
    let eye_cell = grid_from_world(grids[VIEW], eye);
    let eye_in_grid = all(eye_cell > vec3f(0.0)) && all(eye_cell < vec3f(grids[VIEW].cells));
    let contact = CONTACT_CELLS * grids[VIEW].cell_size;
    let row_first = id.y * pixels_per_thread;
    let row_last = select(row_first, min(row_first + pixels_per_thread, settings.size.y), id.x < settings.size.x);
    var row = row_first;

    var running = false;
    var pixel = vec2u(0u);
    var ray: Ray;
    var path: Path;
    var ahead = no_crossing();      // what the ray meets next; at first the rasterized triangle
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
                ray.origin = eye;
                ray.direction = view_direction(picture_from_pixel(pixel, settings.size));
                ray.t_plane = plane_ahead(eye, ray.direction, 0.0);
                ray.media = vec4u(0u);
                ray.sigma = vec3f(0.0);
                ray.ior = 1.0;
                ray.last_part = NO_PART;
                ray.last_front = false;
                ray.crossings = 0u;
                path = clear_path(eye, ray.direction);
            }
        }
        if !running {
            break;
        }

        // The event.
        let is_first = ray.crossings == 0u;
        let orphan = (ahead.triangle & RECORD_ORPHAN) != 0u;
        let slack = 0.3 * grids[VIEW].cell_size;
        let t_near = select(ahead.t, 1.0, is_first);
        let t_far = select(ahead.t, 0.0, is_first);
        var at = surface_at(ahead.triangle & RECORD_TRIANGLE_MASK, ray.origin, ray.direction, t_near, t_far,
                            select(slack, 0.0, is_first));
        if !is_first {
            at.part = ahead.part;
            at.normal = select(at.normal, -at.normal, dot(at.normal, ahead.normal) < 0.0);
            at.front = ahead.front;
        }
        if orphan {
            at.t = ahead.t;
            at.normal = ahead.normal;
        }
        if is_first {
            path.first_t = at.t;
            path.first_normal = at.normal;
            path.first_part = at.part + 1u;
            if !at.front && eye_in_grid && (materials[at.part].flags & (FLAG_OPAQUE | FLAG_THIN_WALL)) == 0u {
                // The eye is in this part's glass.
                ray.media = media_enter(ray.media, at.part);
                ray.ior = materials[at.part].ior;
                ray.sigma = select(vec3f(0.0), materials[at.part].sigma, settings.absorb != 0u);
            }
        }
        let strange = ahead.strange || (is_first && !at.front && !media_has(ray.media, at.part));
        var ends = false;
        if ray.t_plane < at.t - select(contact, 0.0, is_first) {
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
            let grid_line = grid_ray(VIEW, ray.origin, ray.direction);
            let seeker = Seeker(ray.origin, ray.direction, 1e30, ray.media, ray.last_part, ray.last_front, false);
            var walk = walk_start(grid_line);
            ahead = no_crossing();
            if grid_line.s_first < grid_line.s_last {
                loop {
                    if !next_occupied(grid_line, &walk) {
                        break;
                    }
                    ahead = voxel_crossing(VIEW, grid_line, walk, seeker);
                    if ahead.found {
                        break;
                    }
                    walk_on(grid_line, &walk);
                }
            }
            if !ahead.found {
                ends = true;
                // Inside still: in glass that a plane cuts, or lost where the grid ends before the plane.
                if any(ray.media != vec4u(0u)) {
                    let t_out = max(t_from_s(grid_line, grid_line.s_last), 0.0);
                    let lost = ray.t_plane > t_out + LOST_CELLS * grids[VIEW].cell_size;
                    path.questionable = path.questionable || lost;
                    pass_through(ray, &path, select(ray.t_plane, 0.0, lost));
                }
            }
        }
        if ends {
            running = false;
            textureStore(path_place, pixel, path_place_texel(path));
            textureStore(path_way, pixel, path_way_texel(path));
            textureStore(path_depth, pixel, path_depth_texel(path));
            textureStore(path_first, pixel, path_first_texel(path));
        }
    }
}
