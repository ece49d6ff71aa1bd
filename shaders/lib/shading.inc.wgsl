#include "lib/geometry.inc.wgsl"
#include "lib/light_volume.inc.wgsl"
#include "lib/surroundings.inc.wgsl"
// What rays meet outside the volume, and how an opaque surface is lit.
//
// Bind as: var<uniform> surroundings: Surroundings; var environment: texture_2d<f32>; var environment_sampler: sampler;
//          var plane_light: texture_2d_array<f32>;
//          var<storage, read> materials: array<PartMaterial>; and what `lib/light_volume.inc.wgsl` asks for.
//
// Directions point the way a ray travels. Lengths are world units, colours linear radiance. Opaque surfaces are
// Lambertian: radiance = base colour / π × irradiance.

const PI: f32 = 3.14159265;

// The kind of background that a shader is compiled for, so that the code of the others is left out (where branches are
// masks, all would run); or any.
const BACKGROUND_ANY: u32 = 0xffu;
override background: u32 = BACKGROUND_ANY;

// ---- checkerboards

// Share of the first colour in a box of `width` around `p`; both in squares. Exact box filter of the pattern.
fn checker_share(p: vec2f, width: vec2f) -> f32 {
    let w = max(width, vec2f(1e-3));
    let a = p - 0.5 * w;
    let b = p + 0.5 * w;
    // Integral of the ±1 square wave of period 2: a triangle wave.
    let wave = 2.0 * (abs(fract(b * 0.5) - 0.5) - abs(fract(a * 0.5) - 0.5)) / w;
    return 0.5 + 0.5 * wave.x * wave.y;
}

// ---- background

// How much the direction of a pixel's ray differs from its neighbours', along its row and along its column.
struct Spread {
    row: vec3f,
    column: vec3f,
}

// Of rays straight from the eye.
fn straight_spread() -> Spread {
    return Spread(surroundings.pixel_angle * surroundings.right, surroundings.pixel_angle * surroundings.up);
}

// Radiance of the background along `direction` (unit) from `origin`, which matters to the checkerboard alone.
fn background_from(origin: vec3f, direction: vec3f, spread: Spread) -> vec3f {
    switch select(background, surroundings.background_kind, background == BACKGROUND_ANY) {
        case BACKGROUND_SKY: {
            let sky = mix(surroundings.background_a.rgb, surroundings.background_b.rgb,
                          pow(max(direction.y, 0.0), surroundings.background_parameter));
            // A horizon as wide as a pixel, so that it does not show steps.
            let below = smoothstep(0.5, -0.5, direction.y / max(abs(spread.row.y) + abs(spread.column.y), 1e-4));
            return mix(sky, surroundings.background_c.rgb, below);
        }
        case BACKGROUND_CHECKER: {
            let normal = surroundings.background_d.xyz;
            let mean = 0.5 * (surroundings.background_a.rgb + surroundings.background_b.rgb);
            let falling = -dot(direction, normal);
            if falling < 1e-4 {
                return mean;
            }
            let t = dot(origin - surroundings.background_c.xyz, normal) / falling;
            if t <= 0.0 {
                return mean;
            }
            let p = origin + t * direction - surroundings.background_c.xyz;
            // The plane's own axes: level to the right, then up.
            var level = cross(vec3f(0.0, 1.0, 0.0), normal);
            level = select(normalize(level), vec3f(1.0, 0.0, 0.0), dot(level, level) < 1e-8);
            let upward = cross(normal, level);
            let square = surroundings.background_parameter;
            let row = t * (spread.row + direction * (dot(spread.row, normal) / falling));
            let column = t * (spread.column + direction * (dot(spread.column, normal) / falling));
            let width = (abs(vec2f(dot(row, level), dot(row, upward))) + abs(vec2f(dot(column, level), dot(column, upward)))) / square;
            let share = checker_share(vec2f(dot(p, level), dot(p, upward)) / square, width);
            return mix(surroundings.background_b.rgb, surroundings.background_a.rgb, share);
        }
        case BACKGROUND_ENVIRONMENT: {
            let turn = surroundings.background_c.x;
            let c = cos(turn);
            let s = sin(turn);
            let x = c * direction.x - s * direction.z;
            let z = s * direction.x + c * direction.z;
            let uv = vec2f(0.5 + atan2(x, -z) / (2.0 * PI), acos(clamp(direction.y, -1.0, 1.0)) / PI);
            return textureSampleLevel(environment, environment_sampler, uv, 0.0).rgb * surroundings.background_c.y;
        }
        default: {
            return surroundings.background_a.rgb;
        }
    }
}

