// A picture as glTF's samplers lay it on. The array's own sampler repeats and blends; the rest is done here.
//
// Bind as: var textures: texture_2d_array<f32>; var texture_sampler: sampler;

// `Sampling::bits` of the host: two bits for each wrap, one for the nearest texel; 0 is what the sampler does by itself.
const SAMPLING_MASK: u32 = 0x1fu;
const SAMPLING_NEAREST: u32 = 0x10u;
const WRAP_MASK: u32 = 3u;
const WRAP_REPEAT: u32 = 0u;
const WRAP_MIRROR: u32 = 1u;

// A coordinate brought within the picture; half a texel off its edge where the sampler would blend with the other one.
fn wrapped(x: f32, wrap: u32, half_texel: f32) -> f32 {
    if wrap == WRAP_REPEAT {
        return fract(x);
    }
    let mirrored = 1.0 - abs(fract(0.5 * x) * 2.0 - 1.0);
    return clamp(select(x, mirrored, wrap == WRAP_MIRROR), half_texel, 1.0 - half_texel);
}

// By how many halvings a picture is seen smaller than it is: a pixel covers `pixel_area` of a triangle that takes up
// `world_area` in the world and `uv_area` in the picture.
fn texel_level(pixel_area: f32, world_area: f32, uv_area: f32) -> f32 {
    let side = f32(textureDimensions(textures).x);
    return 0.5 * log2(max(pixel_area * uv_area * side * side / max(world_area, 1e-30), 1.0));
}

// The linear colour of layer `layer` at `uv`, its neighbourhood averaged by `level`.
fn texel(layer: i32, uv: vec2f, level: f32, sampling: u32) -> vec3f {
    var at = uv;
    if sampling != 0u {
        // Texels of the smaller copy.
        let side = max(f32(textureDimensions(textures).x) * exp2(-ceil(level)), 1.0);
        at = vec2f(wrapped(uv.x, sampling & WRAP_MASK, 0.5 / side),
                   wrapped(uv.y, (sampling >> 2u) & WRAP_MASK, 0.5 / side));
        at = select(at, (floor(at * side) + 0.5) / side, (sampling & SAMPLING_NEAREST) != 0u);
    }
    return textureSampleLevel(textures, texture_sampler, at, layer, level).rgb;
}

// The linear colour that a vertex carries in place of a texture coordinate: `uv_from_color` of the host.
fn color_from_uv(uv: vec2f) -> vec3f {
    let red = floor(uv.x / 4096.0);
    return vec3f(red, uv.x - red * 4096.0, uv.y) / 4095.0;
}
