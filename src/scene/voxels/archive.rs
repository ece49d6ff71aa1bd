//! The arrays of an `.npz` file: a zip of `.npy` files, as NumPy writes them.
//!
//! Nothing is allocated because a number in the file says so: memory grows with the bytes that are there, up to a limit,
//! and an array's bytes must be as many as its shape says.

use std::io::{Cursor, Read as _};
use zip::ZipArchive;

/// The most bytes of an array: 512³ cells of two bytes, and its head.
const MAX_ARRAY_BYTES: u64 = (2 << 27) + (1 << 16);
/// The most bytes of an item.
const MAX_ITEM_BYTES: usize = 256;

/// An `.npz` file's arrays.
pub(super) struct Archive<'a> {
    zip: ZipArchive<Cursor<&'a [u8]>>,
}

/// An array of numbers.
pub(super) struct Array<T> {
    /// Its shape; none for a single number.
    pub(super) shape: Vec<u64>,
    /// Last index fastest.
    pub(super) values: Vec<T>,
}

/// One array's bytes and what they mean.
struct Raw {
    head: Head,
    bytes: Vec<u8>,
    data_first: usize,
}

/// What an `.npy` file says of itself.
struct Head {
    /// NumPy's word for the items' type.
    word: String,
    big_endian: bool,
    /// `u` unsigned, `i` signed, `f` float, `b` bool, `S` text.
    kind: char,
    item_bytes: usize,
    fortran: bool,
    shape: Vec<u64>,
}

impl<'a> Archive<'a> {
    pub(super) fn open(bytes: &'a [u8]) -> Result<Self, String> {
        let zip = ZipArchive::new(Cursor::new(bytes))
            .map_err(|e| format!("is no .npz file that can be read: {}; save the voxels again", one_line(&e)))?;
        Ok(Self { zip })
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.zip.index_for_name(&format!("{name}.npy")).is_some()
    }

    /// The numbers of array `name`, each made a `T`; `None` from `convert` refuses the number.
    pub(super) fn numbers<T>(&mut self, name: &str, convert: impl Fn(f64) -> Option<T>) -> Result<Array<T>, String> {
        let raw = self.raw(name)?;
        let Head { word, kind, item_bytes, .. } = &raw.head;
        let decode = decoder(*kind, *item_bytes).ok_or_else(|| {
            format!("array `{name}` holds `{word}`, no plain numbers; save it as whole numbers or floats")
        })?;
        let mut values = Vec::with_capacity((raw.bytes.len() - raw.data_first) / item_bytes);
        for (i, item) in raw.items().enumerate() {
            let mut bytes = [0_u8; 8];
            let bytes = &mut bytes[..item.len()];
            bytes.copy_from_slice(item);
            if raw.head.big_endian {
                bytes.reverse();
            }
            let value = decode(bytes);
            let value = convert(value).ok_or_else(|| format!("array `{name}`: number {i} is {value}; mend it"))?;
            values.push(value);
        }
        Ok(Array { shape: raw.head.shape, values })
    }

    /// The texts of array `name`: byte strings, UTF-8, padded with zeros.
    pub(super) fn texts(&mut self, name: &str) -> Result<Vec<String>, String> {
        let raw = self.raw(name)?;
        if raw.head.kind != 'S' {
            return Err(format!("array `{name}` holds `{}`; save it as byte strings (S)", raw.head.word));
        }
        let text = |item: &[u8]| String::from_utf8_lossy(item).trim_end_matches('\0').to_owned();
        Ok(raw.items().map(text).collect())
    }

    fn raw(&mut self, name: &str) -> Result<Raw, String> {
        let fault = |what: &str| format!("array `{name}` {what}; save the voxels again");
        let entry = self.zip.by_name(&format!("{name}.npy")).map_err(|e| match e {
            zip::result::ZipError::FileNotFound => {
                format!("has no array `{name}`; save the voxels with `murrine voxelize`")
            }
            other => fault(&format!("can't be unpacked: {}", one_line(&other))),
        })?;
        let mut bytes = Vec::new();
        let read = entry.take(MAX_ARRAY_BYTES + 1).read_to_end(&mut bytes);
        read.map_err(|e| fault(&format!("can't be unpacked: {}", one_line(&e))))?;
        if bytes.len() as u64 > MAX_ARRAY_BYTES {
            return Err(format!("array `{name}` is larger than 512³ cells; choose a smaller grid"));
        }
        let (head, data_first) = head(&bytes).map_err(fault)?;
        let items = head.shape.iter().try_fold(1_u64, |all, n| all.checked_mul(*n));
        let said = items.and_then(|n| n.checked_mul(head.item_bytes as u64));
        let there = bytes.len() - data_first;
        if said != Some(there as u64) {
            return Err(fault(&format!("of shape {:?} has {there} bytes, not what its shape says", head.shape)));
        }
        if head.fortran && head.shape.iter().filter(|n| **n > 1).count() > 1 {
            return Err(format!("array `{name}` is in Fortran order; save it in C order (numpy.ascontiguousarray)"));
        }
        Ok(Raw { head, bytes, data_first })
    }
}

