// What is left of a light at the end of a record's voxel, 8 bytes. Packing and unpacking side by side.
//
// Red, green, blue by absorption alone, 13 bits each; then what surfaces let through, which is no colour, 12 bits. All
// are stored as square roots, so that the dark has finer steps than the light (2.4e-4 near 1, exact at 1). Then a bit
// for questionable columns, and the medium. Half floats would have steps of 4.9e-4 near 1, and no room for the rest.

struct LightRecord {
    absorption: vec3f,  // RGB that absorption leaves
    surfaces: f32,      // what the surfaces' reflection leaves
    medium: u32,        // the part that the light is in where the voxel ends, or LIGHT_NO_MEDIUM
    questionable: bool, // the column's crossings don't pair up
}

const LIGHT_NO_MEDIUM: u32 = 0xfffu;

fn pack_light_record(r: LightRecord) -> vec2u {
    let root = sqrt(clamp(vec4f(r.absorption, r.surfaces), vec4f(0.0), vec4f(1.0)));
    let q = vec4u(root * vec4f(8191.0, 8191.0, 8191.0, 4095.0) + 0.5);
    let flag = select(0u, 1u << 19u, r.questionable);
    return vec2u(q.x | (q.y << 13u) | (q.z << 26u), (q.z >> 6u) | (q.w << 7u) | flag | (r.medium << 20u));
}

fn unpack_light_record(bits: vec2u) -> LightRecord {
    let q = vec4u(bits.x, bits.x >> 13u, (bits.x >> 26u) | (bits.y << 6u), bits.y >> 7u)
        & vec4u(0x1fffu, 0x1fffu, 0x1fffu, 0xfffu);
    let root = vec4f(q) / vec4f(8191.0, 8191.0, 8191.0, 4095.0);
    let share = root * root;
    return LightRecord(share.rgb, share.a, bits.y >> 20u, (bits.y & (1u << 19u)) != 0u);
}
