//! Pictures lie on opaque parts as glTF's samplers, coordinates and colours say: each pixel of a quad that fills the
//! picture is the texel worked out here.

use super::maker::{Maker, U8};
use crate::support::{render_with, scene_of};
use glam::{UVec2, Vec2, Vec3};
use murrine::frame::Frame;
use murrine::march::Channel;
use murrine::scene::World;
use murrine::scene::description::{Camera, Model};
use serde_json::{Value, json};
use std::io::Cursor;
use std::sync::Arc;

const SIZE: UVec2 = UVec2::splat(48);
/// Texels along a side.
const SIDE: i32 = 4;
const REPEAT: u32 = 10497;
const MIRROR: u32 = 33648;
const CLAMP: u32 = 33071;
const NEAREST: u32 = 9728;
const LINEAR: u32 = 9729;

/// Four corners of a square of side 2, seen whole by [`picture_of`], two triangles.
fn quad(material: &Value, attributes: &[(&str, &str, Vec<f32>)]) -> Maker {
    let mut maker = Maker::new();
    maker.push("materials", material.clone());
    let corners = [-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 1.0, 0.0];
    let mut all = json!({ "POSITION": maker.floats("VEC3", &corners) });
    for (name, kind, values) in attributes {
        all[*name] = json!(maker.floats(kind, values));
    }
    let indices = maker.accessor(U8, "SCALAR", 6, &[0, 1, 2, 0, 2, 3]);
    maker.add_mesh(&json!({ "attributes": all, "indices": indices, "material": 0 }));
    maker
}

/// The texture coordinates of the corners: uv runs from −1 to 2, v downwards.
fn wide() -> Vec<f32> {
    vec![-1.0, 2.0, 2.0, 2.0, 2.0, -1.0, -1.0, -1.0]
}

/// Code of a component of a texel.
fn code(x: i32, y: i32, c: i32) -> u8 {
    u8::try_from((x * 60 + y * 37 + c * 90 + x * y * 11) % 250).unwrap()
}

