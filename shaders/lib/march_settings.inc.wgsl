// What every pass of the stage `march` is told.
struct MarchSettings {
    size: vec2u,                // pixels
    rows: vec2u,                // to march now: the first, and the one behind the last; whole multiples of 8 but for the end
    max_events: u32,
    absorb: u32,                // 1: media absorb
    reflect: u32,               // 1: surfaces mirror
    channel: u32,               // CHANNEL_*
    cos_angle_threshold: f32,   // `hit = "voxel"`: a smaller angle between normals is the same surface again
    nan: f32,                   // a quiet NaN: the language has no way to write one
    rasterized: u32,            // 1: the first surface is; pixels without one have no path
    _pad: u32,
}

const CHANNEL_BEAUTY: u32 = 0u;
const CHANNEL_THICKNESS: u32 = 1u;
const CHANNEL_TRANSMITTANCE: u32 = 2u;
const CHANNEL_NORMAL: u32 = 3u;
const CHANNEL_EVENTS: u32 = 4u;
const CHANNEL_QUESTIONABLE: u32 = 5u;
const CHANNEL_EXIT_DIRECTION: u32 = 6u;
const CHANNEL_EXIT_POSITION: u32 = 7u;
const CHANNEL_GROUND_LIGHT: u32 = 8u;

// Where the middle of a pixel lies in the picture, 0 … 1.
fn picture_from_pixel(pixel: vec2u, size: vec2u) -> vec2f {
    return (vec2f(pixel) + 0.5) / vec2f(size);
}
