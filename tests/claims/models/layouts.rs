//! However a file stores its numbers, the same mesh comes out.

use super::maker::{I8, I16, Maker, U8, U16, U32};
use glam::Vec3;
use murrine::scene::geometry::Geometry;
use murrine::scene::gltf;
use serde_json::{Value, json};
use std::path::Path;

const CORNERS: [[f32; 3]; 5] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.5], [-1.0, -0.5, 0.25]];

fn little(values: &[i32], bytes: usize) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()[..bytes].to_vec()).collect()
}

/// A mesh of [`CORNERS`] whose primitive is completed by the caller.
fn mesh(complete: impl FnOnce(&mut Maker, &mut Value)) -> Geometry {
    let mut maker = Maker::new();
    let position = maker.floats("VEC3", &CORNERS.concat());
    let normal = maker.floats("VEC3", &[0.0, 0.0, 1.0].repeat(5));
    let mut primitive = json!({ "attributes": { "POSITION": position, "NORMAL": normal } });
    complete(&mut maker, &mut primitive);
    maker.add_mesh(&primitive);
    maker.read_cleanly().geometry
}

fn indexed(component: u32, bytes: usize, indices: &[i32]) -> Geometry {
    mesh(|maker, primitive| {
        let accessor = maker.accessor(component, "SCALAR", indices.len(), &little(indices, bytes));
        primitive["indices"] = json!(accessor);
    })
}

#[test]
fn indices_of_every_width_are_the_same_triangles() {
    let expected = vec![[0, 1, 2], [2, 1, 3], [4, 0, 2]];
    for (component, bytes) in [(U8, 1), (U16, 2), (U32, 4)] {
        assert_eq!(indexed(component, bytes, &[0, 1, 2, 2, 1, 3, 4, 0, 2]).triangles, expected);
    }
    assert_ne!(indexed(U8, 1, &[0, 1, 2, 2, 1, 3, 4, 0, 3]).triangles, expected);
    assert_eq!(mesh(|_, _| {}).triangles, [[0, 1, 2]], "without indices: corner after corner, the rest no triangle");
}