fn linear(code: u8) -> f32 {
    let x = f32::from(code) / 255.0;
    if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

fn add_picture(maker: &mut Maker, sampler: &Value) {
    let texels: Vec<u8> = (0..SIDE * SIDE)
        .flat_map(|i| [code(i % SIDE, i / SIDE, 0), code(i % SIDE, i / SIDE, 1), code(i % SIDE, i / SIDE, 2), 255])
        .collect();
    let side = u32::try_from(SIDE).unwrap();
    let mut bytes = Cursor::new(Vec::new());
    let picture = image::RgbaImage::from_raw(side, side, texels).unwrap();
    image::DynamicImage::from(picture).write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    let view = maker.view(&bytes.into_inner());
    maker.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
    maker.json["samplers"] = json!([sampler]);
    maker.push("textures", json!({ "source": 0, "sampler": 0 }));
}

/// Radiance of each pixel of the square seen from straight above it.
fn picture_of(maker: &Maker) -> Vec<Vec3> {
    let geometry = Arc::new(maker.read_cleanly().geometry);
    let camera = Camera { eye: Vec3::new(0.0, 0.0, 2.0), target: Vec3::ZERO, fov_deg: 53.130_1, ..Camera::default() };
    let scene = murrine::scene::Scene { camera, ..scene_of(vec![Model::default()]) };
    let world = World::from_geometry(&scene, vec![geometry]);
    let mut frame = Frame::new(crate::gpu()).unwrap();
    let rendered = render_with(&mut frame, &scene, &world, SIZE, Channel::Beauty);
    rendered.radiance.iter().map(|&[r, g, b, _]| Vec3::new(r, g, b)).collect()
}

/// Where in the square a pixel lies: 0 to 1 from the left and from the top.
fn places() -> impl Iterator<Item = Vec2> {
    (0..SIZE.x * SIZE.y).map(|i| (UVec2::new(i % SIZE.x, i / SIZE.x).as_vec2() + 0.5) / SIZE.as_vec2())
}

/// The texel that lies `n` from the picture's edge along one axis.
fn wrapped(n: i32, wrap: u32) -> i32 {
    match wrap {
        REPEAT => n.rem_euclid(SIDE),
        MIRROR => {
            let m = n.rem_euclid(2 * SIDE);
            if m < SIDE { m } else { 2 * SIDE - 1 - m }
        }
        _ => n.clamp(0, SIDE - 1),
    }
}

/// What a sampler makes of a coordinate, by the book.
fn sampled(uv: Vec2, wraps: [u32; 2], filter: u32) -> Vec3 {
    let texel = |x: i32, y: i32| {
        let (x, y) = (wrapped(x, wraps[0]), wrapped(y, wraps[1]));
        Vec3::new(linear(code(x, y, 0)), linear(code(x, y, 1)), linear(code(x, y, 2)))
    };
    let at = uv * SIDE as f32;
    #[expect(clippy::cast_possible_truncation, reason = "small numbers")]
    let whole = |x: f32| x.floor() as i32;
    if filter == NEAREST {
        return texel(whole(at.x), whole(at.y));
    }
    let (x, y) = (whole(at.x - 0.5), whole(at.y - 0.5));
    let f = (at - 0.5) - (at - 0.5).floor();
    let row = |y: i32| texel(x, y).lerp(texel(x + 1, y), f.x);
    row(y).lerp(row(y + 1), f.y)
}

/// The largest difference of any component.
fn furthest(found: &[Vec3], expected: impl Iterator<Item = Vec3>) -> f32 {
    found.iter().zip(expected).map(|(f, e)| (*f - e).abs().max_element()).fold(0.0, f32::max)
}

fn unlit(color: &Value) -> Value {
    json!({ "pbrMetallicRoughness": color, "extensions": { "KHR_materials_unlit": {} } })
}

#[test]
fn pictures_go_on_beyond_their_edges_and_between_texels_as_their_sampler_says() {
    let cases = [
        ([REPEAT, REPEAT], LINEAR),
        ([MIRROR, CLAMP], LINEAR),
        ([CLAMP, MIRROR], NEAREST),
        ([REPEAT, MIRROR], NEAREST),
    ];
    let expected = |(wraps, filter): ([u32; 2], u32)| places().map(move |p| sampled(p * 3.0 - 1.0, wraps, filter));
    for case in cases {
        let mut maker = quad(&unlit(&json!({ "baseColorTexture": { "index": 0 } })), &[("TEXCOORD_0", "VEC2", wide())]);
        let ([s, t], filter) = case;
        add_picture(&mut maker, &json!({ "wrapS": s, "wrapT": t, "magFilter": filter, "minFilter": 9987 }));
        let found = picture_of(&maker);
        let error = furthest(&found, expected(case));
        assert!(error < 0.01, "{case:?}: {error}");
        for other in cases.into_iter().filter(|other| *other != case) {
            assert!(furthest(&found, expected(other)) > 0.1, "{case:?} looks like {other:?}");
        }
    }
}

#[test]
fn the_second_coordinates_turned_and_scaled_place_the_picture() {
    let (offset, rotation, scale) = (Vec2::new(0.2, -0.3), 0.6_f32, Vec2::new(0.5, 0.75));
    let transform = json!({
        "offset": offset.to_array(), "rotation": rotation, "scale": scale.to_array(), "texCoord": 1,
    });
    let info = json!({ "index": 0, "extensions": { "KHR_texture_transform": transform } });
    let nowhere = vec![0.1; 8];
    let attributes = [("TEXCOORD_0", "VEC2", nowhere), ("TEXCOORD_1", "VEC2", wide())];
    let mut maker = quad(&unlit(&json!({ "baseColorTexture": info })), &attributes);
    add_picture(&mut maker, &json!({ "wrapS": MIRROR, "wrapT": MIRROR }));
    let found = picture_of(&maker);
    // The extension's own matrices: offset · rotation · scale.
    let placed = |p: Vec2, angle: f32| {
        let uv = (p * 3.0 - 1.0) * scale;
        let (s, c) = angle.sin_cos();
        sampled(Vec2::new(c * uv.x + s * uv.y, -s * uv.x + c * uv.y) + offset, [MIRROR; 2], LINEAR)
    };
    assert!(furthest(&found, places().map(|p| placed(p, rotation))) < 0.01);
    assert!(furthest(&found, places().map(|p| placed(p, -rotation))) > 0.1, "the turn's direction matters");
}

#[test]
fn vertex_colours_blend_over_a_part_without_pictures() {
    let colors: [Vec3; 4] = [Vec3::X, Vec3::new(0.1, 0.7, 0.33), Vec3::new(0.0, 0.25, 1.0), Vec3::splat(0.5)];
    let flat: Vec<f32> = colors.iter().flat_map(|c| c.extend(0.3).to_array()).collect();
    let factor = Vec3::new(1.0, 0.5, 0.25);
    let material = unlit(&json!({ "baseColorFactor": [factor.x, factor.y, factor.z, 1.0] }));
    let expected = |factor: Vec3| {
        places().map(move |p| {
            let (x, y) = (p.x, 1.0 - p.y);
            let [a, b, c, d] = colors;
            // The square's two triangles meet on the diagonal from the first corner to the third.
            let color = if x > y { a * (1.0 - x) + b * (x - y) + c * y } else { a * (1.0 - y) + c * x + d * (y - x) };
            color * factor
        })
    };
    let found = picture_of(&quad(&material, &[("COLOR_0", "VEC4", flat)]));
    assert!(furthest(&found, expected(factor)) < 2e-3);
    assert!(furthest(&found, expected(Vec3::ONE)) > 0.1);
    let plain = picture_of(&quad(&material, &[]));
    assert!(furthest(&plain, places().map(|_| factor)) < 1e-5, "an unlit part without colours is its factor");
    assert!(furthest(&plain, expected(factor)) > 0.1);
}

#[test]
fn emission_is_factor_times_strength_times_picture() {
    let material = |strength: f32| {
        json!({
            "pbrMetallicRoughness": { "baseColorFactor": [0.0, 0.0, 0.0, 1.0] },
            "emissiveFactor": [1.0, 0.5, 0.25],
            "emissiveTexture": { "index": 0 },
            "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": strength } },
        })
    };
    let expected = |strength: f32| {
        places().map(move |p| sampled(p * 3.0 - 1.0, [CLAMP; 2], NEAREST) * Vec3::new(1.0, 0.5, 0.25) * strength)
    };
    let mut maker = quad(&material(3.0), &[("TEXCOORD_0", "VEC2", wide())]);
    add_picture(&mut maker, &json!({ "wrapS": CLAMP, "wrapT": CLAMP, "magFilter": NEAREST }));
    let found = picture_of(&maker);
    assert!(furthest(&found, expected(3.0)) < 0.02);
    assert!(furthest(&found, expected(1.0)) > 0.1);
}

