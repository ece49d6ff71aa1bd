//! Surfaces given by expressions are the surfaces that they describe, closed, and seen by every effect.

mod expressions;

use crate::gpu;
use crate::mesh::{corners, open_edges, volume};
use crate::support::{Rendered, glass, render_with, scene_of};
use glam::{DVec3, UVec2, UVec3, Vec3};
use murrine::compose::DebugView;
use murrine::frame::{Frame, Request};
use murrine::gpu::{Timing, buffer};
use murrine::grid::Grid;
use murrine::headless;
use murrine::march::Channel;
use murrine::scene::description::{Cells, GridSettings, Hit, MaterialOverride, Model, Region, Shape, Source};
use murrine::scene::expression::{Dual, Expression, Number};
use murrine::scene::implicit::Implicit;
use murrine::scene::parametric::Parametric;
use murrine::scene::surface::Surface;
use murrine::scene::{Scene, World};
use std::f64::consts::PI;
use std::sync::Arc;

fn implicit(expression: &str, half: f32, cells: u32) -> Implicit {
    let expression = Expression::parse(expression, Implicit::VARIABLES).unwrap();
    Implicit { expression, min: Vec3::splat(-half), max: Vec3::splat(half), cells }
}

fn parametric(position: [&str; 3], ranges: [[&str; 2]; 2], steps: [u32; 2], wrap: [bool; 2]) -> Parametric {
    let parsed = |text| Expression::parse(text, Parametric::VARIABLES).unwrap();
    let constant = |text| Expression::parse(text, &[]).unwrap();
    Parametric { position: position.map(parsed), ranges: ranges.map(|r| r.map(constant)), steps, wrap }
}

fn ball(steps: [u32; 2]) -> Parametric {
    let position = ["sin(v)*cos(u)", "cos(v)", "sin(v)*sin(u)"];
    parametric(position, [["0", "2*pi"], ["0", "pi"]], steps, [true, false])
}

fn ring() -> Parametric {
    let position = ["(1 + 0.4*cos(v))*cos(u)", "0.4*sin(v)", "(1 + 0.4*cos(v))*sin(u)"];
    parametric(position, [["0", "2*pi"]; 2], [96, 48], [true, true])
}

/// Closed, and each with something of its own: round, ringed, Dong's tubes, a sharp groove, a saddle-ridden knot of two.
const CLOSED: [(&str, &str, f32); 5] = [
    ("sphere", "x^2 + y^2 + z^2 - 1", 1.3),
    ("torus", "(sqrt(x^2 + z^2) - 0.9)^2 + y^2 - 0.1", 1.4),
    ("quartic", "x^4 - 5*x^2 + y^4 - 5*y^2 + z^4 - 5*z^2 + 11.8", 2.6),
    ("two balls", "min(x^2 + y^2 + z^2, (x - 0.7)^2 + (y - 0.4)^2 + z^2) - 0.5", 1.6),
    ("chmutov", "8*(x^4 + y^4 + z^4) - 8*(x^2 + y^2 + z^2) + 3.2", 1.2),
];

fn value_and_gradient(expression: &Expression, p: DVec3) -> (f64, DVec3) {
    let variables = [0, 1, 2].map(|axis| Dual::<3>::variable(p[axis], axis));
    let [x, y, z] = variables;
    let dual = expression.evaluate(&[x, y, z, Dual::constant(0.0)], &mut Vec::new());
    (dual.value, DVec3::from_array(dual.slopes))
}

fn model(surface: Surface) -> Model {
    Model {
        source: Source::Surface(Arc::new(surface)),
        materials: vec![MaterialOverride { ior: Some(1.0), sigma: Some(Vec3::ONE), ..MaterialOverride::default() }],
        ..Model::default()
    }
}

