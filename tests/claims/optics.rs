//! How rays go through glass, against what physics says in closed form.

mod balls;
mod eye;
mod nested;
mod repair;
mod two_surface;

use crate::support::{glass, pixel_direction, quantile, render, scene_of};
use balls::refract;
use glam::{DVec3, UVec2, Vec3};
use murrine::march::Channel;
use murrine::scene::Scene;
use murrine::scene::description::{Background, Camera, Hit, Light, LightKind, Projection, Refraction, Shape};

const SPHERE: Shape = Shape::Icosphere { radius: 1.0, subdivisions: 6 };

/// A glass sphere of 81,920 triangles seen from five radii.
fn sphere_scene(ior: f32, hit: Hit) -> Scene {
    let mut scene = scene_of(vec![glass("sphere", SPHERE, ior, Vec3::ZERO)]);
    scene.camera = Camera { eye: Vec3::new(0.0, 0.0, 5.0), fov_deg: 30.0, ..Camera::default() };
    scene.effect.hit = hit;
    scene.effect.fill_questionable = false;
    scene
}

/// Where a ray leaves the unit sphere, and which way; `None` where it misses or passes further out than `impact`.
fn through_sphere(eye: DVec3, d: DVec3, ior: f64, impact: f64) -> Option<(DVec3, DVec3)> {
    let b = eye.dot(d);
    if (eye - b * d).length() > impact {
        return None;
    }
    let entry = eye + (-b - (b * b - eye.length_squared() + 1.0).sqrt()) * d;
    let inside = refract(d, entry, 1.0 / ior);
    let exit = entry - 2.0 * entry.dot(inside) * inside;
    Some((exit, refract(inside, -exit, ior)))
}

/// Errors of the exit direction in degrees, and the share of rays that have none.
pub(crate) fn exit_errors(scene: &Scene, size: UVec2, ior: f64) -> (Vec<f64>, f64) {
    let picture = render(scene, size, Channel::ExitDirection);
    let mut errors = Vec::new();
    let mut lost = 0.0;
    for y in 0..size.y {
        for x in 0..size.x {
            let d = pixel_direction(size, 30.0, x, y);
            if let Some((_, truth)) = through_sphere(DVec3::new(0.0, 0.0, 5.0), d, ior, 0.95) {
                let got = picture.channel_at(x, y);
                if got.is_nan() {
                    lost += 1.0;
                } else {
                    errors.push(got.cross(truth).length().atan2(got.dot(truth)).to_degrees());
                }
            }
        }
    }
    let all = errors.len() as f64 + lost;
    (errors, lost / all)
}

/// Median and 95th percentile of the exit direction's error, degrees.
pub(crate) fn spread(mut errors: Vec<f64>) -> (f64, f64) {
    (quantile(&mut errors, 0.5), quantile(&mut errors, 0.95))
}

#[test]
fn rays_leave_a_sphere_where_snell_says() {
    let size = UVec2::splat(160);
    let scene = sphere_scene(1.5, Hit::Surfel);
    let (errors, lost) = exit_errors(&scene, size, 1.5);
    let (median, p95) = spread(errors);
    assert!(median <= 0.01 && p95 <= 0.1, "median {median}°, p95 {p95}°");
    assert!(lost <= 0.001, "{lost} of the rays never left");
    let (wrong, _) = spread(exit_errors(&scene, size, 1.45).0);
    assert!(wrong > 0.5, "the same picture passes for another glass: {wrong}°");
}

#[test]
fn the_papers_marcher_leaves_a_sphere_within_half_a_degree() {
    let size = UVec2::splat(160);
    let (errors, lost) = exit_errors(&sphere_scene(1.5, Hit::Voxel), size, 1.5);
    let (median, p95) = spread(errors);
    assert!(median <= 0.45 && p95 <= 1.8, "median {median}°, p95 {p95}°");
    assert!(median > 0.05, "{median}° is not what voxels can do: is this the other marcher?");
    assert!(lost <= 0.02, "{lost} of the rays never left");
}

#[test]
fn a_view_grid_in_perspective_bends_rays_as_well_as_an_orthographic_one() {
    let size = UVec2::splat(96);
    for (hit, refraction, most) in [
        (Hit::Surfel, Refraction::MultipleSurface, 0.02),
        (Hit::Voxel, Refraction::MultipleSurface, 0.6),
        (Hit::Voxel, Refraction::None, 0.01),
    ] {
        let mut scene = sphere_scene(if refraction == Refraction::None { 1.0 } else { 1.5 }, hit);
        scene.grid.projection = Projection::Perspective;
        scene.effect.refraction = refraction;
        let ior = f64::from(scene.models[0].materials[0].ior.unwrap());
        let (errors, lost) = exit_errors(&scene, size, ior);
        let (median, _) = spread(errors);
        assert!(median <= most && lost <= 0.03, "{hit:?}, {refraction:?}: median {median}°, {lost} never left");
    }
}

