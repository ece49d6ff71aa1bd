//! Reads accessors: every index, size and offset is checked against the bytes that are there before anything is
//! allocated or read.

use super::container::Container;
use super::document::{Accessor, Document};
use std::borrow::Cow;
use std::cell::{Cell, OnceCell};

/// The type of one component, and how many bytes it has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn from_code(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// A component as a number; `normalized` integers are fractions of their greatest value (glTF 2.0 §3.11).
    fn number(self, bytes: &[u8], normalized: bool) -> f32 {
        let fraction = |value: f32, greatest: f32| if normalized { (value / greatest).max(-1.0) } else { value };
        match (self, bytes) {
            (Self::I8, &[a]) => fraction(f32::from(i8::from_le_bytes([a])), 127.0),
            (Self::U8, &[a]) => fraction(f32::from(a), 255.0),
            (Self::I16, &[a, b]) => fraction(f32::from(i16::from_le_bytes([a, b])), 32767.0),
            (Self::U16, &[a, b]) => fraction(f32::from(u16::from_le_bytes([a, b])), 65535.0),
            (Self::F32, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]),
            // Whole numbers of 32 bits are only read as indices.
            _ => f32::NAN,
        }
    }

    fn index(self, bytes: &[u8]) -> u32 {
        match (self, bytes) {
            (Self::U8, &[a]) => u32::from(a),
            (Self::U16, &[a, b]) => u32::from(u16::from_le_bytes([a, b])),
            (Self::U32, &[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]),
            _ => u32::MAX,
        }
    }
}

/// What an accessor says of itself, its type known.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape {
    pub(super) count: usize,
    pub(super) component: Component,
    pub(super) components: usize,
    normalized: bool,
}

/// Elements in a row, `stride` bytes apart, every one of them inside `bytes`.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    count: usize,
}

impl Elements<'_> {
    fn iter(&self) -> impl Iterator<Item = &[u8]> {
        (0..self.count).map(|i| &self.bytes[i * self.stride..i * self.stride + self.size])
    }
}

/// Reads a document's accessors.
pub(super) struct Accessors<'a> {
    document: &'a Document,
    container: &'a Container<'a>,
    buffers: Vec<OnceCell<Cow<'a, [u8]>>>,
    /// Elements that stand for zeros without any bytes behind them: bounded, for a few bytes could ask for gigabytes.
    zeros_left: Cell<usize>,
}

impl<'a> Accessors<'a> {
    pub(super) fn new(document: &'a Document, container: &'a Container<'a>, file_bytes: usize) -> Self {
        let buffers = document.buffers.iter().map(|_| OnceCell::new()).collect();
        Self { document, container, buffers, zeros_left: Cell::new((1 << 16) + 4 * file_bytes) }
    }

    /// The accessor's type and count: its bytes are there, none are read yet.
    pub(super) fn shape(&self, index: usize) -> Result<Shape, String> {
        let (accessor, shape) = self.checked(index)?;
        if let Some(view) = accessor.buffer_view {
            let size = shape.component.bytes() * shape.components;
            let plain = self.view(view, accessor.byte_offset, size, shape.count, true);
            plain.map_err(|e| format!("accessor {index}: {e}"))?;
        } else if shape.count > self.zeros_left.get() {
            return Err(too_many(index, accessor.count));
        }
        Ok(shape)
    }

