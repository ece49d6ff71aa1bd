// Puts the picture into its place in the window, scaled smoothly. One triangle covers the viewport.

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var linear_clamp: sampler;

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) uv: vec2f,
}

@vertex
fn corner(@builtin(vertex_index) index: u32) -> Corner {
    let uv = vec2f(f32(index << 1u & 2u), f32(index & 2u));
    return Corner(vec4f(uv * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0), 0.0, 1.0), uv);
}

@fragment
fn texel(at: Corner) -> @location(0) vec4f {
    return vec4f(textureSample(picture, linear_clamp, at.uv).rgb, 1.0);
}
