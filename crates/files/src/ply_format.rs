//! PLY, the Stanford polygon format: header and numbers, for the readers of meshes and point clouds.

mod number_kind;
pub mod words;

pub use number_kind::{ByteOrder, NumberKind};

use words::{next_line, quoted, words};

/// Longest padding (bytes) behind the last record of a binary file.
const LONGEST_PADDING: usize = 3;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Storage {
    Ascii,
    Binary(ByteOrder),
}

/// A kind of record, with the number of records declared in the header.
#[derive(Debug)]
pub struct Element {
    /// Name of the element, such as `vertex`.
    pub name: String,
    /// Number of records.
    pub count: usize,
    /// The properties of each record, in order.
    pub properties: Vec<Property>,
}

/// A number, or a list of numbers, in each record.
#[derive(Debug)]
pub struct Property {
    /// Name of the property, such as `x`.
    pub name: String,
    /// Storage type of the number, or of the numbers in the list.
    pub kind: NumberKind,
    /// How the length stands before a list of numbers; `None` for a single one.
    pub list: Option<NumberKind>,
}

/// Reason why bytes are not a PLY, or lack the requested content.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct PlyError(pub String);

/// The data of a PLY after its header.
#[expect(missing_debug_implementations, reason = "numbers are read as they are asked for")]
pub struct PlyFile<'d> {
    /// The elements, in the order of the data.
    pub elements: Vec<Element>,
    /// The data.
    pub numbers: Numbers<'d>,
}

impl<'d> PlyFile<'d> {
    /// Reads the header. Counts are checked against the data before anything is allocated for them.
    ///
    /// # Errors
    /// If the header is incomplete, or an element has more records than fit in the data.
    pub fn open(bytes: &'d [u8]) -> Result<Self, PlyError> {
        let (storage, elements, data) = header(bytes)?;
        for element in &elements {
            let least = element.properties.iter().map(|p| storage.least_bytes(p)).sum::<usize>();
            // the last word of a text may lack its blank
            if element.count.saturating_mul(least) > data.len().saturating_add(1) {
                let (name, count) = (quoted(&element.name), element.count);
                let has = data.len();
                return Err(PlyError(format!(
                    "element {name} has {count} records by the header, but only {has} bytes follow"
                )));
            }
        }
        Ok(Self { elements, numbers: Numbers::new(storage, data) })
    }
}

impl Storage {
    /// Bytes of a property at least: a digit and a blank in text, a length of zero for a list.
    fn least_bytes(self, property: &Property) -> usize {
        match self {
            Self::Ascii => 2,
            Self::Binary(_) => property.list.unwrap_or(property.kind).size(),
        }
    }
}

impl Element {
    /// Where x, y and z are among the properties.
    ///
    /// # Errors
    /// When one of them is missing, there twice, or a list.
    pub fn coordinates(&self) -> Result<[usize; 3], PlyError> {
        let find = |name: &str| {
            let mut named = self.properties.iter().enumerate().filter(|(_, p)| p.name == name);
            match (named.next(), named.next()) {
                (Some((place, property)), None) if property.list.is_none() => Ok(place),
                _ => Err(PlyError(format!("element vertex must have one property {name}, which is no list"))),
            }
        };
        Ok([find("x")?, find("y")?, find("z")?])
    }
}

/// Whether the first line is that of a PLY.
pub fn is_ply(bytes: &[u8]) -> bool {
    next_line(bytes).is_some_and(|(line, _)| line.trim_end() == "ply")
}

