// Snell and Fresnel at an interface between two dielectrics.

struct Bend {
    direction: vec3f,   // unit; of the refracted ray, or of the mirrored one
    reflectance: f32,   // unpolarized Fresnel; 1 where all is reflected
    total: bool,        // total internal reflection
}

// `d` and `n` are unit, n·d < 0; `eta` is the index before over the index behind.
fn bend_at(d: vec3f, n: vec3f, eta: f32) -> Bend {
    let cos_in = -dot(n, d);
    let sin2_out = eta * eta * (1.0 - cos_in * cos_in);
    let total = sin2_out >= 1.0;
    let cos_out = sqrt(max(1.0 - sin2_out, 0.0));
    let refracted = eta * d + (eta * cos_in - cos_out) * n;
    let mirrored = d + (2.0 * cos_in) * n;
    let s = (eta * cos_in - cos_out) / (eta * cos_in + cos_out);
    let p = (cos_in - eta * cos_out) / (cos_in + eta * cos_out);
    return Bend(normalize(select(refracted, mirrored, total)), select(0.5 * (s * s + p * p), 1.0, total), total);
}

// `n` turned so that `d` meets it from its front even where interpolation tips it past the silhouette.
fn facing(n: vec3f, d: vec3f) -> vec3f {
    let c = dot(n, d);
    return select(n, normalize(n - (c + 1e-3) * d), c > -1e-3);
}
