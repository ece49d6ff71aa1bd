//! Implicit surfaces: where an expression of x, y, z and t is zero. It is negative inside.
//!
//! Source: [`papers::DONG_2004`](crate::papers::DONG_2004), §5.2, which evaluates the expression at one point of each
//! cell and keeps those near zero; that leaks where the expression is steep. Here a cell of a lattice holds the surface
//! if the expression's sign differs between its corners, and the surface becomes a closed mesh (a dual one: one vertex
//! a cell, one quad for each lattice edge whose ends differ), which then is voxelized like every model: first surface,
//! records, parity, light, all methods, all grids.
//!
//! Blocks of cells are skipped where interval arithmetic bounds the expression away from zero, so the cost grows with
//! the surface. Vertices are brought onto the surface by Newton steps within their cell; normals are the gradient's.
//! Promises: no leak, whatever the expression, since each corner's sign is decided once; sheets closer to each other
//! than a cell may be joined or missed. Where the surface leaves its box it is cut flat.

use super::expression::Interval;
use super::expression::{Dual, Expression, Lanes, Number};
use super::shapes::Mesh;
use super::surface::in_runs;
use glam::{DVec3, Vec3};

/// An implicit surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Implicit {
    /// Negative inside; in [`Implicit::VARIABLES`].
    pub expression: Expression,
    /// Lower corner of the box that it is looked for in.
    pub min: Vec3,
    /// Upper corner.
    pub max: Vec3,
    /// Lattice cells along the box's longest side.
    pub cells: u32,
}

/// Cells of a block that is skipped as a whole, along each axis.
const BLOCK: usize = 4;
/// Blocks of a larger block that is asked first, along each axis.
const SUPER: usize = 4;
/// Steps toward the surface.
const NEWTON_STEPS: usize = 4;
/// Cells from the surface within which a vertex is on it: what single precision can tell, and less than it.
const NEAR_ENOUGH: f64 = 1e-7;
/// The value of a point of the box's face that would be inside.
const CUT: f64 = f64::INFINITY;
/// Fewest cells along a short side.
const LEAST_CELLS: usize = 4;

impl Implicit {
    /// What its expression may name.
    pub const VARIABLES: &'static [&'static str] = &["x", "y", "z", "t"];
    /// Fewest and most cells along the longest side.
    pub const CELLS: std::ops::RangeInclusive<u32> = 8..=256;

    /// Whether it changes with time.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.expression.uses(3)
    }

    /// Its triangles, wound outward.
    pub(super) fn mesh(&self, time_secs: f64) -> (Mesh, Option<String>) {
        let lattice = Lattice::new(self, time_secs);
        let blocks = lattice.undecided_blocks();
        let samples = lattice.samples(&blocks);
        let surface_cells = lattice.surface_cells(&samples);
        let mut mesh = Mesh::default();
        for run in in_runs(surface_cells.len(), |run| lattice.vertices(&surface_cells[run], &samples)) {
            for vertex in run {
                mesh.add(vertex.position, vertex.normal, [0.0; 2]);
            }
        }
        lattice.quads(&surface_cells, &samples, &mut mesh);
        (mesh, lattice.warning(&samples, surface_cells.is_empty()))
    }
}

/// Which of a lattice's cells may hold the surface, and the sign of the rest.
struct Blocks {
    counts: [usize; 3],
    /// For each block: undecided, or the expression's sign all over it.
    signs: Vec<Sign>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sign {
    Undecided,
    Inside,
    Outside,
}

/// The expression at the lattice's points.
struct Samples {
    /// A point is inside where this is negative.
    values: Vec<f64>,
    /// Points where it is no number, and the first of them.
    strange: (usize, Option<usize>),
    /// Points of the box's faces that would be inside.
    cut: usize,
}

/// A cell that holds surface.
#[derive(Debug, Clone, Copy)]
struct SurfaceCell {
    /// Its lower corner's point.
    point: usize,
    /// Bit `i` is set where corner `i` is inside.
    inside: u8,
}

struct Vertex {
    position: DVec3,
    normal: DVec3,
}

struct Lattice<'a> {
    expression: &'a Expression,
    time_secs: f64,
    origin: DVec3,
    step: DVec3,
    /// Cells along each axis; one more point.
    cells: [usize; 3],
}

