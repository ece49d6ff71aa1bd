//! Parametric surfaces: points (x, y, z) as expressions of u, v and t over a rectangle.
//!
//! Source: [`papers::DONG_2004`](crate::papers::DONG_2004), §5.2, which voxelizes "a boodle of points that cover the
//! parametric field". Points leave holes where they are far apart; here they are the corners of triangles. Normals are
//! ∂p/∂u × ∂p/∂v by automatic differentiation, not the triangles'.

use super::expression::{Dual, Expression, Number};
use super::shapes::Mesh;
use super::surface::{FARTHEST, in_runs};
use glam::DVec3;

/// A parametric surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Parametric {
    /// x, y and z, in [`Parametric::VARIABLES`].
    pub position: [Expression; 3],
    /// From where to where u and v run, without variables.
    pub ranges: [[Expression; 2]; 2],
    /// Steps along u and v.
    pub steps: [u32; 2],
    /// Whether the end of u (of v) meets its start.
    pub wrap: [bool; 2],
}

/// A vertex before it is one: NaN where the expressions give no number.
#[derive(Debug, Clone, Copy)]
struct Point {
    position: DVec3,
    normal: DVec3,
}

/// Sides closer than this fraction of the surface's extent are one point: a pole.
const POLE: f64 = 1e-6;

impl Parametric {
    /// What its expressions may name.
    pub const VARIABLES: &'static [&'static str] = &["u", "v", "t"];
    /// Fewest and most steps.
    pub const STEPS: std::ops::RangeInclusive<u32> = 3..=1024;

    /// Whether it changes with time.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.position.iter().any(|e| e.uses(2))
    }

    /// Its triangles, wound outward where the surface is closed, else toward ∂p/∂u × ∂p/∂v.
    pub(super) fn mesh(&self, time_secs: f64) -> (Mesh, Option<String>) {
        let [nu, nv] = self.steps.map(|n| n as usize);
        let mut points = self.points(time_secs);
        let warning = mend(&mut points, |i| (self.value(0, i % (nu + 1)), self.value(1, i / (nu + 1))));
        let at = |i: usize, j: usize| j * (nu + 1) + i;
        let rows: [Vec<Vec<usize>>; 2] = [
            [0, nu].map(|i| (0..=nv).map(|j| at(i, j)).collect()).to_vec(),
            [0, nv].map(|j| (0..=nu).map(|i| at(i, j)).collect()).to_vec(),
        ];
        let extent = extent(&points);
        let mut torn = false;
        let mut closed = [false; 2];
        let mut poles = Vec::new();
        for (axis, [first, last]) in rows.iter().map(|r| [&r[0], &r[1]]).enumerate() {
            if self.wrap[axis] {
                for (&from, &to) in first.iter().zip(last) {
                    torn |= points[from].position.distance(points[to].position) > 1e-3 * extent;
                    points[to] = points[from];
                }
                closed[axis] = true;
                continue;
            }
            let mut are_poles = true;
            for side in [first, last] {
                let tip = points[side[0]].position;
                let is_pole = side.iter().all(|&i| points[i].position.distance(tip) <= POLE * extent);
                if is_pole {
                    side.iter().for_each(|&i| points[i].position = tip);
                    poles.push(side.clone());
                }
                are_poles &= is_pole;
            }
            closed[axis] = are_poles;
        }
        let mut quads = Vec::with_capacity(nu * nv);
        for j in 0..nv {
            quads.extend((0..nu).map(|i| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]));
        }
        let mut triangles: Vec<[usize; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        // A side that is a point has no area.
        let place = |i: usize| points[i].position;
        triangles.retain(|&[a, b, c]| place(a) != place(b) && place(b) != place(c) && place(c) != place(a));
        let volume: f64 = triangles.iter().map(|t| t.map(place)).map(|[a, b, c]| a.dot(b.cross(c))).sum();
        let inward = closed == [true; 2] && volume < 0.0;
        normals(&mut points, &triangles, &poles);

        let mut mesh = Mesh::default();
        for (i, point) in points.iter().enumerate() {
            let normal = if inward { -point.normal } else { point.normal };
            let uv = [i % (nu + 1), i / (nu + 1)].map(count);
            mesh.add(point.position, normal, [uv[0] / count(nu), uv[1] / count(nv)]);
        }
        let corner = |i: usize| u32::try_from(i).unwrap_or(u32::MAX);
        mesh.triangles =
            triangles.into_iter().map(|[a, b, c]| if inward { [a, c, b] } else { [a, b, c] }.map(corner)).collect();
        let torn = torn.then(|| "its ends don't meet where `wrap` says so; mend its ranges or leave `wrap` out".into());
        (mesh, warning.or(torn))
    }

    /// The parameter of an axis at a step.
    fn value(&self, axis: usize, step: usize) -> f64 {
        let [from, to] = [0, 1].map(|end| self.ranges[axis][end].evaluate::<f64>(&[], &mut Vec::new()));
        let fraction = count(step) / f64::from(self.steps[axis]);
        from * (1.0 - fraction) + to * fraction
    }

    /// Row by row along u.
    fn points(&self, time_secs: f64) -> Vec<Point> {
        let [nu, nv] = self.steps.map(|n| n as usize);
        let u: Vec<f64> = (0..=nu).map(|i| self.value(0, i)).collect();
        let v: Vec<f64> = (0..=nv).map(|j| self.value(1, j)).collect();
        let rows = in_runs(nv + 1, |run| {
            let mut steps = Vec::new();
            let mut points = Vec::with_capacity(run.len() * (nu + 1));
            for j in run {
                for &u in &u {
                    let variables = [Dual::<2>::variable(u, 0), Dual::variable(v[j], 1), Dual::constant(time_secs)];
                    let [x, y, z] = [0, 1, 2].map(|axis| self.position[axis].evaluate(&variables, &mut steps));
                    let along = |i: usize| DVec3::new(x.slopes[i], y.slopes[i], z.slopes[i]);
                    let position = DVec3::new(x.value, y.value, z.value);
                    points.push(Point { position, normal: along(0).cross(along(1)) });
                }
            }
            points
        });
        rows.concat()
    }
}

