//! Bodies made of other models are, cell by cell and ray by ray, what the operations make of them.

use crate::gpu;
use crate::support::{glass, pixel_direction, render, render_with, scene_of};
use glam::{DVec3, UVec2, UVec3, Vec3};
use murrine::frame::Frame;
use murrine::grid::Grid;
use murrine::headless;
use murrine::march::Channel;
use murrine::scene::csg::{Operation, Tree};
use murrine::scene::description::{MaterialOverride, Model, Shape, Source};
use murrine::scene::{Scene, World, file};
use std::path::Path;

fn body(tree: Tree, ior: f32, sigma: Vec3) -> Model {
    Model {
        name: "body".to_owned(),
        source: Source::Csg(tree),
        materials: vec![MaterialOverride { ior: Some(ior), sigma: Some(sigma), ..MaterialOverride::default() }],
        ..Model::default()
    }
}

fn node(operation: Operation, of: &[&str]) -> Tree {
    Tree::Node(operation, of.iter().map(|name| Tree::Model((*name).to_owned())).collect())
}

fn cuboid(min: [f32; 3], max: [f32; 3]) -> Shape {
    Shape::Box { min: Vec3::from_array(min), max: Vec3::from_array(max) }
}

/// Three deep; the ball swells and the ring tilts with time.
const DEEP: &str = r#"
[[model]]
name = "body"
csg = { difference = [{ union = [{ intersection = ["ball", "cube"] }, "ring"] }, "egg", { difference = ["slab", "rod"] }] }
[[model]]
name = "ball"
shape = "implicit"
expression = "x^2 + y^2 + z^2 - (0.85 + 0.1*sin(t))^2"
min = [-1.1, -1.1, -1.1]
max = [1.1, 1.1, 1.1]
cells = 32
[[model]]
name = "cube"
shape = "box"
min = [-0.7, -0.61, -0.93]
max = [0.66, 0.72, 0.71]
rotate_deg = [10, 20, 30]
[[model]]
name = "ring"
shape = "parametric"
x = "(0.8 + 0.2*cos(v))*cos(u)"
y = "0.2*sin(v) + 0.2*sin(u + t)"
z = "(0.8 + 0.2*cos(v))*sin(u)"
u = [0, "2*pi"]
v = [0, "2*pi"]
steps = [48, 24]
wrap = [true, true]
[[model]]
name = "egg"
shape = "sphere"
radius = 0.5
rings = 24
translate = [0.3, 0.1, 0.2]
[[model]]
name = "slab"
shape = "box"
min = [-2, -0.1, -2]
max = [2, 0.13, 2]
[[model]]
name = "rod"
shape = "box"
min = [-0.3, -1, -2]
max = [0.31, 1, 2]
"#;

fn parsed(text: &str) -> Result<Scene, String> {
    file::parse(text, Path::new("a.toml"), &headless::methods()).map(|(scene, _)| scene).map_err(|e| e.to_string())
}

fn solid(scene: &Scene, time_secs: f64) -> Vec<bool> {
    let grid = Grid::world_aligned(DVec3::splat(-1.17), 2.34 / 48.0, UVec3::splat(48));
    let world = World::load(scene, None).unwrap_or_else(|e| panic!("{e}"));
    let slabs = headless::VoxelSlabs::new(gpu(), scene, &world, time_secs, grid, true).unwrap();
    slabs.flat_map(|slab| slab.unwrap().into_slices().flatten()).map(|m| m != 0).collect()
}

