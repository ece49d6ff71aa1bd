// Index of a thread in one-dimensional work that may be dispatched as several rows (see `ComputePass::dispatch`).
fn thread_index(global_id: vec3u, workgroups: vec3u, workgroup_size: u32) -> u32 {
    return global_id.y * workgroups.x * workgroup_size + global_id.x;
}
