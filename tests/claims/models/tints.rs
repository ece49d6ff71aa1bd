//! What passes a clear surface takes its base colour: once through a solid, from each of its sides
//! through a thin wall, and the light on the ground as the ray to the eye.

use super::maker::{Maker, U8};
use crate::support::{render_with, scene_of};
use glam::{DVec3, UVec2, Vec3};
use murrine::frame::Frame;
use murrine::march::Channel;
use murrine::scene::description::{Camera, Light, LightKind, Model, Shape, Source};
use murrine::scene::{Scene, World, shapes};
use serde_json::{Value, json};
use std::sync::Arc;

const TINT: Vec3 = Vec3::new(0.9, 0.5, 0.2);
const SIZE: UVec2 = UVec2::splat(32);

/// A level sheet of side 2 at height 1 that faces up or down; or a cube from 0.5 to 1.5.
fn body(material: &Value, sheet: Option<f32>) -> Maker {
    let mut maker = Maker::new();
    maker.push("materials", material.clone());
    let corner = |i: u8| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { -1.0_f32 } else { 1.0 });
    let corners: Vec<f32> = match sheet {
        Some(_) => vec![-1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0, 1.0, 1.0, -1.0, 1.0, 1.0],
        None => (0..8).map(corner).flat_map(|[x, y, z]| [x, 1.0 + 0.5 * y, z]).collect(),
    };
    let indices: Vec<u8> = match sheet {
        Some(up) if up > 0.0 => vec![0, 2, 1, 0, 3, 2],
        Some(_) => vec![0, 1, 2, 0, 2, 3],
        None => [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
            .iter()
            .flat_map(|&[a, b, c, d]| [a, b, c, a, c, d])
            .collect(),
    };
    let position = maker.floats("VEC3", &corners);
    let indices = maker.accessor(U8, "SCALAR", indices.len(), &indices);
    maker.add_mesh(&json!({ "attributes": { "POSITION": position }, "indices": indices, "material": 0 }));
    maker
}

/// What is left of the ray to the eye and of the light on the ground, straight through the body's middle.
fn passed(maker: &Maker) -> [DVec3; 2] {
    let plane = Model { name: "floor".into(), source: Source::Shape(Shape::Plane { size: 8.0 }), ..Model::default() };
    let kind = LightKind::Directional { direction: Vec3::NEG_Y };
    let light = Light { kind, color: Vec3::ONE, intensity: 1.0, ..Light::default() };
    let camera = Camera { eye: Vec3::new(0.0, 5.0, 0.0), target: Vec3::ZERO, up: Vec3::NEG_Z, ..Camera::default() };
    let scene = Scene { camera, lights: vec![light], ..scene_of(vec![Model::default(), plane]) };
    let floor = Arc::new(shapes::shape(&Shape::Plane { size: 8.0 }));
    let world = World::from_geometry(&scene, vec![Arc::new(maker.read().geometry), floor]);
    let mut frame = Frame::new(crate::gpu()).unwrap();
    [Channel::Transmittance, Channel::GroundLight]
        .map(|channel| render_with(&mut frame, &scene, &world, SIZE, channel).channel_at(SIZE.x / 2, SIZE.y / 2 - 2))
}

fn material(thickness: f32) -> Value {
    json!({
        "pbrMetallicRoughness": { "metallicFactor": 0.0, "baseColorFactor": [TINT.x, TINT.y, TINT.z, 1.0] },
        "extensions": {
            "KHR_materials_transmission": { "transmissionFactor": 1.0 },
            "KHR_materials_volume": { "thicknessFactor": thickness },
        },
    })
}

fn assert_tinted(maker: &Maker, tint: DVec3, what: &str) {
    for (found, which) in passed(maker).into_iter().zip(["to the eye", "on the ground"]) {
        assert!((found - tint).abs().max_element() < 0.01, "{what}, {which}: {found}, not {tint}");
    }
}

#[test]
fn a_thin_wall_tints_from_the_sides_that_it_has() {
    let tint = TINT.as_dvec3();
    let one_sided = material(0.0);
    let mut two_sided = one_sided.clone();
    two_sided["doubleSided"] = json!(true);
    assert_tinted(&body(&one_sided, Some(1.0)), tint, "a sheet that faces the eye");
    assert_tinted(&body(&one_sided, Some(-1.0)), DVec3::ONE, "a sheet that faces away");
    assert_tinted(&body(&one_sided, None), tint, "a hollow box of thin walls");
    assert_tinted(&body(&two_sided, Some(1.0)), tint, "a sheet of two sides");
    assert_tinted(&body(&two_sided, Some(-1.0)), tint, "the same from behind");
    assert_tinted(&body(&two_sided, None), tint * tint, "a hollow box of thin walls of two sides");
}

#[test]
fn a_solid_tints_once_where_light_enters() {
    assert_tinted(&body(&material(1.0), None), TINT.as_dvec3(), "a solid box");
}

#[test]
fn a_film_of_a_picture_tints_by_its_mean() {
    let mut film = material(0.0);
    film["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0 });
    let mut maker = body(&film, Some(1.0));
    let uv = maker.floats("VEC2", &[0.0; 8]);
    maker.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uv);
    // Half black, half white: half of the light, not half of the code.
    let mut png = std::io::Cursor::new(Vec::new());
    let picture = image::GrayImage::from_raw(2, 1, vec![0, 255]).unwrap();
    image::DynamicImage::from(picture).write_to(&mut png, image::ImageFormat::Png).unwrap();
    let view = maker.view(&png.into_inner());
    maker.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
    maker.push("textures", json!({ "source": 0 }));
    assert_tinted(&maker, TINT.as_dvec3() * 0.5, "a film of a picture");
}
