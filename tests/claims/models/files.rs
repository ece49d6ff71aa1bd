//! Real files are read as their authors meant them.

use crate::support::left_out;
use murrine::scene::description::{Model, Scene, Source};
use murrine::scene::pose::pose_vertices;
use murrine::scene::world::World;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A scene of one file, the clip chosen by name.
pub(super) fn scene_of(path: &Path, animation: Option<&str>) -> Scene {
    let folder = path.parent().unwrap().to_path_buf();
    let source = Source::File(path.file_name().unwrap().into());
    let animation = animation.map(str::to_owned);
    Scene {
        models: vec![Model { name: "m".into(), source, animation, ..Model::default() }],
        folder,
        ..Scene::default()
    }
}

/// The folder of other people's models, where it lies beside the checkout; else says that `claim` leaves them out.
fn shared(claim: &str) -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/models");
    if !folder.is_dir() {
        left_out(claim, &format!("other people's models are not in {}", folder.display()));
    }
    folder.is_dir().then_some(folder)
}

/// Our own, always there.
const OWN: [&str; 5] = ["fish.glb", "blob.glb", "paperweight.glb", "tree.glb", "shell.glb"];

/// The vase's authors state 14,036 triangles; the holes of its leaves' mask make more.
/// Name, triangles, matrices, morph targets, clips, clear parts, pictures.
const KNOWN: [(&str, usize, usize, u32, usize, usize, usize); 16] = [
    ("static/bunny_69666_closed.glb", 69_666, 1, 0, 0, 0, 0),
    ("static/dragon_100000.glb", 100_000, 1, 0, 0, 0, 0),
    ("static/spot_5856.glb", 5_856, 1, 0, 0, 0, 0),
    ("animated/CesiumMan.glb", 4_672, 19, 0, 1, 0, 1),
    ("animated/Fox.glb", 576, 24, 0, 3, 0, 1),
    ("animated/RiggedSimple.glb", 188, 2, 0, 1, 0, 0),
    ("animated/SimpleSkin.gltf", 8, 2, 0, 1, 0, 0),
    ("animated/SimpleMorph.gltf", 1, 1, 2, 1, 0, 0),
    ("animated/AnimatedMorphSphere.glb", 960, 1, 2, 1, 0, 0),
    ("animated/MorphStressTest.glb", 2_412, 1, 8, 3, 0, 2),
    ("animated/InterpolationTest.glb", 110, 10, 0, 9, 0, 1),
    ("animated/BoxAnimated.glb", 254, 2, 0, 1, 0, 0),
    ("glass/AttenuationTest.glb", 292, 23, 0, 0, 21, 2),
    ("glass/TransmissionRoughnessTest.glb", 77_792, 9, 0, 0, 5, 3),
    ("glass/DispersionTest.glb", 51_827, 27, 0, 0, 25, 2),
    ("glass/GlassVaseFlowers.glb", 28_774, 4, 0, 0, 2, 1),
];

#[test]
fn shared_models_have_the_counts_that_their_authors_state() {
    let Some(folder) = shared("counts of shared models") else { return };
    for (file, triangles, matrices, targets, clips, clear, pictures) in KNOWN {
        let scene = scene_of(&folder.join(file), None);
        let world = World::load(&scene, None).unwrap_or_else(|e| panic!("{e}"));
        let model = &world.models[0];
        let found = (
            model.triangles.len(),
            model.matrices.len(),
            model.parts.iter().map(|p| p.morph_count).max().unwrap(),
            model.clips.len(),
            world.materials(&scene).iter().filter(|m| !m.opaque).count(),
            model.textures.len(),
        );
        assert_eq!(found, (triangles, matrices, targets, clips, clear, pictures), "{file}");
        assert!(world.warnings.is_empty(), "{file}: {:?}", world.warnings);
    }
}

#[test]
fn bounds_contain_every_posed_vertex_of_our_models_and_of_other_peoples() {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let mut files: Vec<PathBuf> = OWN.iter().map(|file| own.join(file)).collect();
    if let Some(folder) = shared("bounds of shared models") {
        files.extend(KNOWN.iter().map(|(file, ..)| folder.join(file)));
    }
    for file in files {
        let mut scene = scene_of(&file, None);
        let world = World::load(&scene, None).unwrap();
        let file = file.display();
        let clips: Vec<_> = world.models[0].clips.iter().map(|c| Some(c.name.clone())).collect();
        for clip in if clips.is_empty() { vec![None] } else { clips } {
            scene.models[0].animation = clip;
            let duration = world.duration_secs(&scene);
            let steps = if world.models[0].vertices.len() > 20_000 { 1 } else { 5 };
            for step in 0..steps {
                let share = super::bounds::assert_contained(&world, &scene, duration * f64::from(step) / 4.3);
                assert!(share > 0.4, "{file}: its bounds are only {share} filled");
            }
        }
        let posed = pose_vertices(&world, &scene, &world.pose(&scene, 0.0));
        assert!(posed.iter().all(|(p, n)| p.is_finite() && (n.length() - 1.0).abs() < 1e-3), "{file}");
    }
}

#[test]
fn a_model_is_read_again_only_when_its_files_change() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.gltf");
    let maker = super::maker::Maker::triangle();
    let mut json = maker.json.clone();
    json["buffers"][0] = serde_json::json!({ "byteLength": maker.bytes.len(), "uri": "model.bin" });
    std::fs::write(&path, json.to_string()).unwrap();
    std::fs::write(folder.path().join("model.bin"), &maker.bytes).unwrap();
    let mut scene = scene_of(&path, None);
    scene.models.push(Model { name: "twin".into(), ..scene.models[0].clone() });
    let first = World::load(&scene, None).unwrap();
    assert!(Arc::ptr_eq(&first.models[0], &first.models[1]), "one file is read once");
    assert_eq!(first.files(), [folder.path().join("model.bin"), path.clone()]);
    let again = World::load(&scene, Some(&first)).unwrap();
    assert!(Arc::ptr_eq(&first.models[0], &again.models[0]), "nothing changed");
    let longer = [maker.bytes.as_slice(), &[0; 8]].concat();
    std::fs::write(folder.path().join("model.bin"), longer).unwrap();
    let changed = World::load(&scene, Some(&first)).unwrap();
    assert!(!Arc::ptr_eq(&first.models[0], &changed.models[0]), "a file beside it changed");
    std::fs::write(&path, "{").unwrap();
    assert!(World::load(&scene, Some(&first)).is_err(), "a broken file is no reason to show the old one");
}
