//! Nodes, joints and morph targets move vertices as glTF says.

use super::maker::{Maker, U8, U16};
use glam::{Mat4, Vec3};
use murrine::scene::description::{Model, Scene};
use murrine::scene::geometry::Geometry;
use murrine::scene::pose::pose_vertices;
use murrine::scene::{Pose, World};
use serde_json::json;
use std::sync::Arc;

/// World positions and normals of a model alone in a scene.
pub(super) fn posed(geometry: Geometry, time_secs: f64) -> (Vec<(Vec3, Vec3)>, Pose) {
    let scene = Scene { models: vec![Model::default()], ..Scene::default() };
    let world = World::from_geometry(&scene, vec![Arc::new(geometry)]);
    super::bounds::assert_contained(&world, &scene, time_secs);
    let pose = world.pose(&scene, time_secs);
    (pose_vertices(&world, &scene, &pose), pose)
}

fn near(a: Vec3, b: [f32; 3]) -> bool {
    (a - Vec3::from_array(b)).length() < 1e-6
}

const QUARTER_ABOUT_Z: [f32; 4] = [0.0, 0.0, std::f32::consts::FRAC_1_SQRT_2, std::f32::consts::FRAC_1_SQRT_2];

/// A bar of three points up the y axis. The upper joint stands at height 1 and turns by 90° about z within a second.
fn bar(weights: [[f32; 4]; 3]) -> Maker {
    let mut maker = Maker::new();
    let position = maker.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0]);
    let normal = maker.floats("VEC3", &[1.0, 0.0, 0.0].repeat(3));
    let joints = maker.accessor(U8, "VEC4", 3, &[0, 1, 0, 0].repeat(3));
    let weights = maker.floats("VEC4", &weights.concat());
    let attributes = json!({ "POSITION": position, "NORMAL": normal, "JOINTS_0": joints, "WEIGHTS_0": weights });
    let skinned = maker.add_mesh(&json!({ "attributes": attributes }));
    let upper = maker.push("nodes", json!({ "translation": [0.0, 1.0, 0.0] }));
    let lower = maker.add_root(json!({ "children": [upper] }));
    let binds = [Mat4::IDENTITY, Mat4::from_translation(Vec3::new(0.0, -1.0, 0.0))].map(|m| m.to_cols_array()).concat();
    let binds = maker.floats("MAT4", &binds);
    maker.push("skins", json!({ "joints": [lower, upper], "inverseBindMatrices": binds }));
    maker.json["nodes"][skinned]["skin"] = json!(0);
    // A skinned node's own transform means nothing.
    maker.json["nodes"][skinned]["translation"] = json!([100.0, 0.0, 0.0]);
    maker.animate("bend", upper, "rotation", "LINEAR", &[0.0, 1.0, 2.0], &{
        let rest = [0.0, 0.0, 0.0, 1.0];
        [rest, QUARTER_ABOUT_Z, rest].concat()
    });
    maker
}

const WEIGHTS: [[f32; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]];

#[test]
fn a_skin_carries_each_vertex_with_its_joints() {
    let (rest, _) = posed(bar(WEIGHTS).read_cleanly().geometry, 0.0);
    assert!(near(rest[2].0, [0.0, 2.0, 0.0]), "{}", rest[2].0);
    let (bent, _) = posed(bar(WEIGHTS).read_cleanly().geometry, 1.0);
    assert!(near(bent[0].0, [0.0, 0.0, 0.0]) && near(bent[0].1, [1.0, 0.0, 0.0]));
    assert!(near(bent[1].0, [0.0, 1.0, 0.0]), "the joint's own place stays");
    assert!(near(bent[2].0, [-1.0, 1.0, 0.0]), "the end swings round the joint: {}", bent[2].0);
    assert!(near(bent[2].1, [0.0, 1.0, 0.0]), "and its normal with it: {}", bent[2].1);
}

#[test]
fn a_skin_goes_where_the_parents_of_its_joints_go() {
    let mut maker = bar(WEIGHTS);
    // The lower joint gets a parent that turns, scales and moves; the mesh's own node a parent that means nothing.
    let lower = maker.json["skins"][0]["joints"][0].clone();
    let root = maker.push(
        "nodes",
        json!({ "children": [lower], "rotation": QUARTER_ABOUT_Z, "scale": [2.0, 2.0, 2.0], "translation": [5.0, 0.0, 0.0] }),
    );
    let elsewhere = maker.push("nodes", json!({ "children": [0], "translation": [0.0, 0.0, 50.0] }));
    maker.json["scenes"][0]["nodes"] = json!([root, elsewhere]);
    maker.json["skins"][0]["skeleton"] = json!(root);
    let (rest, _) = posed(maker.read_cleanly().geometry, 0.0);
    // (0, 2, 0) turned by 90° about z, doubled, moved.
    assert!(near(rest[2].0, [1.0, 0.0, 0.0]), "{}", rest[2].0);
    assert!(near(rest[2].1, [0.0, 1.0, 0.0]), "{}", rest[2].1);
    let (bent, _) = posed(maker.read_cleanly().geometry, 1.0);
    assert!(near(bent[2].0, [3.0, -2.0, 0.0]), "bent in the root's space: {}", bent[2].0);
}

