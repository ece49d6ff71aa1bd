//! Broken files end in an error of one line or in something whole, never in a panic or a hang.
//!
//! What fuzzing once found stays mended: its corpus is replayed; and some fresh cases follow. `make fuzz` tries 100,000.

#[path = "../fuzz/check.rs"]
mod check;
#[path = "../fuzz/mutate.rs"]
mod mutate;

use mutate::Dice;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// No input of this size may take longer.
const PATIENCE: Duration = Duration::from_secs(5);

type Check = fn(&[u8]) -> Result<String, String>;

fn files_of(folders: &[&str]) -> Vec<Vec<u8>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let entries = folders.iter().flat_map(|folder| std::fs::read_dir(root.join(folder)).unwrap());
    let mut paths: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).filter(|p| p.is_file()).collect();
    paths.sort();
    paths.iter().map(|path| std::fs::read(path).unwrap()).collect()
}

/// Tries inputs; tells those that were accepted, and how many were refused.
fn tried(inputs: Vec<Vec<u8>>, check: Check) -> (Vec<Vec<u8>>, usize) {
    let all = inputs.len();
    let mut accepted = Vec::new();
    for input in inputs {
        let started = Instant::now();
        let outcome = check(&input);
        let took = started.elapsed();
        assert!(took < PATIENCE, "{took:?} for\n{}", String::from_utf8_lossy(&input));
        if outcome.is_ok() {
            accepted.push(input);
        }
    }
    let refused = all - accepted.len();
    (accepted, refused)
}

/// Replays a reader's files, then damages those that it accepts in `cases` ways.
fn stands(folders: &[&str], check: Check, mutate: fn(&mut Dice, &[u8]) -> Vec<u8>, cases: u64) {
    let (good, refused) = tried(files_of(folders), check);
    assert!(!good.is_empty() && refused > 0, "the files hold both: {} accepted, {refused} refused", good.len());
    let fresh = (0..cases).map(|case| {
        let mut dice = Dice::of_case(1, case);
        let from = dice.below(good.len());
        mutate(&mut dice, &good[from])
    });
    let (accepted, refused) = tried(fresh.collect(), check);
    assert!(accepted.len() * 10 > refused, "only {} damaged files were good: nothing was tried", accepted.len());
    assert!(refused > 0, "no damage was noticed");
}

#[test]
fn the_model_reader_stands_its_corpus_and_fresh_damage() {
    stands(&["tests/fuzz/corpus/model"], check::model, mutate::model, 500);
}

#[test]
fn the_scene_reader_stands_its_corpus_and_fresh_damage() {
    let folders = ["tests/fuzz/corpus/scene", "tests/hostile/scenes", "scenes"];
    stands(&folders, check::scene, mutate::scene, 2000);
}

#[test]
fn the_environment_reader_stands_its_corpus_and_fresh_damage() {
    stands(&["tests/fuzz/corpus/environment"], check::environment, mutate::model, 200);
}

#[test]
fn the_reader_of_saved_voxels_stands_its_corpus_and_fresh_damage() {
    stands(&["tests/fuzz/corpus/voxels", "tests/hostile/voxels"], check::voxels, mutate::voxels, 500);
}
