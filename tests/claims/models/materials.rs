//! Materials mean what glTF's extensions say.

use super::maker::Maker;
use glam::Vec3;
use murrine::scene::World;
use murrine::scene::description::{MaterialOverride, Model, Scene, Shape, Source};
use murrine::scene::material::Material;
use serde_json::{Value, json};
use std::io::Cursor;
use std::sync::Arc;

fn maker_of(material: &Value) -> Maker {
    let mut maker = Maker::triangle();
    maker.push("materials", material.clone());
    let normal = maker.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let primitive = &mut maker.json["meshes"][0]["primitives"][0];
    primitive["material"] = json!(0);
    primitive["attributes"]["NORMAL"] = json!(normal);
    maker
}

fn read(material: &Value) -> Material {
    maker_of(material).read_cleanly().geometry.parts[0].material.clone()
}

#[test]
fn absorption_and_index_come_from_the_volume() {
    let glass = read(&json!({
        "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 0.1, "baseColorFactor": [0.9, 0.8, 0.7, 1.0] },
        "extensions": {
            "KHR_materials_transmission": { "transmissionFactor": 1.0 },
            "KHR_materials_volume": { "thicknessFactor": 1.0, "attenuationColor": [1.0, 0.5, 0.0], "attenuationDistance": 2.0 },
            "KHR_materials_ior": { "ior": 1.33 },
            "KHR_materials_dispersion": { "dispersion": 0.3 },
        },
    }));
    assert!(!glass.opaque && !glass.thin_wall);
    let expected = Vec3::new(0.0, 0.5_f32.ln() / -2.0, 1e-4_f32.ln() / -2.0);
    assert!((glass.sigma - expected).length() < 1e-6, "{}", glass.sigma);
    assert_eq!((glass.ior, glass.dispersion, glass.roughness), (1.33, 0.3, 0.1));
    assert_eq!(glass.base_color, Vec3::new(0.9, 0.8, 0.7));
}

#[test]
fn what_transmits_nothing_is_opaque_and_what_has_no_thickness_is_a_film() {
    let transmission = |factor: f32, metallic: f32, volume: Value| {
        json!({
            "pbrMetallicRoughness": { "metallicFactor": metallic },
            "extensions": { "KHR_materials_transmission": { "transmissionFactor": factor }, "KHR_materials_volume": volume },
        })
    };
    let solid = json!({ "thicknessFactor": 0.5 });
    let flags = |m: Material| (m.opaque, m.thin_wall);
    assert_eq!(flags(read(&transmission(1.0, 0.0, solid.clone()))), (false, false));
    assert_eq!(flags(read(&transmission(1.0, 0.0, json!({})))), (false, true));
    assert_eq!(flags(read(&transmission(0.0, 0.0, solid.clone()))), (true, false));
    assert_eq!(flags(read(&transmission(1.0, 1.0, solid))), (true, false), "metal lets nothing in");
    assert_eq!(flags(read(&json!({}))), (true, false));
    let film =
        read(&json!({ "alphaMode": "BLEND", "pbrMetallicRoughness": { "baseColorFactor": [0.0, 0.5, 1.0, 0.25] } }));
    assert_eq!(flags(film.clone()), (false, true));
    assert!((film.base_color - Vec3::new(0.75, 0.875, 1.0)).length() < 1e-6);
}

#[test]
fn emission_is_scaled_by_its_strength_and_odd_numbers_are_tamed() {
    let lamp = read(&json!({
        "emissiveFactor": [1.0, 0.5, 0.0],
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 8.0 } },
    }));
    assert_eq!(lamp.emissive, Vec3::new(8.0, 4.0, 0.0));
    let odd = read(&json!({
        "pbrMetallicRoughness": { "baseColorFactor": [-1.0, 1e39, 2.0, 1.0], "roughnessFactor": 1e39, "metallicFactor": 0.0 },
        "emissiveFactor": [1e30, -1.0, 1e39],
        "extensions": {
            "KHR_materials_transmission": { "transmissionFactor": 1.0 },
            "KHR_materials_volume": { "thicknessFactor": 1.0, "attenuationColor": [-1.0, 9.0, 0.5], "attenuationDistance": -4.0 },
            "KHR_materials_ior": { "ior": 0.0 },
            "KHR_materials_dispersion": { "dispersion": 1e39 },
        },
    }));
    assert_eq!((odd.base_color, odd.roughness), (Vec3::new(0.0, 1.0, 1.0), 1.0));
    assert_eq!((odd.emissive, odd.sigma), (Vec3::new(65504.0, 0.0, 0.0), Vec3::ZERO));
    assert_eq!((odd.ior, odd.dispersion), (1.5, 0.0));
}

