// Work of a known length: turns a hash as often as it is told. What the device's timestamps are checked on, in a compute
// pass and in a render pass: a driver may be right about one and wrong about the other.

struct Turns {
    count: u32,
}

@group(0) @binding(0) var<uniform> turns: Turns;
@group(0) @binding(1) var<storage, read_write> output: array<u32>;

fn spun(seed: u32) -> u32 {
    var state = seed;
    for (var turn = 0u; turn < turns.count; turn += 1u) {
        state = (state ^ (state >> 16u)) * 0x7feb352du + turn;
    }
    return state;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    output[id.x] = spun(id.x + 1u);
}

@vertex
fn corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(f32(index << 1u & 2u) * 2.0 - 1.0, f32(index & 2u) * 2.0 - 1.0, 0.0, 1.0);
}

@fragment
fn pixel(@builtin(position) at: vec4f) -> @location(0) vec4f {
    return vec4f(f32(spun(u32(at.x) + u32(at.y) * 64u) & 255u) / 255.0);
}
