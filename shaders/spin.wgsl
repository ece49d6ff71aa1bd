// Work of a known length: turns a hash as often as it is told. What the device's timestamps are checked on.

struct Turns {
    count: u32,
}

@group(0) @binding(0) var<uniform> turns: Turns;
@group(0) @binding(1) var<storage, read_write> output: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    var state = id.x + 1u;
    for (var turn = 0u; turn < turns.count; turn += 1u) {
        state = (state ^ (state >> 16u)) * 0x7feb352du + turn;
    }
    output[id.x] = state;
}
