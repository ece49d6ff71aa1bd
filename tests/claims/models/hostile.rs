//! Files that are broken, or meant to do harm: each gives one clear error, or a warning and a good picture; none a panic
//! or a wait.

use super::maker::{Maker, U8};
use murrine::scene::gltf::{self, Loaded};
use murrine::scene::{SceneError, World};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// What a file of `tests/hostile/models` must lead to.
enum Outcome {
    /// An error that says this.
    Refused(&'static str),
    /// As many triangles, and a warning that says this; no warning where it is empty.
    Shown(usize, &'static str),
}
use Outcome::{Refused, Shown};

const FILES: [(&str, Outcome); 37] = [
    ("accessor-of-a-gigabyte.gltf", Refused("are more than the 36 bytes of buffer view 0")),
    ("accessor-of-zeros.gltf", Refused("asks for 1000000000 elements that the file has no bytes for")),
    ("accessor-overflow.gltf", Refused("elements of 12 bytes are more than")),
    ("accessor-type.gltf", Refused("accessor 0 has the wrong type")),
    ("animation-nan.gltf", Shown(1, "key times are missing, not finite or not ascending")),
    ("buffer-absolute.gltf", Refused("`/etc/hostname` is not a file in the model's folder")),
    ("buffer-missing.gltf", Refused("can't be read")),
    ("buffer-outside.gltf", Refused("`../../../Cargo.toml` is not a file in the model's folder")),
    ("buffer-remote.gltf", Refused("is not a file in the model's folder")),
    ("buffer-short.gltf", Refused("buffer 0 says 1000 bytes, 36 are there")),
    ("buffer-view-past-end.gltf", Refused("buffer view 0 of 4000 bytes reaches past")),
    ("chunk-too-long.glb", Refused("the chunk at byte 12 says")),
    ("cycle.gltf", Refused("is its own ancestor")),
    ("deep.gltf", Shown(1, "")),
    ("draco.gltf", Refused("needs `KHR_draco_mesh_compression`")),
    ("empty.glb", Refused("is no glTF that can be read")),
    ("far-away.gltf", Refused("lie further out than")),
    ("image-bomb.gltf", Shown(1, "texels are too many")),
    ("index-past-end.gltf", Refused("index 2 is vertex 70, but there are 3 vertices")),
    ("joint-past-end.gltf", Shown(1, "of joints that do not exist")),
    ("material-past-end.gltf", Refused("material 9 does not exist")),
    ("morph-nan.gltf", Shown(1, "2 morph displacements that are not finite")),
    ("nan-positions.gltf", Shown(1, "1 triangles with corners that are not finite")),
    ("nan-positions-only.gltf", Refused("has no triangles to show")),
    ("nesting.gltf", Refused("recursion limit")),
    ("no-triangles.gltf", Refused("has no triangles to show")),
    ("not-json.gltf", Refused("is no glTF that can be read")),
    ("numbers.gltf", Refused("is no glTF that can be read")),
    ("points-only.gltf", Refused("has no triangles to show")),
    ("rotation-huge.gltf", Shown(1, "its rotation is no unit quaternion")),
    ("shared-child.gltf", Refused("node 1 has two parents")),
    ("skin-missing.gltf", Refused("skin 3 does not exist")),
    ("sparse-past-end.gltf", Refused("its sparse index 200 is past the 3 elements")),
    ("truncated.glb", Refused("cut off")),
    ("version-1.gltf", Refused("glTF version `1.0`")),
    ("weights-odd.gltf", Shown(1, "weights were negative, not finite")),
    ("zero-area.gltf", Shown(2, "")),
];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/hostile/models")
}

/// Reads a file as the program does, and poses it.
fn load(path: &Path) -> Result<World, SceneError> {
    let scene = super::files::scene_of(path, None);
    let world = World::load(&scene, None)?;
    for time_secs in [0.0, 0.3, 1e9] {
        let pose = world.pose(&scene, time_secs);
        assert!(pose.matrices.iter().all(glam::Mat4::is_finite));
    }
    Ok(world)
}

#[test]
fn every_hostile_file_gives_one_clear_error_or_a_warning_and_a_picture() {
    for (name, outcome) in &FILES {
        let path = folder().join(name);
        let start = Instant::now();
        let found = load(&path);
        assert!(start.elapsed() < Duration::from_secs(2), "{name} took {:?}", start.elapsed());
        match (outcome, found) {
            (Refused(told), Err(error)) => {
                let text = error.to_string();
                assert!(text.contains(told), "{name}: {text}");
                assert!(text.contains(name) || text.contains("model `m`"), "{name}: the place is missing: {text}");
                assert!(text.contains("; ") && !text.contains('\n'), "{name}: one line with a remedy: {text}");
            }
            (Shown(triangles, told), Ok(world)) => {
                assert_eq!(world.models[0].triangles.len(), *triangles, "{name}");
                let told_so = world.warnings.iter().any(|w| w.what.contains(told));
                assert!(
                    if told.is_empty() { world.warnings.is_empty() } else { told_so },
                    "{name}: {:?}",
                    world.warnings
                );
            }
            (Refused(_), Ok(_)) => panic!("{name} was read"),
            (Shown(..), Err(error)) => panic!("{name}: {error}"),
        }
    }
}

#[test]
fn the_table_knows_every_hostile_file() {
    let mut found: Vec<String> =
        std::fs::read_dir(folder()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    found.sort();
    let mut known: Vec<_> = FILES.iter().map(|(name, _)| (*name).to_owned()).collect();
    known.sort();
    assert_eq!(found, known);
}

#[test]
fn every_truncation_of_a_file_is_refused() {
    let glb = Maker::triangle().glb();
    for length in 0..glb.len() {
        assert!(gltf::parse(&glb[..length], None, "cut.glb").is_err(), "{length} of {} bytes were read", glb.len());
    }
    assert!(gltf::parse(&glb, None, "whole.glb").is_ok());
}

/// A strip that goes round the same three corners many times: a byte a triangle.
fn crowd(triangles: usize) -> Result<Loaded, SceneError> {
    let mut maker = Maker::new();
    let position = maker.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let normal = maker.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
    let corners: Vec<u8> = [0, 1, 2].into_iter().cycle().take(triangles + 2).collect();
    let indices = maker.accessor(U8, "SCALAR", corners.len(), &corners);
    let attributes = json!({ "POSITION": position, "NORMAL": normal });
    maker.add_mesh(&json!({ "attributes": attributes, "indices": indices, "mode": 5 }));
    gltf::parse(&maker.glb(), None, "crowd.glb")
}

#[test]
fn ten_million_triangles_are_read_and_more_than_can_be_numbered_refused() {
    assert_eq!(crowd(10_000_000).unwrap().geometry.triangles.len(), 10_000_000);
    let error = crowd((1 << 24) + 1).unwrap_err().to_string();
    assert!(error.contains("more than 16777216 triangles; simplify the model"), "{error}");
}

#[test]
fn a_mesh_shown_too_often_is_refused_before_it_fills_the_memory() {
    let mut maker = Maker::new();
    let position = maker.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let indices = maker.accessor(U8, "SCALAR", 300_000, &[0, 1, 2].repeat(100_000));
    maker.add_mesh(&json!({ "attributes": { "POSITION": position }, "indices": indices }));
    for _ in 0..99 {
        maker.add_root(json!({ "mesh": 0 }));
    }
    let start = Instant::now();
    let error = maker.error();
    assert!(error.contains("30000000 vertices, more than 16777216"), "{error}");
    assert!(start.elapsed() < Duration::from_secs(1), "{:?}", start.elapsed());
}

#[test]
fn names_are_one_line_and_unique() {
    let mut maker = Maker::triangle();
    for name in ["a\nb", "a\nb", "", "  "] {
        let node = maker.add_root(json!({ "mesh": 0 }));
        maker.json["nodes"][node]["name"] = json!(name);
    }
    let geometry = maker.read_cleanly().geometry;
    let names: Vec<_> = geometry.parts.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["part", "ab", "ab 2", "part 2", "part 3"]);
}
