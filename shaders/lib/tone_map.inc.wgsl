// From linear radiance to what a display shows.

// Where the curve leaves the straight line.
const TONE_KNEE: f32 = 0.72;
// How much light above the curve it takes to bleach a colour half way to white.
const TONE_BLEACH: f32 = 5.0;

// The curve of the brightest channel: straight up to the knee, then a hyperbola that goes on at the same slope and
// reaches 1 at infinity.
fn tone_curve(x: f32) -> f32 {
    let room = 1.0 - TONE_KNEE;
    return select(1.0 - room * room / (x - TONE_KNEE + room), x, x <= TONE_KNEE);
}

// Linear radiance to linear 0 … 1. Up to the knee nothing changes. Above, all channels shrink by what the brightest must,
// so that tinted glass keeps its hue where a curve for each channel would turn amber to yellow and blue to cyan; what is
// far too bright bleaches towards white, as film does.
fn tone_map(radiance: vec3f) -> vec3f {
    let color = clamp(radiance, vec3f(0.0), vec3f(1e6));
    let peak = max(color.r, max(color.g, color.b));
    if peak <= TONE_KNEE {
        return color;
    }
    let shown = tone_curve(peak);
    let over = peak - shown;
    return mix(color * (shown / peak), vec3f(shown), over / (over + TONE_BLEACH));
}

// Linear 0 … 1 to the sRGB curve.
fn srgb_encode(linear: vec3f) -> vec3f {
    let low = linear * 12.92;
    let high = 1.055 * pow(max(linear, vec3f(0.0031308)), vec3f(1.0 / 2.4)) - 0.055;
    return select(high, low, linear <= vec3f(0.0031308));
}

// An ordered pattern of 8×8 pixels within ±½ of a step of 8 bits, added before rounding: a soft sky shows no bands.
fn dither(pixel: vec2u) -> f32 {
    let q = pixel.x ^ pixel.y;
    let y = pixel.y;
    let rank = ((q & 1u) << 5u) | ((y & 1u) << 4u) | ((q & 2u) << 2u) | ((y & 2u) << 1u) | ((q & 4u) >> 1u) | ((y & 4u) >> 2u);
    return ((f32(rank) + 0.5) / 64.0 - 0.5) / 255.0;
}
