#include "lib/one_grid.inc.wgsl"
#include "lib/closest.inc.wgsl"
// A triangle's claim to a voxel, worked out in grid space.

// A triangle that meets a cell has its point closest to the centre within 0.19 cells of it: n·|n|₁/2 with n a unit
// vector is at most 0.683. Beyond this a triangle has no say.
const CLAIM_GROWTH: f32 = 0.2;

struct Claim {
    offset: vec3f,      // from the centre to the closest point, in half cells of each axis
    nearness: u32,      // 1 … 255; 0: no claim
}

// `frame` is the triangle's in grid space.
fn claim_of(frame: ClosestFrame, cell: vec3i) -> Claim {
    var offset: vec3f;
    if !perspective {
        offset = 2.0 * closest_offset(frame, vec3f(cell) + 0.5);
    } else {
        // Nearness is measured in half cells: a cell of a perspective grid is not as deep as it is wide.
        let slabs = slabs_of(cell.z);
        let scale = vec3f(2.0, 2.0, 2.0 / (slabs.y - slabs.x));
        let center = vec3f(vec2f(cell.xy) + 0.5, 0.5 * (slabs.x + slabs.y));
        offset = closest_offset(closest_frame(frame.a * scale, frame.b * scale, frame.c * scale), center * scale);
    }
    let within = all(abs(offset) <= vec3f(1.0 + 2.0 * CLAIM_GROWTH));
    let nearness = 1u + u32(clamp(254.0 * (1.0 - 0.5 * length(offset)), 0.0, 254.0));
    return Claim(offset, select(0u, nearness, within));
}

// Dominant axis and side of a normal: walls that face each other do not compete.
fn slot_of(normal: vec3f) -> u32 {
    let size = abs(normal);
    let axis = select(select(2u, 1u, size.y >= size.z), 0u, size.x >= size.y && size.x >= size.z);
    let along = select(select(normal.z, normal.y, axis == 1u), normal.x, axis == 0u);
    return 2u * axis + select(0u, 1u, along < 0.0);
}
