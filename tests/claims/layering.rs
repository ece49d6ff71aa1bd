//! Imports only go down: a module of the house uses those that `lib.rs` lists before it, never those after.

use std::path::{Path, PathBuf};

/// Module names in the order of `lib.rs`.
fn order() -> Vec<String> {
    let text = std::fs::read_to_string(source().join("lib.rs")).unwrap();
    let names = text.lines().filter_map(|l| l.strip_prefix("pub mod ")?.strip_suffix(';'));
    names.map(str::to_owned).collect()
}

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// The modules that `text` names as `crate::…`, doc comments left out: they may point anywhere.
fn imports(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let line = line.split("//").next().unwrap_or("");
        for (at, _) in line.match_indices("crate::") {
            if at > 0 && line.as_bytes()[at - 1] == b'$' {
                continue;
            }
            let rest = &line[at + "crate::".len()..];
            let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            found.push((number + 1, name));
        }
    }
    found
}

/// Imports of `module`'s text that go up.
fn upward(order: &[String], module: &str, text: &str) -> Vec<(usize, String)> {
    let rank = |name: &str| order.iter().position(|m| m == name);
    let own = rank(module).unwrap_or_else(|| panic!("`{module}` is not listed in lib.rs"));
    imports(text).into_iter().filter(|(_, name)| rank(name).is_some_and(|r| r > own)).collect()
}

#[test]
fn no_module_imports_one_that_comes_later() {
    let order = order();
    assert!(order.len() > 10, "lib.rs lists the house");
    let mut found = Vec::new();
    files(&source(), &mut found);
    let mut faults = Vec::new();
    for path in found {
        let relative = path.strip_prefix(source()).unwrap();
        let module = relative.components().next().unwrap().as_os_str().to_string_lossy();
        let module = module.trim_end_matches(".rs");
        if module == "lib" || module == "main" {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        for (line, name) in upward(&order, module, &text) {
            faults.push(format!("src/{}:{line}: `{module}` uses `{name}`, which comes later", relative.display()));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn an_upward_import_is_found() {
    let order = order();
    assert_eq!(upward(&order, "grid", "use crate::march::March;"), [(1, "march".to_owned())]);
    assert_eq!(upward(&order, "march", "use crate::grid::Grid; // crate::app"), []);
}
