#include "lib/geometry.inc.wgsl"
#include "lib/surroundings.inc.wgsl"
// The triangle that each pixel sees first, by rasterizing: a crisp outline, and no walk to the first surface.

@group(0) @binding(0) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(1) var<storage, read> indices: array<u32>;
@group(0) @binding(2) var<uniform> surroundings: Surroundings;

struct Corner {
    @builtin(position) clip: vec4f,
    @location(0) @interpolate(flat) triangle: u32,
}

// Eye depth, world units, nearer than which nothing is drawn.
const NEAR: f32 = 1e-3;

@vertex
fn corner(@builtin(vertex_index) number: u32) -> Corner {
    let p = vertices[indices[number]].position - surroundings.eye;
    let depth = dot(p, surroundings.forward);
    let x = dot(p, surroundings.right) / (surroundings.tan_half_fov * surroundings.aspect);
    let y = dot(p, surroundings.up) / surroundings.tan_half_fov;
    // 1 at NEAR, 0 at infinity.
    return Corner(vec4f(x, y, NEAR, depth), number / 3u);
}

@fragment
fn number_triangle(corner: Corner) -> @location(0) u32 {
    return corner.triangle + 1u;
}