#[test]
fn an_implicit_surface_lies_where_its_expression_is_zero_and_its_normals_are_the_gradients() {
    for (name, text, half) in CLOSED {
        let surface = implicit(text, half, 48);
        let geometry = Surface::Implicit(surface.clone()).geometry(0.0);
        assert_eq!(geometry.warning, None, "{name}");
        assert_eq!(open_edges(&geometry), 0, "{name} is open");
        let (mut off, mut turned, mut inward) = (0, 0, 0);
        for v in &geometry.vertices {
            let (value, gradient) = value_and_gradient(&surface.expression, v.position.as_dvec3());
            off += usize::from((value / gradient.length()).abs() > 1e-6);
            turned += usize::from(gradient.normalize().angle_between(v.normal.as_dvec3()) > 1e-4);
        }
        for &t in &geometry.triangles {
            let [a, b, c] = corners(&geometry, t);
            let normal: Vec3 = t.iter().map(|v| geometry.vertices[*v as usize].normal).sum();
            inward += usize::from((b - a).cross(c - a).dot(normal.as_dvec3()) < 0.0);
        }
        assert_eq!((off, turned), (0, 0), "{name}: of {} vertices", geometry.vertices.len());
        // In a groove a cell's vertex lies on one of two sheets, and a triangle may lean over.
        assert!(inward * 1000 <= geometry.triangles.len(), "{name}: {inward} triangles face inward");
    }
    let sphere = Surface::Implicit(implicit(CLOSED[0].1, 1.3, 48)).geometry(0.0);
    assert!((volume(&sphere) / (4.0 / 3.0 * PI) - 1.0).abs() < 3e-3, "{}", volume(&sphere));
    let mut torn = sphere;
    torn.triangles.pop();
    assert_eq!(open_edges(&torn), 6, "a missing triangle must be seen");
}

/// Cells that water from outside reaches through the faces of unmarked cells.
fn flooded(grid: &Grid, is_marked: impl Fn([u32; 3]) -> bool) -> Vec<[u32; 3]> {
    let n = grid.cells;
    let index = |c: [u32; 3]| ((c[2] * n.y + c[1]) * n.x + c[0]) as usize;
    let mut seen = vec![false; n.element_product() as usize];
    let mut reached = vec![[0_u32; 3]];
    seen[0] = true;
    let mut next = 0;
    while let Some(&cell) = reached.get(next) {
        next += 1;
        for axis in 0..3 {
            for step in [1_u32, u32::MAX] {
                let mut beside = cell;
                beside[axis] = beside[axis].wrapping_add(step);
                if beside[axis] < n[axis] && !seen[index(beside)] && !is_marked(beside) {
                    seen[index(beside)] = true;
                    reached.push(beside);
                }
            }
        }
    }
    reached
}

#[test]
fn no_water_leaks_into_five_closed_surfaces_at_three_grids() {
    // In a row, each in a box of two units.
    let surfaces = CLOSED.map(|(_, text, half)| implicit(text, half, 40));
    let place = |(i, surface): (u8, &Implicit)| Model {
        name: i.to_string(),
        translate: Vec3::new(2.0 * f32::from(i), 0.0, 0.0),
        scale: 1.0 / surface.max.x,
        ..model(Surface::Implicit(surface.clone()))
    };
    let scene = scene_of((0..).zip(&surfaces).map(place).collect());
    let world = World::load(&scene, None).unwrap();
    let mut sampled_leaks = [0; 5];
    for cells in [24, 37, 64] {
        let side = 2.0 / f64::from(cells);
        let grid = Grid::world_aligned(DVec3::NEG_ONE, side, UVec3::new(5 * cells, cells, cells));
        let slabs = headless::VoxelSlabs::new(gpu(), &scene, &world, 0.0, grid, false).unwrap();
        let voxels: Vec<u8> = slabs.flat_map(|slab| slab.unwrap().into_slices().flatten()).collect();
        let marked = |[x, y, z]: [u32; 3]| voxels[((z * cells + y) * 5 * cells + x) as usize] != 0;
        // Number of its surface, and the expression at a cell's centre.
        let value = |c: [u32; 3]| {
            let i = c[0] / cells;
            let center = grid.world_point(UVec3::from_array(c).as_dvec3() + 0.5) - DVec3::X * 2.0 * f64::from(i);
            let surface = &surfaces[i as usize];
            let p = center * f64::from(surface.max.x);
            let variables = [p.x, p.y, p.z, 0.0];
            (i as usize, surface.expression.evaluate::<f64>(&variables, &mut Vec::new()))
        };
        for cell in flooded(&grid, marked) {
            let (i, value) = value(cell);
            assert!(value >= 0.0, "{} leaks at {cells}³", CLOSED[i].0);
        }
        // Dong's rule: the expression at one point of the cell is near zero.
        for cell in flooded(&grid, |c| value(c).1.abs() < 0.5 * side) {
            let (i, value) = value(cell);
            sampled_leaks[i] += usize::from(value < 0.0);
        }
    }
    assert!(sampled_leaks[2] > 1000, "a cell decided by one sample must leak: {sampled_leaks:?}");
}

