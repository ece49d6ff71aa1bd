#include "lib/march_settings.inc.wgsl"
// Fills questionable pixels from good ones around them (CL §2.3, second strategy; Fig. 3): a low-pass filter over those
// that see the same part first, so that no outline smears. Windows of 5×5, then 9×9, then 17×17 pixels, until there is
// a good one.

@group(0) @binding(0) var<uniform> settings: MarchSettings;
@group(0) @binding(1) var raw_radiance: texture_2d<f32>;
@group(0) @binding(2) var raw_channel: texture_2d<f32>;
@group(0) @binding(3) var first_triangle: texture_2d<u32>;
@group(0) @binding(4) var path_first: texture_2d<f32>;
@group(0) @binding(5) var radiance: texture_storage_2d<rgba32float, write>;
@group(0) @binding(6) var channel: texture_storage_2d<rgba32float, write>;

const WIDEST: i32 = 8;

fn first_part(pixel: vec2i) -> f32 {
    return select(0.0, textureLoad(path_first, pixel, 0).w, textureLoad(first_triangle, pixel, 0).x != 0u);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= settings.size) {
        return;
    }
    let pixel = vec2i(id.xy);
    let last = vec2i(settings.size) - 1;
    var seen = textureLoad(raw_radiance, pixel, 0);
    var value = textureLoad(raw_channel, pixel, 0);
    let averages = settings.channel == CHANNEL_THICKNESS || settings.channel == CHANNEL_TRANSMITTANCE;
    var reach = select(2, 2 * WIDEST, seen.w != 0.0);
    var weight = 0.0;
    var sum = vec3f(0.0);
    var sum_value = vec4f(0.0);
    while weight == 0.0 && reach <= WIDEST {
        let part = first_part(pixel);
        let lo = max(pixel - reach, vec2i(0));
        let hi = min(pixel + reach, last);
        for (var y = lo.y; y <= hi.y; y++) {
            for (var x = lo.x; x <= hi.x; x++) {
                let other_pixel = vec2i(x, y);
                let other = textureLoad(raw_radiance, other_pixel, 0);
                let away = vec2f(other_pixel - pixel) / f32(reach);
                let near = exp(-2.0 * dot(away, away));
                let w = select(0.0, near, other.w != 0.0 && first_part(other_pixel) == part);
                weight += w;
                sum += w * other.rgb;
                sum_value += w * textureLoad(raw_channel, other_pixel, 0);
            }
        }
        reach *= 2;
    }
    if weight > 0.0 {
        seen = vec4f(sum / weight, seen.w);
        value = select(value, sum_value / weight, averages);
    }
    textureStore(radiance, pixel, seen);
    textureStore(channel, pixel, value);
}