    fn checked(&self, index: usize) -> Result<(&'a Accessor, Shape), String> {
        let accessors = &self.document.accessors;
        let accessor = accessors.get(index).ok_or_else(|| {
            format!("accessor {index} does not exist, there are {}; export the file again", accessors.len())
        })?;
        let component = Component::from_code(accessor.component_type).ok_or_else(|| {
            format!(
                "accessor {index} has the unknown component type {}; export the file again",
                accessor.component_type
            )
        })?;
        let components = match accessor.kind.as_str() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            other => {
                let shown: String = other.chars().take(20).collect();
                return Err(format!(
                    "accessor {index} has the type `{shown}`, which is read nowhere; export the file again"
                ));
            }
        };
        let count = usize::try_from(accessor.count).ok().ok_or_else(|| too_many(index, accessor.count))?;
        Ok((accessor, Shape { count, component, components, normalized: accessor.normalized }))
    }

    /// All numbers of an accessor of N components: floats, or integers as the accessor says.
    pub(super) fn numbers<const N: usize>(&self, index: usize) -> Result<Vec<[f32; N]>, String> {
        let shape = self.shape(index)?;
        if shape.components != N || shape.component == Component::U32 {
            return Err(format!("accessor {index} has the wrong type for its use; export the file again"));
        }
        self.elements(index, |bytes| {
            let size = shape.component.bytes();
            std::array::from_fn(|i| shape.component.number(&bytes[i * size..(i + 1) * size], shape.normalized))
        })
    }

    /// Unsigned whole numbers of N components, as indices and joints are.
    pub(super) fn indices<const N: usize>(&self, index: usize) -> Result<Vec<[u32; N]>, String> {
        let shape = self.shape(index)?;
        let unsigned = matches!(shape.component, Component::U8 | Component::U16 | Component::U32);
        if shape.components != N || !unsigned || shape.normalized {
            return Err(format!("accessor {index} has the wrong type for its use; export the file again"));
        }
        self.elements(index, |bytes| {
            let size = shape.component.bytes();
            std::array::from_fn(|i| shape.component.index(&bytes[i * size..(i + 1) * size]))
        })
    }

    /// The plain elements and then the sparse ones in their places.
    fn elements<T: Copy>(&self, index: usize, read: impl Fn(&[u8]) -> T) -> Result<Vec<T>, String> {
        let (accessor, shape) = self.checked(index)?;
        let size = shape.component.bytes() * shape.components;
        let fault = |what: String| format!("accessor {index}: {what}");
        let mut values: Vec<T> = if let Some(view) = accessor.buffer_view {
            let plain = self.view(view, accessor.byte_offset, size, shape.count, true).map_err(fault)?;
            plain.iter().map(&read).collect()
        } else {
            let left = self.zeros_left.get().checked_sub(shape.count);
            self.zeros_left.set(left.ok_or_else(|| too_many(index, accessor.count))?);
            vec![read(&vec![0; size]); shape.count]
        };
        if let Some(sparse) = &accessor.sparse {
            let places = Component::from_code(sparse.indices.component_type)
                .filter(|c| matches!(c, Component::U8 | Component::U16 | Component::U32))
                .ok_or_else(|| fault("its sparse indices have an unknown type; export the file again".to_owned()))?;
            let count = usize::try_from(sparse.count).ok().ok_or_else(|| too_many(index, sparse.count))?;
            let (indices, data) = (&sparse.indices, &sparse.values);
            let at =
                self.view(indices.buffer_view, indices.byte_offset, places.bytes(), count, false).map_err(fault)?;
            let of = self.view(data.buffer_view, data.byte_offset, size, count, false).map_err(fault)?;
            for (place, value) in at.iter().zip(of.iter()) {
                let place = places.index(place) as usize;
                let slot = values.get_mut(place).ok_or_else(|| {
                    fault(format!(
                        "its sparse index {place} is past the {} elements; export the file again",
                        shape.count
                    ))
                })?;
                *slot = read(value);
            }
        }
        Ok(values)
    }

    /// `count` elements of `size` bytes each from `offset` in a buffer view.
    fn view(
        &self,
        index: usize,
        offset: u64,
        size: usize,
        count: usize,
        strided: bool,
    ) -> Result<Elements<'_>, String> {
        let views = &self.document.buffer_views;
        let stride = views.get(index).and_then(|v| v.byte_stride).filter(|&s| strided && s > 0);
        let stride = stride.map_or(Some(size), |s| usize::try_from(s).ok()).filter(|&s| s >= size);
        let stride = stride.ok_or_else(|| format!("buffer view {index} packs elements closer than their size"))?;
        let bytes = self.view_bytes(index)?;
        let whole = usize::try_from(offset).ok().and_then(|o| bytes.get(o..));
        let needed = count.checked_sub(1).map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(size));
        match (whole, needed) {
            (Some(whole), Some(needed)) if needed <= whole.len() => Ok(Elements { bytes: whole, stride, size, count }),
            _ => Err(format!(
                "{count} elements of {size} bytes are more than the {} bytes of buffer view {index}; export the file again",
                bytes.len()
            )),
        }
    }

    /// All bytes of a buffer view.
    pub(super) fn view_bytes(&self, index: usize) -> Result<&[u8], String> {
        let views = &self.document.buffer_views;
        let view = views.get(index).ok_or_else(|| {
            format!("buffer view {index} does not exist, there are {}; export the file again", views.len())
        })?;
        let buffer = self.buffer(view.buffer)?;
        let start = usize::try_from(view.byte_offset).ok();
        let end =
            start.zip(usize::try_from(view.byte_length).ok()).and_then(|(start, length)| start.checked_add(length));
        start.zip(end).and_then(|(start, end)| buffer.get(start..end)).ok_or_else(|| {
            let (said, there) = (view.byte_length, buffer.len());
            format!("buffer view {index} of {said} bytes reaches past the {there} of its buffer; export the file again")
        })
    }

    fn buffer(&self, index: usize) -> Result<&[u8], String> {
        let missing = || format!("buffer {index} does not exist; export the file again");
        let cell = self.buffers.get(index).ok_or_else(missing)?;
        if let Some(bytes) = cell.get() {
            return Ok(bytes);
        }
        let bytes = self.container.buffer(index, &self.document.buffers[index])?;
        Ok(cell.get_or_init(|| bytes))
    }
}

fn too_many(index: usize, count: u64) -> String {
    format!("accessor {index} asks for {count} elements that the file has no bytes for; export the file again")
}
