#include "lib/crossing.inc.wgsl"
#include "lib/event.inc.wgsl"
#include "lib/neighbors.inc.wgsl"
#include "lib/surface.inc.wgsl"
// The media that the eye is in: what a straight walk from outside the view's grid to the eye enters and does not leave.
//
// Bind as: what `lib/crossing.inc.wgsl`, `lib/event.inc.wgsl` and `lib/neighbors.inc.wgsl` ask for.

// The way of the walk: along no axis and no diagonal, so that it runs along no wall of a box.
const EYE_WALK: vec3f = vec3f(0.36, -0.48, 0.8);

fn media_at_eye(eye: vec3f) -> vec4u {
    var media = vec4u(0u);
    let back = grid_ray(VIEW, eye, -EYE_WALK);
    var left = t_from_s(back, back.s_last);     // to the eye
    var at = eye - left * EYE_WALK;
    var last_part = NO_PART;
    var last_front = false;
    for (var crossings = 0u; crossings < MAX_CROSSINGS; crossings++) {
        let reach = left + TRIANGLE_SLACK_CELLS * grids[VIEW].cell_size;
        let ahead = first_crossing(VIEW, Seeker(at, EYE_WALK, reach, media, last_part, last_front, false));
        if !ahead.found {
            break;
        }
        let orphan = (ahead.triangle & RECORD_ORPHAN) != 0u;
        let met = triangle_met(ahead.triangle & RECORD_TRIANGLE_MASK, at, EYE_WALK, orphan);
        let slack = select(PLANE_SLACK_CELLS, TRIANGLE_SLACK_CELLS, met.inside) * grids[VIEW].cell_size;
        let t = select(surface_at(met.triangle, at, EYE_WALK, ahead.t, ahead.t, slack).t, ahead.t, orphan);
        if t >= left {
            break;
        }
        let passes = (materials[ahead.part].flags & (FLAG_OPAQUE | FLAG_THIN_WALL)) != 0u;
        let changed = select(media_leave(media, ahead.part), media_enter(media, ahead.part), ahead.front);
        media = select(changed, media, passes);
        at += t * EYE_WALK;
        left -= t;
        last_part = ahead.part;
        last_front = ahead.front;
    }
    return media;
}
