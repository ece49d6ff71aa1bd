#include "lib/march_settings.inc.wgsl"
#include "lib/opaque.inc.wgsl"
#include "lib/path.inc.wgsl"
#include "lib/refract.inc.wgsl"
#include "lib/shading.inc.wgsl"
#include "lib/surface.inc.wgsl"
#include "lib/texel.inc.wgsl"
// What each pixel's path ends on, what its first surface mirrors, and the float channel.

@group(0) @binding(0) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(1) var<storage, read> indices: array<u32>;
@group(0) @binding(2) var<storage, read> rest_vertices: array<RestVertex>;
@group(0) @binding(3) var<storage, read> materials: array<PartMaterial>;
@group(0) @binding(4) var<storage, read> occupancy: array<u32>;
@group(0) @binding(5) var<storage, read> ranks: array<u32>;
@group(0) @binding(6) var<storage, read> records: array<Record>;
@group(0) @binding(7) var<storage, read> light_records: array<vec2u>;
@group(0) @binding(8) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(9) var<uniform> surroundings: Surroundings;
@group(0) @binding(10) var<uniform> settings: MarchSettings;
@group(0) @binding(11) var environment: texture_2d<f32>;
@group(0) @binding(12) var environment_sampler: sampler;
@group(0) @binding(13) var textures: texture_2d_array<f32>;
@group(0) @binding(22) var plane_light: texture_2d_array<f32>;
@group(0) @binding(21) var texture_sampler: sampler;
@group(0) @binding(14) var first_triangle: texture_2d<u32>;
@group(0) @binding(15) var path_place: texture_2d<f32>;
@group(0) @binding(16) var path_way: texture_2d<f32>;
@group(0) @binding(17) var path_depth: texture_2d<u32>;
@group(0) @binding(18) var path_first: texture_2d<f32>;
@group(0) @binding(19) var radiance: texture_storage_2d<rgba32float, write>;
@group(0) @binding(20) var channel: texture_storage_2d<rgba32float, write>;

// Whether there are opaque parts beside planes.
override opaque_triangles: bool = true;
// Whether there is a channel to write.
override writes_channel: bool = true;

// The nearest opaque matter along a ray that meets no more glass. One straight from the eye that is known to miss every
// triangle sees planes alone: voxels would give outlines their cells' teeth.
fn opaque_ahead(origin: vec3f, direction: vec3f, misses_triangles: bool) -> End {
    var end = plane_end(origin, direction);
    if opaque_triangles && surroundings.counts.z < MAX_GRIDS && !misses_triangles {
        end = opaque_in_grid(surroundings.counts.z, origin, direction, end);
    }
    return end;
}

// The opaque triangle at `p`.
fn seen_triangle(triangle: u32, p: vec3f, direction: vec3f) -> Seen {
    let at = barycentric_at(triangle, p);
    let b = at.weights;
    let part = vertices[at.corner.x].part;
    let normal = b.x * vertices[at.corner.x].normal + b.y * vertices[at.corner.y].normal
        + b.z * vertices[at.corner.z].normal;
    let length2 = dot(normal, normal);
    let n = select(-direction, normal * inverseSqrt(max(length2, 1e-20)), length2 > 1e-12);
    var base_color = materials[part].base_color;
    var emissive = materials[part].emissive;
    let color_layer = materials[part].base_color_layer;
    let emissive_layer = materials[part].emissive_layer;
    let flags = materials[part].flags;
    if max(color_layer, emissive_layer) >= 0 || (flags & FLAG_VERTEX_COLOR) != 0u {
        let uv0 = vec2f(rest_vertices[at.corner.x].u, rest_vertices[at.corner.x].v);
        let uv1 = vec2f(rest_vertices[at.corner.y].u, rest_vertices[at.corner.y].v);
        let uv2 = vec2f(rest_vertices[at.corner.z].u, rest_vertices[at.corner.z].v);
        if (flags & FLAG_VERTEX_COLOR) != 0u {
            let color = b.x * color_from_uv(uv0) + b.y * color_from_uv(uv1) + b.z * color_from_uv(uv2);
            base_color *= max(color, vec3f(0.0));
        }
        let uv = b.x * uv0 + b.y * uv1 + b.z * uv2;
        // A pixel as the eye would see it straight.
        let edges = cross(vertices[at.corner.y].position - vertices[at.corner.x].position,
                          vertices[at.corner.z].position - vertices[at.corner.x].position);
        let reach = surroundings.pixel_angle * length(p - surroundings.eye);
        let pixel_area = reach * reach / max(abs(dot(n, direction)), 0.05);
        let uv_edges = mat2x2f(uv1 - uv0, uv2 - uv0);
        let level = texel_level(pixel_area, length(edges), abs(determinant(uv_edges)));
        if color_layer >= 0 {
            base_color *= texel(color_layer, uv, level, (flags >> BASE_COLOR_SAMPLING_SHIFT) & SAMPLING_MASK);
        }
        if emissive_layer >= 0 {
            emissive *= texel(emissive_layer, uv, level, (flags >> EMISSIVE_SAMPLING_SHIFT) & SAMPLING_MASK);
        }
    }
    let unlit = (flags & FLAG_UNLIT) != 0u;
    emissive = select(emissive, base_color, unlit);
    base_color = select(base_color, vec3f(0.0), unlit);
    return Seen(true, p, n, NO_PLANE, base_color, materials[part].roughness, emissive, 0.0, -1.0);
}

// Only pixels whose ray meets the volume have a path.
fn has_path(pixel: vec2u) -> bool {
    return settings.rasterized == 0u || textureLoad(first_triangle, pixel, 0).x != 0u;
}

