//! PLY, the Stanford polygon format: the vertices only.

use super::points::{ByteOrder, CloudError, CloudPoints, NumberKind};
use super::{next_line, quoted, words};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Storage {
    Ascii,
    Binary(ByteOrder),
}

#[derive(Debug)]
struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

#[derive(Debug)]
struct Property {
    name: String,
    kind: NumberKind,
    /// How the length stands before a list of numbers; `None` for a single one.
    list: Option<NumberKind>,
}

/// Whether the first line is that of a PLY.
pub(super) fn is_ply(bytes: &[u8]) -> bool {
    next_line(bytes).is_some_and(|(line, _)| line.trim_end() == "ply")
}

/// # Errors
/// When the header is incomplete, or the data ends before the last vertex.
pub(super) fn read(bytes: &[u8]) -> Result<CloudPoints, CloudError> {
    let (storage, elements, data) = header(bytes)?;
    let mut cloud = CloudPoints::default();
    let mut numbers = Numbers::new(storage, data);
    for element in &elements {
        if element.name != "vertex" {
            numbers.skip(element)?;
            continue;
        }
        let xyz = coordinates(element)?;
        read_vertices(element, xyz, &mut numbers, &mut cloud)?;
        if elements.iter().any(|e| e.name == "face" && e.count > 0) {
            cloud.remarks.push("its faces are not used: only its vertices are points".to_owned());
        }
        return Ok(cloud);
    }
    Err(CloudError("the header has no element vertex".to_owned()))
}

fn read_vertices(
    element: &Element,
    xyz: [usize; 3],
    numbers: &mut Numbers,
    cloud: &mut CloudPoints,
) -> Result<(), CloudError> {
    for i in 0..element.count {
        let named = |e: CloudError| CloudError(format!("vertex {i} of {}: {e}", element.count));
        let mut point = [0.0; 3];
        for (p, property) in element.properties.iter().enumerate() {
            match (property.list, xyz.iter().position(|&place| place == p)) {
                (None, Some(k)) => point[k] = numbers.next(property.kind).map_err(named)?,
                (None, None) => numbers.skip_one(property.kind).map_err(named)?,
                (Some(length), _) => numbers.skip_list(length, property.kind).map_err(named)?,
            }
        }
        cloud.push(point)?;
    }
    Ok(())
}

/// Which properties are x, y and z.
fn coordinates(vertex: &Element) -> Result<[usize; 3], CloudError> {
    let find = |name: &str| {
        let mut named = vertex.properties.iter().enumerate().filter(|(_, p)| p.name == name);
        match (named.next(), named.next()) {
            (Some((place, property)), None) if property.list.is_none() => Ok(place),
            _ => Err(CloudError(format!("element vertex must have one property {name}, which is no list"))),
        }
    };
    Ok([find("x")?, find("y")?, find("z")?])
}

fn header(bytes: &[u8]) -> Result<(Storage, Vec<Element>, &[u8]), CloudError> {
    let mut storage = None;
    let mut elements = Vec::<Element>::new();
    let (_, mut rest) = next_line(bytes).unwrap_or_default();
    while let Some((line, after)) = next_line(rest) {
        rest = after;
        let line: Vec<&str> = line.split_whitespace().collect();
        match line[..] {
            ["end_header"] => {
                let storage = storage.ok_or_else(|| CloudError("the header has no format".to_owned()))?;
                return Ok((storage, elements, rest));
            }
            [] | ["comment" | "obj_info", ..] => {}
            ["format", name, _] => storage = Some(format_named(name)?),
            ["element", name, count] => elements.push(Element {
                name: name.to_owned(),
                count: count.parse().map_err(|_| {
                    CloudError(format!("element {}: {} is no count", quoted(name), quoted(count)))
                })?,
                properties: Vec::new(),
            }),
            ["property", ref property @ ..] => {
                let element = elements.last_mut();
                let element =
                    element.ok_or_else(|| CloudError("a property stands before any element".to_owned()))?;
                element.properties.push(property_of(property)?);
            }
            _ => return Err(CloudError(format!("the header has {}", quoted(&line.join(" "))))),
        }
    }
    Err(CloudError("the header has no end_header".to_owned()))
}

