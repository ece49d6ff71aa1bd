//! Shader sources: embedded or from a folder, joined by `#include`, parsed and validated by naga.
//!
//! `#include "lib/grid.inc.wgsl"` stands at the top of a file, before anything but comments and other includes. Each
//! file is taken in once however often it is named. Errors are told at the file, line and column they stem from.

use super::GpuError;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use wgpu::naga;

const EMBEDDED: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/shaders.rs"));

/// Where shader sources come from.
#[derive(Debug, Clone, Default)]
pub enum ShaderLibrary {
    /// Built into the program.
    #[default]
    Embedded,
    /// Read from a folder each time, for hot reload.
    Folder(PathBuf),
}

/// A shader whose includes are resolved and that naga has parsed and validated.
#[derive(Debug)]
pub struct Shader {
    /// The file's name under `shaders/`.
    pub name: String,
    /// The joined text.
    pub source: String,
    /// naga's module, for reflection.
    pub module: naga::Module,
    /// naga's analysis of it.
    pub info: naga::valid::ModuleInfo,
    lines: LineMap,
}

/// For each line of the joined text, the file and the line it came from.
type LineMap = Vec<(String, u32)>;

impl ShaderLibrary {
    /// Names of all shaders and includes, sorted.
    ///
    /// # Errors
    /// When the folder can't be read.
    pub fn names(&self) -> Result<Vec<String>, GpuError> {
        match self {
            Self::Embedded => Ok(EMBEDDED.iter().map(|(name, _)| (*name).to_owned()).collect()),
            Self::Folder(root) => {
                let mut names = Vec::new();
                list(root, root, &mut names).map_err(|e| GpuError::Shader(format!("{}: {e}", root.display())))?;
                names.sort();
                Ok(names)
            }
        }
    }

    fn text(&self, name: &str) -> Option<String> {
        match self {
            Self::Embedded => EMBEDDED.iter().find(|(n, _)| *n == name).map(|(_, text)| (*text).to_owned()),
            Self::Folder(root) => std::fs::read_to_string(root.join(name)).ok(),
        }
    }

    /// Resolves, parses and validates every shader.
    ///
    /// # Errors
    /// What is wrong with the first that is wrong.
    pub fn check_all(&self) -> Result<(), GpuError> {
        for name in self.names()?.iter().filter(|name| !name.ends_with(".inc.wgsl")) {
            self.load(name)?;
        }
        Ok(())
    }

    /// Resolves, parses and validates the shader `name`.
    ///
    /// # Errors
    /// `file:line:column: what is wrong`, at the file where it is wrong.
    pub fn load(&self, name: &str) -> Result<Shader, GpuError> {
        let mut source = String::new();
        let mut lines = LineMap::new();
        let mut seen = BTreeMap::new();
        self.join(name, None, &mut source, &mut lines, &mut seen)?;
        let module = naga::front::wgsl::parse_str(&source).map_err(|e| {
            let at = e.location(&source).map(|l| (l.line_number, l.line_position));
            GpuError::Shader(format!("{}: {}", place(&lines, name, at), e.message()))
        })?;
        let info =
            naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::default())
                .validate(&module)
                .map_err(|e| {
                    let at = e.location(&source).map(|l| (l.line_number, l.line_position));
                    let mut text = format!("{}: {}", place(&lines, name, at), e.as_inner());
                    let mut cause = std::error::Error::source(e.as_inner());
                    while let Some(inner) = cause {
                        text.push_str(": ");
                        text.push_str(&inner.to_string());
                        cause = inner.source();
                    }
                    GpuError::Shader(text)
                })?;
        Ok(Shader { name: name.to_owned(), source, module, info, lines })
    }

    fn join(
        &self,
        name: &str,
        from: Option<(&str, u32)>,
        source: &mut String,
        lines: &mut LineMap,
        seen: &mut BTreeMap<String, ()>,
    ) -> Result<(), GpuError> {
        if seen.insert(name.to_owned(), ()).is_some() {
            return Ok(());
        }
        let text = self.text(name).ok_or_else(|| {
            let at = from.map_or_else(String::new, |(file, line)| format!("{file}:{line}:1: "));
            GpuError::Shader(format!("{at}there is no shader `{name}` under shaders/"))
        })?;
        let mut in_head = true;
        for (index, line) in text.lines().enumerate() {
            let number = u32::try_from(index + 1).unwrap_or(u32::MAX);
            let trimmed = line.trim();
            if let Some(rest) = trimmed.strip_prefix("#include") {
                let target = rest.trim().strip_prefix('"').and_then(|r| r.strip_suffix('"'));
                let Some(target) = target.filter(|_| in_head) else {
                    return Err(GpuError::Shader(format!(
                        "{name}:{number}:1: write `#include \"file\"` at the top of the file"
                    )));
                };
                self.join(target, Some((name, number)), source, lines, seen)?;
                source.push('\n');
            } else {
                in_head &= trimmed.is_empty() || trimmed.starts_with("//");
                source.push_str(line);
                source.push('\n');
            }
            lines.push((name.to_owned(), number));
        }
        Ok(())
    }
}

impl Shader {
    /// Turns a line and column of the joined text into `file:line:column`.
    #[must_use]
    pub fn place(&self, line: u32, column: u32) -> String {
        place(&self.lines, &self.name, Some((line, column)))
    }
}

fn place(lines: &LineMap, name: &str, at: Option<(u32, u32)>) -> String {
    match at.and_then(|(line, column)| lines.get(line.saturating_sub(1) as usize).map(|l| (l, column))) {
        Some(((file, line), column)) => format!("shaders/{file}:{line}:{column}"),
        None => format!("shaders/{name}"),
    }
}

fn list(root: &Path, folder: &Path, names: &mut Vec<String>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            list(root, &path, names)?;
        } else if path.extension().is_some_and(|e| e == "wgsl") {
            let name = path.strip_prefix(root).unwrap_or(&path);
            names.push(name.to_string_lossy().replace('\\', "/"));
        }
    }
    Ok(())
}