#[test]
fn quantized_weights_and_sparse_targets_equal_plain_ones() {
    let mut plain = bar([[0.2, 0.8, 0.0, 0.0]; 3]);
    let mut packed = bar([[0.2, 0.8, 0.0, 0.0]; 3]);
    let lift = plain.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.25]);
    plain.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": lift }]);
    let weights = packed.accessor(U8, "VEC4", 3, &[51, 204, 0, 0].repeat(3));
    packed.json["accessors"][weights]["normalized"] = json!(true);
    packed.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
    let place = packed.view(&[2]);
    let value: Vec<u8> = [0.0_f32, 0.5, 0.25].iter().flat_map(|v| v.to_le_bytes()).collect();
    let value = packed.view(&value);
    let indices = json!({ "bufferView": place, "componentType": U8 });
    let sparse = json!({ "count": 1, "indices": indices, "values": { "bufferView": value } });
    let target = json!({ "componentType": 5126, "type": "VEC3", "count": 3, "sparse": sparse });
    let target = packed.push("accessors", target);
    packed.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": target }]);
    for maker in [&mut plain, &mut packed] {
        maker.json["meshes"][0]["weights"] = json!([1.0]);
    }
    let [plain, packed] = [plain, packed].map(|maker| posed(maker.read_cleanly().geometry, 0.7).0);
    for (a, b) in plain.iter().zip(&packed) {
        assert!((a.0 - b.0).length() < 1e-6 && (a.1 - b.1).length() < 1e-6, "{a:?} {b:?}");
    }
    assert!((plain[2].0 - posed(bar([[0.2, 0.8, 0.0, 0.0]; 3]).read_cleanly().geometry, 0.7).0[2].0).length() > 0.1);
}

#[test]
fn weights_that_do_not_sum_to_one_are_scaled_with_a_word() {
    let loaded = bar(WEIGHTS.map(|w| w.map(|x| x * 3.0))).read();
    assert!(
        loaded.warnings[0].what.contains("3 vertices had weights that did not sum to one"),
        "{:?}",
        loaded.warnings
    );
    assert_eq!(posed(loaded.geometry, 1.0).0, posed(bar(WEIGHTS).read().geometry, 1.0).0);
    let mut odd = WEIGHTS;
    odd[0] = [0.0; 4];
    odd[1] = [1.0, f32::NAN, -2.0, 0.0];
    let loaded = bar(odd).read();
    let told: Vec<_> = loaded.warnings.iter().map(|w| w.what.as_str()).collect();
    assert!(told.iter().any(|w| w.contains("1 vertices had no weights")), "{told:?}");
    assert!(told.iter().any(|w| w.contains("2 weights were negative, not finite")), "{told:?}");
    assert!(posed(loaded.geometry, 1.0).0.iter().all(|(p, _)| p.is_finite()));
}

#[test]
fn of_more_than_four_joints_the_strongest_count() {
    let mut maker = bar([[0.1, 0.2, 0.0, 0.0]; 3]);
    let joints = maker.accessor(U16, "VEC4", 3, &[1, 0, 1, 0, 1, 0, 1, 0].repeat(3));
    let weights = maker.floats("VEC4", &[0.3, 0.2, 0.15, 0.05].repeat(3));
    let attributes = &mut maker.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_1"] = json!(joints);
    attributes["WEIGHTS_1"] = json!(weights);
    let loaded = maker.read();
    assert!(loaded.warnings[0].what.contains("strongest"), "{:?}", loaded.warnings);
    let influence = loaded.geometry.influences[0];
    let expected = [0.3, 0.2, 0.2, 0.15].map(|w| w / 0.85);
    for (found, expected) in influence.weights.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-6, "{influence:?}");
    }
    assert_eq!(influence.joints, [1; 4]);
}