fn format_named(name: &str) -> Result<Storage, CloudError> {
    match name {
        "ascii" => Ok(Storage::Ascii),
        "binary_little_endian" => Ok(Storage::Binary(ByteOrder::Little)),
        "binary_big_endian" => Ok(Storage::Binary(ByteOrder::Big)),
        other => Err(CloudError(format!("format {} is none of PLY", quoted(other)))),
    }
}

fn property_of(words: &[&str]) -> Result<Property, CloudError> {
    match *words {
        ["list", length, kind, name] => {
            Ok(Property { name: name.to_owned(), kind: kind_named(kind)?, list: Some(kind_named(length)?) })
        }
        [kind, name] => Ok(Property { name: name.to_owned(), kind: kind_named(kind)?, list: None }),
        _ => Err(CloudError(format!("property {} is none", quoted(&words.join(" "))))),
    }
}

fn kind_named(name: &str) -> Result<NumberKind, CloudError> {
    Ok(match name {
        "char" | "int8" => NumberKind::I8,
        "uchar" | "uint8" => NumberKind::U8,
        "short" | "int16" => NumberKind::I16,
        "ushort" | "uint16" => NumberKind::U16,
        "int" | "int32" => NumberKind::I32,
        "uint" | "uint32" => NumberKind::U32,
        "float" | "float32" => NumberKind::F32,
        "double" | "float64" => NumberKind::F64,
        other => return Err(CloudError(format!("type {} is none of PLY", quoted(other)))),
    })
}

/// The numbers of the data, one after the other.
enum Numbers<'d> {
    Ascii(Box<dyn Iterator<Item = &'d str> + 'd>),
    Binary { rest: &'d [u8], order: ByteOrder },
}

impl<'d> Numbers<'d> {
    fn new(storage: Storage, data: &'d [u8]) -> Self {
        match storage {
            Storage::Ascii => Self::Ascii(Box::new(words(data))),
            Storage::Binary(order) => Self::Binary { rest: data, order },
        }
    }

    fn next(&mut self, kind: NumberKind) -> Result<f64, CloudError> {
        match self {
            Self::Ascii(words) => {
                let word = words.next().ok_or_else(cut)?;
                kind.parse(word).ok_or_else(|| CloudError(format!("{} is no number", quoted(word))))
            }
            Self::Binary { rest, order } => {
                let number = kind.read(rest, *order).ok_or_else(cut)?;
                *rest = &rest[kind.size()..];
                Ok(number)
            }
        }
    }

    fn skip_one(&mut self, kind: NumberKind) -> Result<(), CloudError> {
        self.skip_many(1, kind)
    }

    fn skip_many(&mut self, count: usize, kind: NumberKind) -> Result<(), CloudError> {
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

    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // checked to be a count
    fn skip_list(&mut self, length: NumberKind, kind: NumberKind) -> Result<(), CloudError> {
        let length = self.next(length)?;
        if !(length >= 0.0 && length.fract() == 0.0 && length <= f64::from(u32::MAX)) {
            return Err(CloudError(format!("a list has {length} entries")));
        }
        self.skip_many(length as usize, kind)
    }

    fn skip(&mut self, element: &Element) -> Result<(), CloudError> {
        let named = |e: CloudError| CloudError(format!("element {}: {e}", quoted(&element.name)));
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
                match property.list {
                    None => self.skip_one(property.kind).map_err(named)?,
                    Some(length) => self.skip_list(length, property.kind).map_err(named)?,
                }
            }
        }
        Ok(())
    }
}

fn cut() -> CloudError {
    CloudError("the file ends here".to_owned())
}

#[cfg(test)]
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // small numbers
mod tests;