#[test]
fn glass_of_index_one_bends_nothing() {
    let size = UVec2::splat(64);
    let picture = render(&sphere_scene(1.0, Hit::Surfel), size, Channel::ExitDirection);
    let d = pixel_direction(size, 30.0, 40, 27);
    assert!((picture.channel_at(40, 27) - d).length() < 1e-5);
    let bent = render(&sphere_scene(1.1, Hit::Surfel), size, Channel::ExitDirection);
    assert!((bent.channel_at(40, 27) - d).length() > 1e-2, "glass of another index bends nothing either");
}

#[test]
fn transmittance_of_a_sphere_is_exp_minus_sigma_times_its_chord() {
    let (size, sigma) = (UVec2::splat(128), 0.8);
    let mut scene = sphere_scene(1.5, Hit::Surfel);
    scene.models = vec![glass("sphere", SPHERE, 1.5, Vec3::splat(0.8))];
    let picture = render(&scene, size, Channel::Transmittance);
    let (mut error, mut unbent, mut count) = (0.0, 0.0, 0.0);
    for y in 0..size.y {
        for x in 0..size.x {
            let (eye, d) = (DVec3::new(0.0, 0.0, 5.0), pixel_direction(size, 30.0, x, y));
            let impact = (eye - eye.dot(d) * d).length();
            if impact < 0.95 {
                let inside = 2.0 * (1.0 - (impact / 1.5).powi(2)).sqrt();
                let straight = 2.0 * (1.0 - impact * impact).sqrt();
                let got = picture.channel_at(x, y).x;
                error += (got - (-sigma * inside).exp()).abs();
                unbent += (got - (-sigma * straight).exp()).abs();
                count += 1.0;
            }
        }
    }
    assert!(error / count <= 0.006, "mean |ΔT| {}", error / count);
    assert!(unbent / count > 0.006, "the unbent chord passes as well");
}

/// A slab of glass, 2 thick, turned by 30° about y.
fn slab_scene() -> Scene {
    let shape = Shape::Box { min: Vec3::new(-3.0, -3.0, -1.0), max: Vec3::new(3.0, 3.0, 1.0) };
    let mut scene = scene_of(vec![glass("slab", shape, 1.5, Vec3::new(0.1, 0.2, 0.3))]);
    scene.models[0].rotate_deg = Vec3::new(0.0, 30.0, 0.0);
    scene.camera = Camera { eye: Vec3::new(0.0, 0.0, 12.0), fov_deg: 8.0, ..Camera::default() };
    scene
}

#[test]
fn a_slab_shifts_rays_and_leaves_their_direction() {
    let size = UVec2::splat(32);
    let scene = slab_scene();
    let n = DVec3::new(30f64.to_radians().sin(), 0.0, 30f64.to_radians().cos());
    let ways = render(&scene, size, Channel::ExitDirection);
    let places = render(&scene, size, Channel::ExitPosition);
    for (x, y) in [(16, 16), (3, 20), (29, 5)] {
        let (eye, d) = (DVec3::new(0.0, 0.0, 12.0), pixel_direction(size, 8.0, x, y));
        assert!((ways.channel_at(x, y) - d).length() < 1e-4, "({x}, {y}): {}", ways.channel_at(x, y));
        let entry = eye + d * ((1.0 - eye.dot(n)) / d.dot(n));
        let inside = refract(d, n, 1.0 / 1.5);
        let exit = entry + inside * (2.0 / -inside.dot(n));
        let got = places.channel_at(x, y);
        assert!((got - exit).length() < 2e-3, "({x}, {y}): {got} instead of {exit}");
        let unshifted = entry + d * (2.0 / -d.dot(n));
        assert!((got - unshifted).length() > 0.1, "the ray was not shifted");
    }
}

#[test]
fn transmittance_of_a_slab_is_exp_minus_sigma_d() {
    let size = UVec2::splat(32);
    let n = DVec3::new(30f64.to_radians().sin(), 0.0, 30f64.to_radians().cos());
    let picture = render(&slab_scene(), size, Channel::Transmittance);
    for (x, y) in [(16, 16), (3, 20), (29, 5)] {
        let d = pixel_direction(size, 8.0, x, y);
        let length = 2.0 / -refract(d, n, 1.0 / 1.5).dot(n);
        let truth = (-DVec3::new(0.1, 0.2, 0.3) * length).exp();
        let got = picture.channel_at(x, y);
        assert!((got - truth).abs().max_element() < 1e-3, "({x}, {y}): {got} instead of {truth}");
    }
}

