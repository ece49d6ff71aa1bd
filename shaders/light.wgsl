#include "lib/grid.inc.wgsl"
#include "lib/light_record.inc.wgsl"
#include "lib/media.inc.wgsl"
#include "lib/record.inc.wgsl"
// One thread a column of a light's grid: walks the records from the light on and writes what is left after each.
// See `light.rs` for where the formulas come from.

@group(0) @binding(0) var<uniform> grids: array<Grid, MAX_GRIDS>;
@group(0) @binding(1) var<uniform> grid_index: vec4u;
@group(0) @binding(2) var<uniform> light_settings: LightSettings;
@group(0) @binding(3) var<storage, read> occupancy: array<u32>;
@group(0) @binding(4) var<storage, read> ranks: array<u32>;
@group(0) @binding(5) var<storage, read> records: array<Record>;
@group(0) @binding(6) var<storage, read> materials: array<PartMaterial>;
@group(0) @binding(7) var<storage, read_write> light_records: array<vec2u>;

struct LightSettings {
    shadow: u32,        // SHADOW_LINEAR, SHADOW_BEER_LAMBERT of `lib/light_volume.inc.wgsl`
    _pad0: u32,
    _pad1: u32,
    _pad2: u32,
}

const LINEAR: u32 = 1u;
// Within this many cells a crossing of the same part from the same side is the same surface again.
const DUPLICATE_CELLS: f32 = 1.5;
// A plane that the column meets under a smaller cosine is not crossed.
const LEAST_COSINE: f32 = 1e-3;
// A crossing that contradicts the media is believed if its plane is met under at least this cosine: at a silhouette
// planes reach beyond their triangles.
const BELIEVED_COSINE: f32 = 0.3;
const LEAST_MIRROR_COSINE: f32 = 0.4;
// Cells by which a crossing may lie beyond another sheet of its voxel that bounds it.
const SHEET_CELLS: f32 = 0.05;
// Cells within which surfaces are in one place: bodies that touch.
const TOUCHING_CELLS: f32 = 0.02;
const NEVER: f32 = 1e30;
const ONLY: f32 = 0.0;    // in place of t where a voxel has one sheet

// A column's centre line.
struct Column {
    origin: vec3f,      // world, where slice 0 begins
    before: f32,        // world units from the light to there; 0 where it comes from far away
    direction: vec3f,   // world, unit
    slice_length: f32,  // world units that the line stays in one slice
    cell: vec2u,
}

// A sheet of a voxel, as the column meets its plane.
struct Sheet {
    plane: Plane,
    cosine: f32,        // of the light with the normal: negative where it enters
    t: f32,             // world units from the column's origin
    part: u32,
    crossed: bool,
}

// How a walk went.
const PAIRED: u32 = 0u;     // every entry has its exit
const ODD: u32 = 1u;        // some crossing contradicted the media, or the light never left them
const IN_GLASS: u32 = 2u;   // the light stands in a part that it was not known to stand in

// The light on its way down a column. `depth` holds up to `t`; `tint` and `surfaces` are factors.
struct Light {
    t: f32,
    depth: vec3f,       // optical depth so far: sum of σ·Δs
    tint: vec3f,        // of the surfaces that it met
    surfaces: f32,
    blocked: bool,
    media: vec4u,
    events: vec4u,      // the latest, newest first: 2·part + 2, and 1 more where the light entered
    event_t: vec4f,
    outcome: u32,
    stands_in: u32,     // IN_GLASS: the part
}

fn sigma_of(medium: u32) -> vec3f {
    if medium == NO_PART {
        return vec3f(0.0);
    }
    return materials[medium].sigma;
}

fn ior_of(medium: u32) -> f32 {
    if medium == NO_PART {
        return 1.0;
    }
    return materials[medium].ior;
}

// Unpolarized reflectance between two media. The light is taken to run straight, so the angle to the normal is that on
// the thinner side: there is no total reflection, and a body lets as much out as it lets in. Below LEAST_MIRROR_COSINE
// the cosine counts as that: a rim of all but total reflection is thinner than a column and would show its raster.
fn reflectance(cosine: f32, n1: f32, n2: f32) -> f32 {
    let ratio = max(n1, n2) / min(n1, n2);
    let c = max(abs(cosine), LEAST_MIRROR_COSINE);
    let g = sqrt(max(ratio * ratio - 1.0 + c * c, 0.0));
    let s = (c - g) / (c + g);
    let p = (ratio * ratio * c - g) / (ratio * ratio * c + g);
    return clamp(0.5 * (s * s + p * p), 0.0, 1.0);
}

// Whether the last thing that happened with this part, a moment ago, was just this.
fn is_duplicate(light: Light, part: u32, t: f32, entering: bool, near: f32) -> bool {
    let of_part = (light.events >> vec4u(1u)) == vec4u(part + 1u);
    for (var i = 0u; i < 4u; i++) {
        if of_part[i] {
            return ((light.events[i] & 1u) == 1u) == entering && t - light.event_t[i] < near;
        }
    }
    return false;
}

