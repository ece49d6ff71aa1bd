#include "lib/octahedral.inc.wgsl"
// A surface record: what one sheet of surface in one voxel looks like. 16 bytes. Packing and unpacking side by side.
//
// triangle: number in bits 0–23, RECORD_* flags above. normal: the plane's, world, octahedral. point: a point of the
// plane in the cell, 3×10 bits over −0.5 … 1.5 cell; bits 30–31: how many further sheets the voxel has. medium: part in
// bits 0–11; bits 12–31: the first further sheet, counted from the grid's `extra_base`.

struct Record {
    triangle: u32,
    normal: u32,
    point: u32,
    medium: u32,
}

const RECORD_TRIANGLE_MASK: u32 = 0xffffffu;
const RECORD_ORPHAN: u32 = 1u << 24u;       // no triangle claims the voxel; the normal is gathered from neighbours
const RECORD_OPAQUE: u32 = 1u << 25u;       // of an opaque part
const RECORD_MAX_PARTS: u32 = 4096u;

fn pack_point_in_cell(p_cell: vec3f) -> u32 {
    let q = vec3u(clamp((p_cell + 0.5) * 0.5, vec3f(0.0), vec3f(1.0)) * 1023.0 + 0.5);
    return q.x | (q.y << 10u) | (q.z << 20u);
}

// 0 … 1 within the cell, as fractions of its extent (a perspective cell's z extent is not 1).
fn unpack_point_in_cell(bits: u32) -> vec3f {
    let q = vec3u(bits & 1023u, (bits >> 10u) & 1023u, (bits >> 20u) & 1023u);
    return vec3f(q) / 1023.0 * 2.0 - 0.5;
}

fn record_triangle(r: Record) -> u32 {
    return r.triangle & RECORD_TRIANGLE_MASK;
}

fn record_part(r: Record) -> u32 {
    return r.medium & 0xfffu;
}

fn record_extra_count(r: Record) -> u32 {
    return r.point >> 30u;
}

fn record_extra_first(r: Record) -> u32 {
    return r.medium >> 12u;
}
