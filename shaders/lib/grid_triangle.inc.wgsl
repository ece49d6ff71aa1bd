#include "lib/geometry.inc.wgsl"
#include "lib/grid.inc.wgsl"
// A triangle in grid space, cut at the eye where the grid is a perspective one.
//
// A perspective map turns a triangle that reaches behind the eye inside out. It is cut where the eye depth is half of
// `near`, well before the grid begins; what is left is one triangle or two. The host's twin is `voxelize/clip.rs`.

// Whether the grid is a perspective one: shaders are compiled for one kind.
override perspective: bool = false;

// The part of a triangle that a grid may see: `pieces` triangles, the first a, b, c, the second a, c, d.
struct GridTriangle {
    a: vec3f,
    b: vec3f,
    c: vec3f,
    d: vec3f,
    pieces: u32,
}

fn is_finite(v: vec3f) -> bool {
    return all((bitcast<vec3u>(v) & vec3u(0x7f800000u)) != vec3u(0x7f800000u));
}

fn grid_triangle(g: Grid, w0: vec3f, w1: vec3f, w2: vec3f) -> GridTriangle {
    var h0 = g.grid_from_world * vec4f(w0, 1.0);
    var h1 = g.grid_from_world * vec4f(w1, 1.0);
    var h2 = g.grid_from_world * vec4f(w2, 1.0);
    if !perspective {
        let ok = is_finite(h0.xyz) && is_finite(h1.xyz) && is_finite(h2.xyz);
        return GridTriangle(h0.xyz, h1.xyz, h2.xyz, h2.xyz, select(0u, 1u, ok));
    }
    let limit = 0.5 * g.near;
    let behind = vec3<bool>(h0.w < limit, h1.w < limit, h2.w < limit);
    let count = u32(behind.x) + u32(behind.y) + u32(behind.z);
    // Turn the triangle until vertex 0 is the one on its own side.
    let odd = select(behind, !behind, count == 2u);
    if odd.y {
        let t = h0; h0 = h1; h1 = h2; h2 = t;
    } else if odd.z {
        let t = h0; h0 = h2; h2 = h1; h1 = t;
    }
    let to_1 = h0 + (h1 - h0) * ((limit - h0.w) / select(h1.w - h0.w, 1.0, h1.w == h0.w));
    let to_2 = h0 + (h2 - h0) * ((limit - h0.w) / select(h2.w - h0.w, 1.0, h2.w == h0.w));
    var quad = array<vec4f, 4>(h0, h1, h2, h2);
    if count == 1u {
        quad = array<vec4f, 4>(to_1, h1, h2, to_2);
    } else if count == 2u {
        quad = array<vec4f, 4>(h0, to_1, to_2, to_2);
    }
    let a = quad[0].xyz / quad[0].w;
    let b = quad[1].xyz / quad[1].w;
    let c = quad[2].xyz / quad[2].w;
    let d = quad[3].xyz / quad[3].w;
    let ok = count < 3u && is_finite(a) && is_finite(b) && is_finite(c) && is_finite(d);
    return GridTriangle(a, b, c, d, select(0u, select(1u, 2u, count == 1u), ok));
}
