//! Feeds broken files to the readers: `cargo run --example fuzz -- model|scene|environment|voxels [CASES] [SEED]`.
//!
//! Starts from `tests/fuzz/corpus/`, the hostile files and, for scenes, `scenes/`; changes them, and checks what must
//! hold (`check.rs`). An input that leads to an outcome not seen before joins those that are changed further. Everything
//! follows from the seed. A breach, a panic or a case of more than a second ends the run with exit code 1; the input then
//! lies in `target/`, to be mended and kept: `--keep` writes the inputs of new outcomes to the corpus, which the tests
//! replay. `--also=FOLDER` starts from its files too.
#![expect(clippy::panic, reason = "a breach of what must hold ends the case")]

mod check;
mod mutate;

use mutate::Dice;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// A case may take this long.
const PATIENCE: Duration = Duration::from_secs(1);
/// A case that takes this long does not end.
const HANG_SECS: u64 = 20;
/// The largest input that the corpus keeps, bytes.
const MOST_KEPT: usize = 6000;

struct Reader {
    name: &'static str,
    seeds: &'static [&'static str],
    check: fn(&[u8]) -> Result<String, String>,
    mutate: fn(&mut Dice, &[u8]) -> Vec<u8>,
}

const READERS: [Reader; 4] = [
    Reader {
        name: "model",
        seeds: &["tests/fuzz/corpus/model", "tests/hostile/models"],
        check: check::model,
        mutate: mutate::model,
    },
    Reader {
        name: "scene",
        seeds: &["tests/fuzz/corpus/scene", "tests/hostile/scenes", "scenes"],
        check: check::scene,
        mutate: mutate::scene,
    },
    Reader {
        name: "environment",
        seeds: &["tests/fuzz/corpus/environment"],
        check: check::environment,
        mutate: mutate::model,
    },
    Reader {
        name: "voxels",
        seeds: &["tests/fuzz/corpus/voxels", "tests/hostile/voxels"],
        check: check::voxels,
        mutate: mutate::voxels,
    },
];

fn main() -> ExitCode {
    let (flags, words): (Vec<String>, Vec<String>) = std::env::args().skip(1).partition(|a| a.starts_with("--"));
    let keep = flags.iter().any(|f| f == "--keep");
    let also: Vec<&str> = flags.iter().filter_map(|f| f.strip_prefix("--also=")).collect();
    let reader = words.first().and_then(|name| READERS.iter().find(|r| r.name == name));
    let number = |i: usize, otherwise: u64| words.get(i).map_or(Some(otherwise), |w| w.parse().ok());
    let (Some(reader), Some(cases), Some(seed)) = (reader, number(1, 100_000), number(2, 1)) else {
        eprintln!("usage: fuzz model|scene|environment [CASES] [SEED] [--keep] [--also=FOLDER]");
        return ExitCode::from(2);
    };
    run(reader, cases, seed, &also, keep)
}

fn run(reader: &Reader, cases: u64, seed: u64, also: &[&str], keep: bool) -> ExitCode {
    let mut pool = seeds(reader);
    for folder in also {
        pool.extend(files_of(Path::new(folder)).iter().filter_map(|f| std::fs::read(f).ok()));
    }
    if pool.is_empty() {
        eprintln!("no seeds in {:?}", reader.seeds);
        return ExitCode::from(2);
    }
    // By outcome, its digits blotted out: the smallest input that leads there.
    let mut outcomes: BTreeMap<String, Vec<u8>> = BTreeMap::new();
    let (begun, current) = (Arc::new(AtomicU64::new(0)), Arc::new(Mutex::new(Vec::new())));
    watch(Arc::clone(&begun), Arc::clone(&current));
    std::panic::set_hook(Box::new(|_| {}));
    let start = Instant::now();
    let mut good: Vec<Vec<u8>> = Vec::new();
    let (mut accepted, mut slowest) = (0_u64, Duration::ZERO);
    let untouched = pool.len() as u64;
    for case in 0..cases + untouched {
        // The seeds themselves come first.
        let input = match usize::try_from(case).ok().filter(|_| case < untouched) {
            Some(i) => pool[i].clone(),
            None => {
                let mut dice = Dice::of_case(seed, case);
                // Mostly from what was accepted: changes of those reach deeper.
                let from = if dice.below(4) > 0 { &good } else { &pool };
                let from = if from.is_empty() { &pool } else { from };
                let from = &from[dice.below(from.len())];
                (reader.mutate)(&mut dice, from)
            }
        };
        if let Ok(mut current) = current.lock() {
            current.clone_from(&input);
        }
        begun.store(seconds_since_epoch(), Ordering::Relaxed);
        let began = Instant::now();
        let outcome = std::panic::catch_unwind(|| (reader.check)(&input));
        let took = began.elapsed();
        slowest = slowest.max(took);
        let told = match outcome {
            Ok(Ok(notable)) => {
                accepted += 1;
                let told = format!("accepted: {}", blotted(&notable));
                if case < untouched || !outcomes.contains_key(&told) {
                    good.push(input.clone());
                }
                told
            }
            Ok(Err(told)) => blotted(&told),
            Err(panic) => return fail(&input, &format!("case {case} panicked: {}", words_of(&*panic))),
        };
        if took > PATIENCE {
            return fail(&input, &format!("case {case} took {took:?}"));
        }
        let known = outcomes.get(&told).map(Vec::len);
        if known.is_none() {
            pool.push(input.clone());
        }
        if known.is_none_or(|size| size > input.len()) {
            outcomes.insert(told, input);
        }
    }
    eprintln!(
        "{}: {cases} cases in {:.0} s, {accepted} accepted, {} outcomes, slowest {slowest:?}",
        reader.name,
        start.elapsed().as_secs_f64(),
        outcomes.len()
    );
    if keep { keep_new(reader, &outcomes) } else { ExitCode::SUCCESS }
}

