// The point of a triangle that is closest to another point. A needle or a point is a triangle too.

// What does not depend on the point.
struct ClosestFrame {
    a: vec3f,
    b: vec3f,
    c: vec3f,
    normal: vec3f,          // not unit: twice the area long
    inverse_square: vec4f,  // of the sides ab, bc, ca and of the normal; 0 where a side is a point
}

fn inverse_or_zero(v: f32) -> f32 {
    return select(0.0, 1.0 / v, v > 0.0);
}

fn closest_frame(a: vec3f, b: vec3f, c: vec3f) -> ClosestFrame {
    let n = cross(b - a, c - a);
    let squares = vec4f(dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c), dot(n, n));
    return ClosestFrame(a, b, c, n, vec4f(
        inverse_or_zero(squares.x),
        inverse_or_zero(squares.y),
        inverse_or_zero(squares.z),
        inverse_or_zero(squares.w),
    ));
}

// The closest point minus `q`. The nearest of the three sides' points, or the plane's foot if that lies inside.
fn closest_offset(f: ClosestFrame, q: vec3f) -> vec3f {
    let a = f.a - q;
    let b = f.b - q;
    let c = f.c - q;
    let ab = f.b - f.a;
    let bc = f.c - f.b;
    let ca = f.a - f.c;
    let on_ab = a + ab * clamp(-dot(a, ab) * f.inverse_square.x, 0.0, 1.0);
    let on_bc = b + bc * clamp(-dot(b, bc) * f.inverse_square.y, 0.0, 1.0);
    let on_ca = c + ca * clamp(-dot(c, ca) * f.inverse_square.z, 0.0, 1.0);
    var best = on_ab;
    best = select(best, on_bc, dot(on_bc, on_bc) < dot(best, best));
    best = select(best, on_ca, dot(on_ca, on_ca) < dot(best, best));
    // The sides of q's foot: q − a and its foot differ along the normal alone.
    let inside = dot(cross(a, ab), f.normal) >= 0.0 && dot(cross(b, bc), f.normal) >= 0.0
        && dot(cross(c, ca), f.normal) >= 0.0 && f.inverse_square.w > 0.0;
    return select(best, f.normal * (dot(f.normal, a) * f.inverse_square.w), inside);
}