impl<'a> Lattice<'a> {
    fn new(implicit: &'a Implicit, time_secs: f64) -> Self {
        let (min, max) = (implicit.min.as_dvec3(), implicit.max.as_dvec3());
        let side = (max - min).max_element() / f64::from(implicit.cells);
        let cells = (max - min).to_array().map(|length| (whole(length / side)).max(LEAST_CELLS));
        let step = (max - min) / DVec3::from_array(cells.map(float));
        Self { expression: &implicit.expression, time_secs, origin: min, step, cells }
    }

    /// Distance in points from one to the next along each axis.
    fn strides(&self) -> [usize; 3] {
        let [nx, ny, _] = self.cells.map(|n| n + 1);
        [1, nx, nx * ny]
    }

    fn coordinates(&self, point: usize) -> [usize; 3] {
        let [_, row, plane] = self.strides();
        [point % row, point % plane / row, point / plane]
    }

    fn place(&self, coordinates: [usize; 3]) -> DVec3 {
        self.origin + self.step * DVec3::from_array(coordinates.map(float))
    }

    fn on_face(&self, coordinates: [usize; 3]) -> bool {
        coordinates.iter().zip(self.cells).any(|(&c, n)| c == 0 || c == n)
    }

    /// Asks large blocks of cells first, then the small ones within those that are undecided.
    fn undecided_blocks(&self) -> Blocks {
        let counts = self.cells.map(|n| n.div_ceil(BLOCK));
        let supers = counts.map(|n| n.div_ceil(SUPER));
        let mut blocks = Blocks { counts, signs: vec![Sign::Undecided; counts.iter().product()] };
        let mut steps = Vec::new();
        let mut sign_of = |first: [usize; 3], size: usize| {
            let last = std::array::from_fn(|axis| (first[axis] + size).min(self.cells[axis]));
            let (low, high) = (self.place(first), self.place(last));
            let side = |axis: usize| Interval { low: low[axis], high: high[axis] };
            let variables = [side(0), side(1), side(2), Interval::constant(self.time_secs)];
            let bounds = self.expression.evaluate(&variables, &mut steps);
            match bounds {
                Interval { low, .. } if low > 0.0 => Sign::Outside,
                Interval { high, .. } if high < 0.0 => Sign::Inside,
                _ => Sign::Undecided,
            }
        };
        for super_block in each([0; 3], supers) {
            let size = BLOCK * SUPER;
            let whole = sign_of(super_block.map(|b| b * size), size);
            let first = super_block.map(|b| b * SUPER);
            let end = std::array::from_fn(|axis| (first[axis] + SUPER).min(counts[axis]));
            for block in each(first, end) {
                let index = blocks.index(block);
                blocks.signs[index] = match whole {
                    Sign::Undecided => sign_of(block.map(|b| b * BLOCK), BLOCK),
                    decided => decided,
                };
            }
        }
        blocks
    }

    /// The expression at all points of undecided blocks, a number of the right sign at the others. The box's faces are
    /// outside, so that the surface closes.
    fn samples(&self, blocks: &Blocks) -> Samples {
        let planes = self.cells[2] + 1;
        let parts = in_runs(planes, |run| self.sample_planes(blocks, run));
        let mut samples = Samples { values: Vec::new(), strange: (0, None), cut: 0 };
        for part in parts {
            let before = samples.values.len();
            samples.values.extend(part.values);
            samples.strange.0 += part.strange.0;
            samples.strange.1 = samples.strange.1.or(part.strange.1.map(|point| point + before));
            samples.cut += part.cut;
        }
        samples
    }

