#include "lib/crossing.inc.wgsl"
#include "lib/surroundings.inc.wgsl"
// The nearest opaque matter along a straight ray: planes exactly, triangles by a grid's records.
//
// Bind as: what `lib/crossing.inc.wgsl` and `lib/surroundings.inc.wgsl` ask for.

// What a ray ends on.
struct End {
    t: f32,
    triangle: u32,      // opaque, or NO_TRIANGLE
    plane: u32,         // or NO_PLANE
}

// `before`, or what lies before it among the opaque parts in `grid`.
fn opaque_in_grid(grid: u32, origin: vec3f, direction: vec3f, before: End) -> End {
    let hit = first_crossing(grid, Seeker(origin, direction, before.t, vec4u(0u), NO_PART, false, true));
    if hit.found {
        return End(hit.t, hit.triangle & RECORD_TRIANGLE_MASK, NO_PLANE);
    }
    return before;
}

fn plane_end(origin: vec3f, direction: vec3f) -> End {
    let plane = nearest_plane(origin, direction, 1e30);
    return End(plane.t, NO_TRIANGLE, plane.plane);
}
