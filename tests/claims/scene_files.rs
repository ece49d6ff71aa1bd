//! Scene files read back what they say, and what is wrong with one is told with its place and its remedy.

use glam::{UVec3, Vec3};
use murrine::scene::description::{
    Align, Background, Blending, Cells, Classify, ColumnLoop, Conservative, Deformer, Fill, GridSettings, Hit, Light,
    LightKind, MaterialOverride, Model, Projection, Refraction, Region, Scene, Separability, Shadow, Shape,
    SizeMeasure, Source,
};
use murrine::scene::file;
use murrine::scene::words::Words;
use std::path::{Path, PathBuf};

const METHODS: &[&str] = &["cpu-exact", "hybrid"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn files_in(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == ending))
        .collect();
    files.sort();
    files
}

fn all_methods() -> Vec<&'static str> {
    murrine::voxelize::METHODS.iter().map(|m| m.name).chain(METHODS.iter().copied()).collect()
}

#[test]
fn every_shipped_scene_parses_without_a_warning() {
    let files = files_in(&root().join("scenes"), "toml");
    assert!(!files.is_empty());
    for path in files {
        let (scene, warnings) = file::read(&path, &[], &all_methods()).unwrap_or_else(|e| panic!("{e}"));
        assert!(warnings.is_empty(), "{warnings:?}");
        assert!(!scene.models.is_empty());
    }
}

#[test]
fn every_shipped_scene_survives_writing_and_reading() {
    for path in files_in(&root().join("scenes"), "toml") {
        let (scene, _) = file::read(&path, &[], &all_methods()).unwrap();
        let text = file::to_toml(&scene);
        let (again, _) = file::parse(&text, &path, &all_methods()).unwrap_or_else(|e| panic!("{e}\n{text}"));
        assert_eq!(scene, again, "{text}");
        let mut other = scene.clone();
        other.models[0].translate.x += 1.0;
        assert_ne!(scene, file::parse(&file::to_toml(&other), &path, &all_methods()).unwrap().0);
    }
}

