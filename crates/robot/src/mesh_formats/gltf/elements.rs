//! Elements of a glTF accessor, read one at a time from its buffer, without allocation for unused ones.

use std::cmp::Ordering;

use super::buffers::Buffers;
use super::document::{Accessor, Document, Sparse};

/// Extensions of buffer views that store elements compressed.
const COMPRESSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Storage type of a number, by the constants of OpenGL.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

/// Elements in sequence, `stride` bytes apart.
#[derive(Debug)]
struct Strided {
    buffer: usize,
    offset: usize,
    stride: usize,
}

/// An accessor whose range was checked against its buffer.
#[derive(Debug)]
pub struct Elements {
    pub count: usize,
    component: Component,
    normalized: bool,
    /// Numbers of an element.
    width: usize,
    /// `None` for zeros.
    place: Option<Strided>,
    sparse: Option<Replaced>,
}

/// Sparse elements: their indices, in increasing order, and their values.
#[derive(Debug)]
struct Replaced {
    count: usize,
    kind: Component,
    numbers: Strided,
    values: Strided,
}

impl Component {
    fn from_number(number: u32) -> Result<Self, String> {
        Ok(match number {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            other => return Err(format!("componentType {other} is none of glTF")),
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    fn read(self, bytes: &[u8], normalized: bool) -> Option<f64> {
        let largest = match self {
            _ if !normalized => 1.0,
            Self::I8 => f64::from(i8::MAX),
            Self::U8 => f64::from(u8::MAX),
            Self::I16 => f64::from(i16::MAX),
            Self::U16 => f64::from(u16::MAX),
            Self::U32 | Self::F32 => 1.0,
        };
        let number: f64 = match self {
            Self::I8 => i8::from_le_bytes(*bytes.first_chunk()?).into(),
            Self::U8 => u8::from_le_bytes(*bytes.first_chunk()?).into(),
            Self::I16 => i16::from_le_bytes(*bytes.first_chunk()?).into(),
            Self::U16 => u16::from_le_bytes(*bytes.first_chunk()?).into(),
            Self::U32 => u32::from_le_bytes(*bytes.first_chunk()?).into(),
            Self::F32 => f32::from_le_bytes(*bytes.first_chunk()?).into(),
        };
        // the smallest signed integer counts as -1 like its neighbour
        Some(if normalized && number < -largest { -1.0 } else { number / largest })
    }
}

impl Elements {
    /// Positions: three numbers, floats or, with KHR_mesh_quantization, integers.
    pub fn positions(document: &Document, index: usize, buffers: &mut Buffers) -> Result<Self, String> {
        let elements = Self::open(document, index, "VEC3", buffers)?;
        match elements.component {
            Component::U32 => Err(format!("accessor {index}: positions are no unsigned integers of 32 bits")),
            _ => Ok(elements),
        }
    }

    /// Indices of vertices: unsigned integers.
    pub fn indices(document: &Document, index: usize, buffers: &mut Buffers) -> Result<Self, String> {
        let elements = Self::open(document, index, "SCALAR", buffers)?;
        match elements.component {
            Component::U8 | Component::U16 | Component::U32 => Ok(Self { normalized: false, ..elements }),
            _ => Err(format!("accessor {index}: indices are unsigned integers of 8, 16 or 32 bits")),
        }
    }

    fn open(document: &Document, index: usize, kind: &str, buffers: &mut Buffers) -> Result<Self, String> {
        let Some(accessor) = document.accessors.get(index) else {
            return Err(format!("names accessor {index}, but there are {}", document.accessors.len()));
        };
        let named = |reason: String| format!("accessor {index}: {reason}");
        if accessor.kind != kind {
            return Err(named(format!("its type must be {kind}")));
        }
        Self::of(document, accessor, if kind == "VEC3" { 3 } else { 1 }, buffers).map_err(named)
    }

    fn of(
        document: &Document,
        accessor: &Accessor,
        width: usize,
        buffers: &mut Buffers,
    ) -> Result<Self, String> {
        let component = Component::from_number(accessor.component_type)?;
        let count = accessor.count;
        let place = match accessor.buffer_view {
            Some(view) => {
                let size = width * component.size();
                let range = ElementRange { offset: accessor.byte_offset, count, size };
                Some(Strided::open(document, view, range, buffers)?)
            }
            // zeros take no bytes, so the count has no other limit
            None if count > buffers.total() => {
                return Err(format!("says {count} elements, more than the buffers have bytes"));
            }
            None => None,
        };
        let normalized = accessor.normalized;
        let mut elements = Self { count, component, normalized, width, place, sparse: None };
        if let Some(sparse) = &accessor.sparse {
            let replaced =
                elements.replaced(document, sparse, buffers).map_err(|e| format!("sparse: {e}"))?;
            elements.sparse = Some(replaced);
        }
        Ok(elements)
    }

    fn replaced(
        &self,
        document: &Document,
        sparse: &Sparse,
        buffers: &mut Buffers,
    ) -> Result<Replaced, String> {
        let (count, of) = (sparse.count, self.count);
        if count > of {
            return Err(format!("replaces {count} elements, but there are {of}"));
        }
        let kind = Component::from_number(sparse.indices.component_type.unwrap_or_default())?;
        if !matches!(kind, Component::U8 | Component::U16 | Component::U32) {
            return Err("its indices are unsigned integers of 8, 16 or 32 bits".to_owned());
        }
        let numbers = ElementRange { offset: sparse.indices.byte_offset, count, size: kind.size() };
        let numbers = Strided::open(document, sparse.indices.buffer_view, numbers, buffers)?;
        let size = self.width * self.component.size();
        let values = ElementRange { offset: sparse.values.byte_offset, count, size };
        let values = Strided::open(document, sparse.values.buffer_view, values, buffers)?;
        let replaced = Replaced { count, kind, numbers, values };
        let mut before = None;
        for i in 0..count {
            let number = replaced.number(buffers, i).ok_or_else(|| format!("ends in element {i}"))?;
            if number >= of {
                return Err(format!("element {i} replaces one that is not there"));
            }
            if before.is_some_and(|before| before >= number) {
                return Err(format!("its indices do not increase at element {i}, as glTF demands"));
            }
            before = Some(number);
        }
        Ok(replaced)
    }

    /// Element number `index`, padded with zeros; `None` beyond the last.
    pub fn get(&self, index: usize, buffers: &Buffers) -> Option<[f64; 3]> {
        if index >= self.count {
            return None;
        }
        let elsewhere = self.sparse.as_ref().and_then(|replaced| replaced.find(buffers, index));
        let (place, at) = match elsewhere {
            Some((values, at)) => (Some(values), at),
            None => (self.place.as_ref(), index),
        };
        let mut element = [0.0; 3];
        if let Some(place) = place {
            for (k, number) in element.iter_mut().enumerate().take(self.width) {
                *number = place.number(buffers, at, k, self.component, self.normalized)?;
            }
        }
        Some(element)
    }

    /// A vertex number.
    pub fn index(&self, index: usize, buffers: &Buffers) -> Option<usize> {
        whole(self.get(index, buffers)?[0])
    }
}

impl Replaced {
    /// The index of the element that is replaced by value `i`.
    fn number(&self, buffers: &Buffers, i: usize) -> Option<usize> {
        whole(self.numbers.number(buffers, i, 0, self.kind, false)?)
    }

    /// The location of the value of element `index`, if it is replaced.
    fn find(&self, buffers: &Buffers, index: usize) -> Option<(&Strided, usize)> {
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let middle = low.midpoint(high);
            match self.number(buffers, middle)?.cmp(&index) {
                Ordering::Less => low = middle + 1,
                Ordering::Greater => high = middle,
                Ordering::Equal => return Some((&self.values, middle)),
            }
        }
        None
    }
}

/// `count` elements of `size` bytes from byte `offset`.
#[derive(Clone, Copy, Debug)]
struct ElementRange {
    offset: usize,
    count: usize,
    size: usize,
}

impl Strided {
    /// Elements of a buffer view.
    fn open(
        document: &Document,
        view: usize,
        ElementRange { offset, count, size }: ElementRange,
        buffers: &mut Buffers,
    ) -> Result<Self, String> {
        let Some(found) = document.buffer_views.get(view) else {
            return Err(format!("names bufferView {view}, but there are {}", document.buffer_views.len()));
        };
        if let Some(name) = COMPRESSIONS.iter().find(|name| found.extensions.contains_key(**name)) {
            return Err(format!(
                "bufferView {view} is compressed by {name}, which is not read; save the file without"
            ));
        }
        let stride = found.byte_stride.unwrap_or(size);
        if stride < size {
            return Err(format!(
                "bufferView {view} has a byteStride of {stride}, less than the {size} bytes of an element"
            ));
        }
        let last = count.checked_sub(1).map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(size));
        let end = last.and_then(|last| last.checked_add(offset));
        if end.is_none_or(|end| end > found.byte_length) {
            let length = found.byte_length;
            return Err(format!("says {count} elements, but bufferView {view} has only {length} bytes"));
        }
        buffers.load(found.buffer)?;
        if buffers.slice(found.buffer, found.byte_offset, found.byte_length).is_none() {
            return Err(format!("bufferView {view} ends behind buffer {}", found.buffer));
        }
        Ok(Self { buffer: found.buffer, offset: found.byte_offset + offset, stride })
    }

    fn number(
        &self,
        buffers: &Buffers,
        index: usize,
        k: usize,
        component: Component,
        normalized: bool,
    ) -> Option<f64> {
        let at = self.offset + index * self.stride + k * component.size();
        component.read(buffers.slice(self.buffer, at, component.size())?, normalized)
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // checked
fn whole(number: f64) -> Option<usize> {
    (number >= 0.0 && number.fract() == 0.0 && number <= f64::from(u32::MAX)).then_some(number as usize)
}
