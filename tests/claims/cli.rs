//! The command line, run as a user runs it: what goes where, which exit code, and that nothing is left half done.

use murrine::image;
use murrine::voxel_file::VoxelFormat;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

fn murrine(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_murrine"));
    command.args(arguments).current_dir(env!("CARGO_MANIFEST_DIR")).stdin(Stdio::null());
    command
}

fn run(arguments: &[&str]) -> Output {
    murrine(arguments).output().unwrap()
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// What was told on stderr, less what the system's own libraries write there.
fn stderr(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    text.lines().filter(|line| !line.contains("XDG_RUNTIME_DIR")).map(|line| format!("{line}\n")).collect()
}

/// A scene that costs little, in a folder of its own.
fn small_scene(folder: &Path) -> PathBuf {
    let path = folder.join("small.toml");
    let text = "[grid]\ncells = 32\n[light_grid]\ncells = 32\n[voxelizer]\nmethod = \"triangle-parallel\"\n\
        [[model]]\nshape = \"icosphere\"\nsubdivisions = 3\n";
    std::fs::write(&path, text).unwrap();
    path
}

fn names_in(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn every_kind_of_file_holds_the_picture_that_was_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let scene = small_scene(folder.path());
    let file = |name: &str| folder.path().join(name).display().to_string();
    for (name, channel) in
        [("a.png", "beauty"), ("a.exr", "thickness"), ("a.npy", "exit-direction"), ("b.npy", "beauty")]
    {
        let file = file(name);
        let arguments = ["render", scene.to_str().unwrap(), "-o", &file, "--size", "48x32", "--channel", channel];
        let output = run(&[&arguments[..], &["--adapter", "software"]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        assert_eq!(stdout(&output), "", "a file is the data; the rest goes to stderr");
    }
    let png = image::read_png(Path::new(&file("a.png"))).unwrap();
    assert_eq!((png.width, png.height), (48, 32));
    let exr = image::read_exr(Path::new(&file("a.exr"))).unwrap();
    assert_eq!((exr.width, exr.height, exr.components), (48, 32, 1));
    let (middle, corner) = (exr.at(24, 16)[0], exr.at(0, 0)[0]);
    assert!((1.5..=2.1).contains(&middle) && corner == 0.0, "the ball is 2 thick: {middle}, {corner}");
    let (shape, values) = image::read_array::<f32>(Path::new(&file("a.npy"))).unwrap();
    assert_eq!(shape, [32, 48, 3]);
    assert!(values[0].is_nan(), "a ray that met no glass left none");
    assert!(values.iter().any(|v| v.is_finite()));
    assert_eq!(names_in(folder.path()), ["a.exr", "a.npy", "a.png", "b.npy", "small.toml"]);
}

#[test]
fn flags_and_assignments_change_the_picture_and_later_ones_win() {
    let folder = tempfile::tempdir().unwrap();
    let scene = small_scene(folder.path());
    let path = folder.path().join("a.npy").display().to_string();
    let render = |more: &[&str]| {
        let first = ["render", scene.to_str().unwrap(), "-o", &path, "--size", "40x40", "--adapter", "software"];
        let output = run(&[&first[..], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        image::read_array::<f32>(Path::new(&path)).unwrap().1
    };
    let plain = render(&[]);
    let straight = render(&["--refraction", "none"]);
    assert_eq!(plain, render(&[]), "the same picture every time");
    assert_ne!(plain, straight);
    assert_eq!(straight, render(&["--set", "effect.refraction=none"]));
    assert_eq!(plain, render(&["--refraction", "none", "--set", "effect.refraction=multiple-surface"]));
    let voxels = ["--hit", "voxel", "--grid", "16x24x40"]; // rays from triangle to triangle see no grid
    assert!(render(&voxels) != render(&voxels[..2]));
    assert_ne!(plain, render(&["--set", "model.0.material.0.sigma=[1, 2, 3]"]));
}

#[test]
fn what_cannot_be_done_is_told_once_and_exits_with_2() {
    let folder = tempfile::tempdir().unwrap();
    let scene = small_scene(folder.path()).display().to_string();
    let out = folder.path().join("a.png").display().to_string();
    let nowhere = folder.path().join("no/a.png").display().to_string();
    let table: &[(&[&str], &str)] = &[
        (&["render", &scene, "-o", "a.jpg"], "unknown ending; write .png, .exr or .npy"),
        (&["render", &scene, "-o", &nowhere], "its folder does not exist"),
        (&["render", &scene, "-o", &out, "--size", "0x100"], "write 1 to 8192"),
        (&["render", &scene, "-o", &out, "--size", "8192x8192"], "choose a smaller picture"),
        (&["render", &scene, "-o", &out, "--size", "big"], "write WIDTHxHEIGHT"),
        (&["render", &scene, "-o", &out, "--time", "nan"], "write seconds"),
        (&["render", &scene, "-o", &out, "--time", "-1"], "write seconds"),
        (&["render", &scene, "-o", &out, "--grid", "0"], "`cells` is 0; give a whole number from 16 to 1024"),
        (&["render", &scene, "-o", &out, "--grid", "1025"], "`cells` is 1025"),
        (&["render", &scene, "-o", &out, "--grid", "1000000"], "`cells` is 1000000"),
        (&["render", &scene, "-o", &out, "--grid", "16x16"], "write a whole number or three of them"),
        (&["render", &scene, "-o", &out, "--voxelizer", "triangle-paralel"], "did you mean `triangle-parallel`?"),
        (&["render", &scene, "-o", &out, "--refraction", "sideways"], "choose none, single"),
        (&["render", &scene, "-o", &out, "--channel", "depth"], "choose beauty, thickness"),
        (&["render", &scene, "-o", &out, "--set", "effect.max_events=0"], "--set effect.max_events=0: "),
        (&["render", &scene, "-o", &out, "--adapter", "no such adapter"], "no such adapter"),
        (&["render", "absent.toml", "-o", &out], "absent.toml: can't open it"),
        (&["render", "Cargo.lock", "-o", &out], "neither a scene (.toml) nor a model"),
        (&["voxelize", &scene, "-o", &out, "--grid", "16"], "unknown ending; write one of .npy, .npz, .vti"),
        (&["voxelize", &scene, "-o", "a.ply", "--grid", "16", "--solid"], "holds points of the surface, no interior"),
        (&["voxelize", &scene, "-o", "a.vox", "--grid", "512"], "holds 256 cells along an axis"),
        (&["voxelize", &scene, "-o", "a.npz", "--grid", "513"], "holds 512 cells along an axis"),
        (&["voxelize", &scene, "-o", "a.npy", "--grid", "0"], "write 1 to 1024"),
        (&["voxelize", &scene, "-o", "a.npy", "--grid", "1025"], "write 1 to 1024"),
        (&["voxelize", &scene, "-o", "a.npy", "--grid", "1000000"], "write 1 to 1024"),
        (&["voxelize", &scene, "-o", "a.npy", "--grid", "16", "--origin", "0,0,0"], "--cell"),
        (&["voxelize", &scene, "-o", "a.npy", "--grid", "16", "--origin", "0,0", "--cell", "1"], "three numbers"),
        (&["voxelize", &scene, "-o", "a.npy", "--grid", "16", "--origin", "0,0,0", "--cell", "0"], "a length above 0"),
        (&["list", "chanels"], "did you mean `channels`?"),
        (&["golden", "run", "no-such"], "no-such"),
        (&["golden", "list", "--folder", "/nowhere"], "/nowhere"),
        (&["render", "--frobnicate"], "--frobnicate"),
    ];
    for (arguments, expected) in table {
        let output = run(arguments);
        let told = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
        assert!(told.contains(expected), "{arguments:?}: {told}");
        assert_eq!(told.matches("error:").count(), 1, "{arguments:?}: {told}");
        assert_eq!(stdout(&output), "", "{arguments:?}");
        assert_eq!(names_in(folder.path()), ["small.toml"], "{arguments:?}");
    }
}

#[test]
fn check_passes_good_scenes_and_exits_with_1_for_bad_ones() {
    let good = run(&["check", "scenes/sphere.toml", "scenes/torus.toml"]);
    assert_eq!(good.status.code(), Some(0));
    assert_eq!(stdout(&good).lines().count(), 2);
    let bad = run(&["check", "tests/hostile/scenes/unknown-key.toml", "scenes/sphere.toml"]);
    assert_eq!(bad.status.code(), Some(1));
    let told = stdout(&bad);
    assert!(told.contains("unknown-key.toml:3:1: unknown key `max_event`"), "{told}");
    assert!(told.contains("scenes/sphere.toml: ok"), "every scene is looked at: {told}");
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    for arguments in [&["list"][..], &["--help"], &["check", "scenes/sphere.toml"]] {
        let mut child = murrine(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", stderr(&output));
        assert_eq!(stderr(&output), "", "{arguments:?}");
    }
}

#[test]
fn a_missing_driver_is_told_with_the_package_that_mends_it() {
    let folder = tempfile::tempdir().unwrap();
    let scene = small_scene(folder.path()).display().to_string();
    let without_driver = |arguments: &[&str]| {
        let nowhere = folder.path().join("no-driver.json");
        murrine(arguments).env("VK_DRIVER_FILES", &nowhere).env("VK_ICD_FILENAMES", &nowhere).output().unwrap()
    };
    let out = folder.path().join("a.png").display().to_string();
    let output = without_driver(&["render", &scene, "-o", &out]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("apt install mesa-vulkan-drivers"), "{}", stderr(&output));
    assert_eq!(names_in(folder.path()), ["small.toml"]);
    let doctor = without_driver(&["doctor"]);
    assert_eq!(doctor.status.code(), Some(1));
    assert!(stdout(&doctor).contains("FAILS      adapter: no Vulkan"), "{}", stdout(&doctor));
    assert_eq!(without_driver(&["check", &scene]).status.code(), Some(0), "reading needs no driver");
}

#[cfg(unix)]
#[test]
fn a_full_disk_is_told_and_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let scene = small_scene(folder.path()).display().to_string();
    let golden = "[[golden]]\nname = \"a\"\nabout = \"a\"\nscene = \"small.toml\"\nsize = [64, 48]\n\
        control = \"effect.refraction=none\"\n";
    let goldens = folder.path().join("screenshots");
    std::fs::create_dir(&goldens).unwrap();
    std::fs::write(goldens.join("goldens.toml"), golden).unwrap();
    let inside = |name: &str| folder.path().join(name).display().to_string();
    // Files may grow to one block of 512 or 1,024 bytes: less than any of these takes.
    let script = "trap '' XFSZ; ulimit -f 1; exec \"$0\" \"$@\" --adapter software";
    let npy = inside("a.npy");
    let voxels = VoxelFormat::ALL.map(|(_, ending)| inside(&format!("v.{ending}")));
    let mut commands: Vec<(&str, Vec<&str>)> = vec![
        ("a.npy", vec!["render", &scene, "-o", &npy, "--size", "64x64"]),
        ("a.png", vec!["golden", "--folder", goldens.to_str().unwrap(), "update"]),
    ];
    for file in &voxels {
        commands.push((file.as_str(), vec!["voxelize", &scene, "-o", file, "--grid", "32"]));
    }
    for (name, arguments) in commands {
        let output =
            Command::new("sh").args(["-c", script, env!("CARGO_BIN_EXE_murrine")]).args(&arguments).output().unwrap();
        let told = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert!(told.contains(&format!("{name}: can't write it")) && told.contains("free some space"), "{told}");
        assert_eq!(told.matches("error:").count(), 1, "{told}");
        assert_eq!(names_in(folder.path()), ["screenshots", "small.toml"]);
        assert_eq!(names_in(&goldens), ["goldens.toml"]);
    }
}

#[test]
fn a_voxelized_box_has_the_cells_that_its_surface_and_its_inside_meet() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("box.toml");
    std::fs::write(&scene, "[[model]]\nshape = \"box\"\nmin = [0.0, 0.0, 0.0]\nmax = [1.0, 0.5, 0.25]\n").unwrap();
    let out = folder.path().join("box.npy");
    let voxelize = |more: &[&str]| {
        let (scene, out) = (scene.to_str().unwrap(), out.to_str().unwrap());
        let first = ["voxelize", scene, "-o", out, "--grid", "40x32x24", "--voxelizer", "triangle-parallel"];
        // Faces lie in the middle of cells.
        let second = ["--origin", "-0.375,-0.375,-0.375", "--cell", "0.05", "--adapter", "software"];
        let output = run(&[&first[..], &second, more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let (shape, marked) = image::read_array::<u8>(Path::new(out)).unwrap();
        assert_eq!(shape, [24, 32, 40], "[z][y][x]");
        (marked, stdout(&output))
    };
    let (surface, told) = voxelize(&[]);
    let count = |marked: &[u8]| marked.iter().filter(|v| **v == 1).count();
    // 21 × 11 × 6 cells meet the box, 19 × 9 × 4 of them are wholly inside.
    assert_eq!(count(&surface), 21 * 11 * 6 - 19 * 9 * 4);
    assert!(told.contains(&format!("surface    {}", count(&surface))), "{told}");
    assert!(told.lines().any(|line| line.starts_with("ms ")), "{told}");
    let at = |x: usize, y: usize, z: usize| surface[(z * 32 + y) * 40 + x];
    assert_eq!((at(7, 7, 7), at(27, 17, 12), at(8, 8, 8), at(28, 17, 12)), (1, 1, 0, 0));
}

/// Ctrl+C as a terminal sends it.
#[cfg(unix)]
#[test]
fn what_is_interrupted_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let scene = small_scene(folder.path());
    let out = folder.path().join("v.npy");
    let arguments = ["voxelize", scene.to_str().unwrap(), "-o", out.to_str().unwrap(), "--grid", "512"];
    let mut running = murrine(&arguments).args(["--adapter", "software"]).stderr(Stdio::piped()).spawn().unwrap();
    // The file grows beside its place for a good while.
    while !names_in(folder.path()).iter().any(|name| name.ends_with(".part")) {
        assert!(running.try_wait().unwrap().is_none(), "it ended without a file");
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    assert!(Command::new("kill").args(["-INT", &running.id().to_string()]).status().unwrap().success());
    let output = running.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("v.npy: stopped; nothing was left behind"), "{}", stderr(&output));
    assert_eq!(names_in(folder.path()), ["small.toml"]);
}

#[test]
fn lists_come_from_the_lists() {
    let told = stdout(&run(&["list"]));
    for method in murrine::voxelize::METHODS {
        assert!(told.contains(method.name), "{}", method.name);
    }
    for word in ["multiple-surface", "beer-lambert", "surfel", "exit-direction", "icosphere", "environment"] {
        assert!(told.contains(word), "{word}");
    }
    let channels = stdout(&run(&["list", "channels"]));
    assert!(channels.contains("ground-light") && !channels.contains("icosphere"));
}

#[test]
fn the_doctor_names_adapter_driver_and_what_works() {
    let output = run(&["doctor", "--adapter", "software"]);
    let told = stdout(&output);
    assert_eq!(output.status.code(), Some(0), "{told}");
    for part in ["adapter ", "driver ", "ok         limits", "largest grids", "ok         rendering", "window"] {
        assert!(told.contains(part), "no `{part}` in:\n{told}");
    }
    let absent = run(&["doctor", "--adapter", "no such adapter"]);
    assert_eq!(absent.status.code(), Some(1));
    assert!(stdout(&absent).contains("FAILS      adapter"));
}

#[test]
fn the_benchmark_advances_the_time_and_its_stages_add_up_to_the_wall_clock() {
    let arguments = ["bench", "--only", "one scene-sized triangle", "--iterations", "3", "--adapter", "software"];
    let output = run(&[&arguments[..], &["--json"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let report: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 3, "hybrid and its halves");
    for row in rows {
        let median = |key: &str| row[key]["median"].as_f64().unwrap();
        assert!(median("sum") > 0.0 && median("sum") <= median("wall") * 1.001, "{row}");
        // Nothing stood still: the body is animated and voxelized in every iteration.
        let stages = row["stages"].as_array().unwrap();
        let ms = |name: &str| stages.iter().find(|s| s[0] == name).unwrap()[1]["min"].as_f64().unwrap();
        assert!(ms("animate") > 0.0 && ms("voxelize") > 0.0, "{row}");
        assert!(row["records"].as_u64().unwrap() > 1000, "{row}");
    }
    let findings = report["findings"].as_array().unwrap();
    assert!(findings.iter().any(|f| f["text"].as_str().unwrap().contains("the better of its halves")));
}

#[test]
fn four_rays_a_pixel_smooth_outlines_and_are_for_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let scene = small_scene(folder.path());
    let render = |name: &str, flags: &[&str]| {
        let file = folder.path().join(name);
        let arguments = ["render", scene.to_str().unwrap(), "-o", file.to_str().unwrap(), "--size", "48x32"];
        let output = run(&[&arguments[..], &["--adapter", "software"], flags].concat());
        (output, file)
    };
    // How far pixels lie from the mean of the two beside them.
    let roughness = |file: &Path| {
        let png = image::read_png(file).unwrap();
        assert_eq!((png.width, png.height), (48, 32));
        png.rgb8
            .windows(3)
            .map(|p| (2 * i32::from(p[1][1]) - i32::from(p[0][1]) - i32::from(p[2][1])).abs())
            .sum::<i32>()
    };
    let (one, four) = (render("one.png", &[]).1, render("four.png", &["--antialias"]).1);
    let (rough, smooth) = (roughness(&one), roughness(&four));
    assert!(smooth < rough * 9 / 10, "{smooth} instead of {rough}");
    let (refused, file) = render("four.exr", &["--antialias"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("leave it out") && !file.exists(), "{}", stderr(&refused));
}