fn seeds(reader: &Reader) -> Vec<Vec<u8>> {
    let files = reader.seeds.iter().flat_map(|folder| files_of(&root().join(folder)));
    files.filter_map(|f| std::fs::read(f).ok()).collect()
}

/// The files of a folder, in order.
fn files_of(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    let mut files: Vec<PathBuf> = entries.filter_map(Result::ok).map(|e| e.path()).filter(|p| p.is_file()).collect();
    files.sort();
    files
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// An outcome without its particulars, so that the same complaint about another number is no news.
fn blotted(told: &str) -> String {
    let mut quoted = false;
    let mut kept = String::new();
    for c in told.chars().take(300) {
        if c == '`' {
            quoted = !quoted;
        }
        if !c.is_ascii_digit() && (!quoted || c == '`') {
            kept.push(c);
        }
    }
    kept
}

fn words_of(panic: &(dyn std::any::Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("without a word")
}

/// Writes the input down and says what went wrong.
fn fail(input: &[u8], what: &str) -> ExitCode {
    let path = root().join("target/fuzz-failure");
    let kept = std::fs::write(&path, input).map_or_else(|e| e.to_string(), |()| path.display().to_string());
    eprintln!("{what}\nthe input: {kept}");
    ExitCode::FAILURE
}

/// Ends the program when a case hangs.
fn watch(begun: Arc<AtomicU64>, current: Arc<Mutex<Vec<u8>>>) {
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(Duration::from_secs(2));
            let since = begun.load(Ordering::Relaxed);
            if since > 0 && seconds_since_epoch().saturating_sub(since) > HANG_SECS {
                let input = current.lock().map(|c| c.clone()).unwrap_or_default();
                let _ = fail(&input, "a case does not end");
                std::process::exit(1);
            }
        }
    });
}

fn seconds_since_epoch() -> u64 {
    std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).map_or(0, |d| d.as_secs())
}

/// Writes the small inputs of outcomes that the seeds alone don't lead to.
fn keep_new(reader: &Reader, outcomes: &BTreeMap<String, Vec<u8>>) -> ExitCode {
    let told = |seed: &Vec<u8>| match (reader.check)(seed) {
        Ok(notable) => format!("accepted: {}", blotted(&notable)),
        Err(told) => blotted(&told),
    };
    let known: Vec<String> = seeds(reader).iter().map(told).collect();
    let folder = root().join(reader.seeds[0]);
    let mut kept = 0;
    let few_words = |told: &str| told.matches(", ").count() < 2;
    let small = |told: &str, input: &[u8]| few_words(told) && input.len() <= MOST_KEPT;
    for (told, input) in outcomes.iter().filter(|(told, input)| !known.contains(told) && small(told, input)) {
        let name =
            told.bytes().fold(0xCBF2_9CE4_8422_2325_u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x100_0000_01B3));
        if let Err(e) = std::fs::write(folder.join(format!("{name:016x}")), input) {
            eprintln!("can't keep an input: {e}");
            return ExitCode::FAILURE;
        }
        kept += 1;
    }
    eprintln!("{kept} inputs kept in {}", folder.display());
    ExitCode::SUCCESS
}