#[test]
fn the_solid_is_cell_by_cell_what_the_operations_make_of_the_operands_solids() {
    let scene = parsed(DEEP).unwrap();
    let of = |i: usize, time_secs| solid(&Scene { models: vec![scene.models[i].clone()], ..scene.clone() }, time_secs);
    let [cube, egg, slab, rod] = [2, 4, 5, 6].map(|i| of(i, 0.0));
    let mut last = Vec::new();
    for time_secs in [0.0, 1.3] {
        let here = solid(&scene, time_secs);
        let [ball, ring] = [1, 3].map(|i| of(i, time_secs));
        let truth = |i: usize| ((ball[i] && cube[i]) || ring[i]) && !egg[i] && (!slab[i] || rod[i]);
        let count = here.iter().filter(|inside| **inside).count();
        let wrong = (0..here.len()).filter(|i| here[*i] != truth(*i)).count();
        assert!(count > 3000, "{count} cells are solid");
        assert_eq!(wrong, 0, "of {} cells at {time_secs} s", here.len());
        let without_rod = (0..here.len()).filter(|i| here[*i] != (truth(*i) && !slab[*i])).count();
        assert!(without_rod > 100, "another tree must show: {without_rod}");
        last.push(here);
    }
    let moved = last[0].iter().zip(&last[1]).filter(|(a, b)| a != b).count();
    assert!(moved > 300, "the operands don't move: {moved}");
}

/// Length of a ray inside a box.
fn chord(eye: DVec3, d: DVec3, min: [f64; 3], max: [f64; 3]) -> f64 {
    let (a, b) = ((DVec3::from_array(min) - eye) / d, (DVec3::from_array(max) - eye) / d);
    (a.max(b).min_element() - a.min(b).max_element()).max(0.0)
}

#[test]
fn absorption_in_a_drilled_block_is_that_of_the_block_less_the_hole() {
    let (size, sigma) = (UVec2::splat(96), 0.7);
    let [block, hole] = [([-1.0, -0.9, -0.8], [1.0, 0.9, 0.8]), ([-0.45, -0.4, -0.5], [0.4, 0.5, 2.0])];
    let single = |c: [f64; 3]| c.map(|x| format!("{x}").parse().unwrap());
    let shapes = [block, hole].map(|(min, max)| cuboid(single(min), single(max)));
    let models = vec![
        body(node(Operation::Difference, &["block", "hole"]), 1.0, Vec3::splat(0.7)),
        glass("block", shapes[0], 1.0, Vec3::ZERO),
        glass("hole", shapes[1], 1.0, Vec3::ZERO),
    ];
    let mut scene = scene_of(models);
    scene.camera.eye = Vec3::new(0.0, 0.0, 6.0);
    let picture = render(&scene, size, Channel::Transmittance);
    let eye = scene.camera.eye.as_dvec3();
    let (mut wrong, mut drilled, mut as_if_whole) = (0, 0, 0);
    for (x, y) in (0..size.y).flat_map(|y| (0..size.x).map(move |x| (x, y))) {
        let d = pixel_direction(size, 30.0, x, y);
        let outer = chord(eye, d, block.0, block.1);
        let gone = chord(eye, d, hole.0.map(|c| c.max(-0.8)), [hole.1[0], hole.1[1], 0.8]);
        let seen = picture.channel_at(x, y).x;
        wrong += usize::from((seen - (-sigma * (outer - gone)).exp()).abs() > 5e-3);
        drilled += usize::from(gone > 0.2);
        as_if_whole += usize::from(gone > 0.2 && (seen - (-sigma * outer).exp()).abs() < 5e-3);
    }
    assert!(drilled > 200, "{drilled} rays meet the hole");
    assert!(wrong <= 96, "{wrong} of {} rays are wrong", size.element_product());
    assert!(as_if_whole <= 8, "the hole must show: {as_if_whole} rays");
}