fn header(bytes: &[u8]) -> Result<(Storage, Vec<Element>, &[u8]), PlyError> {
    let mut storage = None;
    let mut elements = Vec::<Element>::new();
    let (_, mut rest) = next_line(bytes).unwrap_or_default();
    while let Some((line, after)) = next_line(rest) {
        rest = after;
        let line: Vec<&str> = line.split_whitespace().collect();
        match line[..] {
            ["end_header"] => {
                let storage = storage.ok_or_else(|| PlyError("the header has no format".to_owned()))?;
                return Ok((storage, elements, rest));
            }
            [] | ["comment" | "obj_info", ..] => {}
            ["format", name, _] => storage = Some(format_named(name)?),
            ["element", name, count] => elements.push(Element {
                name: name.to_owned(),
                count: count.parse().map_err(|_| {
                    PlyError(format!("element {}: {} is no count", quoted(name), quoted(count)))
                })?,
                properties: Vec::new(),
            }),
            ["property", ref property @ ..] => {
                let element = elements.last_mut();
                let element =
                    element.ok_or_else(|| PlyError("a property stands before any element".to_owned()))?;
                element.properties.push(property_of(property)?);
            }
            _ => return Err(PlyError(format!("the header has {}", quoted(&line.join(" "))))),
        }
    }
    Err(PlyError("the header has no end_header".to_owned()))
}

fn format_named(name: &str) -> Result<Storage, PlyError> {
    match name {
        "ascii" => Ok(Storage::Ascii),
        "binary_little_endian" => Ok(Storage::Binary(ByteOrder::Little)),
        "binary_big_endian" => Ok(Storage::Binary(ByteOrder::Big)),
        other => Err(PlyError(format!("format {} is none of PLY", quoted(other)))),
    }
}

fn property_of(words: &[&str]) -> Result<Property, PlyError> {
    match *words {
        ["list", length, kind, name] => {
            Ok(Property { name: name.to_owned(), kind: kind_named(kind)?, list: Some(kind_named(length)?) })
        }
        [kind, name] => Ok(Property { name: name.to_owned(), kind: kind_named(kind)?, list: None }),
        _ => Err(PlyError(format!("property {} is none", quoted(&words.join(" "))))),
    }
}

fn kind_named(name: &str) -> Result<NumberKind, PlyError> {
    Ok(match name {
        "char" | "int8" => NumberKind::I8,
        "uchar" | "uint8" => NumberKind::U8,
        "short" | "int16" => NumberKind::I16,
        "ushort" | "uint16" => NumberKind::U16,
        "int" | "int32" => NumberKind::I32,
        "uint" | "uint32" => NumberKind::U32,
        "float" | "float32" => NumberKind::F32,
        "double" | "float64" => NumberKind::F64,
        other => return Err(PlyError(format!("type {} is none of PLY", quoted(other)))),
    })
}

/// The numbers of the data, one after the other.
#[expect(missing_debug_implementations, reason = "numbers are read as they are asked for")]
pub enum Numbers<'d> {
    /// Words of a text.
    Ascii(Box<dyn Iterator<Item = &'d str> + 'd>),
    /// Binary records.
    Binary {
        /// The bytes that are not yet read.
        rest: &'d [u8],
        /// Byte order of the numbers.
        order: ByteOrder,
    },
}

impl<'d> Numbers<'d> {
    fn new(storage: Storage, data: &'d [u8]) -> Self {
        match storage {
            Storage::Ascii => Self::Ascii(Box::new(words(data))),
            Storage::Binary(order) => Self::Binary { rest: data, order },
        }
    }

    /// The next number.
    ///
    /// # Errors
    /// If the data ends, or a word is not a number of this type.
    pub fn next(&mut self, kind: NumberKind) -> Result<f64, PlyError> {
        match self {
            Self::Ascii(words) => {
                let word = words.next().ok_or_else(cut)?;
                kind.parse(word).ok_or_else(|| PlyError(format!("{} is no number", quoted(word))))
            }
            Self::Binary { rest, order } => {
                let number = kind.read(rest, *order).ok_or_else(cut)?;
                *rest = &rest[kind.size()..];
                Ok(number)
            }
        }
    }

    fn skip_many(&mut self, count: usize, kind: NumberKind) -> Result<(), PlyError> {
        match self {
            Self::Ascii(words) => {
                for _ in 0..count {
                    words.next().ok_or_else(cut)?;
                }
            }
            Self::Binary { rest, .. } => {
                let bytes = count.checked_mul(kind.size());
                *rest = bytes.and_then(|bytes| rest.get(bytes..)).ok_or_else(cut)?;
            }
        }
        Ok(())
    }

