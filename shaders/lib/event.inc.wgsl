#include "lib/geometry.inc.wgsl"
#include "lib/march_settings.inc.wgsl"
#include "lib/media.inc.wgsl"
#include "lib/path.inc.wgsl"
#include "lib/refract.inc.wgsl"
#include "lib/surface.inc.wgsl"
#include "lib/surroundings.inc.wgsl"
// A ray on its way through media, and what happens to it where it meets a surface.
//
// Bind as: var<uniform> settings: MarchSettings; var<uniform> surroundings: Surroundings;
//          var<storage, read> materials: array<PartMaterial>;

// How many surfaces bend the ray: 0, 1 or all.
override bends: u32 = 2u;

// The grid that paths are followed in.
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

// Where the ray meets the nearest analytic plane, looked for from a little before its origin.
fn plane_ahead(origin: vec3f, direction: vec3f, back: f32) -> f32 {
    return nearest_plane(origin - back * direction, direction, 1e30).t - back;
}

fn ray_from_eye(eye: vec3f, direction: vec3f) -> Ray {
    return Ray(eye, direction, plane_ahead(eye, direction, 0.0), vec4u(0u), vec3f(0.0), 1.0, NO_PART, false, 0u);
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
    // The surface's own tint, from the front; of a thin wall with two sides from either.
    let tints = at.front || (is_thin && (material_flags & FLAG_DOUBLE_SIDED) != 0u);
    if tints && settings.absorb != 0u {
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
