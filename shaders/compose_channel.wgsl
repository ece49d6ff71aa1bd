#include "lib/compose_settings.inc.wgsl"
#include "lib/tone_map.inc.wgsl"
// A float channel in false colours.

@group(0) @binding(0) var<uniform> compose_settings: ComposeSettings;
@group(0) @binding(1) var channel: texture_2d<f32>;
@group(0) @binding(2) var picture: texture_storage_2d<rgba8unorm, write>;

// Shown where the channel has no value.
const NOTHING: vec3f = vec3f(0.09, 0.09, 0.11);

fn is_nan(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7fffffffu) > 0x7f800000u;
}

// Dark violet, blue, green, yellow: evenly brighter, readable without colour vision. sRGB-encoded; anchors every eighth
// of the way, after the matplotlib map `viridis`.
fn viridis(x: f32) -> vec3f {
    var anchors = array<vec3f, 9>(
        vec3f(0.267, 0.005, 0.329), vec3f(0.279, 0.175, 0.483), vec3f(0.230, 0.322, 0.546), vec3f(0.173, 0.449, 0.558),
        vec3f(0.128, 0.567, 0.551), vec3f(0.158, 0.684, 0.502), vec3f(0.369, 0.789, 0.383), vec3f(0.678, 0.864, 0.190),
        vec3f(0.993, 0.906, 0.144));
    let at = clamp(x, 0.0, 1.0) * 8.0;
    let i = min(u32(at), 7u);
    return mix(anchors[i], anchors[i + 1u], at - f32(i));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(picture);
    if any(id.xy >= size) {
        return;
    }
    let value = textureLoad(channel, id.xy * textureDimensions(channel) / size, 0).rgb;
    let scale = 1.0 / max(compose_settings.max, 1e-9);
    var color = NOTHING;
    if !is_nan(value.x) {
        switch compose_settings.kind {
            case KIND_NUMBER: { color = viridis(value.x * scale); }
            case KIND_COLOR: { color = srgb_encode(clamp(value * scale, vec3f(0.0), vec3f(1.0))); }
            case KIND_DIRECTION: { color = 0.5 + 0.5 * value; }
            default: { color = 0.5 + 0.5 * clamp(value * scale, vec3f(-1.0), vec3f(1.0)); }
        }
    }
    textureStore(picture, id.xy, vec4f(color, 1.0));
}