    fn sample_planes(&self, blocks: &Blocks, planes: std::ops::Range<usize>) -> Samples {
        let [nx, ny, _] = self.cells.map(|n| n + 1);
        let mut samples = Samples { values: Vec::with_capacity(planes.len() * nx * ny), strange: (0, None), cut: 0 };
        let mut steps = Vec::new();
        for (z, y) in planes.flat_map(|z| (0..ny).map(move |y| (z, y))) {
            let first = samples.values.len();
            let signs = blocks.signs_of_row(y, z);
            let at_end = blocks.counts[0] - 1;
            // A point between two blocks needs a sample if one of them is undecided.
            let sign_at = |x: usize| {
                let own = signs[(x / BLOCK).min(at_end)];
                let before = signs[(x.saturating_sub(1) / BLOCK).min(at_end)];
                if before == Sign::Undecided { before } else { own }
            };
            let mut x = 0;
            while x < nx {
                let sign = sign_at(x);
                if sign != Sign::Undecided {
                    samples.values.push(if sign == Sign::Inside { -1.0 } else { 1.0 });
                    x += 1;
                    continue;
                }
                let run = (x..nx.min(x + Lanes::COUNT)).take_while(|&x| sign_at(x) == Sign::Undecided).count();
                let place = self.place([x, y, z]);
                let along = Lanes(std::array::from_fn(|i| self.origin.x + self.step.x * float(x + i)));
                let across = [place.y, place.z, self.time_secs].map(Lanes::constant);
                let values = self.expression.evaluate(&[along, across[0], across[1], across[2]], &mut steps);
                samples.values.extend(&values.0[..run]);
                x += run;
            }
            for (x, value) in samples.values[first..].iter_mut().enumerate() {
                if value.is_nan() {
                    samples.strange.0 += 1;
                    samples.strange.1 = samples.strange.1.or(Some(first + x));
                    *value = 1.0;
                }
                if *value < 0.0 && self.on_face([x, y, z]) {
                    samples.cut += 1;
                    *value = CUT;
                }
            }
        }
        samples
    }

    /// Corner `i` of a cell lies at x + (i & 1), y + (i >> 1 & 1), z + (i >> 2).
    fn corner_offsets(&self) -> [usize; 8] {
        let [sx, sy, sz] = self.strides();
        std::array::from_fn(|i| (i & 1) * sx + (i >> 1 & 1) * sy + (i >> 2) * sz)
    }

    /// All cells whose corners are not of one sign, in the order of their points.
    fn surface_cells(&self, samples: &Samples) -> Vec<SurfaceCell> {
        let runs = in_runs(self.cells[2], |planes| {
            let mut found = Vec::new();
            for (z, y) in planes.flat_map(|z| (0..self.cells[1]).map(move |y| (z, y))) {
                let first = self.point([0, y, z]);
                let [_, row, plane] = self.strides();
                let rows = [0, row, plane, row + plane].map(|offset| &samples.values[first + offset..]);
                // The four corners that two neighbouring cells share.
                let side = |x: usize| (0..4).fold(0_u8, |bits, i| bits | u8::from(rows[i][x] < 0.0) << (2 * i));
                let mut before = side(0);
                for x in 0..self.cells[0] {
                    let after = side(x + 1);
                    let inside = before | after << 1;
                    if inside != 0 && inside != 0xff {
                        found.push(SurfaceCell { point: first + x, inside });
                    }
                    before = after;
                }
            }
            found
        });
        runs.concat()
    }

    fn point(&self, coordinates: [usize; 3]) -> usize {
        coordinates.iter().zip(self.strides()).map(|(c, stride)| c * stride).sum()
    }

    fn vertices(&self, cells: &[SurfaceCell], samples: &Samples) -> Vec<Vertex> {
        let mut steps = Vec::new();
        cells.iter().map(|cell| self.vertex(*cell, samples, &mut steps)).collect()
    }