#[test]
fn light_bends_at_a_bodys_surface_as_at_that_of_models_which_are_it() {
    let size = UVec2::splat(80);
    let ball = |name: &str, x: f32| Model {
        translate: Vec3::new(x, 0.0, 0.0),
        ..glass(name, Shape::Icosphere { radius: 0.8, subdivisions: 5 }, 1.3, Vec3::ZERO)
    };
    let balls = [ball("left", -0.35), ball("right", 0.35)];
    let mut frame = Frame::new(gpu()).unwrap();
    let mut exits = |models: Vec<Model>| {
        let scene = scene_of(models);
        let world = World::load(&scene, None).unwrap();
        render_with(&mut frame, &scene, &world, size, Channel::ExitDirection)
    };
    let with = |operation| [vec![body(node(operation, &["left", "right"]), 1.3, Vec3::ZERO)], balls.to_vec()].concat();
    let plain = exits(balls.to_vec());
    let apart = |a: &crate::support::Rendered, b: &crate::support::Rendered| {
        let pixels = (0..size.y).flat_map(|y| (0..size.x).map(move |x| (x, y)));
        let differ = |a: DVec3, b: DVec3| a.is_nan() != b.is_nan() || a.distance(b) > 0.01;
        pixels.filter(|&(x, y)| differ(a.channel_at(x, y), b.channel_at(x, y))).count()
    };
    // Overlapping models of one glass are their union.
    let union = exits(with(Operation::Union));
    assert!(apart(&union, &plain) < 130, "{} rays differ", apart(&union, &plain));
    let difference = exits(with(Operation::Difference));
    assert!(apart(&difference, &plain) > 1000, "a difference is no union: {}", apart(&difference, &plain));
    // A ball taken away leaves what a ball of air in the glass is, whose normals look the other way.
    let small = |ior| Model {
        name: "hole".to_owned(),
        ..glass("hole", Shape::Icosphere { radius: 0.4, subdivisions: 5 }, ior, Vec3::ZERO)
    };
    let hollow = exits(vec![
        body(node(Operation::Difference, &["ball", "hole"]), 1.3, Vec3::ZERO),
        ball("ball", 0.0),
        small(1.3),
    ]);
    let bubble = exits(vec![ball("ball", 0.0), small(1.0)]);
    assert!(apart(&hollow, &bubble) < 130, "{} rays differ", apart(&hollow, &bubble));
    // What is taken away where nothing is changes nothing.
    let far = Model { translate: Vec3::new(0.0, 9.0, 0.0), ..ball("right", 0.0) };
    let alone = exits(vec![ball("left", -0.35)]);
    let models = vec![body(node(Operation::Difference, &["left", "right"]), 1.3, Vec3::ZERO), ball("left", -0.35), far];
    let untouched = exits(models);
    assert!(apart(&untouched, &alone) < 60, "{} rays differ", apart(&untouched, &alone));
}

#[test]
fn what_no_body_can_be_made_of_is_refused_by_name() {
    let with = |tree: &str, more: &str| {
        let text = format!(
            "[[model]]\nname = \"body\"\ncsg = {tree}\n[[model]]\nname = \"a\"\nshape = \"box\"\n\
            [[model]]\nname = \"b\"\nshape = \"sphere\"\n{more}"
        );
        let scene = parsed(&text)?;
        World::load(&scene, None).map(|_| ()).map_err(|e| e.to_string())
    };
    assert_eq!(with("{ union = [\"a\", \"b\"] }", ""), Ok(()));
    let open = "[[model]]\nname = \"sheet\"\nshape = \"parametric\"\nx = \"u\"\ny = \"u*v\"\nz = \"v\"\nu = [0, 1]\nv = [0, 1]\n";
    let plane = "[[model]]\nname = \"floor\"\nshape = \"plane\"\n";
    let cases = [
        ("{ union = [\"a\", \"c\"] }", "", "`c`, which is no model; choose body, a, b"),
        ("{ union = [\"a\", \"a\"] }", "", "`a` a second time; "),
        ("{ union = [\"a\", \"body\"] }", "", "`body`, which has one itself; "),
        ("{ difference = [\"a\", \"sheet\"] }", open, "`sheet`, whose mesh is open at"),
        ("{ difference = [\"a\", \"floor\"] }", plane, "`floor`, which has no triangles; "),
        ("{ differenc = [\"a\", \"b\"] }", "", "unknown operation `differenc`; did you mean `difference`?"),
        ("{ union = [\"a\"] }", "", "takes a list of two models or more"),
        ("{ union = [\"a\", 3] }", "", "a.toml:3:23: neither a model's name nor a tree; "),
        ("{ union = [\"a\", \"b\"], difference = [] }", "", "one operation on a list; "),
        ("\"a\"", "", "`csg` is a string; write"),
    ];
    for (tree, more, expected) in cases {
        let told = with(tree, more).unwrap_err();
        assert!(told.contains(expected), "{tree}: expected {expected}, told {told}");
    }
}
