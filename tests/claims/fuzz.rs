//! What fuzzing once found stays mended: its corpus is replayed. `cargo run --example fuzz` looks for more.

#[path = "../fuzz/check.rs"]
mod check;

use std::path::Path;
use std::time::{Duration, Instant};

fn replay(reader: &str, check: fn(&[u8]) -> Result<String, String>) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpus").join(reader);
    let (mut accepted, mut refused) = (0, 0);
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let start = Instant::now();
        match check(&std::fs::read(&path).unwrap()) {
            Ok(_) => accepted += 1,
            Err(_) => refused += 1,
        }
        assert!(start.elapsed() < Duration::from_secs(5), "{} took {:?}", path.display(), start.elapsed());
    }
    assert!(accepted > 0 && refused > 0, "the corpus holds both: {accepted} accepted, {refused} refused");
}

#[test]
fn the_model_reader_stands_its_corpus() {
    replay("model", check::model);
}

#[test]
fn the_scene_reader_stands_its_corpus() {
    replay("scene", check::scene);
}

#[test]
fn the_environment_reader_stands_its_corpus() {
    replay("environment", check::environment);
}
