//! Golden frames are compared strictly, kept with what made them, and blessed only where they show something.

use crate::gpu;
use murrine::frame::Frame;
use murrine::golden::{self, Golden, GoldenError, Goldens, Verdict};
use murrine::image::{self, Picture};
use std::path::Path;

const SCENE: &str = "[grid]\ncells = 32\n[light_grid]\ncells = 32\n[voxelizer]\nmethod = \"triangle-parallel\"\n\
    [background]\nkind = \"checker\"\n[[model]]\nshape = \"icosphere\"\nsubdivisions = 3\n";

fn list(control: &str, time_secs: f64) -> String {
    format!(
        "[[golden]]\nname = \"ball\"\nabout = \"a ball\"\nscene = \"ball.toml\"\nsize = [64, 48]\n\
        time_secs = {time_secs:?}\ncontrol = \"{control}\"\n"
    )
}

/// A project with one golden.
fn project(list: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("screenshots")).unwrap();
    std::fs::write(folder.path().join("ball.toml"), SCENE).unwrap();
    std::fs::write(folder.path().join("screenshots/goldens.toml"), list).unwrap();
    folder
}

fn open(project: &Path) -> (Goldens, Golden) {
    let goldens = Goldens::open(&project.join("screenshots")).unwrap_or_else(|e| panic!("{e}"));
    let golden = goldens.entries[0].clone();
    (goldens, golden)
}

fn picture(value: impl Fn(usize) -> u8) -> Picture {
    Picture { width: 100, height: 100, rgb8: (0..10_000).map(|i| [100, value(i), 100]).collect() }
}

#[test]
fn the_tolerance_is_two_levels_for_all_but_a_thousandth_of_the_pixels() {
    let plain = picture(|_| 100);
    assert!(golden::compare(&plain, &plain).passes());
    assert!(golden::compare(&plain, &picture(|_| 102)).passes());
    assert!(golden::compare(&plain, &picture(|i| if i < 10 { 255 } else { 98 })).passes());
    assert!(!golden::compare(&plain, &picture(|_| 103)).passes());
    assert!(!golden::compare(&plain, &picture(|_| 97)).passes());
    assert!(!golden::compare(&plain, &picture(|i| if i < 11 { 103 } else { 100 })).passes());
    let smaller = Picture { width: 100, height: 99, rgb8: plain.rgb8[..9_900].to_vec() };
    assert!(!golden::compare(&plain, &smaller).passes());
    assert_eq!(golden::difference_picture(&plain, &plain).rgb8[0], [0, 0, 0]);
    assert_ne!(golden::difference_picture(&plain, &picture(|_| 103)).rgb8[0], [0, 0, 0]);
}

#[test]
fn a_golden_is_missing_then_blessed_then_the_same_then_different_when_touched() {
    let project = project(&list("effect.refraction=none", 0.0));
    let (goldens, golden) = open(project.path());
    let failures = project.path().join("failures");
    let mut frame = Frame::new(gpu()).unwrap();
    let mut check = |goldens: &Goldens, golden: &Golden| {
        goldens.check(gpu(), &mut frame, golden, &failures).unwrap_or_else(|e| panic!("{e}"))
    };

    let Verdict::Missing(remedy) = check(&goldens, &golden) else { panic!("there is none yet") };
    assert!(remedy.contains("murrine golden update ball"), "{remedy}");

    goldens.bless(gpu(), &mut Frame::new(gpu()).unwrap(), &golden).unwrap_or_else(|e| panic!("{e}"));
    assert!(matches!(check(&goldens, &golden), Verdict::Same(_)));
    assert!(!failures.exists());
    let sidecar = goldens.sidecar(&golden).unwrap();
    assert!(sidecar.adapter.contains("llvmpipe") && sidecar.driver.contains("Mesa"), "{sidecar:?}");

    let path = goldens.picture_path(&golden);
    let blessed = image::read_png(&path).unwrap();
    let mut touched = blessed.clone();
    touched.rgb8[1000..1100].fill([255, 0, 255]);
    image::write_png(&path, &touched).unwrap();
    assert!(matches!(check(&goldens, &golden), Verdict::Different(..)));
    let actual = image::read_png(&failures.join("ball.actual.png")).unwrap();
    assert!(golden::compare(&actual, &blessed).passes());
    assert!(failures.join("ball.difference.png").is_file());

    image::write_png(&path, &blessed).unwrap();
    std::fs::write(project.path().join("screenshots/goldens.toml"), list("effect.refraction=none", 1.0)).unwrap();
    let (goldens, golden) = open(project.path());
    assert!(matches!(check(&goldens, &golden), Verdict::Missing(_)), "the list's settings have changed");
}

#[test]
fn a_golden_that_its_control_leaves_as_it_is_is_not_blessed() {
    let project = project(&list("camera.frame=false", 0.0));
    let (goldens, golden) = open(project.path());
    let refused = goldens.bless(gpu(), &mut Frame::new(gpu()).unwrap(), &golden).unwrap_err();
    assert!(matches!(refused, GoldenError::Blind { .. }), "{refused}");
    assert!(!goldens.picture_path(&golden).exists() && !goldens.sidecar_path(&golden).exists());
}

#[test]
fn only_lavapipe_makes_goldens() {
    let mut info = gpu().info.clone();
    assert!(golden::is_lavapipe(&info));
    for (name, driver, kind) in [
        ("NVIDIA GeForce RTX 4090", "NVIDIA", wgpu::DeviceType::DiscreteGpu),
        ("Microsoft Basic Render Driver", "WARP", wgpu::DeviceType::Cpu),
        ("SwiftShader Device", "SwiftShader driver", wgpu::DeviceType::Cpu),
    ] {
        (info.name, info.driver, info.device_type) = (name.into(), driver.into(), kind);
        assert!(!golden::is_lavapipe(&info), "{name}");
    }
}

#[test]
fn a_wrong_list_is_told_with_its_file() {
    let entry = |name: &str| list("a=1", 0.0).replace("\"ball\"", &format!("\"{name}\""));
    for (text, expected) in [
        ("", "missing field `golden`"),
        ("[[golden]]\nname = 3\n", "name"),
        (&entry("../ball"), "is no name for a golden"),
        (&entry("goldens"), "is no name for a golden"),
        (&(entry("a") + &entry("a")), "two goldens are called `a`"),
        (&(entry("a") + "colour = 3\n"), "unknown field `colour`"),
        (&entry("a").replace("[64, 48]", "[64, 100000]"), "outside 1 to 4096 pixels"),
    ] {
        let project = project(text);
        let told = Goldens::open(&project.path().join("screenshots")).unwrap_err().to_string();
        assert!(told.contains("goldens.toml: ") && told.contains(expected), "{told}");
    }
}
