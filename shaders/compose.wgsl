#include "lib/compose_settings.inc.wgsl"
#include "lib/tone_map.inc.wgsl"
// The picture: tone map and sRGB, at the march's resolution (`main`), or in two steps where the picture is larger:
// `encode` at the march's resolution, then `enlarge`.

@group(0) @binding(0) var<uniform> compose_settings: ComposeSettings;
@group(0) @binding(1) var radiance: texture_2d<f32>;
@group(0) @binding(2) var picture: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(3) var encoded: texture_storage_2d<rgba16float, write>;
@group(0) @binding(4) var small: texture_2d<f32>;
@group(0) @binding(5) var small_sampler: sampler;

fn shown(pixel: vec2u) -> vec3f {
    return srgb_encode(tone_map(compose_settings.exposure * textureLoad(radiance, pixel, 0).rgb));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(picture)) {
        return;
    }
    textureStore(picture, id.xy, vec4f(shown(id.xy) + dither(id.xy), 1.0));
}

@compute @workgroup_size(8, 8)
fn encode(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(encoded)) {
        return;
    }
    textureStore(encoded, id.xy, vec4f(shown(id.xy), 1.0));
}

// Catmull–Rom, which keeps edges crisp, by five bilinear samples: the four corners' weights are small and left out.
@compute @workgroup_size(8, 8)
fn enlarge(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(picture);
    if any(id.xy >= size) {
        return;
    }
    let texels = vec2f(textureDimensions(small));
    let p = (vec2f(id.xy) + 0.5) / vec2f(size) * texels;
    let middle = floor(p - 0.5) + 0.5;
    let f = p - middle;
    let w0 = f * (-0.5 + f * (1.0 - 0.5 * f));
    let w3 = f * f * (-0.5 + 0.5 * f);
    let w2 = f * (0.5 + f * (2.0 - 1.5 * f));
    let w1 = 1.0 - w0 - w2 - w3;
    let w12 = w1 + w2;
    let at0 = (middle - 1.0) / texels;
    let at12 = (middle + w2 / w12) / texels;
    let at3 = (middle + 2.0) / texels;
    let left = w0.x * w12.y;
    let right = w3.x * w12.y;
    let above = w12.x * w0.y;
    let below = w12.x * w3.y;
    let center = w12.x * w12.y;
    var sum = center * textureSampleLevel(small, small_sampler, at12, 0.0).rgb;
    sum += left * textureSampleLevel(small, small_sampler, vec2f(at0.x, at12.y), 0.0).rgb;
    sum += right * textureSampleLevel(small, small_sampler, vec2f(at3.x, at12.y), 0.0).rgb;
    sum += above * textureSampleLevel(small, small_sampler, vec2f(at12.x, at0.y), 0.0).rgb;
    sum += below * textureSampleLevel(small, small_sampler, vec2f(at12.x, at3.y), 0.0).rgb;
    let color = clamp(sum / (left + right + above + below + center), vec3f(0.0), vec3f(1.0));
    textureStore(picture, id.xy, vec4f(color + dither(id.xy), 1.0));
}
