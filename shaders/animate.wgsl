#include "lib/dispatch.inc.wgsl"
#include "lib/geometry.inc.wgsl"
// Moves every vertex: morph targets, then up to four joints, then the model's deformers, then its placement.
//
// Normals go through the inverse transpose of each step's Jacobian, as the cofactor matrix with the sign of the
// determinant: a mirrored node keeps its normals outward though its triangles' winding turns round.

struct Influence {
    joints: vec4u,
    weights: vec4f,
}

struct Morph {
    position: vec3f,
    _pad0: u32,
    normal: vec3f,
    _pad1: u32,
}

// Where a part's vertices, targets and weights lie. Does not change while a scene is shown.
struct PartMotion {
    model: u32,
    vertex_first: u32,
    vertex_count: u32,
    flat_shaded: u32,
    morph_first: u32,       // in `morphs`: target after target, `vertex_count` each
    morph_count: u32,
    weight_first: u32,      // in `weights`
    _pad: u32,
}

struct ModelMotion {
    world_from_model: mat4x4f,
    deformer_first: u32,
    deformer_count: u32,
    _pad: vec2u,
}

struct DeformerMotion {
    axis: vec3f,            // unit, model space
    kind: u32,
    along: vec3f,           // wave: unit, model space
    rate: f32,              // twist: radians a unit; wave: radians a unit along `axis`
    amplitude: f32,         // wave: model units
    phase: f32,             // wave: radians
    _pad: vec2u,
}

const DEFORMER_TWIST: u32 = 0u;
const MAX_DEFORMERS: u32 = 64u;
// Fills `flat_triangles` up: the smallest buffer has room for four.
const PADDING: u32 = 0xffffffffu;

@group(0) @binding(0) var<storage, read_write> vertices: array<Vertex>;     // `part` is set when a scene is uploaded
@group(0) @binding(1) var<storage, read> rest_vertices: array<RestVertex>;
@group(0) @binding(2) var<storage, read> influences: array<Influence>;
@group(0) @binding(3) var<storage, read> morphs: array<Morph>;
@group(0) @binding(4) var<storage, read> part_motions: array<PartMotion>;
@group(0) @binding(5) var<storage, read> model_motions: array<ModelMotion>;
@group(0) @binding(6) var<storage, read> matrices: array<mat4x4f>;           // model from rest
@group(0) @binding(7) var<storage, read> weights: array<f32>;
@group(0) @binding(8) var<uniform> deformers: array<DeformerMotion, MAX_DEFORMERS>;
@group(0) @binding(9) var<storage, read> indices: array<u32>;
@group(0) @binding(10) var<storage, read> flat_triangles: array<u32>;

// The inverse transpose of `m` applied to `n`, times |det m|.
fn transform_normal(m: mat3x3f, n: vec3f) -> vec3f {
    let yz = cross(m[1], m[2]);
    let turned = yz * n.x + cross(m[2], m[0]) * n.y + cross(m[0], m[1]) * n.z;
    return select(turned, -turned, dot(m[0], yz) < 0.0);
}

fn linear_part(m: mat4x4f) -> mat3x3f {
    return mat3x3f(m[0].xyz, m[1].xyz, m[2].xyz);
}

struct Moved {
    position: vec3f,
    normal: vec3f,
}

// J = (1 + rate·(a × p′) ⊗ a)·R, whose determinant is 1.
fn twist(d: DeformerMotion, p: Moved) -> Moved {
    let height = dot(d.axis, p.position);
    let c = cos(d.rate * height);
    let s = sin(d.rate * height);
    let position = d.axis * height + (p.position - d.axis * height) * c + cross(d.axis, p.position) * s;
    let along_axis = d.axis * dot(d.axis, p.normal);
    let turned = along_axis + (p.normal - along_axis) * c + cross(d.axis, p.normal) * s;
    return Moved(position, turned - d.axis * (d.rate * dot(cross(d.axis, position), turned)));
}

// J = 1 + slope · along ⊗ axis; times its determinant, so that a fold does not divide by zero.
fn wave(d: DeformerMotion, p: Moved) -> Moved {
    let angle = d.rate * dot(d.axis, p.position) + d.phase;
    let slope = d.amplitude * d.rate * cos(angle);
    let determinant = 1.0 + slope * dot(d.axis, d.along);
    let turned = p.normal * determinant - d.axis * (slope * dot(d.along, p.normal));
    return Moved(p.position + d.along * (d.amplitude * sin(angle)), select(turned, -turned, determinant < 0.0));
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let v = thread_index(id, workgroups, 64u);
    if v >= arrayLength(&rest_vertices) {
        return;
    }
    let rest = rest_vertices[v];
    let part = vertices[v].part;
    let motion = part_motions[part];
    var p = Moved(rest.position, rest.normal);
    for (var t = 0u; t < motion.morph_count; t++) {
        let weight = weights[motion.weight_first + t];
        if weight != 0.0 {
            let target_index = motion.morph_first + t * motion.vertex_count + v - motion.vertex_first;
            p.position += weight * morphs[target_index].position;
            p.normal += weight * morphs[target_index].normal;
        }
    }

    let influence = influences[v];
    var model_from_rest = matrices[influence.joints.x] * influence.weights.x;
    if influence.weights.y != 0.0 {
        model_from_rest += matrices[influence.joints.y] * influence.weights.y;
    }
    if influence.weights.z != 0.0 {
        model_from_rest += matrices[influence.joints.z] * influence.weights.z;
    }
    if influence.weights.w != 0.0 {
        model_from_rest += matrices[influence.joints.w] * influence.weights.w;
    }
    let rest_turn = linear_part(model_from_rest);
    p = Moved((model_from_rest * vec4f(p.position, 1.0)).xyz, transform_normal(rest_turn, p.normal));

    let model = model_motions[motion.model];
    for (var d = 0u; d < model.deformer_count; d++) {
        let deformer = deformers[model.deformer_first + d];
        if deformer.kind == DEFORMER_TWIST {
            p = twist(deformer, p);
        } else {
            p = wave(deformer, p);
        }
    }

    let placement = linear_part(model.world_from_model);
    vertices[v].position = (model.world_from_model * vec4f(p.position, 1.0)).xyz;
    vertices[v].mirrored = u32((determinant(rest_turn) < 0.0) != (determinant(placement) < 0.0));
    if motion.flat_shaded == 0u {
        let normal = transform_normal(placement, p.normal);
        let size = length(normal);
        vertices[v].normal = select(vec3f(0.0), normal / size, size > 0.0);
    }
}

// Parts without normals take those of their triangles; such a part's vertices belong to one triangle each.
@compute @workgroup_size(64)
fn flat_normals(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) workgroups: vec3u) {
    let i = thread_index(id, workgroups, 64u);
    if i >= arrayLength(&flat_triangles) {
        return;
    }
    let triangle = flat_triangles[i];
    if triangle == PADDING {
        return;
    }
    let first = 3u * triangle;
    let a = indices[first];
    let b = indices[first + 1u];
    let c = indices[first + 2u];
    let area = cross(vertices[b].position - vertices[a].position, vertices[c].position - vertices[a].position);
    let size = length(area);
    let outward = select(area, -area, vertices[a].mirrored != 0u);
    let normal = select(vec3f(0.0), outward / size, size > 0.0);
    vertices[a].normal = normal;
    vertices[b].normal = normal;
    vertices[c].normal = normal;
}