    /// The length of the list that comes next.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // checked to be a count
    pub fn length(&mut self, kind: NumberKind) -> Result<usize, PlyError> {
        let length = self.next(kind)?;
        if !(length >= 0.0 && length.fract() == 0.0 && length <= f64::from(u32::MAX)) {
            return Err(PlyError(format!("a list has {length} entries")));
        }
        Ok(length as usize)
    }

    /// The coordinates of the record that comes next, number `index` of `element`.
    pub fn point(&mut self, element: &Element, xyz: [usize; 3], index: usize) -> Result<[f64; 3], PlyError> {
        let named = |e: PlyError| PlyError(format!("vertex {index} of {}: {e}", element.count));
        let mut point = [0.0; 3];
        for (p, property) in element.properties.iter().enumerate() {
            match (property.list, xyz.iter().position(|&place| place == p)) {
                (None, Some(k)) => point[k] = self.next(property.kind).map_err(named)?,
                _ => self.skip_property(property).map_err(named)?,
            }
        }
        Ok(point)
    }

    /// Checks that all has been read. Returns a remark on padding: programs add a line break or a few zeros to binary
    /// data.
    ///
    /// # Errors
    /// If more data is left: the header is wrong, and records may have been read from the numbers of others.
    pub fn end(&mut self) -> Result<Option<String>, PlyError> {
        let is_padding = self.is_padding_left();
        match self.left() {
            Some(left) if !is_padding => {
                Err(PlyError(format!("{left}: the header is wrong, or two files were joined")))
            }
            left => Ok(left),
        }
    }

    /// Describes unread data, as a clause; `None` when all has been read.
    fn left(&mut self) -> Option<String> {
        match self {
            Self::Ascii(words) => {
                let first = words.next()?;
                let count = 1 + words.count();
                Some(format!(
                    "{count} more word{} after the last record that its header announces, the first is {}",
                    if count == 1 { " follows" } else { "s follow" },
                    quoted(first)
                ))
            }
            Self::Binary { rest: [], .. } => None,
            Self::Binary { rest, .. } => Some(format!(
                "{} more byte{} after the last record that its header announces",
                rest.len(),
                if rest.len() == 1 { " follows" } else { "s follow" }
            )),
        }
    }

    /// Whether a line break or a few zeros at most are left of binary data.
    fn is_padding_left(&self) -> bool {
        match self {
            Self::Ascii(_) => false,
            Self::Binary { rest, .. } => {
                rest.len() <= LONGEST_PADDING && rest.iter().all(|b| matches!(b, 0 | b'\n' | b'\r'))
            }
        }
    }

    /// Skips one property of a record.
    ///
    /// # Errors
    /// If the data ends, or the length of a list is not a length.
    pub fn skip_property(&mut self, property: &Property) -> Result<(), PlyError> {
        match property.list {
            None => self.skip_many(1, property.kind),
            Some(length) => {
                let length = self.length(length)?;
                self.skip_many(length, property.kind)
            }
        }
    }

    /// Skips all records of an element.
    ///
    /// # Errors
    /// If the data ends, or contains a word that is not a number.
    pub fn skip(&mut self, element: &Element) -> Result<(), PlyError> {
        let named = |e: PlyError| PlyError(format!("element {}: {e}", quoted(&element.name)));
        let singles = element.properties.iter().all(|p| p.list.is_none());
        if singles && let Self::Binary { rest, .. } = self {
            let size: usize = element.properties.iter().map(|p| p.kind.size()).sum();
            let bytes = size.checked_mul(element.count);
            *rest = bytes.and_then(|bytes| rest.get(bytes..)).ok_or_else(|| named(cut()))?;
            return Ok(());
        }
        // what takes no bytes has no end
        let count = if element.properties.is_empty() { 0 } else { element.count };
        for _ in 0..count {
            for property in &element.properties {
                self.skip_property(property).map_err(named)?;
            }
        }
        Ok(())
    }
}

fn cut() -> PlyError {
    PlyError("the file ends here".to_owned())
}
