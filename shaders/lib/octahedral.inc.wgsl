// Unit vectors in 32 bits: the octahedral map, two 16-bit signed fractions. Round trip: `octahedral.rs`' test.
fn octahedral_wrap(v: vec2f) -> vec2f {
    return (1.0 - abs(v.yx)) * select(vec2f(-1.0), vec2f(1.0), v >= vec2f(0.0));
}

fn pack_unit(n: vec3f) -> u32 {
    let p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    return pack2x16snorm(select(octahedral_wrap(p), p, n.z >= 0.0));
}

fn unpack_unit(bits: u32) -> vec3f {
    let p = unpack2x16snorm(bits);
    let z = 1.0 - abs(p.x) - abs(p.y);
    return normalize(vec3f(select(octahedral_wrap(p), p, z >= 0.0), z));
}
