#include "lib/dispatch.inc.wgsl"
#include "lib/march_settings.inc.wgsl"
// Fills questionable pixels from good ones around them (CL §2.3, second strategy; Fig. 3): a low-pass filter over those
// that see the same part first, so that no outline smears. Windows of 5×5, then 9×9, then 17×17 pixels, until there is
// a good one. Only the listed pixels cost anything.
//
// `gather` leaves what it finds in the path's first two pictures, which nobody needs any more; `place` puts it in place:
// so no pixel is filled from one that is filled in the same pass.

@group(0) @binding(0) var<uniform> settings: MarchSettings;
@group(0) @binding(1) var<storage, read> questionable: array<u32>;
@group(0) @binding(2) var seen_radiance: texture_2d<f32>;
@group(0) @binding(3) var seen_channel: texture_2d<f32>;
@group(0) @binding(4) var first_triangle: texture_2d<u32>;
@group(0) @binding(5) var path_first: texture_2d<f32>;
@group(0) @binding(6) var found_radiance: texture_storage_2d<rgba32float, write>;
@group(0) @binding(7) var found_channel: texture_storage_2d<rgba32float, write>;
@group(0) @binding(8) var filled_radiance: texture_2d<f32>;
@group(0) @binding(9) var filled_channel: texture_2d<f32>;
@group(0) @binding(10) var radiance: texture_storage_2d<rgba32float, write>;
@group(0) @binding(11) var channel: texture_storage_2d<rgba32float, write>;

// As in `lib/path_store.inc.wgsl`.
const LIST_COUNT: u32 = 3u;
const LIST_PIXELS: u32 = 4u;
const NARROWEST: i32 = 2;
const WIDEST: i32 = 8;

fn listed_pixel(number: u32) -> vec2i {
    let bits = questionable[LIST_PIXELS + number];
    return vec2i(i32(bits & 0xffffu), i32(bits >> 16u));
}

fn first_part(pixel: vec2i) -> f32 {
    let has_path = settings.rasterized == 0u || textureLoad(first_triangle, pixel, 0).x != 0u;
    return select(0.0, abs(textureLoad(path_first, pixel, 0).w), has_path);
}

@compute @workgroup_size(64)
fn gather(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let number = thread_index(id, workgroups, 64u);
    if number >= questionable[LIST_COUNT] {
        return;
    }
    let pixel = listed_pixel(number);
    let part = first_part(pixel);
    let last = vec2i(settings.size) - 1;
    let averages = settings.channel == CHANNEL_THICKNESS || settings.channel == CHANNEL_TRANSMITTANCE;
    var weight = 0.0;
    var sum = vec3f(0.0);
    var sum_value = vec4f(0.0);
    var reach = NARROWEST;
    while weight == 0.0 && reach <= WIDEST {
        let lo = max(pixel - reach, vec2i(0));
        let hi = min(pixel + reach, last);
        for (var y = lo.y; y <= hi.y; y++) {
            for (var x = lo.x; x <= hi.x; x++) {
                let beside = vec2i(x, y);
                let there = textureLoad(seen_radiance, beside, 0);
                let away = vec2f(beside - pixel) / f32(reach);
                let good = there.w != 0.0 && first_part(beside) == part;
                let w = select(0.0, exp(-2.0 * dot(away, away)), good);
                weight += w;
                sum += w * there.rgb;
                if averages {
                    sum_value += w * textureLoad(seen_channel, beside, 0);
                }
            }
        }
        reach *= 2;
    }
    let found = weight > 0.0;
    let kept = textureLoad(seen_radiance, pixel, 0);
    let kept_value = textureLoad(seen_channel, pixel, 0);
    textureStore(found_radiance, pixel, select(kept, vec4f(sum / weight, kept.w), found));
    textureStore(found_channel, pixel, select(kept_value, sum_value / weight, found && averages));
}

@compute @workgroup_size(64)
fn place(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let number = thread_index(id, workgroups, 64u);
    if number >= questionable[LIST_COUNT] {
        return;
    }
    let pixel = listed_pixel(number);
    textureStore(radiance, pixel, textureLoad(filled_radiance, pixel, 0));
    textureStore(channel, pixel, textureLoad(filled_channel, pixel, 0));
}