    /// From the mean of the crossings on the cell's edges by Newton steps to the surface, within the cell.
    fn vertex(&self, cell: SurfaceCell, samples: &Samples, steps: &mut Vec<Dual<3>>) -> Vertex {
        let corner = self.coordinates(cell.point);
        let offsets = self.corner_offsets();
        let (mut sum, mut count, mut face_normal) = (DVec3::ZERO, 0.0, DVec3::ZERO);
        for axis in 0..3 {
            for from in (0..8).filter(|from| from >> axis & 1 == 0) {
                let to = from | 1 << axis;
                if cell.inside >> from & 1 == cell.inside >> to & 1 {
                    continue;
                }
                let ends = [from, to].map(|i| cell.point + offsets[i]);
                let [a, b] = ends.map(|point| samples.values[point]);
                let mut fraction = a / (a - b);
                if let Some(end) = [a, b].iter().position(|value| *value == CUT)
                    && self.on_face(self.coordinates(ends[end]))
                {
                    // The surface is the box's face there.
                    fraction = [0.0, 1.0][end];
                    face_normal[axis] += [-1.0, 1.0][end];
                }
                let mut place: [f64; 3] = std::array::from_fn(|k| float(from >> k & 1));
                place[axis] = if fraction.is_finite() { fraction.clamp(0.0, 1.0) } else { 0.5 };
                sum += DVec3::from_array(place);
                count += 1.0;
            }
        }
        let low = self.place(corner);
        let high = low + self.step;
        let mean = low + self.step * (sum / count);
        let is_cut = face_normal != DVec3::ZERO;
        let mut position = mean;
        let mut normal = DVec3::ZERO;
        for step in 0..=NEWTON_STEPS {
            let variable = |axis: usize| Dual::variable(position[axis], axis);
            let variables = [variable(0), variable(1), variable(2), Dual::constant(self.time_secs)];
            let value = self.expression.evaluate(&variables, steps);
            let gradient = DVec3::from_array(value.slopes);
            if gradient.is_finite() {
                normal = gradient;
            }
            let is_there = value.value.abs() < NEAR_ENOUGH * self.step.min_element() * gradient.length();
            if is_cut || step == NEWTON_STEPS || is_there {
                break;
            }
            position = newton_step(position, value.value, gradient, [low, high]);
        }
        let outward = self.outward(cell, face_normal);
        let gradient = normal.try_normalize().unwrap_or(outward);
        Vertex { position, normal: (gradient + face_normal).try_normalize().unwrap_or(outward) }
    }

    /// Away from the inside corners: for where the gradient says nothing.
    fn outward(&self, cell: SurfaceCell, otherwise: DVec3) -> DVec3 {
        let mut sum = otherwise;
        for i in 0..8 {
            let toward = DVec3::new(float(i & 1), float(i >> 1 & 1), float(i >> 2)) - 0.5;
            sum += if cell.inside >> i & 1 == 1 { -toward } else { toward };
        }
        sum.try_normalize().unwrap_or(DVec3::Y)
    }

    /// Two triangles around each edge whose ends differ, through the vertices of its four cells.
    fn quads(&self, cells: &[SurfaceCell], samples: &Samples, mesh: &mut Mesh) {
        let strides = self.strides();
        let mut number_of = vec![u32::MAX; samples.values.len()];
        for (number, cell) in (0..).zip(cells) {
            number_of[cell.point] = number;
        }
        for cell in cells {
            // Each edge belongs to the cell whose lower corner it starts from.
            let starts_inside = cell.inside & 1 == 1;
            for axis in 0..3 {
                if (cell.inside >> (1 << axis) & 1 == 1) == starts_inside {
                    continue;
                }
                let (b, c) = (strides[(axis + 1) % 3], strides[(axis + 2) % 3]);
                let around = [b + c, c, 0, b].map(|back| number_of[cell.point - back]);
                let [p, q, r, s] = around;
                let quad = if starts_inside { [p, q, r, s] } else { [s, r, q, p] };
                mesh.triangles.extend(split(quad, mesh));
            }
        }
    }

