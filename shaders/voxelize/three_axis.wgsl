#include "lib/dispatch.inc.wgsl"
#include "lib/geometry.inc.wgsl"
#include "lib/grid_triangle.inc.wgsl"
#include "lib/occupancy.inc.wgsl"
// Triangles by dominant axis into three directional sheet buffers, merged into the worksheet (DO §3–4; TR §1.4.4).
//
// Seen along its dominant axis d a triangle has the coordinates u, v, w of axes d + 1, d + 2, d. The sheet of d has a texel
// a (u, v) and slab; a slab is 32 cells along d, a bit each. A sheet's patches, one a slab, lie one after the other.

@group(0) @binding(0) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(1) var<uniform> grid_index: vec4u;
@group(0) @binding(2) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(3) var<storage, read> indices: array<u32>;
@group(0) @binding(4) var<storage, read> materials: array<PartMaterial>;
@group(0) @binding(6) var<storage, read_write> sheets: array<atomic<u32>>;

// Bits are added, each 8-bit component of a texel by itself and no further than 255, as blending does (DO §4.2).
override additive: bool = false;

const SLAB: u32 = 32u;
const WORKGROUP: u32 = 64u;

// What is drawn for a triangle is its rectangle, two triangles; the fragment asks whether the triangle holds its middle.
// So nothing hangs on how a rasterizer rounds and clips, and slices may bend lines, as they do in perspective.
const RECTANGLE_VERTICES: u32 = 6u;

// A bit a vertex: which lie at the rectangle's higher end.
const HIGH_U: u32 = 0x32u;
const HIGH_V: u32 = 0x2cu;

// By how much an axis must lead those after it: a triangle that faces two alike goes to the later one, however it rounds.
const DOMINANT: f32 = 1.001;

// What rasterizers may take away of a rectangle.
const SLACK: f32 = 1.0 / 32.0;

// x, y, z → u, v, w.
fn seen_along(axis: u32, p: vec3f) -> vec3f {
    return select(select(p, p.zxy, axis == 1u), p.yzx, axis == 0u);
}

fn sheet_size(g: Grid, axis: u32) -> vec2u {
    return select(select(g.cells.xy, g.cells.zx, axis == 1u), g.cells.yz, axis == 0u);
}

fn slab_count(g: Grid, axis: u32) -> u32 {
    return (g.cells[axis] + SLAB - 1u) / SLAB;
}

// First texel of an axis' sheet; that of axis 3 is their number.
fn sheet_base(g: Grid, axis: u32) -> u32 {
    var base = 0u;
    for (var a = 0u; a < axis; a++) {
        let size = sheet_size(g, a);
        base += size.x * size.y * slab_count(g, a);
    }
    return base;
}

struct Fragment {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat, either) axis: u32,
    @location(1) @interpolate(flat, either) a: vec3f,   // u, v, w
    @location(2) @interpolate(flat, either) b: vec3f,
    @location(3) @interpolate(flat, either) c: vec3f,
}

// Pixel (fractional) of u, v of grid space: slices count along z.
fn pixel_of(g: Grid, axis: u32, p: vec3f) -> vec2f {
    var pixel = p.xy;
    if perspective && axis != 2u {
        pixel[1u - axis] = slice_of(g, clamp(pixel[1u - axis], 0.0, f32(g.cells.z)));
    }
    return pixel;
}

// `vertex` of a triangle seen along its dominant axis. The raster is a square of the grid's longest side.
@vertex
fn turned(@builtin(vertex_index) vertex: u32, @builtin(instance_index) piece: u32) -> Fragment {
    let g = grids[grid_index.x];
    let number = vertex / RECTANGLE_VERTICES;
    let corner = vertex % RECTANGLE_VERTICES;
    let v0 = vertices[indices[number * 3u]];
    let t = grid_triangle(
        g, v0.position, vertices[indices[number * 3u + 1u]].position, vertices[indices[number * 3u + 2u]].position);
    let second = select(t.c, t.b, piece == 0u);
    let third = select(t.d, t.c, piece == 0u);
    let n = abs(cross(second - t.a, third - t.a));
    let axis = select(select(2u, 1u, n.y > DOMINANT * n.z), 0u, n.x > DOMINANT * max(n.y, n.z));
    let is_unwanted = g.required_flags != 0u && (materials[v0.part].flags & g.required_flags) != g.required_flags;
    if piece >= t.pieces || n[axis] == 0.0 || is_unwanted {
        return Fragment(vec4f(2.0, 2.0, 2.0, 1.0), 0u, vec3f(0.0), vec3f(0.0), vec3f(0.0));
    }
    let corners = array<vec3f, 3>(seen_along(axis, t.a), seen_along(axis, second), seen_along(axis, third));
    let a = pixel_of(g, axis, corners[0]);
    let b = pixel_of(g, axis, corners[1]);
    let c = pixel_of(g, axis, corners[2]);
    let limit = vec2f(sheet_size(g, axis)) + 1.0;
    let lo = clamp(min(a, min(b, c)) - SLACK, vec2f(-1.0), limit);
    let hi = clamp(max(a, max(b, c)) + SLACK, vec2f(-1.0), limit);
    let place = select(lo, hi, vec2<bool>((HIGH_U >> corner & 1u) != 0u, (HIGH_V >> corner & 1u) != 0u));
    let p = 2.0 * place / f32(max(g.cells.x, max(g.cells.y, g.cells.z))) - 1.0;
    return Fragment(vec4f(p.x, -p.y, 0.5, 1.0), axis, corners[0], corners[1], corners[2]);
}

