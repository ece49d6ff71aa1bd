// Toggles into runs: each bit is the exclusive or of all bits up to it.
fn prefix_xor(toggles: u32) -> u32 {
    var bits = toggles;
    bits ^= bits << 1u;
    bits ^= bits << 2u;
    bits ^= bits << 4u;
    bits ^= bits << 8u;
    bits ^= bits << 16u;
    return bits;
}
