// What a ray's path through the glass leaves behind, a texel each in four textures: `march*` writes, `shade` reads.
//
// path_place: last place where the path bent or left glass, world; how far on it ends on opaque matter, or −1.
// path_way: direction there (octahedral, f32); length inside glass; unused.
// path_depth: optical depth RGB (bits of f32); PathMarks.
// path_first: distance of the first surface; its outward normal (octahedral, f32); its part + 1, or 0 for none, negative
// where it is met from behind.

struct Path {
    place: vec3f,
    t_end: f32,
    direction: vec3f,
    thickness: f32,
    optical_depth: vec3f,
    events: u32,            // refractions and internal reflections
    questionable: bool,
    left_glass: bool,       // `place` is where the path left glass for good
    triangle: u32,          // opaque matter that ends the path, or NO_TRIANGLE
    first_t: f32,
    first_normal: vec3f,
    first_part: u32,        // part + 1 of the first surface, or 0
    first_front: bool,      // met from its front; its smooth normal may still lean away
}

fn pack_direction(n: vec3f) -> vec2f {
    let p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    return select((1.0 - abs(p.yx)) * select(vec2f(-1.0), vec2f(1.0), p >= vec2f(0.0)), p, n.z >= 0.0);
}

fn unpack_direction(p: vec2f) -> vec3f {
    let z = 1.0 - abs(p.x) - abs(p.y);
    let folded = (1.0 - abs(p.yx)) * select(vec2f(-1.0), vec2f(1.0), p >= vec2f(0.0));
    return normalize(vec3f(select(folded, p, z >= 0.0), z));
}

fn path_place_texel(path: Path) -> vec4f {
    return vec4f(path.place, path.t_end);
}

fn path_way_texel(path: Path) -> vec4f {
    return vec4f(pack_direction(path.direction), path.thickness, 0.0);
}

fn path_depth_texel(path: Path) -> vec4u {
    let marks = (path.triangle & 0xffffffu) | (min(path.events, 63u) << 24u) | (u32(path.left_glass) << 30u)
        | (u32(path.questionable) << 31u);
    return vec4u(bitcast<vec3u>(path.optical_depth), marks);
}

fn path_first_texel(path: Path) -> vec4f {
    return vec4f(path.first_t, pack_direction(path.first_normal), select(-1.0, 1.0, path.first_front) * f32(path.first_part));
}

fn path_from_texels(place: vec4f, way: vec4f, depth: vec4u, first: vec4f) -> Path {
    return Path(place.xyz, place.w, unpack_direction(way.xy), way.z, bitcast<vec3f>(depth.xyz),
                (depth.w >> 24u) & 63u, (depth.w >> 31u) != 0u, ((depth.w >> 30u) & 1u) != 0u, depth.w & 0xffffffu,
                first.x, unpack_direction(first.yz), u32(abs(first.w)), first.w > 0.0);
}

// The path of a ray that meets no triangle.
fn clear_path(eye: vec3f, direction: vec3f) -> Path {
    return Path(eye, -1.0, direction, 0.0, vec3f(0.0), 0u, false, false, 0xffffffu, 0.0, vec3f(0.0, 0.0, 1.0), 0u, false);
}