// Irradiance that a surface with unit normal `n` receives from the whole background.
fn background_irradiance(n: vec3f) -> vec3f {
    var e = surroundings.irradiance[0].rgb;
    e += surroundings.irradiance[1].rgb * n.y + surroundings.irradiance[2].rgb * n.z + surroundings.irradiance[3].rgb * n.x;
    e += surroundings.irradiance[4].rgb * (n.x * n.y) + surroundings.irradiance[5].rgb * (n.y * n.z);
    e += surroundings.irradiance[6].rgb * (3.0 * n.z * n.z - 1.0) + surroundings.irradiance[7].rgb * (n.x * n.z);
    e += surroundings.irradiance[8].rgb * (n.x * n.x - n.y * n.y);
    return max(e, vec3f(0.0));
}

// ---- planes

// Where a pixel's footprint ends on a plane, from its middle: along its row and along its column, world units.
struct Footprint {
    row: vec3f,
    column: vec3f,
}

// A pixel's footprint at `p` of plane number `plane`, seen straight from the eye: two steps across the ray, slid along
// it into the plane.
fn footprint_from_eye(plane: u32, p: vec3f) -> Footprint {
    let from_eye = p - surroundings.eye;
    let distance = max(length(from_eye), 1e-6);
    let along = from_eye / distance;
    let n = surroundings.planes[plane].normal;
    let falling = dot(along, n);
    let slant = select(-1.0, 1.0, falling >= 0.0) * max(abs(falling), 1e-3);
    let aside = normalize(cross(along, select(vec3f(0.0, 1.0, 0.0), vec3f(1.0, 0.0, 0.0), abs(along.y) > 0.9)));
    let second = cross(along, aside);
    let size = distance * surroundings.pixel_angle;
    return Footprint(size * (aside - along * (dot(aside, n) / slant)), size * (second - along * (dot(second, n) / slant)));
}

// The step from `p` on plane number `plane` to where a neighbouring pixel's ray meets that plane; far off where it
// misses.
fn footprint_step(plane: u32, p: vec3f, origin: vec3f, direction: vec3f) -> vec3f {
    let n = surroundings.planes[plane].normal;
    let t = dot(p - origin, n) / dot(direction, n);
    return select(vec3f(1e4), origin + t * direction - p, t > 0.0 && t < 1e6);
}

// Colour of plane number `plane` at world point `p`: a checkerboard whose squares blend where a pixel holds several.
fn plane_base_color(plane: u32, p: vec3f, footprint: Footprint) -> vec3f {
    let base = materials[surroundings.planes[plane].part].base_color;
    let squares = surroundings.planes[plane].checker_squares;
    if squares <= 0.0 {
        return base;
    }
    let local_from_world = surroundings.planes[plane].local_from_world;
    let at = (local_from_world * vec4f(p, 1.0)).xz * squares;
    let width_row = abs((local_from_world * vec4f(footprint.row, 0.0)).xz);
    let width_column = abs((local_from_world * vec4f(footprint.column, 0.0)).xz);
    let share = checker_share(at, (width_row + width_column) * squares);
    return mix(surroundings.planes[plane].checker_color, base, share);
}

// ---- lights

struct Arriving {
    to_light: vec3f,        // unit
    irradiance: vec3f,      // on a surface that faces the light, nothing in between
}