impl Raw {
    fn items(&self) -> impl Iterator<Item = &[u8]> {
        self.bytes[self.data_first..].chunks_exact(self.head.item_bytes)
    }
}

/// The head of an `.npy` file and where its data starts: magic, version, length, and a Python dictionary.
fn head(bytes: &[u8]) -> Result<(Head, usize), &'static str> {
    const NO_ARRAY: &str = "is no array";
    let version = bytes.strip_prefix(b"\x93NUMPY").and_then(|rest| rest.first()).ok_or(NO_ARRAY)?;
    let (first, length_bytes) = match version {
        1 => (10, bytes.get(8..10)),
        2 | 3 => (12, bytes.get(8..12)),
        _ => return Err("is of a version that is not known"),
    };
    let length = length_bytes.ok_or(NO_ARRAY)?.iter().rev().fold(0, |n, b| n << 8 | usize::from(*b));
    let text = bytes.get(first..first + length).ok_or("has a header without end")?;
    let text = std::str::from_utf8(text).ok().ok_or(NO_ARRAY)?;
    let value = |key: &str| {
        let (_, rest) = text.split_once(&format!("'{key}'"))?;
        rest.trim_start().strip_prefix(':').map(str::trim_start)
    };
    let word = value("descr").and_then(|v| v.strip_prefix('\'')).and_then(|v| v.split_once('\''));
    let (word, _) = word.ok_or("holds records, no plain numbers")?;
    let fortran = value("fortran_order").ok_or(NO_ARRAY)?.starts_with("True");
    let sides = value("shape").and_then(|v| v.strip_prefix('(')).and_then(|v| v.split_once(')')).ok_or(NO_ARRAY)?.0;
    let sides = sides.split(',').map(str::trim).filter(|side| !side.is_empty());
    let shape = sides.map(|side| side.parse().ok()).collect::<Option<Vec<u64>>>().ok_or(NO_ARRAY)?;
    let mut letters = word.chars();
    let (order, kind) = letters.next().zip(letters.next()).ok_or(NO_ARRAY)?;
    let item_bytes = letters.as_str().parse().ok().filter(|n| (1..=MAX_ITEM_BYTES).contains(n));
    let item_bytes = item_bytes.ok_or("holds no plain items")?;
    let head = Head { word: word.to_owned(), big_endian: order == '>', kind, item_bytes, fortran, shape };
    Ok((head, first + length))
}

/// How a number of this kind is read from its bytes, lowest first.
fn decoder(kind: char, bytes: usize) -> Option<fn(&[u8]) -> f64> {
    fn array<const N: usize>(bytes: &[u8]) -> [u8; N] {
        std::array::from_fn(|i| bytes.get(i).copied().unwrap_or(0))
    }
    #[expect(clippy::cast_precision_loss, reason = "whole numbers beyond 2⁵³ are refused by their range")]
    Some(match (kind, bytes) {
        ('b' | 'u', 1) => |b| f64::from(b[0]),
        ('u', 2) => |b| f64::from(u16::from_le_bytes(array(b))),
        ('u', 4) => |b| f64::from(u32::from_le_bytes(array(b))),
        ('u', 8) => |b| u64::from_le_bytes(array(b)) as f64,
        ('i', 1) => |b| f64::from(i8::from_le_bytes(array(b))),
        ('i', 2) => |b| f64::from(i16::from_le_bytes(array(b))),
        ('i', 4) => |b| f64::from(i32::from_le_bytes(array(b))),
        ('i', 8) => |b| i64::from_le_bytes(array(b)) as f64,
        ('f', 4) => |b| f64::from(f32::from_le_bytes(array(b))),
        ('f', 8) => |b| f64::from_le_bytes(array(b)),
        _ => return None,
    })
}

fn one_line(error: &dyn std::fmt::Display) -> String {
    error.to_string().lines().next().unwrap_or_default().chars().take(200).collect()
}