fn was_met(light: Light, part: u32) -> bool {
    return any((light.events >> vec4u(1u)) == vec4u(part + 1u));
}

// Remembers an event in place of the oldest.
fn remember(light: ptr<function, Light>, part: u32, t: f32, entering: bool) {
    (*light).events = vec4u(2u * part + select(2u, 3u, entering), (*light).events.xyz);
    (*light).event_t = vec4f(t, (*light).event_t.xyz);
}

// Brings the optical depth up to `t` through the ruling medium.
fn advance(light: ptr<function, Light>, t: f32) {
    (*light).depth += sigma_of(media_ruling((*light).media)) * (t - (*light).t);
    (*light).t = t;
}

// One surface. `saturate`: a part counts once however often it is entered, for columns whose crossings don't pair up.
fn meet(light: ptr<function, Light>, sheet: Sheet, saturate: bool, column: Column) {
    let flags = materials[sheet.part].flags;
    let entering = sheet.cosine < 0.0;
    if (flags & FLAG_OPAQUE) != 0u {
        (*light).blocked = true;
        return;
    }
    if is_duplicate(*light, sheet.part, sheet.t, entering, DUPLICATE_CELLS * column.slice_length) {
        return;
    }
    if (flags & FLAG_THIN_WALL) != 0u {
        let through = 1.0 - reflectance(sheet.cosine, 1.0, materials[sheet.part].ior);
        if entering || (flags & FLAG_DOUBLE_SIDED) != 0u {
            (*light).tint *= clamp(materials[sheet.part].base_color, vec3f(0.0), vec3f(1.0));
        }
        (*light).surfaces *= through * through;
        remember(light, sheet.part, sheet.t, entering);
        return;
    }
    let inside = media_has((*light).media, sheet.part);
    if !entering && !inside {
        if abs(sheet.cosine) > BELIEVED_COSINE {
            (*light).outcome = select(ODD, IN_GLASS, column.before > 0.0 && !was_met(*light, sheet.part));
            (*light).stands_in = sheet.part;
        }
        return;
    }
    advance(light, sheet.t);
    let before = media_ruling((*light).media);
    if !entering {
        (*light).media = media_leave((*light).media, sheet.part);
    } else if !(saturate && inside) {
        (*light).media = media_enter((*light).media, sheet.part);
        (*light).tint *= clamp(materials[sheet.part].base_color, vec3f(0.0), vec3f(1.0));
    }
    let after = media_ruling((*light).media);
    let n1 = ior_of(before);
    let n2 = ior_of(after);
    if n1 != n2 {
        (*light).surfaces *= 1.0 - reflectance(sheet.cosine, n1, n2);
    }
    remember(light, sheet.part, sheet.t, entering);
}

// The plane of a record: its normal, and a point of it.
struct Plane {
    normal: vec3f,
    point: vec3f,
}

fn plane_of(g: Grid, column: Column, slice: u32, record: Record) -> Plane {
    let fraction = unpack_point_in_cell(record.point);
    let z = mix(slab(g, f32(slice)), slab(g, f32(slice) + 1.0), fraction.z);
    return Plane(unpack_unit(record.normal), world_from_grid(g, vec3f(vec2f(column.cell) + fraction.xy, z)));
}

// The sheet of a record as the column crosses it, or not.
fn sheet_of(g: Grid, column: Column, slice: u32, record: Record) -> Sheet {
    let plane = plane_of(g, column, slice, record);
    let cosine = dot(plane.normal, column.direction);
    let t = dot(plane.normal, plane.point - column.origin) / cosine;
    let at = t / column.slice_length - f32(slice);
    let crossed = abs(cosine) > LEAST_COSINE && at >= -g.tolerance && at <= 1.0 + g.tolerance
        && (record.triangle & RECORD_ORPHAN) == 0u;
    return Sheet(plane, cosine, t, record_part(record), crossed);
}

// Whether a crossing of `sheet` lies on the solid's surface as far as `other` bounds it: within where they meet as a
// ridge, outside where they meet as a groove. Only sheets of one part bound each other.
fn is_bounded(sheet: Sheet, other: Sheet, column: Column) -> bool {
    let ridge = dot(other.plane.normal - sheet.plane.normal, other.plane.point - sheet.plane.point);
    let beyond = dot(other.plane.normal, column.origin + sheet.t * column.direction - other.plane.point);
    let slack = SHEET_CELLS * column.slice_length;
    let free = sheet.part != other.part || abs(ridge) < slack;
    return free || select(-beyond, beyond, ridge > 0.0) < slack;
}

// When the column meets a sheet: its t; of sheets in one place the one where it enters comes first, so that no air opens
// between bodies that touch.
fn turn_of(sheet: Sheet, column: Column) -> f32 {
    return sheet.t - select(0.0, TOUCHING_CELLS * column.slice_length, sheet.cosine < 0.0);
}