#[test]
fn morphs_act_before_the_skin() {
    let mut maker = bar(WEIGHTS);
    let lift = maker.floats("VEC3", &[0.0, 0.5, 0.0].repeat(3));
    let turn = maker.floats("VEC3", &[-1.0, 0.0, 1.0].repeat(3));
    maker.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": lift, "NORMAL": turn }]);
    maker.json["meshes"][0]["weights"] = json!([1.0]);
    let (bent, pose) = posed(maker.read_cleanly().geometry, 1.0);
    assert_eq!(pose.morph_weights, [1.0]);
    // (0, 2.5, 0) turned by 90° about (0, 1, 0); after the skin it would be (−1, 1.5, 0).
    assert!(near(bent[2].0, [-1.5, 1.0, 0.0]), "{}", bent[2].0);
    assert!(near(bent[2].1, [0.0, 0.0, 1.0]), "{}", bent[2].1);
}

#[test]
fn morph_weights_are_animated_and_the_node_overrides_the_mesh() {
    let mut maker = Maker::triangle();
    let right = maker.floats("VEC3", &[1.0, 0.0, 0.0].repeat(3));
    let up = maker.floats("VEC3", &[0.0, 0.0, 2.0].repeat(3));
    maker.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": right }, { "POSITION": up }]);
    maker.json["meshes"][0]["weights"] = json!([0.5, 0.5]);
    let corner = |maker: &Maker, time| posed(maker.read_cleanly().geometry, time).0[0].0;
    assert!(near(corner(&maker, 0.0), [0.5, 0.0, 1.0]));
    maker.json["nodes"][0]["weights"] = json!([1.0, 0.0]);
    assert!(near(corner(&maker, 0.0), [1.0, 0.0, 0.0]));
    maker.animate("morph", 0, "weights", "LINEAR", &[0.0, 2.0], &[0.0, 1.0, 1.0, 0.0]);
    assert!(near(corner(&maker, 0.5), [0.25, 0.0, 1.5]));
}