    fn warning(&self, samples: &Samples, is_empty: bool) -> Option<String> {
        let (count, first) = samples.strange;
        if let Some(first) = first {
            let p = self.place(self.coordinates(first));
            let of = samples.values.len();
            return Some(format!(
                "the expression is no number at {count} of {of} points, the first at x = {:.4}, y = {:.4}, z = {:.4}; \
                 they count as outside; change it or its box",
                p.x, p.y, p.z
            ));
        }
        if samples.cut > 0 {
            return Some("the surface is cut where it leaves its box; widen `min` and `max`".to_owned());
        }
        let what = "nothing of the surface lies in its box; mend `min`, `max` or the sign (it is negative inside)";
        is_empty.then(|| what.to_owned())
    }
}

/// A step toward where the value is nought, within a box: along the gradient, and where that leads out of the box along
/// its faces.
fn newton_step(from: DVec3, value: f64, gradient: DVec3, [low, high]: [DVec3; 2]) -> DVec3 {
    let (mut free, mut position) = (gradient, from);
    for _ in 0..3 {
        // What the axes that have come to a face did already is taken off.
        let left = value + (gradient - free).dot(position - from);
        let step = -free * (left / free.length_squared());
        if !step.is_finite() {
            break;
        }
        let wanted = DVec3::select(free.cmpne(DVec3::ZERO), from + step, position);
        position = wanted.clamp(low, high);
        let stopped = wanted.cmpne(position);
        if !stopped.any() {
            break;
        }
        free = DVec3::select(stopped, DVec3::ZERO, free);
    }
    position
}

/// A quad's triangles: of its two diagonals the one whose triangles agree better with the vertices' normals.
fn split([a, b, c, d]: [u32; 4], mesh: &Mesh) -> [[u32; 3]; 2] {
    let place = |i: u32| mesh.vertices[i as usize].position;
    let worst = |pair: [[u32; 3]; 2]| {
        let cosine = |t: [u32; 3]| {
            let [p, q, r] = t.map(place);
            let normal: Vec3 = t.iter().map(|&i| mesh.vertices[i as usize].normal).sum();
            (q - p).cross(r - p).normalize_or_zero().dot(normal)
        };
        cosine(pair[0]).min(cosine(pair[1]))
    };
    let (one, other) = ([[a, b, c], [a, c, d]], [[b, c, d], [b, d, a]]);
    if worst(one) >= worst(other) { one } else { other }
}

impl Blocks {
    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.counts[1] + y) * self.counts[0] + x
    }

    /// The sign of each block that a row of points runs through; undecided where one of those beside the row is.
    fn signs_of_row(&self, y: usize, z: usize) -> Vec<Sign> {
        let beside = |c: usize, axis: usize| {
            let last = self.counts[axis] - 1;
            [(c.saturating_sub(1) / BLOCK).min(last), (c / BLOCK).min(last)]
        };
        (0..self.counts[0])
            .map(|x| {
                let all =
                    beside(y, 1).into_iter().flat_map(|y| beside(z, 2).map(|z| self.signs[self.index([x, y, z])]));
                let mut own = Sign::Outside;
                for sign in all {
                    if sign == Sign::Undecided {
                        return sign;
                    }
                    own = sign;
                }
                own
            })
            .collect()
    }
}

/// Every (x, y, z) from `first` to before `end`.
fn each(first: [usize; 3], end: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (first[2]..end[2])
        .flat_map(move |z| (first[1]..end[1]).flat_map(move |y| (first[0]..end[0]).map(move |x| [x, y, z])))
}

fn float(n: usize) -> f64 {
    u32::try_from(n).map_or(f64::MAX, f64::from)
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most as many as `cells`, rounded up")]
fn whole(cells: f64) -> usize {
    (cells - 1e-6).ceil().clamp(1.0, 1024.0) as usize
}
