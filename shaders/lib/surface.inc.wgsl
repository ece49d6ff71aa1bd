#include "lib/geometry.inc.wgsl"
// The exact place where a ray meets a triangle's plane, and the smooth normal there.
//
// Bind as: var<storage, read> vertices: array<Vertex>; var<storage, read> indices: array<u32>;



struct Surface {
    t: f32,
    normal: vec3f,      // smooth, unit, outward
    front: bool,        // met from the front
    part: u32,
}

struct Barycentric {
    weights: vec3f,
    corner: vec3u,      // vertex numbers
}

// Weights of the triangle's corners at `p`, extrapolated no further than −2 … 3.
fn barycentric_at(triangle: u32, p: vec3f) -> Barycentric {
    let corner = vec3u(indices[3u * triangle], indices[3u * triangle + 1u], indices[3u * triangle + 2u]);
    let p0 = vertices[corner.x].position;
    let e1 = vertices[corner.y].position - p0;
    let e2 = vertices[corner.z].position - p0;
    return Barycentric(barycentric_weights(p - p0, e1, e2), corner);
}

fn barycentric_weights(v: vec3f, e1: vec3f, e2: vec3f) -> vec3f {
    let n = cross(e1, e2);
    let n2 = dot(n, n);
    let b = clamp(vec2f(dot(cross(v, e2), n), dot(cross(e1, v), n)) / n2, vec2f(-2.0), vec2f(3.0));
    return select(vec3f(1.0 - b.x - b.y, b), vec3f(1.0 / 3.0), n2 == 0.0);
}

// The ray meets the triangle's plane at t, kept within `slack` of `t_near` … `t_far`, which also holds for a triangle
// that is seen edge on. With `t_near` > `t_far` the range is the triangle's own.
fn surface_at(triangle: u32, origin: vec3f, direction: vec3f, t_near: f32, t_far: f32, slack: f32) -> Surface {
    let i0 = indices[3u * triangle];
    let i1 = indices[3u * triangle + 1u];
    let i2 = indices[3u * triangle + 2u];
    let p0 = vertices[i0].position;
    let e1 = vertices[i1].position - p0;
    let e2 = vertices[i2].position - p0;
    let n0 = vertices[i0].normal;
    let n1 = vertices[i1].normal;
    let n2 = vertices[i2].normal;
    let cross_normal = cross(e1, e2);
    // Vertex normals tell which side is out, whatever the winding.
    let geometric = select(cross_normal, -cross_normal, dot(cross_normal, n0 + n1 + n2) < 0.0);

    let d0 = dot(p0 - origin, direction);
    let d1 = d0 + dot(e1, direction);
    let d2 = d0 + dot(e2, direction);
    let own = t_near > t_far;
    let lo = select(t_near, min(d0, min(d1, d2)), own) - slack;
    let hi = select(t_far, max(d0, max(d1, d2)), own) + slack;
    let cosine = dot(geometric, direction);
    let t_plane = dot(geometric, p0 - origin) / cosine;
    let t = select(lo + slack, clamp(t_plane, lo, hi), abs(cosine) > 1e-20);

    let b = barycentric_weights(origin + t * direction - p0, e1, e2);
    let smooth_normal = b.x * n0 + b.y * n1 + b.z * n2;
    let length2 = dot(smooth_normal, smooth_normal);
    let normal = select(geometric, smooth_normal, length2 > 1e-12);
    return Surface(t, normalize(normal), cosine < 0.0, vertices[i0].part);
}