/// Corners of a ball, and its triangles.
fn ball() -> (Vec<Vec3>, Vec<u16>) {
    const AROUND: u16 = 48;
    const DOWN: u16 = 32;
    let mut points = Vec::new();
    for j in 0..=DOWN {
        for i in 0..=AROUND {
            // The last column repeats the first, as a seam of texture coordinates does.
            let (a, b) = (f32::from(i % AROUND) / f32::from(AROUND), f32::from(j) / f32::from(DOWN));
            let ((s, c), (down, up)) = ((a * std::f32::consts::TAU).sin_cos(), (b * std::f32::consts::PI).sin_cos());
            points.push(Vec3::new(down * c, up, -down * s));
        }
    }
    let mut corners = Vec::new();
    for j in 0..DOWN {
        for i in 0..AROUND {
            let at = |i: u16, j: u16| j * (AROUND + 1) + i;
            corners.extend([at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    (points, corners)
}

#[test]
fn a_target_without_normals_is_lit_as_it_stands() {
    const STRETCH: Vec3 = Vec3::new(2.5, 1.0, 1.0);
    let (points, corners) = ball();
    let flat = |values: &mut dyn Iterator<Item = Vec3>| values.flat_map(|p| p.to_array()).collect::<Vec<f32>>();
    let mut maker = Maker::new();
    let position = maker.floats("VEC3", &flat(&mut points.iter().copied()));
    let bytes: Vec<u8> = corners.iter().flat_map(|c| c.to_le_bytes()).collect();
    let indices = maker.accessor(U16, "SCALAR", corners.len(), &bytes);
    let still = maker.floats("VEC3", &vec![0.0; 3 * points.len()]);
    let stretched = maker.floats("VEC3", &flat(&mut points.iter().map(|p| *p * (STRETCH - 1.0))));
    let targets = json!([{ "POSITION": still }, { "POSITION": stretched }]);
    let attributes = json!({ "POSITION": position, "NORMAL": position });
    maker.add_mesh(&json!({ "attributes": attributes, "indices": indices, "targets": targets }));
    let error_deg = |maker: &Maker, weights: [f32; 2]| {
        let mut maker = Maker { json: maker.json.clone(), bytes: maker.bytes.clone() };
        maker.json["meshes"][0]["weights"] = json!(weights);
        let (found, _) = posed(maker.read_cleanly().geometry, 0.0);
        let scale = Vec3::ONE + (STRETCH - 1.0) * weights[1];
        let error = |((_, n), p): (&(Vec3, Vec3), &Vec3)| n.angle_between((*p / scale).normalize()).to_degrees();
        found.iter().zip(&points).map(error).fold(0.0, f32::max)
    };
    assert!(error_deg(&maker, [0.0, 0.0]) < 0.1);
    assert!(error_deg(&maker, [1.0, 0.0]) < 0.1, "a target that moves nothing turns nothing");
    assert!(error_deg(&maker, [0.0, 1.0]) < 2.0, "{}", error_deg(&maker, [0.0, 1.0]));
    assert!(error_deg(&maker, [1.0, 0.5]) < 8.0, "half way is between: {}", error_deg(&maker, [1.0, 0.5]));
    maker.json["meshes"][0]["primitives"][0]["targets"][1]["NORMAL"] = json!(still);
    assert!(error_deg(&maker, [0.0, 1.0]) > 20.0, "what the file says of its normals holds");
}

#[test]
fn without_normals_each_triangle_has_its_own_at_every_pose() {
    let mut maker = Maker::new();
    let position = maker.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0]);
    let indices = maker.accessor(U8, "SCALAR", 6, &[0, 1, 2, 2, 1, 3]);
    let target = maker.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    let targets = json!([{ "POSITION": target }]);
    maker.add_mesh(&json!({ "attributes": { "POSITION": position }, "indices": indices, "targets": targets }));
    maker.animate("fold", 0, "weights", "LINEAR", &[0.0, 1.0, 2.0], &[0.0, 1.0, 0.0]);
    let geometry = maker.read_cleanly().geometry;
    assert!(geometry.parts[0].flat && geometry.vertices.len() == 6);
    let (flat, _) = posed(geometry.clone(), 0.0);
    assert!(flat.iter().all(|(_, n)| near(*n, [0.0, 0.0, 1.0])));
    let (folded, _) = posed(geometry, 1.0);
    let third = 1.0 / 3.0_f32.sqrt();
    assert!(near(folded[0].1, [0.0, 0.0, 1.0]) && near(folded[3].1, [-third, -third, third]), "{folded:?}");
}

#[test]
fn a_mirrored_mesh_keeps_its_normals_outward() {
    for (scale, up) in [([1.0, 1.0, 1.0], 1.0), ([-1.0, 1.0, 1.0], 1.0), ([-1.0, -2.0, -1.0], -1.0)] {
        for smooth in [true, false] {
            let mut maker = Maker::triangle();
            if smooth {
                let normal = maker.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
                maker.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normal);
            }
            maker.json["nodes"][0]["scale"] = json!(scale);
            let (posed, _) = posed(maker.read_cleanly().geometry, 0.0);
            assert!(posed.iter().all(|(_, normal)| near(*normal, [0.0, 0.0, up])), "{scale:?} {posed:?}");
        }
    }
}

#[test]
fn a_matrix_and_its_parts_place_a_node_alike_under_its_parents() {
    let build = |child: serde_json::Value| {
        let mut maker = Maker::new();
        let position = maker.floats("VEC3", &[0.1, 0.2, 0.3, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        let mesh = maker.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": position } }] }));
        // The child stands before its parent in the file.
        let child = maker.push("nodes", child);
        maker.json["nodes"][child]["mesh"] = json!(mesh);
        maker.add_root(json!({ "children": [child], "scale": [2.0, 2.0, 2.0], "translation": [0.0, 0.0, 5.0] }));
        posed(maker.read_cleanly().geometry, 0.0).0
    };
    let rotation = glam::Quat::from_array(QUARTER_ABOUT_Z);
    let matrix = Mat4::from_scale_rotation_translation(Vec3::new(1.0, 2.0, 3.0), rotation, Vec3::X);
    let by_parts =
        build(json!({ "scale": [1.0, 2.0, 3.0], "rotation": QUARTER_ABOUT_Z, "translation": [1.0, 0.0, 0.0] }));
    let by_matrix = build(json!({ "matrix": matrix.to_cols_array() }));
    assert!(near(by_parts[0].0, [2.0 * (1.0 - 0.4), 2.0 * 0.1, 5.0 + 2.0 * 0.9]), "{}", by_parts[0].0);
    for (a, b) in by_parts.iter().zip(by_matrix) {
        assert!((a.0 - b.0).length() < 1e-5 && (a.1 - b.1).length() < 1e-5);
    }
}

#[test]
fn what_an_animation_throws_out_of_range_collapses_and_stays_finite() {
    let mut maker = Maker::triangle();
    let child = maker.push("nodes", json!({ "mesh": 0, "scale": [1e30, 1e30, 1e30] }));
    maker.json["nodes"][0]["children"] = json!([child]);
    maker.json["nodes"][0].as_object_mut().unwrap().remove("mesh");
    maker.animate("burst", 0, "scale", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1e30, 1e30, 1e30]);
    let (_, pose) = posed(maker.read_cleanly().geometry, 0.9);
    assert!(pose.matrices.iter().all(Mat4::is_finite));
    assert!(pose.part_bounds.iter().all(|b| b.min.is_finite() && b.max.is_finite()));
}
