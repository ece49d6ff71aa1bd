//! The golden frames that ship are made again, and each fails when its own effect is off.

use crate::gpu;
use murrine::frame::Frame;
use murrine::golden::{self, Goldens, Verdict};
use std::path::Path;

fn open() -> Goldens {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("screenshots");
    Goldens::open(&folder).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn every_golden_frame_is_made_again_and_fails_when_its_own_effect_is_off() {
    let goldens = open();
    assert!(goldens.entries.len() >= 8);
    let failures = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/golden");
    let mut frame = Frame::new(gpu()).unwrap();
    let mut faults = Vec::new();
    for golden in &goldens.entries {
        match goldens.check(gpu(), &mut frame, golden, &failures).unwrap_or_else(|e| panic!("{}: {e}", golden.name)) {
            Verdict::Same(_) => {
                let picture = murrine::image::read_png(&goldens.picture_path(golden)).unwrap();
                if !goldens
                    .control_shows(gpu(), &mut frame, golden, &picture)
                    .unwrap_or_else(|e| panic!("{}: {e}", golden.name))
                {
                    faults.push(format!("{}: {} changes nothing", golden.name, golden.control));
                }
            }
            Verdict::Different(difference, look) => faults.push(format!("{}: {difference:?}; {look}", golden.name)),
            Verdict::Missing(remedy) => faults.push(remedy),
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn the_golden_frames_show_an_animation_at_three_times_and_were_made_on_lavapipe() {
    let goldens = open();
    let fish = goldens.entries.iter().filter(|golden| golden.settings.scene.ends_with("fish.toml"));
    let mut times: Vec<f64> = fish.map(|golden| golden.settings.time_secs).collect();
    times.dedup();
    assert!(times.len() >= 3, "{times:?}");
    for golden in &goldens.entries {
        let sidecar = goldens.sidecar(golden).unwrap_or_else(|| panic!("{} has no sidecar", golden.name));
        assert!(sidecar.adapter.contains("llvmpipe") && sidecar.driver.contains("Mesa"), "{sidecar:?}");
    }
}

#[test]
fn every_voxelizer_that_is_exact_makes_the_same_picture() {
    let goldens = open();
    let picture = |name: &str| {
        let golden = goldens.entries.iter().find(|golden| golden.name == name).unwrap_or_else(|| panic!("no {name}"));
        murrine::image::read_png(&goldens.picture_path(golden)).unwrap()
    };
    let hybrid = picture("hybrid");
    for exact in ["triangle-parallel", "fragment-parallel", "exact-columns"] {
        let difference = golden::compare(&hybrid, &picture(exact));
        assert!(difference.passes(), "{exact}: {difference:?}");
    }
    for approximate in ["slicemap", "three-axis"] {
        let difference = golden::compare(&hybrid, &picture(approximate));
        assert!(!difference.passes(), "{approximate}: {difference:?}");
    }
}