/// Every hostile file opens with the place and a piece of the message that it must cause: `# 3:7: unknown key`.
#[test]
fn every_hostile_scene_is_refused_with_its_place_and_remedy() {
    let files = files_in(&root().join("tests/hostile/scenes"), "toml");
    assert!(files.len() > 40, "only {} hostile scenes", files.len());
    let mut faults = Vec::new();
    for path in files {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let bytes = std::fs::read(&path).unwrap();
        let first = String::from_utf8_lossy(&bytes).lines().next().unwrap_or("").to_owned();
        let Some(expected) = first.strip_prefix("# ") else { panic!("{name} does not open with its message") };
        match file::read(&path, &[], METHODS) {
            Ok(_) => faults.push(format!("{name}: was accepted, expected {expected}")),
            Err(error) => {
                let told = error.to_string().replace(&format!("{}:", path.display()), "");
                let told = told.trim_start();
                if !told.starts_with(expected) {
                    faults.push(format!("{name}:\n  expected {expected}\n  told     {told}"));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn what_is_no_scene_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    let table = [
        (write("latin.toml", b"# caf\xe9"), "byte 5 is no UTF-8"),
        (write("long.toml", &vec![b'#'; (1 << 20) + 1]), "too many for a scene"),
        (write("scene.txt", b""), "neither a scene (.toml) nor a model"),
        (folder.path().to_path_buf(), "it is no file"),
        (folder.path().join("absent.toml"), "can't open it"),
    ];
    for (path, expected) in table {
        let told = file::read(&path, &[], METHODS).unwrap_err().to_string();
        assert!(told.contains(expected) && !told.contains('\n'), "{told}");
    }
}

#[test]
fn deep_and_huge_texts_end_in_an_error() {
    let path = Path::new("scene.toml");
    for text in ["[".repeat(100_000), format!("a = {}", "[".repeat(100_000)), "a.".repeat(50_000), "\u{feff}\0".into()]
    {
        assert!(file::parse(&text, path, METHODS).is_err());
    }
}

#[cfg(unix)]
#[test]
fn a_link_that_leaves_the_surroundings_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let scenes = folder.path().join("project/scenes");
    std::fs::create_dir_all(&scenes).unwrap();
    std::fs::write(folder.path().join("secret.glb"), b"").unwrap();
    std::fs::write(folder.path().join("project/near.glb"), b"").unwrap();
    std::os::unix::fs::symlink("../../secret.glb", scenes.join("link.glb")).unwrap();
    let parse = |file: &str| {
        let text = format!("[[model]]\nfile = \"{file}\"\n");
        file::parse(&text, &scenes.join("a.toml"), METHODS)
    };
    assert!(parse("../near.glb").is_ok());
    for escape in ["link.glb", "../../secret.glb", "x/../../../secret.glb"] {
        let told = parse(escape).unwrap_err();
        assert!(told.what.contains("leaves the scene's surroundings"), "{told}");
        assert!(told.place.ends_with("a.toml:2:8"), "{told}");
    }
}

/// A scene with no value at its default.
fn unusual() -> Scene {
    let (mut scene, _) =
        file::parse(include_str!("../../scenes/two-lights.toml"), Path::new("scenes/x.toml"), METHODS).unwrap();
    scene.frame_camera = true;
    scene.camera.eye = Vec3::new(0.1, 0.2, 1.0 / 3.0);
    scene.grid = GridSettings {
        cells: Cells::Each(UVec3::new(16, 100, 512)),
        align: Align::World,
        projection: Projection::Orthographic,
        region: Some(Region { min: Vec3::new(-1.5, 0.0, 0.25), max: Vec3::splat(2.0) }),
    };
    scene.light_grid = GridSettings {
        cells: Cells::Longest(99),
        align: Align::Camera,
        projection: Projection::Perspective,
        region: None,
    };
    scene.voxelizer.method = "cpu-exact".into();
    scene.voxelizer.separability = Separability::Six;
    scene.voxelizer.fill = Fill::Eager;
    scene.voxelizer.conservative = Conservative::Box;
    scene.voxelizer.conservative_depth = true;
    scene.voxelizer.slice_overlap = 0.125;
    scene.voxelizer.cutoff_cells2 = Some(7.1);
    scene.voxelizer.size_measure = SizeMeasure::Extent2d;
    scene.voxelizer.classify = Classify::First;
    scene.voxelizer.column_loop = ColumnLoop::TwoEnded;
    scene.voxelizer.three_axis_blending = Blending::Additive;
    scene.effect.refraction = Refraction::TwoSurface;
    scene.effect.hit = Hit::Voxel;
    scene.effect.shadow = Shadow::Linear;
    scene.effect.angle_threshold_deg = 3.3;
    scene.effect.max_events = 32;
    scene.effect.transmittance = false;
    scene.effect.fill_questionable = false;
    scene.effect.reflection = false;
    scene.effect.exposure = 0.7;
    scene.background = Background::Checker { a: Vec3::X, b: Vec3::Y, square: 0.3, distance: 2.0 };
    scene.lights.push(Light {
        kind: LightKind::Directional { direction: Vec3::new(1.0, 2.0, 3.0).normalize() },
        color: Vec3::X,
        intensity: 0.1,
        angular_radius_deg: 9.0,
        casts_shadow: false,
    });
    let wave = Deformer::Wave { axis: 2, along: 0, amplitude: 0.3, wavelength: 1.7, hz: -1.0 };
    let material = MaterialOverride {
        part: "fin \"left\"".into(),
        ior: Some(1.33),
        attenuation_color: Some(Vec3::splat(0.9)),
        attenuation_distance: Some(1e-3),
        sigma: None,
        opaque: Some(true),
        base_color: Some(Vec3::X),
        priority: Some(-3),
        roughness: Some(0.25),
        dispersion: Some(0.4),
        checker_color: Some(Vec3::Z),
        checker_square: Some(0.2),
        emissive: Some(Vec3::splat(1e5)),
    };
    for (i, shape) in [
        Shape::Sphere { radius: 0.3, rings: 7 },
        Shape::Box { min: Vec3::NEG_ONE, max: Vec3::splat(0.5) },
        Shape::Icosphere { radius: 2.0, subdivisions: 0 },
    ]
    .into_iter()
    .enumerate()
    {
        scene.models.push(Model {
            name: format!("extra {i} \u{1f41f}"),
            source: Source::Shape(shape),
            animation: Some("Swim".into()),
            speed: -2.0,
            variant: Some("midnight".into()),
            translate: Vec3::X,
            rotate_deg: Vec3::new(10.0, 20.0, 30.0),
            scale: 0.01,
            deformers: vec![wave, Deformer::Twist { axis: 0, deg_per_unit: 45.0, hz: 2.0 }],
            materials: vec![material.clone(), MaterialOverride { sigma: Some(Vec3::ONE), ..Default::default() }],
        });
    }
    let surfaces = "[[model]]\nshape = \"implicit\"\nexpression = \"x^2 + y*z - t\"\nmin = [-2, -1, 0]\ncells = 9\n\
        [[model]]\nshape = \"parametric\"\nx = \"u\"\ny = \"v/t\"\nz = \"sin(u)\"\nu = [-0.5, \"pi/2\"]\nv = [0, 3]\n\
        steps = [7, 9]\nwrap = [true, false]\n";
    let (other, _) = file::parse(surfaces, Path::new("scenes/x.toml"), METHODS).unwrap();
    scene.models.extend(other.models);
    scene
}

#[test]
fn a_scene_with_nothing_at_its_default_survives_writing_and_reading() {
    let scene = unusual();
    let text = file::to_toml(&scene);
    let (again, _) = file::parse(&text, Path::new("scenes/x.toml"), METHODS).unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert_eq!(scene, again, "{text}");
}

fn set_all(text: &str, sets: &[&str]) -> Result<Scene, String> {
    let mut text = text.to_owned();
    for assignment in sets {
        text = file::set(&text, assignment).map_err(|e| e.to_string())?;
    }
    file::parse(&text, Path::new("scenes/x.toml"), METHODS).map(|(scene, _)| scene).map_err(|e| e.to_string())
}

#[test]
fn set_changes_the_key_it_names_and_no_other() {
    let text = include_str!("../../scenes/nested.toml");
    let before = set_all(text, &[]).unwrap();
    let mut wanted = before.clone();
    wanted.effect.max_events = 4;
    wanted.effect.refraction = Refraction::TwoSurface;
    wanted.camera.eye.y = 2.5;
    wanted.models[1].materials[0].ior = Some(1.7);
    wanted.models[0].scale = 2.0;
    wanted.models[2].materials.push(MaterialOverride { roughness: Some(0.5), ..Default::default() });
    let sets = [
        "effect.max_events=4",
        "effect.refraction = two-surface",
        "camera.eye.1=2.5",
        "model.inner.material.0.ior=1.7",
        "model.0.scale=2",
        "model.floor.material.1.roughness=0.5",
    ];
    let after = set_all(text, &sets).unwrap();
    assert_eq!(after, wanted);
    assert_ne!(after, before);
    assert!(file::set(text, sets[0]).unwrap().contains("# A ball of one glass"), "comments are kept");
}

#[test]
fn a_wrong_assignment_says_what_is_wrong() {
    let text = include_str!("../../scenes/nested.toml");
    for (assignment, expected) in [
        ("effect.max_events", "no `=`"),
        ("effect.max_events=", "the value is empty"),
        ("=4", "is no path"),
        ("effect..x=4", "is no path"),
        ("model.9.scale=2", "there is no item 9; the list has 3"),
        ("model.fish.scale=2", "choose outer, inner, floor"),
        ("model=2", "`model` is a table"),
        ("model.0=2", "is an item of a list"),
        ("camera.eye.3=1", "there is no item 3"),
        ("camera.fov_deg.x=1", "holds a plain value"),
        ("effect.max_event=4", "did you mean `max_events`?"),
        ("effect.exposure=nan", "`exposure` is NaN"),
        ("effect.max_events=0", "from 1 to 32"),
        ("efect.max_events=3", "did you mean `effect`?"),
        ("light.0.color=red", "write three numbers"),
        ("voxelizer.conservative=boxes", "did you mean `box`?"),
        ("voxelizer.conservative_depth=1", "`conservative_depth`"),
    ] {
        let told = set_all(text, &[assignment]).unwrap_err();
        assert!(told.contains(expected), "{assignment}: {told}");
    }
}

#[test]
fn an_error_caused_by_an_assignment_names_the_assignment() {
    let scene = root().join("scenes/sphere.toml");
    let told = file::read(&scene, &["effect.max_events=0".into()], &all_methods()).unwrap_err();
    assert_eq!(told.place, "--set effect.max_events=0");
}

#[test]
fn a_model_alone_opens_in_a_scene_that_is_framed_around_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("odd \"name\".glb");
    std::fs::write(&path, b"not looked at yet").unwrap();
    let (scene, _) = file::read(&path, &["effect.max_events=3".into()], &all_methods()).unwrap();
    assert!(scene.frame_camera);
    assert_eq!(scene.models[0].source, Source::File("odd \"name\".glb".into()));
    assert_eq!(scene.models[0].name, "odd \"name\"");
    assert_eq!(scene.effect.max_events, 3);
}

#[test]
fn every_word_reads_back_to_its_choice() {
    fn check<T: Words + std::fmt::Debug>() {
        for (choice, word, about) in T::WORDS {
            assert_eq!(T::from_word(word), Some(*choice));
            assert_eq!(choice.word(), *word);
            assert!(!about.is_empty());
        }
        assert_eq!(T::from_word("no such word"), None);
    }
    check::<Align>();
    check::<Projection>();
    check::<Conservative>();
    check::<Fill>();
    check::<Refraction>();
    check::<Hit>();
    check::<Shadow>();
}

#[test]
fn a_scene_written_into_its_own_text_keeps_every_line_that_did_not_change() {
    let methods = all_methods();
    for entry in std::fs::read_dir("scenes").unwrap() {
        let path = entry.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        let (read, _) = file::parse(&text, &path, &methods).unwrap();
        assert_eq!(file::amended(&text, &read, &path, &methods), text, "{}: nothing was changed", path.display());

        let mut edited = read.clone();
        edited.effect.exposure = 1.625;
        edited.camera.fov_deg = 27.5;
        edited.background = Background::Color { color: Vec3::new(0.25, 0.5, 0.75) };
        edited.lights.push(Light { intensity: 1.5, ..Light::default() });
        let over = MaterialOverride { ior: Some(1.375), ..MaterialOverride::default() };
        edited.models[0].materials.push(over);
        edited.models[0].translate.y += 0.125;
        let amended = file::amended(&text, &edited, &path, &methods);
        let (again, _) = file::parse(&amended, &path, &methods).unwrap();
        assert_eq!(again, edited, "{}: {amended}", path.display());
        let comments = text.lines().filter(|line| line.starts_with('#'));
        for comment in comments {
            assert!(amended.contains(comment), "{}: lost `{comment}`", path.display());
        }
        assert!(!file::to_toml(&edited).contains('#'), "the control has comments by itself");

        // And back: what is the default again is no longer said.
        let back = file::amended(&amended, &read, &path, &methods);
        assert_eq!(file::parse(&back, &path, &methods).unwrap().0, read);
        assert!(!back.contains("1.625"));
    }
}

#[test]
fn a_text_that_can_not_be_amended_is_written_anew() {
    let (path, methods) = (Path::new("scenes/x.toml"), all_methods());
    let (mut scene, _) = file::parse("[[model]]\nshape = \"icosphere\"\n", path, &methods).unwrap();
    scene.effect.max_events = 3;
    for broken in ["", "[camera", "# framed\n[camera]\nframe = true\n[[model]]\nshape = \"icosphere\"\n"] {
        let text = file::amended(broken, &scene, path, &methods);
        assert_eq!(file::parse(&text, path, &methods).unwrap().0, scene, "{text}");
    }
}