fn turn(a: vec2f, b: vec2f, p: vec2f) -> f32 {
    return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

// Adds a bit to a texel as an 8-bit render target does: one that is there already carries, and 255 is the end.
fn blend(texel: u32, bit: u32) {
    let shift = bit & 24u;
    var old = atomicLoad(&sheets[texel]);
    loop {
        let component = min((old >> shift & 255u) + (1u << (bit & 7u)), 255u);
        let result = atomicCompareExchangeWeak(&sheets[texel], old, (old & ~(255u << shift)) | (component << shift));
        if result.exchanged {
            break;
        }
        old = result.old_value;
    }
}

// Texelization: the triangle's depth at the pixel's middle is a bit of a texel of its axis' sheet.
@fragment
fn texelize(in: Fragment) {
    let g = grids[grid_index.x];
    let size = sheet_size(g, in.axis);
    let pixel = vec2u(in.position.xy);
    if any(pixel >= size) {
        return;
    }
    var p = vec2f(pixel) + 0.5;
    if perspective && in.axis != 2u {
        p[1u - in.axis] = slab(g, p[1u - in.axis]);
    }
    let weights = vec3f(
        turn(in.b.xy, in.c.xy, p), turn(in.c.xy, in.a.xy, p), turn(in.a.xy, in.b.xy, p));
    if any(weights < vec3f(0.0)) && any(weights > vec3f(0.0)) {
        return;
    }
    let depths = vec3f(in.a.z, in.b.z, in.c.z);
    let along = dot(weights.yz, depths.yz - depths.x) / (weights.x + weights.y + weights.z);
    var depth = clamp(
        depths.x + along, min(depths.x, min(depths.y, depths.z)), max(depths.x, max(depths.y, depths.z)));
    if perspective && in.axis == 2u && depth >= 0.0 && depth < f32(g.cells.z) {
        depth = slice_of(g, depth);
    }
    if !(depth >= 0.0 && depth < f32(g.cells[in.axis])) {
        return;
    }
    let cell = u32(depth);
    let texel = sheet_base(g, in.axis) + (cell / SLAB * size.y + pixel.y) * size.x + pixel.x;
    if additive {
        blend(texel, cell % SLAB);
    } else {
        atomicOr(&sheets[texel], 1u << (cell % SLAB));
    }
}

// Synthesis: a thread a texel takes its bits to the worksheet, which is the volume's words.
@compute @workgroup_size(WORKGROUP)
fn synthesize(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let texel = thread_index(id, groups, WORKGROUP);
    let g = grids[grid_index.x];
    if texel >= sheet_base(g, 3u) {
        return;
    }
    var bits = atomicLoad(&sheets[texel]);
    if bits == 0u {
        return;
    }
    let axis = select(0u, 1u, texel >= sheet_base(g, 1u)) + select(0u, 1u, texel >= sheet_base(g, 2u));
    let size = sheet_size(g, axis);
    let at = texel - sheet_base(g, axis);
    let u = at % size.x;
    let v = at / size.x % size.y;
    let first = at / (size.x * size.y) * SLAB;
    if axis == 2u {
        atomicOr(&occupancy[word_index(g, vec3u(u, v, first))], bits);
        return;
    }
    while bits != 0u {
        let w = first + firstTrailingBit(bits);
        bits &= bits - 1u;
        // Carries reach into the bits beyond a sheet's last slab.
        if w < g.cells[axis] {
            let cell = select(vec3u(v, w, u), vec3u(w, u, v), axis == 0u);
            atomicOr(&occupancy[word_index(g, cell)], word_bit(cell.z));
        }
    }
}