#[test]
fn strips_and_fans_wind_like_lists() {
    let with_mode = |mode: u32, indices: &[u8]| {
        mesh(|maker, primitive| {
            primitive["mode"] = json!(mode);
            primitive["indices"] = json!(maker.accessor(U8, "SCALAR", indices.len(), indices));
        })
        .triangles
    };
    assert_eq!(with_mode(5, &[0, 1, 2, 3, 4]), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
    assert_eq!(with_mode(5, &[0, 1, 2, 2, 3, 4]), [[0, 1, 2], [2, 4, 3]], "stitches vanish, the turn goes on");
    assert_eq!(with_mode(6, &[0, 1, 2, 3, 4]), [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
}

#[test]
fn quantized_positions_and_normals_equal_floats() {
    let whole = [[0, 0, 0], [100, 0, 0], [0, 100, 0], [100, 100, 50], [-100, -50, 25]].concat();
    for (component, bytes, normalized, unit) in
        [(I8, 1, false, 1.0), (I16, 2, false, 1.0), (I8, 1, true, 127.0), (I16, 2, true, 32767.0)]
    {
        let geometry = mesh(|maker, primitive| {
            maker.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
            // Elements padded to four bytes, as the extension asks.
            let stride = (3_usize * bytes).next_multiple_of(4);
            let packed: Vec<u8> = whole
                .chunks(3)
                .flat_map(|p| {
                    let mut element = little(p, bytes);
                    element.resize(stride, 0xEE);
                    element
                })
                .collect();
            let position = maker.accessor(component, "VEC3", 5, &packed);
            maker.json["accessors"][position]["normalized"] = json!(normalized);
            maker.last_view()["byteStride"] = json!(stride);
            primitive["attributes"]["POSITION"] = json!(position);
            let normals = little(&[0, 0, 127].repeat(5), 1);
            let normal = maker.accessor(I8, "VEC3", 5, &normals);
            maker.json["accessors"][normal]["normalized"] = json!(true);
            primitive["attributes"]["NORMAL"] = json!(normal);
        });
        for (vertex, corner) in geometry.vertices.iter().zip(CORNERS) {
            let expected = Vec3::from_array(corner) * 100.0 / unit;
            assert!((vertex.position - expected).length() < 1e-5, "{} {expected}", vertex.position);
            assert_eq!(vertex.normal, Vec3::Z);
        }
    }
}

#[test]
fn the_least_normalized_integer_is_minus_one() {
    let geometry = mesh(|maker, primitive| {
        let position = maker.accessor(I8, "VEC3", 5, &little(&[-128, 127, 0, 0, 0, 0, 5, 5, 5, 5, 5, 5, 5, 5, 5], 1));
        maker.json["accessors"][position]["normalized"] = json!(true);
        primitive["attributes"]["POSITION"] = json!(position);
    });
    assert_eq!(geometry.vertices[0].position, Vec3::new(-1.0, 1.0, 0.0));
}

#[test]
fn sparse_accessors_equal_dense_ones() {
    let dense = mesh(|maker, primitive| {
        let mut corners = CORNERS;
        corners[1] = [7.0, 8.0, 9.0];
        corners[4] = [1.0, 2.0, 3.0];
        primitive["attributes"]["POSITION"] = json!(maker.floats("VEC3", &corners.concat()));
    });
    let sparse = mesh(|maker, primitive| {
        let places = maker.view(&little(&[1, 4], 2));
        let values: Vec<u8> = [7.0_f32, 8.0, 9.0, 1.0, 2.0, 3.0].iter().flat_map(|v| v.to_le_bytes()).collect();
        let values = maker.view(&values);
        let position = usize::try_from(primitive["attributes"]["POSITION"].as_u64().unwrap()).unwrap();
        let indices = json!({ "bufferView": places, "componentType": U16 });
        maker.json["accessors"][position]["sparse"] =
            json!({ "count": 2, "indices": indices, "values": { "bufferView": values } });
    });
    assert_eq!(dense.vertices, sparse.vertices);
    assert_ne!(dense.vertices, mesh(|_, _| {}).vertices);
    let from_zeros = mesh(|maker, primitive| {
        let places = maker.view(&[1, 2]);
        let values: Vec<u8> = [1.0_f32, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|v| v.to_le_bytes()).collect();
        let values = maker.view(&values);
        let sparse = json!({ "count": 2, "indices": { "bufferView": places, "componentType": U8 }, "values": { "bufferView": values } });
        let position = json!({ "componentType": 5126, "type": "VEC3", "count": 5, "sparse": sparse });
        primitive["attributes"]["POSITION"] = json!(maker.push("accessors", position));
    });
    let positions: Vec<_> = from_zeros.vertices.iter().map(|v| v.position).collect();
    assert_eq!(positions, [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ZERO, Vec3::ZERO]);
}

#[test]
fn interleaved_attributes_are_told_apart() {
    let geometry = mesh(|maker, primitive| {
        let packed: Vec<u8> =
            CORNERS.iter().flat_map(|c| [*c, [0.0, 1.0, 0.0]].concat()).flat_map(f32::to_le_bytes).collect();
        let position = maker.accessor(5126, "VEC3", 5, &packed);
        maker.last_view()["byteStride"] = json!(24);
        let view = maker.json["accessors"][position]["bufferView"].clone();
        let normal = json!({ "bufferView": view, "byteOffset": 12, "componentType": 5126, "type": "VEC3", "count": 5 });
        let normal = maker.push("accessors", normal);
        primitive["attributes"] = json!({ "POSITION": position, "NORMAL": normal });
    });
    for (vertex, corner) in geometry.vertices.iter().zip(CORNERS) {
        assert_eq!((vertex.position.to_array(), vertex.normal), (corner, Vec3::Y));
    }
}

#[test]
fn data_uris_and_files_beside_the_model_hold_the_same_bytes() {
    let maker = Maker::triangle();
    let inside = maker.read_cleanly().geometry;
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    std::fs::write(folder.path().join("sub/a b.bin"), &maker.bytes).unwrap();
    for uri in ["sub/a%20b.bin".to_owned(), format!("data:application/octet-stream;base64,{}", base64(&maker.bytes))] {
        let mut json = maker.json.clone();
        json["buffers"][0] = json!({ "byteLength": maker.bytes.len(), "uri": uri });
        let path = folder.path().join("model.gltf");
        std::fs::write(&path, json.to_string()).unwrap();
        let loaded = gltf::read(&path).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(loaded.geometry.vertices, inside.vertices);
        assert_eq!(loaded.files.len(), usize::from(!uri.starts_with("data:")));
    }
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for chunk in bytes.chunks(3) {
        let bits = chunk.iter().fold(0_u32, |bits, b| bits << 8 | u32::from(*b)) << (8 * (3 - chunk.len()));
        for digit in 0..=chunk.len() {
            text.push(DIGITS[(bits >> (18 - 6 * digit) & 63) as usize] as char);
        }
        text.push_str(&"=".repeat(3 - chunk.len()));
    }
    text
}

#[test]
fn files_outside_the_models_folder_are_not_opened() {
    let home = tempfile::tempdir().unwrap();
    let folder = home.path().join("model");
    std::fs::create_dir(&folder).unwrap();
    let maker = Maker::triangle();
    let secret = home.path().join("secret.bin");
    std::fs::write(&secret, &maker.bytes).unwrap();
    let mut uris = vec![
        "../secret.bin".to_owned(),
        "%2e%2e/secret.bin".to_owned(),
        "sub/../../secret.bin".to_owned(),
        secret.display().to_string(),
        format!("file://{}", secret.display()),
        "http://example.com/secret.bin".to_owned(),
        String::new(),
        ".".to_owned(),
    ];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&secret, folder.join("link.bin")).unwrap();
        uris.push("link.bin".to_owned());
    }
    let read = |uri: &str, folder: Option<&Path>| {
        let mut json = maker.json.clone();
        json["buffers"][0] = json!({ "byteLength": maker.bytes.len(), "uri": uri });
        gltf::parse(json.to_string().as_bytes(), folder, "model.gltf")
    };
    for uri in uris {
        let error = read(&uri, Some(&folder)).unwrap_err().to_string();
        assert!(error.contains("put it there") || error.contains("is no file"), "`{uri}`: {error}");
    }
    std::fs::copy(&secret, folder.join("own.bin")).unwrap();
    assert!(read("own.bin", Some(&folder)).is_ok());
    assert!(read("own.bin", None).is_err(), "bytes without a place may name no file");
}