/// A square whose picture of 64 texels has a round hole in its middle, a third of its side wide.
fn holed(alpha_mode: &str, morphs: bool) -> Maker {
    let material = json!({
        "alphaMode": alpha_mode,
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } },
        "extensions": { "KHR_materials_unlit": {} },
    });
    let uv = vec![0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
    let mut maker = quad(&material, &[("TEXCOORD_0", "VEC2", uv)]);
    let hole = |x: u32, y: u32| (Vec2::new(x as f32, y as f32) + 0.5).distance(Vec2::splat(32.0)) < 64.0 / 6.0;
    let texel = |x, y| image::Rgba([255, 255, 255, if hole(x, y) { 0 } else { 255 }]);
    let mut png = Cursor::new(Vec::new());
    image::DynamicImage::from(image::RgbaImage::from_fn(64, 64, texel))
        .write_to(&mut png, image::ImageFormat::Png)
        .unwrap();
    let view = maker.view(&png.into_inner());
    maker.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
    maker.push("textures", json!({ "source": 0 }));
    if morphs {
        let lean = maker.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        maker.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": lean }]);
        maker.json["meshes"][0]["weights"] = json!([1.0]);
    }
    maker
}

fn area(geometry: &murrine::scene::geometry::Geometry) -> f32 {
    let doubled = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| geometry.vertices[v as usize].position);
        (b - a).cross(c - a).length()
    };
    geometry.triangles.iter().map(doubled).sum::<f32>() / 2.0
}

#[test]
fn the_holes_of_a_mask_are_cut_out_of_the_mesh() {
    let hole = std::f32::consts::PI / 9.0;
    let cut = holed("MASK", false).read_cleanly().geometry;
    assert!((area(&cut) - (4.0 - hole)).abs() < 0.05 * hole, "{} is left", area(&cut));
    assert!(cut.triangles.len() < 1000, "{} triangles", cut.triangles.len());
    let whole = holed("OPAQUE", false).read_cleanly().geometry;
    assert_eq!((area(&whole), whole.triangles.len()), (4.0, 2), "only a mask has holes");
    let seen = picture_of(&holed("MASK", false));
    for (p, color) in places().zip(&seen) {
        let off = (p - 0.5).length() - 1.0 / 6.0;
        let expected = if off < 0.0 { Vec3::ZERO } else { Vec3::ONE };
        assert!(off.abs() < 0.02 || (*color - expected).length() < 1e-3, "{color} at {p}");
    }
}

#[test]
fn what_is_cut_moves_with_what_is_left() {
    let leaning = holed("MASK", true).read_cleanly().geometry;
    let (posed, _) = super::rigs::posed(leaning, 0.0);
    assert!(posed.len() > 100);
    for (p, _) in posed {
        assert!((p.z - (p.x + 1.0) / 2.0).abs() < 1e-5, "{p} left the plane");
    }
}

#[test]
fn a_picture_seen_small_is_its_mean() {
    let mut maker = quad(
        &unlit(&json!({ "baseColorTexture": { "index": 0 } })),
        &[("TEXCOORD_0", "VEC2", wide().into_iter().map(|x| x * 400.0).collect())],
    );
    add_picture(&mut maker, &json!({}));
    let texels =
        (0..SIDE * SIDE).map(|i| sampled(Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) / 4.0, [CLAMP; 2], NEAREST));
    let mean = texels.sum::<Vec3>() / (SIDE * SIDE) as f32;
    let found = picture_of(&maker);
    assert!(furthest(&found, places().map(|_| mean)) < 0.01, "{} instead of {mean}", found[0]);
    maker = quad(&unlit(&json!({ "baseColorTexture": { "index": 0 } })), &[("TEXCOORD_0", "VEC2", wide())]);
    add_picture(&mut maker, &json!({}));
    assert!(furthest(&picture_of(&maker), places().map(|_| mean)) > 0.1, "seen large it is itself");
}