#[test]
fn what_is_not_shown_of_a_material_is_told_once() {
    let clear = |more: Value| {
        let mut extensions = json!({ "KHR_materials_volume": { "thicknessFactor": 1.0 } });
        extensions["KHR_materials_transmission"] = more;
        json!({ "pbrMetallicRoughness": { "metallicFactor": 0.0 }, "extensions": extensions })
    };
    let half = maker_of(&clear(json!({ "transmissionFactor": 0.5 }))).read();
    assert_eq!(half.warnings.len(), 1);
    assert!(half.warnings[0].what.contains("wholly clear"), "{}", half.warnings[0]);
    let whole = clear(json!({ "transmissionFactor": 1.0 }));
    maker_of(&whole).read_cleanly();
    let mut faceted = maker_of(&whole);
    faceted.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("NORMAL");
    assert!(faceted.read().warnings[0].what.contains("has facets"), "{:?}", faceted.read().warnings);
    let png = picture(image::ImageFormat::Png);
    let base = json!({ "baseColorTexture": { "index": 0 } });
    let blended = textured(&png, &json!({ "pbrMetallicRoughness": base, "alphaMode": "BLEND" })).read();
    assert!(blended.warnings[0].what.contains("shown opaque"), "{:?}", blended.warnings);
    let elsewhere = json!({ "index": 0, "texCoord": 1 });
    let lamp = json!({ "pbrMetallicRoughness": base, "emissiveFactor": [1, 1, 1], "emissiveTexture": elsewhere });
    let lamp = textured(&png, &lamp).read();
    assert!(lamp.warnings[0].what.contains("different texture coordinates"), "{:?}", lamp.warnings);
    assert_eq!(lamp.geometry.parts[0].material.emissive_texture, None);
}

#[test]
fn a_variant_changes_the_material_that_it_names() {
    let mut maker = maker_of(&json!({ "name": "plain" }));
    maker.push("materials", json!({ "emissiveFactor": [1.0, 0.0, 0.0] }));
    maker.json["extensions"] =
        json!({ "KHR_materials_variants": { "variants": [{ "name": "day" }, { "name": "night" }] } });
    maker.json["extensionsRequired"] = json!(["KHR_materials_variants"]);
    let mappings = json!([{ "material": 1, "variants": [1] }]);
    maker.json["meshes"][0]["primitives"][0]["extensions"] =
        json!({ "KHR_materials_variants": { "mappings": mappings } });
    let geometry = Arc::new(maker.read_cleanly().geometry);
    assert_eq!(geometry.variants, ["day", "night"]);
    for (variant, red) in [(None, 0.0), (Some("day"), 0.0), (Some("night"), 1.0)] {
        let model = Model { variant: variant.map(str::to_owned), ..Model::default() };
        let scene = Scene { models: vec![model], ..Scene::default() };
        let world = World::from_geometry(&scene, vec![Arc::clone(&geometry)]);
        assert_eq!(world.materials(&scene)[0].emissive.x, red, "{variant:?}");
    }
}

/// A picture of 2×1 texels, red and half-clear blue.
fn picture(format: image::ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let picture = image::RgbaImage::from_raw(2, 1, vec![255, 0, 0, 255, 0, 0, 255, 100]).unwrap();
    image::DynamicImage::from(picture).write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn textured(bytes: &[u8], material: &Value) -> Maker {
    let mut maker = maker_of(material);
    let view = maker.view(bytes);
    maker.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
    maker.push("textures", json!({ "source": 0 }));
    let uv = maker.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    maker.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uv);
    maker
}

