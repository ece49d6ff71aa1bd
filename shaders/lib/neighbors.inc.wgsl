#include "lib/geometry.inc.wgsl"
// From a triangle near a ray to the one that the ray meets, from neighbour to neighbour over the edges that it passes.
//
// Bind as: var<storage, read> vertices: array<Vertex>; var<storage, read> indices: array<u32>;
//          var<storage, read> neighbors: array<u32>;

// A voxel's record names one of the few triangles that lie in it: the one that is met is never far.
const MAX_NEIGHBOR_STEPS: u32 = 8u;

// Cells by which a surface may lie off its record's plane: as far as the record's triangle goes on beyond its edges, and
// where the ray meets a triangle beside it.
const PLANE_SLACK_CELLS: f32 = 0.3;
const TRIANGLE_SLACK_CELLS: f32 = 1.5;

struct Met {
    triangle: u32,
    inside: bool,       // the ray meets it within its edges
    turns: bool,        // the surface turns away there: the ray passes its rim by
    ends: bool,         // the surface has an edge there, and the ray passes beyond it
}

// The triangle that a ray meets, looked for from `start`; the last one met from the same side where the surface ends or
// turns away from the ray. `start` itself where it `stays`.
fn triangle_met(start: u32, origin: vec3f, direction: vec3f, stays: bool) -> Met {
    var met = Met(start, false, false, false);
    var next = start;
    var facing = 0.0;
    var steps = select(0u, MAX_NEIGHBOR_STEPS, stays);
    while steps < MAX_NEIGHBOR_STEPS {
        steps += 1u;
        let a = vertices[indices[3u * next]].position - origin;
        let b = vertices[indices[3u * next + 1u]].position - origin;
        let c = vertices[indices[3u * next + 2u]].position - origin;
        // On which side of the edge opposite each corner the ray passes; their sum tells from which side it comes.
        let sides = vec3f(dot(direction, cross(b, c)), dot(direction, cross(c, a)), dot(direction, cross(a, b)));
        let sum = sides.x + sides.y + sides.z;
        if sum * facing < 0.0 {
            met.turns = true;
            break;
        }
        facing = sum;
        met.triangle = next;
        let weights = sides * sign(sum);
        let least = min(weights.x, min(weights.y, weights.z));
        met.inside = least >= 0.0;
        next = neighbors[3u * next + select(select(2u, 1u, weights.y == least), 0u, weights.x == least)];
        met.ends = !met.inside && next == NO_TRIANGLE;
        if met.inside || met.ends {
            break;
        }
    }
    return met;
}
