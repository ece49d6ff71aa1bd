#include "lib/event.inc.wgsl"
#include "lib/steps.inc.wgsl"
// The paper's marcher, whole (CL §3.2.2, Eqs. 3 and 4, Figs. 6 and 7; with `bends` = 0 the walk of Fig. 3): the ray
// starts at the camera, goes on by fixed steps of one voxel and is bent where a step ends in a boundary voxel, by that
// voxel's normal. A boundary voxel whose normal is within the angle threshold of the last one's is the same surface
// again (Fig. 7a). Each voxel that counts toggles whether the ray is inside its part.
//
// How the volume is stored is the includer's: it defines
//     fn next_boundary(ray: GridRay, steps: ptr<function, Steps>) -> bool     as `next_boundary_voxel`
//     fn boundary_at(steps: Steps) -> Boundary

struct Boundary {
    normal: vec3f,      // world, unit
    part: u32,
    triangle: u32,
}

fn voxel_path(pixel: vec2u) -> Path {
    var ray = ray_from_eye(surroundings.eye, view_direction(picture_from_pixel(pixel, settings.size)));
    var path = clear_path(ray.origin, ray.direction);
    var last_normal = vec3f(0.0);
    loop {
        let line = grid_ray(VIEW, ray.origin, ray.direction);
        // From the camera the samples lie in the middle of the slices; from a bend they are whole steps away.
        var steps = steps_from(line, select(0.0, line.s_first, ray.crossings == 0u), select(1.0, 0.5, ray.crossings == 0u));
        var found = false;
        var boundary: Boundary;
        loop {
            if !next_boundary(line, &steps) {
                break;
            }
            boundary = boundary_at(steps);
            if dot(boundary.normal, last_normal) < settings.cos_angle_threshold {
                found = true;
                break;
            }
        }
        let t = t_from_s(line, steps.s);
        if !found || ray.t_plane < t {
            // Left the volume: a ray that is inside still has met an odd number of surfaces (Fig. 3, line 8).
            if any(ray.media != vec4u(0u)) {
                path.questionable = path.questionable || ray.t_plane > 1e29;
                pass_through(ray, &path, select(ray.t_plane, 0.0, ray.t_plane > 1e29));
            }
            break;
        }
        let part = boundary.part;
        let normal = boundary.normal;
        let enters = !media_has(ray.media, part);
        // The surface as the toggle has it, whichever way the normal points.
        let against = select(normal, -normal, dot(normal, ray.direction) > 0.0);
        let at = Surface(t, select(-against, against, enters), enters, part);
        if ray.crossings == 0u {
            path.first_t = t;
            path.first_normal = at.normal;
            path.first_part = part + 1u;
            path.first_front = true;
        }
        last_normal = normal;
        if !meet(&ray, &path, at, false) {
            path.triangle = select(path.triangle, boundary.triangle, path.t_end >= 0.0);
            break;
        }
        ray.t_plane = plane_ahead(ray.origin, ray.direction, 0.0);
    }
    return path;
}
