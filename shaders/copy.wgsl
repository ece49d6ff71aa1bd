#include "lib/dispatch.inc.wgsl"
// Copies words, a thread each: what a scan over the same words is held against.

@group(0) @binding(0) var<storage, read> source: array<u32>;
@group(0) @binding(1) var<storage, read_write> copied: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let word = thread_index(id, workgroups, 64u);
    if word < arrayLength(&source) {
        copied[word] = source[word];
    }
}
