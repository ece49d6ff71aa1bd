// Animated triangles: what `animate` writes and every later stage reads.
//
// Bind as: var<storage, read> vertices: array<Vertex>; var<storage, read> indices: array<u32>;
//          var<storage, read> rest_vertices: array<RestVertex>; var<storage, read> materials: array<PartMaterial>;
struct Vertex {
    position: vec3f,    // world
    part: u32,
    normal: vec3f,      // world, unit
    mirrored: u32,      // 1: outside is where the corners of its triangles run clockwise
}

struct RestVertex {
    position: vec3f,
    u: f32,
    normal: vec3f,
    v: f32,
}

struct PartMaterial {
    sigma: vec3f,
    ior: f32,
    base_color: vec3f,
    flags: u32,
    emissive: vec3f,
    roughness: f32,
    dispersion: f32,
    priority: i32,
    base_color_layer: i32,
    emissive_layer: i32,
}

const FLAG_OPAQUE: u32 = 1u;
const FLAG_THIN_WALL: u32 = 2u;
const FLAG_FLAT: u32 = 4u;
const FLAG_PLANE: u32 = 8u;
const FLAG_VERTEX_COLOR: u32 = 16u;
const FLAG_UNLIT: u32 = 32u;
const FLAG_DOUBLE_SIDED: u32 = 64u;
const BASE_COLOR_SAMPLING_SHIFT: u32 = 8u;
const EMISSIVE_SAMPLING_SHIFT: u32 = 16u;
const FLAG_TURNED: u32 = 1u << 23u;     // an operand that is taken away from its body
const OPERAND_SHIFT: u32 = 24u;         // number of the operand of a body that a part is, and one; else 0

const NO_TRIANGLE: u32 = 0xffffffu;
