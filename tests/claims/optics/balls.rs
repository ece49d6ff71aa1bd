//! Rays through perfect balls of glass in closed form, in f64: in one another, overlapping, or side by side.

use glam::DVec3;

/// A ball of one medium. Of several around a point the one of the highest priority rules; of equal ones the later.
#[derive(Clone, Copy)]
pub(super) struct Ball {
    pub(super) center: DVec3,
    pub(super) radius: f64,
    pub(super) ior: f64,
    pub(super) sigma: f64,
    pub(super) priority: i32,
}

/// Where a ray ends up behind all balls.
pub(super) struct Traced {
    pub(super) direction: DVec3,
    pub(super) transmittance: f64,
    pub(super) events: u32,
}

pub(super) fn refract(d: DVec3, n: DVec3, eta: f64) -> DVec3 {
    let c = -d.dot(n);
    let k = 1.0 - eta * eta * (1.0 - c * c);
    eta * d + (eta * c - k.sqrt()) * n
}

/// Rays this near to an outline, or this flat on a surface, are left out: a mesh's outline is not quite a ball's.
const CLEAR: f64 = 0.04;

/// The ray behind all balls; `None` where it meets none, bends more than `max_events` times, or passes an outline.
pub(super) fn through(balls: &[Ball], eye: DVec3, d: DVec3, max_events: u32) -> Option<Traced> {
    let (mut origin, mut direction) = (eye, d);
    let mut inside: Vec<bool> = balls.iter().map(|b| eye.distance(b.center) < b.radius).collect();
    let ruling = |inside: &[bool]| {
        let around = (0..balls.len()).filter(|i| inside[*i]);
        around.max_by_key(|i| (balls[*i].priority, *i)).map_or((1.0, 0.0), |i| (balls[i].ior, balls[i].sigma))
    };
    let (mut depth, mut events, mut crossings) = (0.0_f64, 0, 0);
    loop {
        let mut next: Option<(f64, usize)> = None;
        for (i, ball) in balls.iter().enumerate() {
            let middle = (ball.center - origin).dot(direction);
            let off = (origin + middle * direction - ball.center).length();
            if middle > 0.0 && (off / ball.radius - 1.0).abs() < CLEAR {
                return None;
            }
            let half = (ball.radius.powi(2) - off * off).max(0.0).sqrt();
            let t = if inside[i] { middle + half } else { middle - half };
            if off < ball.radius && t > 1e-9 && next.is_none_or(|(nearest, _)| t < nearest) {
                next = Some((t, i));
            }
        }
        let (ior, sigma) = ruling(&inside);
        let Some((t, hit)) = next else {
            let left = crossings > 0 && inside.iter().all(|i| !i);
            return left.then_some(Traced { direction, transmittance: (-depth).exp(), events });
        };
        depth += sigma * t;
        origin += t * direction;
        crossings += 1;
        inside[hit] = !inside[hit];
        let (ior_behind, _) = ruling(&inside);
        if ior_behind == ior {
            continue;
        }
        events += 1;
        let outward = (origin - balls[hit].center) / balls[hit].radius;
        let n = if outward.dot(direction) > 0.0 { -outward } else { outward };
        let refracted = refract(direction, n, ior / ior_behind);
        if refracted.is_nan() {
            inside[hit] = !inside[hit];
            direction -= 2.0 * direction.dot(n) * n;
        } else {
            direction = refracted.normalize();
        }
        if events > max_events {
            return None;
        }
    }
}