/// Puts points that are no numbers where their forerunner is; says where the first one was.
fn mend(points: &mut [Point], parameters: impl Fn(usize) -> (f64, f64)) -> Option<String> {
    let good = |p: &Point| p.position.is_finite() && p.position.abs().max_element() <= FARTHEST;
    let mut last = points.iter().copied().find(good);
    let mut first_bad = None;
    let mut count = 0_usize;
    for (i, point) in points.iter_mut().enumerate() {
        if good(point) {
            last = Some(*point);
        } else {
            first_bad.get_or_insert(i);
            count += 1;
            *point = last.unwrap_or(Point { position: DVec3::ZERO, normal: DVec3::Y });
        }
    }
    let (u, v) = parameters(first_bad?);
    let of = points.len();
    Some(format!(
        "{count} of its {of} points are no numbers or beyond {FARTHEST:e}, the first at u = {u:.4}, v = {v:.4}; \
         they are left out; change the expressions or the ranges"
    ))
}

/// Makes normals unit vectors. Where the derivatives give none, as at poles, the mean of the triangles' counts.
fn normals(points: &mut [Point], triangles: &[[usize; 3]], poles: &[Vec<usize>]) {
    let mut sums = vec![DVec3::ZERO; points.len()];
    for t in triangles {
        let [a, b, c] = t.map(|i| points[i].position);
        let area = (b - a).cross(c - a);
        t.iter().for_each(|&i| sums[i] += area);
    }
    for pole in poles {
        let sum: DVec3 = pole.iter().map(|&i| sums[i]).sum();
        pole.iter().for_each(|&i| sums[i] = sum);
    }
    let scale = points.iter().map(|p| p.normal.length()).filter(|l| l.is_finite()).fold(0.0, f64::max);
    for (point, sum) in points.iter_mut().zip(sums) {
        let by_derivatives = point.normal.is_finite() && point.normal.length() > 1e-9 * scale;
        let normal = if by_derivatives { point.normal } else { sum };
        point.normal = normal.try_normalize().unwrap_or(DVec3::Y);
    }
}

/// The diagonal of the box around all points.
fn extent(points: &[Point]) -> f64 {
    let least = points.iter().fold(DVec3::INFINITY, |m, p| m.min(p.position));
    let most = points.iter().fold(DVec3::NEG_INFINITY, |m, p| m.max(p.position));
    (most - least).length()
}

fn count(n: usize) -> f64 {
    u32::try_from(n).map_or(f64::MAX, f64::from)
}