#[test]
fn a_parametric_surface_is_closed_over_its_seams_and_poles_with_its_derivatives_normals() {
    type NormalAt = fn(DVec3) -> DVec3;
    let exact: [(Parametric, NormalAt, f64); 2] = [
        (ball([64, 32]), |p| p, 4.0 / 3.0 * PI),
        (ring(), |p| p - DVec3::new(p.x, 0.0, p.z).normalize(), 2.0 * PI * PI * 0.16),
    ];
    for (surface, normal_at, true_volume) in exact {
        let geometry = Surface::Parametric(surface.clone()).geometry(0.0);
        assert_eq!(geometry.warning, None);
        assert_eq!(open_edges(&geometry), 0);
        assert!((volume(&geometry) / true_volume - 1.0).abs() < 0.02, "{} of {true_volume}", volume(&geometry));
        let worst = geometry
            .vertices
            .iter()
            .map(|v| normal_at(v.position.as_dvec3()).normalize().angle_between(v.normal.as_dvec3()));
        assert!(worst.fold(0.0, f64::max) < 1e-3);
        // Run the other way round it is the same surface, outward all the same.
        let mut mirrored = surface.clone();
        mirrored.position.swap(0, 2);
        assert!(volume(&Surface::Parametric(mirrored).geometry(0.0)) > 0.0);
        let torn =
            Parametric { wrap: [false; 2], ranges: [surface.ranges[0].clone(), surface.ranges[1].clone()], ..surface };
        let shorter = Expression::parse("6", &[]).unwrap();
        let torn = Parametric { ranges: [[torn.ranges[0][0].clone(), shorter], torn.ranges[1].clone()], ..torn };
        assert!(open_edges(&Surface::Parametric(torn).geometry(0.0)) > 0, "a slit must be seen");
    }
}

fn transmittance_at(frame: &mut Frame, scene: &Scene, world: &World, time_secs: f64) -> Vec<f64> {
    let size = UVec2::splat(48);
    let (channel, view) = (Channel::Transmittance, DebugView::None);
    let request = Request { scene, world, time_secs, size, picture_size: size, channel, view, timing: Timing::Off };
    for _ in 0..4 {
        frame.render(gpu(), &request).unwrap();
        if frame.settle(gpu()).unwrap() {
            break;
        }
    }
    let texels: Vec<[f32; 4]> = buffer::read_texture(gpu(), &frame.radiance().channel).unwrap();
    texels.iter().map(|t| f64::from(t[0])).collect()
}

#[test]
fn moving_surfaces_are_at_every_time_what_still_ones_are() {
    let (mut frame, mut still_frame) = (Frame::new(gpu()).unwrap(), Frame::new(gpu()).unwrap());
    let moving = |surface| scene_of(vec![model(surface)]);
    let radius = |t: f64| 0.5 + 0.4 * (t - 1.0).abs();
    let implicit_ball = |r: &str| Surface::Implicit(implicit(&format!("x^2 + y^2 + z^2 - ({r})^2"), 1.2, 32));
    let parametric_ball = |r: &str| {
        let mut surface = ball([48, 24]);
        let scaled =
            |e: &Expression| Expression::parse(&format!("({r})*({})", e.text()), Parametric::VARIABLES).unwrap();
        surface.position = surface.position.each_ref().map(scaled);
        Surface::Parametric(surface)
    };
    for make in [&implicit_ball as &dyn Fn(&str) -> Surface, &parametric_ball] {
        let scene = moving(make("0.5 + 0.4*abs(t - 1)"));
        let world = World::load(&scene, None).unwrap();
        let mut seen = Vec::new();
        // At 0.75 and 1 it is small, so that what comes then has not the room of what was before, and the other way round.
        for t in [1.0, 0.0, 0.75, 2.0] {
            let here = transmittance_at(&mut frame, &scene, &world, t);
            let still = moving(make(&radius(t).to_string()));
            let still_world = World::load(&still, None).unwrap();
            let expected = transmittance_at(&mut still_frame, &still, &still_world, 0.0);
            let apart = here.iter().zip(&expected).filter(|(a, b)| (*a - *b).abs() > 2e-3).count();
            assert!(apart <= 12, "{apart} of {} pixels differ at {t} s", here.len());
            assert!(here.iter().any(|x| *x < 0.5), "there is no glass at {t} s");
            seen.push(here);
        }
        let moved = seen[0].iter().zip(&seen[1]).filter(|(a, b)| (*a - *b).abs() > 2e-3).count();
        assert!(moved > 100, "the ball does not move: {moved}");
    }
}

