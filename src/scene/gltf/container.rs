//! The bytes around a document: the binary container, data URIs, and files beside it.
//!
//! A document may only name files inside its own folder: no `..`, no absolute path, no other scheme, and no link that
//! leads out. Nothing is allocated because a number in the file says so: sizes are those of bytes that are there.

use super::document::Buffer;
use std::borrow::Cow;
use std::cell::{Cell, RefCell};
use std::path::{Component, Path, PathBuf};

/// The largest file that is read.
pub(in crate::scene) const MAX_FILE_BYTES: u64 = 2 << 30;
/// The most bytes that all files beside a document may have together.
const MAX_EXTERNAL_BYTES: u64 = 2 << 30;

/// The JSON and the binary chunk of a `.glb`, or all of a `.gltf` and nothing.
pub(super) fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    if !bytes.starts_with(b"glTF") {
        // A byte order mark is against the specification, but harmless.
        return Ok((bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes), None));
    }
    let word = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
    let truncated = || format!("cut off after {} bytes; copy the file again", bytes.len());
    let version = word(4).ok_or_else(truncated)?;
    if version != 2 {
        return Err(format!("binary glTF version {version}; only version 2 can be read, convert the file"));
    }
    let length = word(8).ok_or_else(truncated)? as usize;
    if length > bytes.len() {
        return Err(format!("cut off: {} of {length} bytes are there; copy the file again", bytes.len()));
    }
    let (mut json, mut binary) = (None, None);
    let mut at = 12;
    while at < length {
        let (size, kind) = (word(at).ok_or_else(truncated)?, word(at + 4).ok_or_else(truncated)?);
        let end = (at + 8).checked_add(size as usize).filter(|&end| end <= length).ok_or_else(|| {
            format!("the chunk at byte {at} says {size} bytes, more than the file has; export the file again")
        })?;
        let chunk = &bytes[at + 8..end];
        match &kind.to_le_bytes() {
            b"JSON" if json.is_none() => json = Some(chunk),
            b"BIN\0" if binary.is_none() => binary = Some(chunk),
            _ => {}
        }
        at = end;
    }
    let json = json.ok_or("the binary container has no JSON chunk; export the file again")?;
    Ok((json, binary))
}

/// Where a document's bytes come from.
pub(super) struct Container<'a> {
    folder: Option<&'a Path>,
    binary: Option<&'a [u8]>,
    files: RefCell<Vec<PathBuf>>,
    external_bytes: Cell<u64>,
}

impl<'a> Container<'a> {
    /// `folder` is where files are looked for, `None` where the document has no place; `binary` the `.glb`'s own chunk.
    pub(super) fn new(folder: Option<&'a Path>, binary: Option<&'a [u8]>) -> Self {
        Self { folder, binary, files: RefCell::default(), external_bytes: Cell::new(0) }
    }

    /// Files beside the document that were read.
    pub(super) fn into_files(self) -> Vec<PathBuf> {
        self.files.into_inner()
    }

    /// A buffer's bytes: at least as many as it declares.
    pub(super) fn buffer(&self, index: usize, buffer: &Buffer) -> Result<Cow<'a, [u8]>, String> {
        let bytes = match (&buffer.uri, self.binary) {
            (Some(uri), _) => Cow::Owned(self.uri(uri).map_err(|e| format!("buffer {index}: {e}"))?),
            (None, Some(binary)) if index == 0 => Cow::Borrowed(binary),
            _ => return Err(format!("buffer {index} has no bytes; export the file again")),
        };
        if (bytes.len() as u64) < buffer.byte_length {
            let (there, said) = (bytes.len(), buffer.byte_length);
            return Err(format!("buffer {index} says {said} bytes, {there} are there; export the file again"));
        }
        Ok(bytes)
    }

    /// The bytes that a URI stands for.
    pub(super) fn uri(&self, uri: &str) -> Result<Vec<u8>, String> {
        if let Some(rest) = strip_prefix_ignoring_case(uri, "data:") {
            let (kind, data) = rest.split_once(',').ok_or("a data URI without a comma; export the file again")?;
            if !kind.ends_with(";base64") {
                return Err("a data URI that is not base64; export the file again".to_owned());
            }
            return base64(data).ok_or_else(|| "a data URI with broken base64; export the file again".to_owned());
        }
        let path = self.inside(uri)?;
        let left = MAX_EXTERNAL_BYTES - self.external_bytes.get();
        let bytes = read_file(&path, left).map_err(|e| format!("`{uri}` {e}"))?;
        self.external_bytes.set(MAX_EXTERNAL_BYTES.min(self.external_bytes.get() + bytes.len() as u64));
        self.files.borrow_mut().push(path);
        Ok(bytes)
    }

    /// The file that a relative URI names, if it lies inside the folder.
    fn inside(&self, uri: &str) -> Result<PathBuf, String> {
        let shown: String = uri.chars().take(100).collect();
        let outside = || format!("`{shown}` is not a file in the model's folder; put it there and name it relatively");
        let folder = self.folder.ok_or_else(outside)?;
        let name = percent_decoded(uri).ok_or_else(outside)?;
        let plain = Path::new(&name).components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
        if !plain || name.is_empty() || name.contains([':', '\\', '\0']) {
            return Err(outside());
        }
        let path = folder.join(&name);
        let found =
            path.canonicalize().map_err(|e| format!("`{shown}` can't be read: {e}; put it beside the model"))?;
        let home = folder.canonicalize().map_err(|e| format!("the model's folder can't be read: {e}"))?;
        if found.starts_with(home) { Ok(path) } else { Err(outside()) }
    }
}

/// Reads a plain file of at most `limit` bytes.
pub(in crate::scene) fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, String> {
    let meta = std::fs::metadata(path).map_err(|e| format!("can't be read: {e}"))?;
    if !meta.is_file() {
        return Err("is no file; name a .glb or .gltf file".to_owned());
    }
    if meta.len() > limit {
        return Err(format!("has {} bytes, at most {limit} can be read; make it smaller", meta.len()));
    }
    std::fs::read(path).map_err(|e| format!("can't be read: {e}"))
}

fn strip_prefix_ignoring_case<'a>(text: &'a str, prefix: &str) -> Option<&'a str> {
    let head = text.get(..prefix.len())?;
    head.eq_ignore_ascii_case(prefix).then(|| &text[prefix.len()..])
}

fn percent_decoded(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.bytes();
    while let Some(byte) = rest.next() {
        if byte == b'%' {
            let digits = [rest.next()?, rest.next()?];
            bytes.push(u8::from_str_radix(std::str::from_utf8(&digits).ok()?, 16).ok()?);
        } else {
            bytes.push(byte);
        }
    }
    String::from_utf8(bytes).ok()
}

/// Standard base64 with or without padding; white space is passed over.
fn base64(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 3);
    let (mut bits, mut count) = (0_u32, 0_u32);
    for c in text.bytes() {
        let value = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            b'=' => break,
            b' ' | b'\n' | b'\r' | b'\t' => continue,
            _ => return None,
        };
        bits = bits << 6 | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count & 0xFF).to_le_bytes()[0]);
            bits &= (1 << count) - 1;
        }
    }
    Some(bytes)
}
