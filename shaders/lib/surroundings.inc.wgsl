// What surrounds the volume, as data: camera, lights, analytic planes, background; and the geometry of it.
// What it looks like: `lib/shading.inc.wgsl`.
//
// Bind as: var<uniform> surroundings: Surroundings;
//
// Directions point the way a ray travels. Lengths are world units, colours linear radiance.

const MAX_LIGHTS: u32 = 8u;
const MAX_PLANES: u32 = 8u;
const NO_PLANE: u32 = 0xffffffffu;
const NO_LAYER: u32 = 0xffffffffu;

const LIGHT_DIRECTIONAL: u32 = 0u;
const LIGHT_POINT: u32 = 1u;
const LIGHT_SPOT: u32 = 2u;

const BACKGROUND_COLOR: u32 = 0u;
const BACKGROUND_SKY: u32 = 1u;
const BACKGROUND_CHECKER: u32 = 2u;
const BACKGROUND_ENVIRONMENT: u32 = 3u;

struct LightData {
    position: vec3f,
    kind: u32,
    direction: vec3f,
    cos_outer: f32,
    radiance: vec3f,
    cos_inner: f32,
    first_grid: u32,
    grid_count: u32,
    first_layer: u32,       // of the planes' light: of its first grid on plane 0; then plane by plane, grid by grid
    angular_radius: f32,    // under which it is seen, radians
}

struct PlaneData {
    local_from_world: mat4x4f,
    normal: vec3f,
    part: u32,
    checker_color: vec3f,
    checker_squares: f32,
}

struct Surroundings {
    eye: vec3f,
    tan_half_fov: f32,
    right: vec3f,
    aspect: f32,
    up: vec3f,
    background_kind: u32,
    forward: vec3f,
    background_parameter: f32,
    background_a: vec4f,
    background_b: vec4f,
    background_c: vec4f,
    background_d: vec4f,
    counts: vec4u,                  // lights, planes, scene grid or MAX, how light is shadowed (SHADOW_*)
    lights: array<LightData, MAX_LIGHTS>,
    planes: array<PlaneData, MAX_PLANES>,
    irradiance: array<vec4f, 9>,    // of the background, spherical harmonics of the normal, cosine lobe folded in
    pixel_angle: f32,           // radians that a pixel covers in the middle of the picture
    _pad0: u32,
    _pad1: u32,
    _pad2: u32,
}

// ---- camera

// Unit direction through a point of the picture; (0, 0) is its upper left corner, (1, 1) the lower right.
fn view_direction(picture: vec2f) -> vec3f {
    let s = (picture * 2.0 - 1.0) * vec2f(surroundings.aspect, -1.0) * surroundings.tan_half_fov;
    return normalize(surroundings.forward + s.x * surroundings.right + s.y * surroundings.up);
}

// ---- planes

struct PlaneHit {
    t: f32,         // along the ray; t_max where there is none
    plane: u32,     // index, or NO_PLANE
}

// The nearest plane that the ray meets before `t_max`, from either side.
fn nearest_plane(origin: vec3f, direction: vec3f, t_max: f32) -> PlaneHit {
    var hit = PlaneHit(t_max, NO_PLANE);
    for (var i = 0u; i < surroundings.counts.y; i++) {
        let o = (surroundings.planes[i].local_from_world * vec4f(origin, 1.0)).xyz;
        let d = (surroundings.planes[i].local_from_world * vec4f(direction, 0.0)).xyz;
        let t = -o.y / d.y;
        let at = abs(o.xz + t * d.xz);
        if t > 1e-5 && t < hit.t && max(at.x, at.y) <= 1.0 {
            hit = PlaneHit(t, i);
        }
    }
    return hit;
}
