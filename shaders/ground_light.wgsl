#include "lib/light_volume.inc.wgsl"
#include "lib/march_settings.inc.wgsl"
#include "lib/opaque.inc.wgsl"
#include "lib/surface.inc.wgsl"
// The channel `ground-light`: for the first opaque surface that the unbent ray of a pixel meets, behind whatever glass,
// the share of light 0 that absorption lets through to it. NaN where there is no such surface.

@group(0) @binding(0) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(1) var<storage, read> indices: array<u32>;
@group(0) @binding(2) var<storage, read> materials: array<PartMaterial>;
@group(0) @binding(3) var<storage, read> occupancy: array<u32>;
@group(0) @binding(4) var<storage, read> ranks: array<u32>;
@group(0) @binding(5) var<storage, read> records: array<Record>;
@group(0) @binding(6) var<storage, read> light_records: array<vec2u>;
@group(0) @binding(7) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(8) var<uniform> surroundings: Surroundings;
@group(0) @binding(9) var<uniform> settings: MarchSettings;
@group(0) @binding(10) var first_triangle: texture_2d<u32>;
@group(0) @binding(11) var channel: texture_storage_2d<rgba32float, write>;

const VIEW: u32 = 0u;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= settings.size) {
        return;
    }
    let eye = surroundings.eye;
    let view = view_direction(picture_from_pixel(id.xy, settings.size));
    var end = plane_end(eye, view);
    let number = textureLoad(first_triangle, id.xy, 0).x;
    if number != 0u {
        let first = surface_at(number - 1u, eye, view, 1.0, 0.0, 0.0);
        let flags = materials[first.part].flags;
        if (flags & FLAG_OPAQUE) != 0u && (flags >> OPERAND_SHIFT) == 0u {
            if first.t < end.t {
                end = End(first.t, number - 1u, NO_PLANE);
            }
        } else {
            end = opaque_in_grid(VIEW, eye, view, end);
            if surroundings.counts.z < MAX_GRIDS {
                end = opaque_in_grid(surroundings.counts.z, eye, view, end);
            }
        }
    }
    var share = vec3f(settings.nan);
    let p = eye + end.t * view;
    if end.plane != NO_PLANE {
        // A plane is in no light's grid.
        share = light_absorption(0u, p, vec3f(0.0));
    } else if end.triangle != NO_TRIANGLE {
        let normal = surface_at(end.triangle, eye, view, end.t, end.t, 0.0).normal;
        share = light_absorption(0u, p, select(normal, -normal, dot(normal, view) > 0.0));
    }
    textureStore(channel, id.xy, vec4f(share, 1.0));
}