// When the column crosses the sheets of a voxel that has several, NEVER for none.
fn crossings(g: Grid, column: Column, slice: u32, first: Record) -> vec3f {
    let further = g.extra_base + record_extra_first(first);
    let a = sheet_of(g, column, slice, first);
    let b = sheet_of(g, column, slice, records[further]);
    var t = vec3f(NEVER);
    t.x = select(NEVER, turn_of(a, column), a.crossed && is_bounded(a, b, column));
    t.y = select(NEVER, turn_of(b, column), b.crossed && is_bounded(b, a, column));
    if record_extra_count(first) > 1u {
        let c = sheet_of(g, column, slice, records[further + 1u]);
        t.x = select(NEVER, t.x, is_bounded(a, c, column));
        t.y = select(NEVER, t.y, is_bounded(b, c, column));
        t.z = select(NEVER, turn_of(c, column), c.crossed && is_bounded(c, a, column) && is_bounded(c, b, column));
    }
    return t;
}

// What is left at world distance `t`, which the light has reached.
fn light_record_at(light: Light, t: f32, questionable: bool) -> LightRecord {
    if light.blocked {
        return LightRecord(vec3f(0.0), 0.0, LIGHT_NO_MEDIUM, questionable);
    }
    let medium = media_ruling(light.media);
    let depth = max(light.depth + sigma_of(medium) * (t - light.t), vec3f(0.0));
    // CL Eq. 1 as printed, or Beer–Lambert's law.
    let left = select(exp(-depth), max(1.0 - depth, vec3f(0.0)), light_settings.shadow == LINEAR);
    return LightRecord(left * light.tint, light.surfaces, min(medium, LIGHT_NO_MEDIUM), questionable);
}

// Walks the column once, from the media that the light stands in. `saturate`: see `meet`; closes the column too.
// Stops early where the light turns out to stand in glass.
fn walk(g: Grid, column: Column, media: vec4u, saturate: bool) -> Light {
    let base = word_index(g, vec3u(column.cell, 0u));
    var light: Light;
    light.t = -column.before;
    light.media = media;
    light.tint = vec3f(1.0);
    light.surfaces = 1.0;
    var last = 0xffffffffu;
    var w = 0u;
    var bits = occupancy[base];
    var rank = ranks[base];
    var slice = 0u;
    var several = vec3f(NEVER);     // crossings of the voxel's sheets that are still to be met
    var first: Record;
    // One sheet a turn, so that lanes that walk side by side wait for each other little.
    while light.outcome != IN_GLASS {
        if all(several == vec3f(NEVER)) {
            if bits == 0u {
                w += 1u;
                if w >= g.words_per_column {
                    break;
                }
                bits = occupancy[base + w];
                rank = ranks[base + w];
                continue;
            }
            slice = w * 32u + firstTrailingBit(bits);
            bits &= bits - 1u;
            rank += 1u;
            if rank > g.record_capacity {
                continue;
            }
            last = g.record_base + rank - 1u;
            first = records[last];
            several.x = ONLY;
            if record_extra_count(first) > 0u {
                several = crossings(g, column, slice, first);
            }
        }
        let next = min(several.x, min(several.y, several.z));
        let number = select(select(2u, 1u, next == several.y), 0u, next == several.x);
        var record = first;
        if number != 0u {
            record = records[g.extra_base + record_extra_first(first) + number - 1u];
        }
        several[number] = NEVER;
        let sheet = sheet_of(g, column, slice, record);
        if sheet.crossed && next != NEVER && !light.blocked {
            meet(&light, sheet, saturate, column);
        }
        if all(several == vec3f(NEVER)) {
            let t_end = (f32(slice) + 1.0) * column.slice_length;
            light_records[last] = pack_light_record(light_record_at(light, t_end, saturate));
        }
    }
    let open = !light.blocked && media_ruling(light.media) != NO_PART;
    if open && light.outcome == PAIRED {
        light.outcome = ODD;
    }
    if open && saturate && last != 0xffffffffu {
        // A leak: the body ends with the column's last record.
        var closing = unpack_light_record(light_records[last]);
        closing.medium = LIGHT_NO_MEDIUM;
        light_records[last] = pack_light_record(closing);
    }
    return light;
}

// The most parts that a light may be found to stand in.
const MAX_BEGINNINGS: u32 = 3u;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let g = grids[grid_index.x];
    if any(id.xy >= g.cells.xy) {
        return;
    }
    let center = vec2f(id.xy) + 0.5;
    let begin = world_from_grid(g, vec3f(center, 0.0));
    let along = world_from_grid(g, vec3f(center, slab(g, f32(g.cells.z)))) - begin;
    let reach = length(along);
    // Slices are even in depth, so the way from the eye to the first is to the whole as the depths are.
    let before = select(0.0, reach * g.near / (g.far - g.near), g.projection == PERSPECTIVE);
    let column = Column(begin, before, along / reach, reach / f32(g.cells.z), id.xy);
    var media = vec4u(0u);
    var saturate = false;
    for (var turn = 0u; turn < MAX_BEGINNINGS + 2u; turn++) {
        let light = walk(g, column, media, saturate);
        if light.outcome == PAIRED || saturate {
            break;
        }
        if light.outcome == IN_GLASS && turn < MAX_BEGINNINGS {
            media = media_enter(media, light.stands_in);
        } else {
            saturate = true;
        }
    }
}
