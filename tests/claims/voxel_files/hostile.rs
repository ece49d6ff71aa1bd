//! Saved voxels that are broken, or meant to do harm: each gives one clear error, or a model; none a panic or a wait.

use murrine::scene::voxels;
use std::path::Path;
use std::time::{Duration, Instant};

/// What a file of `tests/hostile/voxels` must lead to.
enum Outcome {
    /// An error that says this.
    Refused(&'static str),
    /// Parts of these names.
    Shown([&'static str; 2]),
}
use Outcome::{Refused, Shown};

const FILES: [(&str, Outcome); 28] = [
    ("bomb.npz", Refused("array `occupancy` is larger than 512³ cells")),
    ("cell-zero.npz", Refused("array `cell`: number 0 is 0")),
    ("empty.npz", Refused("is no .npz file that can be read")),
    ("flipped-bit.npz", Refused("array `occupancy`")),
    ("fortran-order.npz", Refused("is in Fortran order")),
    ("header-without-end.npz", Refused("has a header without end")),
    ("huge-shape.npz", Refused("has 96 bytes, not what its shape says")),
    ("index-negative.npz", Refused("array `index`: number 0 is -1")),
    ("index-past-end.npz", Refused("outside the grid")),
    ("index-too-short.npz", Refused("`index` has shape [63, 3], not [64, 3]")),
    ("infinite-position.npz", Refused("array `position`: number 0 is inf")),
    ("interior-of-another-shape.npz", Refused("`interior` has shape [4, 4, 5]")),
    ("ior-huge.npz", Refused("array `ior`: number 0 is")),
    ("names-alike.npz", Shown(["a", "a #1"])),
    ("nan-normal.npz", Refused("array `normal`: number 3 is NaN")),
    ("no-materials.npz", Refused("has no array `ior`")),
    ("no-occupancy.npz", Refused("has no array `occupancy`; save the voxels with `murrine voxelize`")),
    ("no-voxels.npz", Refused("has no voxels")),
    ("normal-of-complex-numbers.npz", Refused("array `normal` holds `<c8`")),
    ("not-a-zip.npz", Refused("is no .npz file that can be read")),
    ("origin-nan.npz", Refused("array `origin`: number 1 is NaN")),
    ("other-number-types.npz", Shown(["ball/icosphere", "box/box"])),
    ("part-of-texts.npz", Refused("array `part` holds `|S2`, no plain numbers")),
    ("part-past-end.npz", Refused("names part 9, but there are 2 materials")),
    ("pickled.npz", Refused("array `part`")),
    ("shape-of-more-bytes.npz", Refused("has 96 bytes, not what its shape says")),
    ("shape-too-fine.npz", Refused("three axes of 1 to 512 cells")),
    ("shape-two-axes.npz", Refused("three axes of 1 to 512 cells")),
];

fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/hostile/voxels")
}

#[test]
fn every_hostile_file_of_voxels_gives_one_clear_error_or_a_model() {
    for (name, outcome) in &FILES {
        let start = Instant::now();
        let found = voxels::read(&folder().join(name));
        let took = start.elapsed();
        assert!(took < Duration::from_secs(10), "{name}: {took:?}");
        match (found, outcome) {
            (Err(error), Refused(words)) => {
                let told = error.to_string();
                assert!(told.contains(words) && told.contains(name) && !told.contains('\n'), "{name}: {told}");
            }
            (Ok(loaded), Shown(names)) => {
                let found: Vec<&str> = loaded.geometry.parts.iter().map(|p| p.name.as_str()).collect();
                assert_eq!(found, names, "{name}");
            }
            (Ok(_), Refused(words)) => panic!("{name}: was read, though {words}"),
            (Err(error), Shown(_)) => panic!("{name}: {error}"),
        }
    }
}

#[test]
fn every_hostile_file_of_voxels_is_looked_at() {
    for entry in std::fs::read_dir(folder()).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(FILES.iter().any(|(known, _)| *known == name) || name == "truncated.npz", "{name}");
    }
    let truncated = voxels::read(&folder().join("truncated.npz")).unwrap_err().to_string();
    assert!(truncated.contains("is no .npz file that can be read"), "{truncated}");
}