#[test]
fn pictures_of_opaque_parts_are_decoded_and_masks_are_holes() {
    let png = picture(image::ImageFormat::Png);
    let base = json!({ "baseColorTexture": { "index": 0 } });
    let plain = textured(&png, &json!({ "pbrMetallicRoughness": base })).read_cleanly().geometry;
    assert_eq!(plain.parts[0].material.base_color_texture, Some(0));
    assert_eq!((plain.textures[0].width, plain.textures[0].height), (2, 1));
    assert_eq!(plain.textures[0].rgba8, [255, 0, 0, 255, 0, 0, 255, 255]);
    let masked = textured(&png, &json!({ "pbrMetallicRoughness": base, "alphaMode": "MASK" })).read_cleanly().geometry;
    assert_eq!(masked.textures[0].rgba8, [255, 0, 0, 255, 0, 0, 255, 0]);
    let broken = textured(&png[..40], &json!({ "pbrMetallicRoughness": base })).read();
    assert_eq!(broken.geometry.parts[0].material.base_color_texture, None);
    assert!(broken.warnings[0].what.contains("the part is plain"), "{:?}", broken.warnings);
}

#[test]
fn texture_transforms_turn_the_coordinates() {
    // A quarter about the origin, then moved: KHR_texture_transform's own example of a 90° turn.
    let transform = json!({ "offset": [0.0, 1.0], "rotation": std::f32::consts::FRAC_PI_2, "scale": [0.5, 0.5] });
    let info = json!({ "index": 0, "extensions": { "KHR_texture_transform": transform } });
    let png = picture(image::ImageFormat::Png);
    let model =
        textured(&png, &json!({ "pbrMetallicRoughness": { "baseColorTexture": info } })).read_cleanly().geometry;
    let uv: Vec<[f32; 2]> = model.vertices.iter().map(|v| [v.u, v.v]).collect();
    for (found, expected) in uv.iter().zip([[0.0, 1.0], [0.0, 0.5], [0.5, 1.0]]) {
        assert!((found[0] - expected[0]).abs() + (found[1] - expected[1]).abs() < 1e-6, "{uv:?}");
    }
}

#[test]
fn overrides_apply_in_order_to_the_parts_they_name() {
    let shape = Source::Shape(Shape::Icosphere { radius: 1.0, subdivisions: 1 });
    let with = |materials: Vec<MaterialOverride>| {
        let model = Model { name: "m".into(), source: shape.clone(), materials, ..Model::default() };
        let scene = Scene { models: vec![model], ..Scene::default() };
        World::load(&scene, None).map(|w| w.materials(&scene).remove(0)).map_err(|e| e.to_string())
    };
    let change = |part: &str| MaterialOverride { part: part.into(), ..MaterialOverride::default() };
    let first = MaterialOverride { ior: Some(1.2), priority: Some(3), ..change("*") };
    let second = MaterialOverride { ior: Some(1.7), ..change("ico*") };
    let found = with(vec![first, second]).unwrap();
    assert_eq!((found.ior, found.priority), (1.7, 3));
    let color = MaterialOverride {
        attenuation_color: Some(Vec3::splat(0.5)),
        attenuation_distance: Some(2.0),
        ..change("icosphere")
    };
    assert!((with(vec![color.clone()]).unwrap().sigma.x - 0.346_573_6).abs() < 1e-6);
    let raw = MaterialOverride { sigma: Some(Vec3::X), ..color };
    assert_eq!(with(vec![raw]).unwrap().sigma, Vec3::X, "sigma wins");
    let error = with(vec![change("cube")]).unwrap_err();
    assert_eq!(error, "model `m`: no part `cube`; choose *, icosphere");
}

#[test]
fn an_opaque_part_made_clear_loses_its_paint() {
    let painted = Material {
        opaque: true,
        base_color: Vec3::new(0.1, 0.2, 0.3),
        roughness: 0.9,
        base_color_texture: Some(0),
        ..Material::default()
    };
    let clear = MaterialOverride { opaque: Some(false), ior: Some(1.4), ..MaterialOverride::default() };
    let glass = painted.clone().overridden("any", &[clear]);
    assert_eq!(glass, Material { ior: 1.4, ..Material::default() });
    let other = MaterialOverride { part: "else".into(), opaque: Some(false), ..MaterialOverride::default() };
    assert_eq!(painted.clone().overridden("any", &[other]), painted);
}
