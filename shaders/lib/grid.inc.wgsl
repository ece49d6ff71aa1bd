// Voxel cameras: the map between world space and the grid space of one grid.
//
// Grid space counts cells: (0, 0, 0) is the grid's lower corner, x and y run across the columns, z along them. An
// orthographic grid is the linear case. A perspective grid is projective: x/z, y/z and −1/z, scaled to cells, so that
// straight lines stay straight and cells stay boxes; its slices are uniform in eye depth, so their boundaries
// (`slab`) are not whole numbers.
const MAX_GRIDS: u32 = 16u;
const ORTHOGRAPHIC: u32 = 0u;
const PERSPECTIVE: u32 = 1u;

struct Grid {
    grid_from_world: mat4x4f,   // homogeneous: divide by w
    world_from_grid: mat4x4f,   // homogeneous: divide by w
    cells: vec3u,
    words_per_column: u32,
    word_base: u32,             // this grid's first word in `occupancy`, `ranks` and `interior`
    record_base: u32,           // this grid's first record; records of one grid are numbered from here by rank
    record_capacity: u32,
    extra_base: u32,            // records of second and third sheets of a voxel start here
    extra_capacity: u32,
    projection: u32,
    required_flags: u32,        // only parts that have all of these flags are voxelized here
    cell_size: f32,             // world size of a cell (perspective: of a middle one)
    near: f32,                  // perspective: eye depth of slab 0
    far: f32,                   // perspective: eye depth of the last slab
    tolerance: f32,             // cells by which a crossing may lie outside its voxel's interval
    _pad: u32,
}

fn grid_from_world(g: Grid, p_world: vec3f) -> vec3f {
    let h = g.grid_from_world * vec4f(p_world, 1.0);
    return h.xyz / h.w;
}

fn world_from_grid(g: Grid, p_grid: vec3f) -> vec3f {
    let h = g.world_from_grid * vec4f(p_grid, 1.0);
    return h.xyz / h.w;
}

// Grid-space z of the boundary below slice k; slab(cells.z) is the far end.
fn slab(g: Grid, k: f32) -> f32 {
    if g.projection == ORTHOGRAPHIC {
        return k;
    }
    let n = f32(g.cells.z);
    let depth = g.near + k * (g.far - g.near) / n;
    return n * g.far / (g.far - g.near) * (1.0 - g.near / depth);
}

// The slice (not clamped, fractional) that grid-space z lies in: the inverse of `slab`.
fn slice_of(g: Grid, z_grid: f32) -> f32 {
    if g.projection == ORTHOGRAPHIC {
        return z_grid;
    }
    let n = f32(g.cells.z);
    let depth = g.near / (1.0 - z_grid * (g.far - g.near) / (n * g.far));
    return (depth - g.near) * n / (g.far - g.near);
}

// Centre and half extents of a cell in grid space.
struct CellBox {
    center: vec3f,
    half: vec3f,
}

fn cell_box(g: Grid, cell: vec3i) -> CellBox {
    let lo = slab(g, f32(cell.z));
    let hi = slab(g, f32(cell.z) + 1.0);
    return CellBox(vec3f(f32(cell.x) + 0.5, f32(cell.y) + 0.5, 0.5 * (lo + hi)), vec3f(0.5, 0.5, 0.5 * (hi - lo)));
}

fn in_grid(g: Grid, cell: vec3i) -> bool {
    return all(cell >= vec3i(0)) && all(cell < vec3i(g.cells));
}

// Occupancy layout: 32 consecutive slices of one column are one word; a column's words lie together.
fn word_index(g: Grid, cell: vec3u) -> u32 {
    return g.word_base + (cell.y * g.cells.x + cell.x) * g.words_per_column + (cell.z >> 5u);
}

fn word_bit(z: u32) -> u32 {
    return 1u << (z & 31u);
}
