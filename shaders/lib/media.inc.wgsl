#include "lib/geometry.inc.wgsl"
// The media that a ray is in: at most four parts, each with how often it was entered. The highest priority rules; of
// equal ones the later part.
//
// Bind as: var<storage, read> materials: array<PartMaterial>;
//
// An entry is 0 (free), or 1 in bit 28, priority + 128 in bits 20–27, part in bits 8–19, count in bits 0–7: the ruling
// medium is the largest number.

const NO_PART: u32 = 0xffffffffu;

fn media_key(part: u32) -> u32 {
    let priority = u32(clamp(materials[part].priority, -128, 127) + 128);
    return (1u << 28u) | (priority << 20u) | (part << 8u);
}

// Which entries are of this part.
fn media_of(media: vec4u, part: u32) -> vec4<bool> {
    return ((media >> vec4u(8u)) & vec4u(0xfffu)) == vec4u(part) & media != vec4u(0u);
}

fn media_has(media: vec4u, part: u32) -> bool {
    return any(media_of(media, part));
}

// Enters a part once more. Where no entry is free the part is left out.
fn media_enter(media: vec4u, part: u32) -> vec4u {
    let same = media_of(media, part);
    let free = media == vec4u(0u);
    let first_free = vec4<bool>(free.x, free.y && !free.x, free.z && !free.x && !free.y,
                                free.w && !free.x && !free.y && !free.z);
    let counted = media + select(vec4u(0u), vec4u(1u), same);
    let added = select(media, vec4u(media_key(part) | 1u), first_free);
    return select(added, counted, vec4<bool>(any(same)));
}

// Leaves a part once.
fn media_leave(media: vec4u, part: u32) -> vec4u {
    let less = media - select(vec4u(0u), vec4u(1u), media_of(media, part));
    return select(less, vec4u(0u), (less & vec4u(0xffu)) == vec4u(0u));
}

// The part that rules, or NO_PART outside of all.
fn media_ruling(media: vec4u) -> u32 {
    let top = max(max(media.x, media.y), max(media.z, media.w));
    return select((top >> 8u) & 0xfffu, NO_PART, top == 0u);
}
