// Triangles over many columns are put in a queue, in shares that a workgroup takes each; see `resolve/large.rs`. What
// becomes of a column does not depend on who walks it, so a full queue costs time, not truth.

// Columns of a box above which a triangle is large.
const LARGE_COLUMNS: u32 = 64u;
// Columns that a workgroup takes of a large triangle, while shares have numbers.
const SHARE_COLUMNS: u32 = 1024u;
const MAX_SHARES: u32 = 256u;

// Workgroups in x, y, z, for the indirect dispatch, and the queue's length, which may pass its capacity.
@group(0) @binding(8) var<storage, read_write> large_dispatch: array<atomic<u32>, 4>;
// Triangle in bits 0–23, share above.
@group(0) @binding(9) var<storage, read_write> large_shares: array<u32>;

// Columns of a box, both ends included.
fn column_count(lo: vec2i, hi: vec2i) -> u32 {
    let size = vec2u(hi - lo + 1);
    return size.x * size.y;
}

fn share_count(columns: u32) -> u32 {
    return min((columns + SHARE_COLUMNS - 1u) / SHARE_COLUMNS, MAX_SHARES);
}

// Queues a triangle over so many columns if it is large. False: walk it now.
fn defer_large(triangle: u32, columns: u32) -> bool {
    if columns <= LARGE_COLUMNS {
        return false;
    }
    let shares = share_count(columns);
    let place = atomicAdd(&large_dispatch[3], shares);
    if place + shares > arrayLength(&large_shares) {
        return false;
    }
    for (var share = 0u; share < shares; share++) {
        large_shares[place + share] = triangle | (share << 24u);
    }
    atomicMax(&large_dispatch[0], place + shares);
    return true;
}

// Columns of a box that one thread walks: from `first` on, `stride` further each time, both as steps in x and rows.
struct ColumnWalk {
    first: vec2i,
    stride: vec2i,
}

fn every_column() -> ColumnWalk {
    return ColumnWalk(vec2i(0), vec2i(1, 0));
}

// The columns of thread `thread` of 64 of a share of a triangle that was deferred for so many columns.
fn share_of_columns(lo: vec2i, hi: vec2i, columns: u32, share: u32, thread: u32) -> ColumnWalk {
    let first = share * 64u + thread;
    let stride = share_count(columns) * 64u;
    let width = u32(max(hi.x - lo.x + 1, 1));
    return ColumnWalk(vec2i(vec2u(first % width, first / width)), vec2i(vec2u(stride % width, stride / width)));
}

// The walk is over when y passes hi.y.
fn next_column(lo: vec2i, hi: vec2i, column: vec2i, stride: vec2i) -> vec2i {
    let next = column + stride;
    return select(next, vec2i(next.x - (hi.x - lo.x + 1), next.y + 1), next.x > hi.x);
}