#[test]
fn what_is_no_number_is_told_and_never_seen() {
    let mut frame = Frame::new(gpu()).unwrap();
    let odd_ball = parametric(
        ["sin(v)*cos(u)/(u - 1)*(u - 1)", "cos(v)", "sin(v)*sin(u) + 0*log(v - 1)"],
        [["0", "2*pi"], ["0", "pi"]],
        [48, 24],
        [true, false],
    );
    let cases = [
        (Surface::Implicit(implicit("x^2 + y^2 + z^2 - 1 + 0*sqrt(x)", 1.3, 24)), "no number at"),
        (Surface::Implicit(implicit("x^2 + y^2 + z^2 - 1 + 0.001/(x - x)", 1.3, 24)), "nothing of the surface"),
        (Surface::Implicit(implicit("x^2 + y^2 + z^2 - 4", 1.3, 24)), "cut where it leaves"),
        (Surface::Implicit(implicit("x^2 + y^2 + z^2 + 1", 1.3, 24)), "nothing of the surface"),
        (Surface::Parametric(odd_ball), "no numbers"),
    ];
    for (surface, warning) in cases {
        let scene = scene_of(vec![model(surface)]);
        let world = World::load(&scene, None).unwrap();
        let told = world.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
        assert!(told.contains(warning) && told.contains("; "), "expected {warning}, told {told}");
        let geometry = &world.models[0];
        assert!(geometry.vertices.iter().all(|v| v.position.is_finite() && v.normal.is_finite()));
        assert_eq!(open_edges(geometry), if warning == "no numbers" { open_edges(geometry) } else { 0 }, "{warning}");
        let picture = render_with(&mut frame, &scene, &world, UVec2::splat(32), Channel::Transmittance);
        assert!(picture.radiance.iter().flatten().all(|x| x.is_finite()), "{warning}: the picture is no number");
    }
    let good = scene_of(vec![model(Surface::Implicit(implicit(CLOSED[0].1, 1.3, 24)))]);
    assert!(World::load(&good, None).unwrap().warnings.is_empty());
}

#[test]
fn a_surface_is_cut_flat_at_the_faces_of_its_box() {
    let cube = Surface::Implicit(implicit("x^2 + y^2 + z^2 - 4", 1.0, 24)).geometry(0.0);
    let (mut least, mut most) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for v in &cube.vertices {
        least = least.min(v.position);
        most = most.max(v.position);
    }
    assert_eq!((least, most), (Vec3::NEG_ONE, Vec3::ONE));
    // Its edges are bevelled by no more than a cell.
    assert!(volume(&cube) > 7.8 && volume(&cube) <= 8.0 + 1e-6, "{}", volume(&cube));
}

#[test]
fn a_region_is_voxelized_at_full_resolution_and_what_lies_in_it_looks_as_if_alone() {
    let ball = |name: &str, x: f32| Model {
        name: name.to_owned(),
        translate: Vec3::new(x, 0.0, 0.0),
        ..glass(name, Shape::Icosphere { radius: 1.0, subdivisions: 4 }, 1.4, Vec3::ONE)
    };
    let mut frame = Frame::new(gpu()).unwrap();
    let mut shown = |models: Vec<Model>, region: Option<Region>| {
        let mut scene = scene_of(models);
        scene.camera.eye = Vec3::new(0.0, 0.0, 9.0);
        scene.effect.hit = Hit::Voxel; // whose pictures hang on the grid
        scene.grid = GridSettings { cells: Cells::Longest(48), region, ..GridSettings::default() };
        let world = World::load(&scene, None).unwrap();
        let picture = render_with(&mut frame, &scene, &world, UVec2::splat(64), Channel::ExitDirection);
        (picture, frame.volume().grids[0])
    };
    let whole = || vec![ball("here", 0.0), ball("beside", 8.0)];
    let region = Region { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) };
    let (alone, alone_grid) = shown(vec![ball("here", 0.0)], None);
    let (inside, inside_grid) = shown(whole(), Some(region));
    let (coarse, coarse_grid) = shown(whole(), None);
    assert!(inside_grid.cell_size <= alone_grid.cell_size && coarse_grid.cell_size > 3.0 * alone_grid.cell_size);
    let apart = |picture: &Rendered| {
        let middle = (16..48).flat_map(|y| (16..48).map(move |x| (x, y)));
        middle.filter(|&(x, y)| picture.channel_at(x, y).distance(alone.channel_at(x, y)) > 2e-3).count()
    };
    let (by_region, by_all) = (apart(&inside), apart(&coarse));
    assert!(by_region <= 4, "{by_region} rays differ");
    assert!(by_all > 10 * (by_region + 1), "the coarse grid must show: {by_all} against {by_region}");
}
