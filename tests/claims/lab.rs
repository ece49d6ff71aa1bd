//! The laboratory's report: what it measures is true, what it leaves out it says, and it is whole or not there.

use murrine::marking::Faults;
use murrine::voxelize::{ExactVoxels, METHODS, Promise};
use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Command, Output, Stdio};

fn murrine(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_murrine"));
    command.args(arguments).args(["--adapter", "software"]).current_dir(env!("CARGO_MANIFEST_DIR"));
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Runs `murrine lab` into a folder.
fn lab(arguments: &str, folder: &Path) -> Output {
    let mut all = vec!["lab"];
    all.extend(arguments.split(' '));
    let folder = folder.display().to_string();
    all.extend(["-o", &folder]);
    murrine(&all).output().unwrap()
}

/// Of a line of the CSV, by the names of its head. Quoted values have no quotes within here.
fn rows(csv: &str) -> Vec<std::collections::BTreeMap<String, String>> {
    let split = |line: &str| {
        let (mut values, mut quoted) = (vec![String::new()], false);
        for c in line.chars() {
            match c {
                '"' => quoted = !quoted,
                ',' if !quoted => values.push(String::new()),
                c => values.last_mut().unwrap().push(c),
            }
        }
        values
    };
    let mut lines = csv.lines();
    let head = split(lines.next().unwrap());
    let row = |line| {
        let values = split(line);
        assert_eq!(values.len(), head.len(), "{line}");
        head.iter().cloned().zip(values).collect()
    };
    lines.map(row).collect()
}

fn read(folder: &Path) -> (String, String) {
    let text = |name| std::fs::read_to_string(folder.join(name)).unwrap();
    (text("report.html"), text("report.csv"))
}

#[test]
fn faults_are_counted_voxel_by_voxel_and_ties_apart() {
    let truth = ExactVoxels { words: vec![0b0011_1100, 0b1], ties: vec![0b0010_0010, 0] };
    let of = |a, b| Faults::of(&[a, b], &truth);
    assert_eq!(of(0b0011_1100, 1), Faults { found: 5, ..Faults::default() });
    assert_eq!(of(0b0001_1000, 1), Faults { found: 3, missing: 1, spurious: 0, ties: 1 });
    assert_eq!(of(0b1011_1110, 3), Faults { found: 8, missing: 0, spurious: 2, ties: 1 });
}

#[test]
fn the_report_holds_every_method_and_the_exact_ones_have_no_faults() {
    let folder = tempfile::tempdir().unwrap();
    let into = folder.path().join("report");
    let output = lab("shape:torus,segments=20 --grids 24 --angles 1 --aspects 1:1:4", &into);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let (html, csv) = read(&into);
    let rows = rows(&csv);
    for method in METHODS {
        let of_method: Vec<_> = rows.iter().filter(|r| r["method"] == method.name && r["series"] != "cutoff").collect();
        let plain = of_method.iter().filter(|r| r["conservative"] == "none" && r["in_depth"] == "false").count();
        assert_eq!(plain, 3, "{}: a grid, an angle, a shape", method.name);
        assert_eq!(of_method.len() - plain, 2 * method.conservative.len(), "{}", method.name);
        for row in of_method.iter().filter(|r| r["left_out"].is_empty()) {
            assert!(row["found"].parse::<u32>().unwrap() > 100 && row["ms_median"].parse::<f64>().unwrap() > 0.0);
            if method.promise == Promise::Exact {
                assert_eq!((row["missing"].as_str(), row["spurious"].as_str()), ("0", "0"), "{row:?}");
            }
        }
        assert!(html.contains(&format!(">{}</text>", method.name)), "{} stands in a plot", method.name);
    }
    let misses =
        |name: &str| rows.iter().any(|r| r["method"] == name && r["missing"].parse().is_ok_and(|n: u32| n > 0));
    assert!(misses("slice-amplified"), "an approximate method's faults are seen");
    assert_eq!(rows.iter().filter(|r| r["series"] == "cutoff").count(), 17);

    for part in ["<script", "src=", "href=", "http", "@import", "url("] {
        assert!(!html.contains(part), "the page needs nothing else, but has `{part}`");
    }
    assert_eq!(html.matches("<svg").count(), 5 + 2 + 2 + 1);
    assert_eq!(html.matches("<svg").count(), html.matches("</svg>").count());
    assert!(html.contains("llvmpipe"), "the adapter's name");
    assert!(
        html.contains("murrine lab shape:torus,segments=20 --grids 24 --voxelizers all --angles 1 --aspects 1:1:4")
    );
    assert!(!html.contains("was stopped"));
}

#[test]
fn the_command_line_in_the_report_finds_the_same_voxels_again() {
    let folder = tempfile::tempdir().unwrap();
    let (first, second) = (folder.path().join("a report"), folder.path().join("again"));
    let what = "shape:icosphere,subdivisions=2 shape:box --grids 24 --voxelizers triangle-parallel,exact-columns \
        --angles 2 --aspects none";
    assert_eq!(lab(what, &first).status.code(), Some(0));
    let (html, csv) = read(&first);
    let told = html.split("<pre>").nth(1).unwrap().split("</pre>").next().unwrap();
    let program = format!("'{}'", env!("CARGO_BIN_EXE_murrine"));
    let script = told.replacen("murrine", &program, 1).replace("a report", "again");
    let output = Command::new("sh").args(["-c", &script]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{script}: {}", String::from_utf8_lossy(&output.stderr));
    let found = |csv: &str| -> Vec<_> {
        let keys = ["model", "angle_deg", "cells_x", "method", "found", "missing", "spurious"];
        rows(csv).into_iter().map(|row| keys.map(|key| row[key].clone())).collect()
    };
    assert_eq!(found(&csv), found(&read(&second).1));
    assert_eq!(found(&csv).len(), 2 * 3 * 2);
}

#[test]
fn what_would_take_longer_than_the_cap_is_left_out_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let what = "shape:icosphere --grids 16,32,64 --voxelizers slice-amplified --angles 0 --aspects none --cap 0.001";
    assert_eq!(lab(what, folder.path()).status.code(), Some(0));
    let (html, csv) = read(folder.path());
    let rows = rows(&csv);
    let plain: Vec<_> = rows.iter().filter(|r| r["conservative"] == "none" && r["in_depth"] == "false").collect();
    assert!(plain[0]["left_out"].is_empty() && plain[0]["rounds"] == "1", "the coarsest grid is measured once");
    assert!(plain[2]["left_out"].contains("more than the cap") && plain[2]["found"].is_empty(), "{:?}", plain[2]);
    assert!(html.contains("<h2>Left out</h2>") && html.contains("raise --cap"));
}

#[test]
fn the_gallerys_table_is_the_list_of_methods() {
    let output = murrine(&["list", "--markdown"]).output().unwrap();
    let table = String::from_utf8(output.stdout).unwrap();
    for method in METHODS {
        assert_eq!(table.matches(&format!("| `{}` |", method.name)).count(), 1);
    }
    let docs = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/gallery.md")).unwrap();
    assert!(docs.contains(&table), "write the output of `murrine list --markdown` into docs/gallery.md:\n{table}");
    assert!(!docs.contains(&table.replacen("exact", "inexact", 1)), "a change is seen");
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_what_there_is() {
    let folder = tempfile::tempdir().unwrap();
    let into = folder.path().display().to_string();
    let mut child = murrine(&["lab", "shape:torus", "--grids", "16,512", "-o", &into]).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(lines.any(|line| line.unwrap().contains("torus 16³")), "it tells where it is");
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let told: Vec<String> = lines.map(Result::unwrap).collect();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{told:?}");
    assert!(told.last().unwrap().contains("stopped after"), "{told:?}");
    let (html, csv) = read(folder.path());
    assert!(html.contains("was stopped after") && html.ends_with("</html>\n"));
    assert!(csv.starts_with("model,"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "nothing else is left");
}

#[test]
fn what_cannot_be_measured_is_told_before_anything_is() {
    let folder = tempfile::tempdir().unwrap();
    let nowhere = folder.path().join("no/report");
    for (arguments, expected) in [
        ("shape:tours", "did you mean `torus`?"),
        ("shape:torus,segment=3", "unknown key `segment`"),
        ("shape:torus --grids 8", "8 is not in 16..=512"),
        ("shape:torus --voxelizers slice-amplifed", "did you mean `slice-amplified`?"),
        ("shape:torus --aspects 1:2", "write X:Y:Z"),
        ("shape:torus --cap 0", "write seconds"),
        ("absent.glb", "absent.glb: can't open it"),
        ("shape:torus", "can't make this folder"),
    ] {
        let output = lab(arguments, &nowhere);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments}: {told}");
        assert!(told.contains(expected), "{arguments}: {told}");
        assert!(!nowhere.exists());
    }
}
