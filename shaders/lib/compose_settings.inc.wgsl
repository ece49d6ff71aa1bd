// What the compose passes are told; `ComposeSettings` of `compose.rs`.
struct ComposeSettings {
    exposure: f32,
    max: f32,           // the value of a channel that is shown brightest
    position: f32,      // of the slice, 0 … 1
    axis: u32,          // of the slice: 0 = x, 1 = y, 2 = z
    kind: u32,          // of a channel: KIND_*
    compares: u32,      // 1: `truth` holds the view grid's true voxels
    filled: u32,        // 1: `interior` holds the view grid's solid
    _pad: u32,
}

const KIND_NUMBER: u32 = 0u;
const KIND_COLOR: u32 = 1u;
const KIND_DIRECTION: u32 = 2u;
const KIND_POSITION: u32 = 3u;