// Light number `light` at `p`, nothing in between.
fn light_arriving(light: u32, p: vec3f) -> Arriving {
    let radiance = surroundings.lights[light].radiance;
    if surroundings.lights[light].kind == LIGHT_DIRECTIONAL {
        return Arriving(-surroundings.lights[light].direction, radiance);
    }
    let offset = surroundings.lights[light].position - p;
    let distance2 = max(dot(offset, offset), 1e-6);
    let to_light = offset * inverseSqrt(distance2);
    var cone = 1.0;
    if surroundings.lights[light].kind == LIGHT_SPOT {
        let outer = surroundings.lights[light].cos_outer;
        let inner = max(surroundings.lights[light].cos_inner, outer + 1e-5);
        cone = smoothstep(outer, inner, -dot(to_light, surroundings.lights[light].direction));
    }
    return Arriving(to_light, radiance * (cone / distance2));
}

// ---- what a ray ends on

// Matter, or nothing.
struct Seen {
    is_matter: bool,
    p: vec3f,               // where; where the ray comes from if there is nothing
    normal: vec3f,          // unit, either side
    plane: u32,             // the plane that it is, or NO_PLANE
    base_color: vec3f,
    roughness: f32,         // 0: matte, no lobe beside the diffuse
    emissive: vec3f,
    haze: f32,              // share of the background in front of it
    wider: f32,             // nothing: by how much the lights' own discs are widened; negative where they are not seen
}

// Schlick's Fresnel term of a dielectric in air.
fn fresnel_schlick(cos_angle: f32, f0: f32) -> f32 {
    let m = clamp(1.0 - cos_angle, 0.0, 1.0);
    return f0 + (1.0 - f0) * (m * m) * (m * m) * m;
}

// Broad GGX lobe of an opaque dielectric, times the cosine of the light.
fn rough_lobe(n: vec3f, view_dir: vec3f, to_light: vec3f, roughness: f32) -> f32 {
    let a2 = pow(max(roughness, 0.2), 4.0);
    let h = normalize(to_light - view_dir);
    let nh = max(dot(n, h), 0.0);
    let nl = max(dot(n, to_light), 0.0);
    let nv = max(-dot(n, view_dir), 1e-3);
    let q = nh * nh * (a2 - 1.0) + 1.0;
    let d = a2 / (PI * q * q);
    let v = 0.5 / max(nl * sqrt(nv * nv * (1.0 - a2) + a2) + nv * sqrt(nl * nl * (1.0 - a2) + a2), 1e-4);
    return d * v * fresnel_schlick(max(dot(h, to_light), 0.0), 0.04) * nl;
}

// The four texels of a layer about a place in cells, blended. Not by a sampler: how that rounds hangs on the texture's
// size, which may be larger than the layer.
fn plane_light_at(p: vec2f, cells: vec2u, layer: u32) -> vec3f {
    let at = clamp(p - 0.5, vec2f(0.0), vec2f(cells - 1u));
    let lo = vec2u(at);
    let hi = min(lo + 1u, cells - 1u);
    let f = at - vec2f(lo);
    let low = mix(textureLoad(plane_light, lo, layer, 0).rgb, textureLoad(plane_light, vec2u(hi.x, lo.y), layer, 0).rgb, f.x);
    let high = mix(textureLoad(plane_light, vec2u(lo.x, hi.y), layer, 0).rgb, textureLoad(plane_light, hi, layer, 0).rgb, f.x);
    return mix(low, high, f.y);
}

