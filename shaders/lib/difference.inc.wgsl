// Voxels held against the true ones: what differs is loud, what agrees is quiet.

const MISSING: vec3f = vec3f(0.93, 0.20, 0.16);
const SPURIOUS: vec3f = vec3f(0.22, 0.47, 1.0);

fn difference_color(marked: bool, true_voxel: bool, color: vec3f) -> vec3f {
    let quiet = mix(color, vec3f(dot(color, vec3f(0.3, 0.5, 0.2))), 0.8) * 0.72;
    return select(select(SPURIOUS, quiet, true_voxel), MISSING, !marked);
}
