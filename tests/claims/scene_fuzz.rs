//! Damaged scene texts and assignments end in an error or in a scene that survives writing and reading: never in a
//! panic or a hang.
//!
//! The corpus is every scene that ships and every hostile one; what once broke the reader is kept among the latter.
//! `MURRINE_FUZZ_CASES=100000 cargo test scene_fuzz` runs longer; `MURRINE_FUZZ_SEED` chooses other cases.

use murrine::scene::file;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Cases in the ordinary run of the tests.
const CASES: u64 = 3_000;
/// No text of this size may take longer.
const PATIENCE: Duration = Duration::from_secs(5);

const METHODS: &[&str] = &["cpu-exact", "hybrid", "triangle-parallel"];

/// Pieces that matter to the format, or to those who write numbers badly.
const PIECES: &[&str] = &[
    "nan",
    "inf",
    "-inf",
    "-1",
    "0",
    "1e999",
    "9223372036854775807",
    "-0.0",
    "1e-45",
    "[[",
    "]]",
    "[",
    "]",
    "{",
    "}",
    "\"",
    "\"\"\"",
    "'''",
    "=",
    ".",
    ",",
    "#",
    "\n",
    "\r\n",
    "\0",
    "\u{feff}",
    "é",
    "🐟",
    "[[model]]\n",
    "[model]\n",
    "[[model.material]]\n",
    "[[model.deformer]]\n",
    "[effect]\n",
    "[grid]\n",
    "[camera]\n",
    "cells = ",
    "kind = ",
    "shape = ",
    "file = ",
    "name = ",
    "true",
    "\"box\"",
    "\"plane\"",
    "\"wave\"",
    "\"spot\"",
    "\"../../x.glb\"",
    "[1, 2, 3]",
    "[16, 16, 16]",
    "{ shape = \"box\" }",
    "frame = true\n",
    "1979-05-27T07:32:00Z",
    "0x7fffffff",
    "1_000",
];

/// A small generator of its own (xorshift), so that a case can be run again by its seed.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, n: usize) -> usize {
        usize::try_from(self.next() % u64::try_from(n.max(1)).unwrap()).unwrap()
    }

    fn pick<'a, T: ?Sized>(&mut self, items: &[&'a T]) -> &'a T {
        items[self.below(items.len())]
    }

    fn damage(&mut self, text: &mut Vec<u8>, corpus: &[&str]) {
        let at = self.below(text.len() + 1);
        let end = (at + self.below(40)).min(text.len());
        match self.below(7) {
            0 => text.truncate(at),
            1 => drop(text.drain(at..end)),
            2 => {
                let copy = text[at..end].to_vec();
                text.splice(at..at, copy);
            }
            3 if at < text.len() => text[at] ^= 1 << self.below(8),
            4 => {
                let other = self.pick(corpus).as_bytes();
                let from = self.below(other.len());
                let to = (from + self.below(120)).min(other.len());
                text.splice(at..end, other[from..to].to_vec());
            }
            _ => drop(text.splice(at..end, self.pick(PIECES).bytes())),
        }
    }

    fn assignment(&mut self) -> String {
        let steps =
            ["model", "light", "camera", "effect", "grid", "material", "deformer", "0", "1", "99", "eye", "name"];
        let mut path: Vec<&str> = (0..=self.below(4)).map(|_| self.pick(&steps)).collect();
        if self.below(8) == 0 {
            path.push(self.pick(PIECES));
        }
        format!("{}={}", path.join("."), self.pick(PIECES))
    }
}

/// Every text, and how many of them are good.
fn corpus() -> (Vec<String>, usize) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut paths: Vec<PathBuf> = ["scenes", "tests/hostile/scenes"]
        .iter()
        .flat_map(|folder| std::fs::read_dir(root.join(folder)).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    paths.sort();
    let good = paths.iter().filter(|path| path.starts_with(root.join("scenes"))).count();
    (paths.iter().map(|path| String::from_utf8_lossy(&std::fs::read(path).unwrap()).into_owned()).collect(), good)
}

fn number_from(variable: &str, default: u64) -> u64 {
    std::env::var(variable).map_or(default, |text| text.parse().unwrap_or_else(|e| panic!("{variable}: {e}")))
}

#[test]
fn damaged_scenes_never_panic_and_good_ones_survive_writing() {
    let (corpus, good) = corpus();
    let corpus: Vec<&str> = corpus.iter().map(String::as_str).collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/fuzz.toml");
    let seed = number_from("MURRINE_FUZZ_SEED", 1);
    let mut accepted = 0_u64;
    let cases = number_from("MURRINE_FUZZ_CASES", CASES);
    for case in 0..cases {
        let mut chance = Chance((seed << 32 | case).wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        let start = if chance.below(3) > 0 { &corpus[..good] } else { &corpus[good..] };
        let mut bytes = chance.pick(start).as_bytes().to_vec();
        for _ in 0..chance.below(4) {
            chance.damage(&mut bytes, &corpus);
        }
        let mut text = String::from_utf8_lossy(&bytes).into_owned();
        let started = Instant::now();
        if chance.below(2) == 0
            && let Ok(changed) = file::set(&text, &chance.assignment())
        {
            text = changed;
        }
        if let Ok((scene, _)) = file::parse(&text, &path, METHODS) {
            accepted += 1;
            let written = file::to_toml(&scene);
            let again = file::parse(&written, &path, METHODS);
            let (again, _) = again.unwrap_or_else(|e| panic!("case {case}: {e}\n{written}\nfrom\n{text}"));
            assert_eq!(scene, again, "case {case}: {written}\nfrom\n{text}");
        }
        assert!(started.elapsed() < PATIENCE, "case {case} took {:?}:\n{text}", started.elapsed());
    }
    assert!(accepted * 10 > cases, "only {accepted} of {cases} damaged scenes were good: nothing was tried");
    assert!(accepted < cases, "no damage was noticed");
}