// The way of a pixel's path behind its last bend.
struct Way {
    place: vec3f,
    direction: vec3f,
}

fn way_of(pixel: vec2u, eye: vec3f) -> Way {
    if !has_path(pixel) {
        return Way(eye, view_direction(picture_from_pixel(pixel, settings.size)));
    }
    return Way(textureLoad(path_place, pixel, 0).xyz, unpack_direction(textureLoad(path_way, pixel, 0).xy));
}

// What the first surface mirrors of what comes along the mirrored ray.
fn first_reflectance(path: Path, view: vec3f, n: vec3f) -> f32 {
    let part = path.first_part - 1u;
    let once = bend_at(view, n, 1.0 / materials[part].ior).reflectance;
    // Both sides of a thin wall mirror.
    return select(once, 2.0 * once / (1.0 + once), (materials[part].flags & FLAG_THIN_WALL) != 0u);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let pixel = vec2u(id.x, settings.rows.x + id.y);
    if pixel.x >= settings.size.x || pixel.y >= settings.rows.y {
        return;
    }
    let eye = surroundings.eye;
    let view = view_direction(picture_from_pixel(pixel, settings.size));
    var path = clear_path(eye, view);
    if has_path(pixel) {
        path = path_from_texels(textureLoad(path_place, pixel, 0), textureLoad(path_way, pixel, 0),
                                textureLoad(path_depth, pixel, 0), textureLoad(path_first, pixel, 0));
    }
    let is_glass = path.first_part != 0u && (materials[path.first_part - 1u].flags & FLAG_OPAQUE) == 0u;
    let mirrors = settings.reflect != 0u && is_glass && path.first_front;
    let transmittance = exp(-path.optical_depth);

    // First what the path ends on, then what the first surface mirrors: two turns of one loop, so that the code is there
    // once and a stretch of pixels without glass takes one.
    var origin = path.place;
    var direction = path.direction;
    // Of later surfaces what they mirror is taken to be as bright as what they let through: a ray that goes on alone
    // carries both, and clear glass in an even light can't be seen.
    let out_of_first = facing(path.first_normal, view);
    var mirrored = 0.0;
    if mirrors {
        mirrored = first_reflectance(path, view, out_of_first);
    }
    var weight = transmittance * (1.0 - mirrored);
    var end = End(path.t_end, path.triangle, NO_PLANE);
    var out_of = direction;
    let bent = path.first_part != 0u;
    var beside = Way(eye, view);
    var below = beside;
    var spread = straight_spread();
    var wider = -1.0;
    if bent {
        let last = settings.size - 1u;
        beside = way_of(vec2u(min(pixel.x ^ 1u, last.x), pixel.y), eye);
        below = way_of(vec2u(pixel.x, min(pixel.y ^ 1u, last.y)), eye);
        spread = Spread(beside.direction - direction, below.direction - direction);
        wider = select(-1.0, spread_width(spread), path.left_glass && path.events != 0u && settings.rasterized != 0u);
    }
    var sum = vec3f(0.0);
    for (var turn = 0u; turn < select(1u, 2u, mirrors); turn++) {
        if end.t < 0.0 {
            let misses_triangles = turn == 0u && path.first_part == 0u && settings.rasterized != 0u;
            end = opaque_ahead(origin, direction, misses_triangles);
        }
        let p = origin + end.t * direction;
        var seen = seen_nothing(origin, out_of, wider);
        if opaque_triangles && end.triangle != NO_TRIANGLE {
            seen = seen_triangle(end.triangle, p, direction);
        } else if end.plane != NO_PLANE {
            var footprint = footprint_from_eye(end.plane, p);
            if turn == 0u && bent {
                footprint = Footprint(footprint_step(end.plane, p, beside.place, beside.direction),
                                      footprint_step(end.plane, p, below.place, below.direction));
            }
            seen = seen_plane(end.plane, p, direction, footprint);
        }
        sum += weight * radiance_of(seen, origin, direction, spread);

        out_of = out_of_first;
        origin = eye + path.first_t * view;
        direction = reflect(view, out_of);
        weight = vec3f(mirrored);
        spread = straight_spread();
        wider = mirror_width(materials[max(path.first_part, 1u) - 1u].roughness);
        end = End(-1.0, NO_TRIANGLE, NO_PLANE);
    }
    textureStore(radiance, pixel, vec4f(sum, select(1.0, 0.0, path.questionable)));
    if writes_channel {
        textureStore(channel, pixel, channel_value(path, transmittance));
    }
}

fn channel_value(path: Path, transmittance: vec3f) -> vec4f {
    let none = vec4f(vec3f(settings.nan), 1.0);
    switch settings.channel {
        case CHANNEL_THICKNESS: {
            return vec4f(path.thickness);
        }
        case CHANNEL_TRANSMITTANCE: {
            return vec4f(transmittance, 1.0);
        }
        case CHANNEL_NORMAL: {
            return select(none, vec4f(path.first_normal, 1.0), path.first_part != 0u);
        }
        case CHANNEL_EVENTS: {
            return vec4f(f32(path.events));
        }
        case CHANNEL_QUESTIONABLE: {
            return vec4f(f32(path.questionable));
        }
        case CHANNEL_EXIT_DIRECTION: {
            return select(none, vec4f(path.direction, 1.0), path.left_glass);
        }
        case CHANNEL_EXIT_POSITION: {
            return select(none, vec4f(path.place, 1.0), path.left_glass);
        }
        default: {
            return vec4f(0.0);
        }
    }
}