// What is left of light number `light` at `p`, RGB. On plane number `plane` its shadows are soft (see `plane_light.rs`);
// elsewhere (NO_PLANE) `n` is the normal on the side to be lit, by which a surface keeps clear of its own voxels.
fn light_share(light: u32, p: vec3f, n: vec3f, plane: u32) -> vec3f {
    let on_plane = plane != NO_PLANE;
    let place = light_place(light, p, select(n, vec3f(0.0), on_plane));
    if place.grid == NO_GRID {
        return vec3f(1.0);
    }
    let first_layer = surroundings.lights[light].first_layer;
    if on_plane && first_layer != NO_LAYER {
        let layer = first_layer + (place.grid - surroundings.lights[light].first_grid) * surroundings.counts.y + plane;
        return plane_light_at(place.p_grid.xy, grids[place.grid].cells.xy, layer);
    }
    let left = grid_light(place.grid, place.p, place.p_grid, light_travel(light, place.p));
    return left.rgb * left.a;
}

// Radiance that comes back along a ray that went along `direction` (unit) from `origin`. Matter: every light's share
// with its shadow, the background's, and its own. Nothing: the background, and the lights as discs that what stands
// between dims. A disc's radiance is its irradiance over its solid angle, so that a highlight's energy does not hang on its
// size; its edge is soft by a third of its radius. One loop over the lights serves both.
fn radiance_of(seen: Seen, origin: vec3f, direction: vec3f, spread: Spread) -> vec3f {
    let n = select(seen.normal, -seen.normal, seen.is_matter && dot(seen.normal, direction) > 0.0);
    var diffuse = background_irradiance(n);
    var direct = vec3f(0.0);
    for (var i = 0u; i < surroundings.counts.x; i++) {
        let arriving = light_arriving(i, seen.p);
        let cosine = dot(n, arriving.to_light);
        // A chord: equals the angle as far as it is small.
        let radius = surroundings.lights[i].angular_radius + seen.wider;
        let angle = length(direction - arriving.to_light) / radius;
        let faces_light = cosine > 0.0;
        let sees_light = angle < 1.15 && seen.wider >= 0.0;
        let counts = select(sees_light, faces_light, seen.is_matter);
        if counts && any(arriving.irradiance > vec3f(0.0)) {
            let left = arriving.irradiance * light_share(i, seen.p, n, seen.plane);
            if seen.is_matter {
                diffuse += left * cosine;
                if seen.roughness > 0.0 {
                    direct += left * rough_lobe(n, direction, arriving.to_light, seen.roughness);
                }
            } else {
                direct += left * smoothstep(1.15, 0.85, angle) / (PI * radius * radius);
            }
        }
    }
    let background = background_from(origin, direction, spread);
    if seen.is_matter {
        return mix(seen.base_color / PI * diffuse + direct + seen.emissive, background, seen.haze);
    }
    return background + direct;
}

// Nothing, seen from `p`. `n`: the way out of what stands at `p`, zero where nothing does.
fn seen_nothing(p: vec3f, n: vec3f, wider: f32) -> Seen {
    return Seen(false, p, n, NO_PLANE, vec3f(0.0), 0.0, vec3f(0.0), 0.0, wider);
}

// Plane number `plane` at `p`, met by a ray along `direction`. Towards the edge of a large floor seen at a low angle it
// melts into the background, as haze does to a horizon.
fn seen_plane(plane: u32, p: vec3f, direction: vec3f, footprint: Footprint) -> Seen {
    let part = surroundings.planes[plane].part;
    let n = surroundings.planes[plane].normal;
    let low = smoothstep(0.16, 0.04, abs(dot(n, direction)));
    let at = (surroundings.planes[plane].local_from_world * vec4f(p, 1.0)).xz;
    let haze = low * smoothstep(0.25, 1.0, length(at));
    let color = plane_base_color(plane, p, footprint);
    return Seen(true, p, n, plane, color, materials[part].roughness, materials[part].emissive, haze, -1.0);
}

// By how much a bent ray's spread widens the lights' discs: a pixel shows the mean of what its rays meet, so that a glint
// in glass that scatters them is as faint as it is broad.
fn spread_width(spread: Spread) -> f32 {
    return 0.5 * max(length(spread.row), length(spread.column));
}

// By how much a mirror of this roughness widens the lights' discs.
fn mirror_width(roughness: f32) -> f32 {
    return 0.6 * roughness * roughness;
}