#[test]
fn light_that_meets_glass_from_within_beyond_the_critical_angle_is_mirrored() {
    // A cube seen along its diagonal plane: rays through one face meet the next at 90° less the refracted angle.
    let shape = Shape::Box { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) };
    let mut scene = scene_of(vec![glass("cube", shape, 1.5, Vec3::ZERO)]);
    scene.models[0].rotate_deg = Vec3::new(0.0, 45.0, 0.0);
    scene.camera = Camera { eye: Vec3::new(0.0, 0.0, 12.0), fov_deg: 12.0, ..Camera::default() };
    let size = UVec2::splat(32);
    let at = (6, 16);
    let events = render(&scene, size, Channel::Events).channel_at(at.0, at.1).x;
    let d = pixel_direction(size, 12.0, at.0, at.1);
    // In at the left face, mirrored at the face behind it, out through the third or mirrored again.
    assert!(events >= 3.0, "{events} events: the ray left where it must be mirrored");
    scene.models = vec![glass("cube", shape, 1.05, Vec3::ZERO)];
    scene.models[0].rotate_deg = Vec3::new(0.0, 45.0, 0.0);
    let weak = render(&scene, size, Channel::Events).channel_at(at.0, at.1).x;
    assert!(weak <= 3.0 && d.z < 0.0, "{weak} events in weak glass");
}

#[test]
fn rays_are_questionable_where_they_run_out_of_events_and_hardly_ever_in_a_closed_body() {
    let size = UVec2::splat(96);
    let share = |scene: &Scene| {
        let picture = render(scene, size, Channel::Questionable);
        let agree = picture.channel.iter().zip(&picture.radiance).all(|(c, r)| (c[0] > 0.0) == (r[3] == 0.0));
        assert!(agree, "the picture marks other rays than the channel");
        picture.channel.iter().filter(|p| p[0] > 0.0).count() as f64 / f64::from(size.x * size.y)
    };
    let closed = share(&sphere_scene(1.5, Hit::Surfel));
    assert!(closed < 0.005, "{closed} of a closed sphere's picture");
    let mut short = sphere_scene(1.5, Hit::Surfel);
    short.effect.max_events = 1;
    assert!(share(&short) > 0.1, "rays that may not leave are no less sure of themselves");
}

#[test]
fn clear_glass_in_an_even_light_cannot_be_seen() {
    let size = UVec2::splat(64);
    let grey = Vec3::new(0.2, 0.3, 0.4);
    let brightness = |scene: &Scene| {
        let picture = render(scene, size, Channel::Beauty);
        let ratios = picture.radiance.iter().filter(|p| p[3] > 0.0).map(|p| f64::from(p[1] / grey.y));
        ratios.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), r| (lo.min(r), hi.max(r)))
    };
    for shape in [SPHERE, Shape::Box { min: Vec3::splat(-0.8), max: Vec3::splat(0.8) }] {
        let mut scene = sphere_scene(1.5, Hit::Surfel);
        scene.models = vec![glass("body", shape, 1.5, Vec3::ZERO)];
        scene.models[0].rotate_deg = Vec3::new(20.0, 30.0, 0.0);
        scene.background = Background::Color { color: grey };
        let (darkest, brightest) = brightness(&scene);
        assert!(darkest > 0.999 && brightest < 1.001, "{shape:?}: {darkest} … {brightest} of what is around");
        scene.models[0].materials[0].sigma = Some(Vec3::splat(0.5));
        assert!(brightness(&scene).0 < 0.9, "glass that absorbs can't be seen either");
    }
}

#[test]
fn a_lamp_behind_clear_glass_glints_through_it() {
    let size = UVec2::splat(96);
    let sun =
        Light { kind: LightKind::Directional { direction: Vec3::new(0.1, 0.05, 1.0).normalize() }, ..Light::default() };
    let mut scene = sphere_scene(1.5, Hit::Surfel);
    let brightest =
        |scene: &Scene| render(scene, size, Channel::Beauty).radiance.iter().map(|p| p[1]).fold(0.0, f32::max);
    let dark = brightest(&scene);
    assert!(dark < 1e-3, "{dark} without any light");
    scene.lights = vec![sun];
    let glint = brightest(&scene);
    let disc = sun.intensity / (std::f32::consts::PI * 0.06 * 0.06);
    assert!(glint > 5.0 && glint < 1.01 * disc, "{glint} where the sun's own disc is {disc}");
    scene.effect.refraction = Refraction::None;
    scene.effect.reflection = false;
    assert!(brightest(&scene) < 1e-3, "a ray that is not bent sees the lamp");
}
