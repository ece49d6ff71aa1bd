#include "lib/grid.inc.wgsl"
// Looking up how much of a light is left at a point: the transparent shadow map, depth-resolved.
//
// Bind as: var<uniform> grids: array<Grid, MAX_GRIDS>; var<uniform> surroundings: Surroundings;
//          var<storage, read> occupancy: array<u32>; ranks: array<u32>; records: array<Record>;
//          light_records: array<vec2u>; materials: array<PartMaterial>.

const SHADOW_NONE: u32 = 0u;
const SHADOW_LINEAR: u32 = 1u;
const SHADOW_BEER_LAMBERT: u32 = 2u;

// What is left of light number `light` at `p`, RGB: absorption and the surfaces' reflection. `n` is the surface's
// normal on the side to be lit, by which an opaque surface keeps clear of its own voxels; zero for what is in no grid.
fn light_transmittance(light: u32, p: vec3f, n: vec3f) -> vec3f {
    return vec3f(1.0);
}

// As `light_transmittance`, absorption alone: what the channel `ground-light` shows.
fn light_absorption(light: u32, p: vec3f, n: vec3f) -> vec3f {
    return vec3f(1.0);
}
