//! Reader of PCD files, the format of the Point Cloud Library (PCL).

use clearance_files::ply_format::words::{next_line, quoted, words};
use clearance_files::ply_format::{ByteOrder, NumberKind};

use super::lzf;
use super::points::{CloudError, CloudPoints, Column, Columns};

/// Most zeros after the data (bytes): the Point Cloud Library adds up to one page.
const LONGEST_PADDING: usize = 64 << 10;

/// The header.
#[derive(Debug, Default)]
struct Header {
    names: Vec<String>,
    sizes: Vec<usize>,
    types: Vec<char>,
    counts: Vec<usize>,
    width: Option<usize>,
    height: Option<usize>,
    points: Option<usize>,
    viewpoint: Option<[f64; 7]>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Storage {
    Ascii,
    Binary,
    Compressed,
}

/// One field of a point; it may hold several numbers.
#[derive(Clone, Debug)]
struct Field {
    name: String,
    kind: Option<NumberKind>,
    /// Bytes of one number.
    size: usize,
    count: usize,
    /// Bytes before it in a point's record.
    offset: usize,
    /// Numbers before it in a point's line.
    place: usize,
}

/// True if the first line that is not a comment is a PCD header line.
pub(super) fn is_pcd(bytes: &[u8]) -> bool {
    let mut rest = bytes;
    while let Some((line, after)) = next_line(rest) {
        let word = line.split_whitespace().next().unwrap_or_default();
        match word {
            "VERSION" | "FIELDS" | "COLUMNS" => return true,
            _ if word.is_empty() || word.starts_with('#') => rest = after,
            _ => return false,
        }
    }
    false
}

/// # Errors
/// If the header is incomplete or contradictory, or the data holds fewer or more points than it declares.
pub(super) fn read(bytes: &[u8]) -> Result<CloudPoints, CloudError> {
    let (header, storage, data) = Header::read(bytes)?;
    let fields = header.fields()?;
    let count = header.point_count()?;
    let mut cloud = CloudPoints::default();
    match storage {
        Storage::Ascii => read_ascii(data, &fields, count, &mut cloud)?,
        Storage::Binary => read_binary(data, &fields, count, &mut cloud)?,
        Storage::Compressed => read_compressed(data, &fields, count, &mut cloud)?,
    }
    // as the Point Cloud Library: the sensor's pose is read, but the points are not transformed
    if header.viewpoint.is_some_and(|v| v != [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]) {
        cloud.remarks.push("its VIEWPOINT is not applied: points are taken as they are".to_owned());
    }
    Ok(cloud)
}

impl Header {
    fn read(bytes: &[u8]) -> Result<(Self, Storage, &[u8]), CloudError> {
        let mut header = Self::default();
        let mut seen = Vec::<String>::new();
        let mut rest = bytes;
        while let Some((line, after)) = next_line(rest) {
            rest = after;
            let mut words = line.split_whitespace();
            let Some(key) = words.next() else { continue };
            let values: Vec<&str> = words.collect();
            // the oldest files have COLUMNS
            let key = if key == "COLUMNS" { "FIELDS" } else { key };
            if seen.iter().any(|other| other == key) {
                return Err(CloudError(format!("the header has {key} twice: leave one of them out")));
            }
            if !key.starts_with('#') {
                seen.push(key.to_owned());
            }
            match key {
                "DATA" => return Ok((header, storage(&values)?, rest)),
                "VERSION" => {}
                "FIELDS" => header.names = values.iter().map(|&v| v.to_owned()).collect(),
                "SIZE" => header.sizes = numbers(key, &values)?,
                "COUNT" => header.counts = numbers(key, &values)?,
                "TYPE" => header.types = values.iter().filter_map(|v| v.chars().next()).collect(),
                "WIDTH" => header.width = only_number(key, &values)?,
                "HEIGHT" => header.height = only_number(key, &values)?,
                "POINTS" => header.points = only_number(key, &values)?,
                "VIEWPOINT" => header.viewpoint = numbers(key, &values)?.try_into().ok(),
                _ if key.starts_with('#') => {}
                _ => return Err(CloudError(format!("the header has {}, which no PCD has", quoted(key)))),
            }
        }
        Err(CloudError("the header has no DATA".to_owned()))
    }

    fn fields(&self) -> Result<Vec<Field>, CloudError> {
        for (key, given) in
            [("SIZE", self.sizes.len()), ("TYPE", self.types.len()), ("COUNT", self.counts.len())]
        {
            if given != 0 && given != self.names.len() {
                return Err(CloudError(format!("{key} has {given} values for {} FIELDS", self.names.len())));
            }
        }
        let mut fields = Vec::<Field>::new();
        for (i, name) in self.names.iter().enumerate() {
            // the oldest files have neither sizes nor types: 32-bit floats
            let size = self.sizes.get(i).copied().unwrap_or(4);
            let kind = number_kind(self.types.get(i).copied().unwrap_or('F'), size);
            let count = self.counts.get(i).copied().unwrap_or(1);
            let (offset, place) = match fields.last() {
                Some(last) => last.end().ok_or_else(too_long)?,
                None => (0, 0),
            };
            fields.push(Field { name: name.clone(), kind, size, count, offset, place });
        }
        fields.last().map_or(Some((0, 0)), Field::end).ok_or_else(too_long)?;
        Ok(fields)
    }

    fn point_count(&self) -> Result<usize, CloudError> {
        let grid = match (self.width, self.height) {
            (Some(width), height) => Some(width.checked_mul(height.unwrap_or(1)).ok_or_else(too_long)?),
            (None, Some(height)) => {
                return Err(CloudError(format!("HEIGHT is {height}, but WIDTH is missing")));
            }
            (None, None) => None,
        };
        match (grid, self.points) {
            (Some(grid), Some(points)) if grid != points => {
                Err(CloudError(format!("WIDTH and HEIGHT make {grid} points, but POINTS is {points}")))
            }
            (Some(count), _) | (None, Some(count)) => Ok(count),
            (None, None) => Err(CloudError("the header has neither POINTS nor WIDTH".to_owned())),
        }
    }
}

impl Field {
    /// Bytes and numbers of a point up to the end of this field; `None` on overflow.
    fn end(&self) -> Option<(usize, usize)> {
        let offset = self.offset.checked_add(self.size.checked_mul(self.count)?)?;
        Some((offset, self.place.checked_add(self.count)?))
    }
}

fn too_long() -> CloudError {
    CloudError("the header announces more than can be counted".to_owned())
}

fn storage(values: &[&str]) -> Result<Storage, CloudError> {
    match values {
        ["ascii"] => Ok(Storage::Ascii),
        ["binary"] => Ok(Storage::Binary),
        ["binary_compressed"] => Ok(Storage::Compressed),
        other => Err(CloudError(format!(
            "DATA is {}, but must be ascii, binary or binary_compressed",
            quoted(&other.join(" "))
        ))),
    }
}

fn numbers<T: std::str::FromStr>(key: &str, values: &[&str]) -> Result<Vec<T>, CloudError> {
    (values.iter())
        .map(|v| v.parse().map_err(|_| CloudError(format!("{key} has {}, which is no number", quoted(v)))))
        .collect()
}

/// The number of a line that may have only one; `None` if it has none.
fn only_number(key: &str, values: &[&str]) -> Result<Option<usize>, CloudError> {
    match numbers::<usize>(key, values)?[..] {
        [] => Ok(None),
        [number] => Ok(Some(number)),
        [..] => Err(CloudError(format!("{key} has {} values, but must have one", values.len()))),
    }
}

fn number_kind(kind: char, size: usize) -> Option<NumberKind> {
    Some(match (kind, size) {
        ('I', 1) => NumberKind::I8,
        ('U', 1) => NumberKind::U8,
        ('I', 2) => NumberKind::I16,
        ('U', 2) => NumberKind::U16,
        ('I', 4) => NumberKind::I32,
        ('U', 4) => NumberKind::U32,
        ('I', 8) => NumberKind::I64,
        ('U', 8) => NumberKind::U64,
        ('F', 4) => NumberKind::F32,
        ('F', 8) => NumberKind::F64,
        _ => return None,
    })
}

/// The fields x, y and z, each with the storage kind of its numbers.
fn coordinates(fields: &[Field]) -> Result<[(&Field, NumberKind); 3], CloudError> {
    let find = |name: &str| -> Result<_, CloudError> {
        let mut named = fields.iter().filter(|f| f.name == name);
        let (Some(field), None) = (named.next(), named.next()) else {
            return Err(CloudError(format!("FIELDS must have {name} once")));
        };
        match field.kind {
            Some(kind) if field.count == 1 => Ok((field, kind)),
            _ => Err(CloudError(format!("field {name}: its SIZE, TYPE and COUNT are of no single number"))),
        }
    };
    Ok([find("x")?, find("y")?, find("z")?])
}

fn read_ascii(
    data: &[u8],
    fields: &[Field],
    count: usize,
    cloud: &mut CloudPoints,
) -> Result<(), CloudError> {
    let xyz = coordinates(fields)?;
    let numbers = fields.last().and_then(Field::end).map_or(0, |(_, numbers)| numbers);
    let mut rest = data;
    let mut read = 0;
    while let Some((line, after)) = next_line(rest) {
        rest = after;
        let line: Vec<&str> = words(line.as_bytes()).collect();
        if line.is_empty() {
            continue;
        }
        if read == count {
            return Err(surplus("a line follows", count));
        }
        if line.len() != numbers {
            return Err(CloudError(format!(
                "point {read} has {} numbers, but must have {numbers}",
                line.len()
            )));
        }
        let mut point = [0.0; 3];
        for (coordinate, (field, kind)) in point.iter_mut().zip(xyz) {
            let word = line[field.place];
            *coordinate = (kind.parse(word)).ok_or_else(|| {
                CloudError(format!("point {read}: {} is {}, which is no number", field.name, quoted(word)))
            })?;
        }
        cloud.push(point)?;
        read += 1;
    }
    let cut = || CloudError(format!("the file ends after {read} of {count} points"));
    (read == count).then_some(()).ok_or_else(cut)
}

fn read_binary(
    data: &[u8],
    fields: &[Field],
    count: usize,
    cloud: &mut CloudPoints,
) -> Result<(), CloudError> {
    let stride = fields.last().and_then(Field::end).map_or(0, |(bytes, _)| bytes);
    let xyz = coordinates(fields)?.map(|(field, kind)| Column { first: field.offset, stride, kind });
    let expected = stride.checked_mul(count).ok_or_else(too_long)?;
    if data.len() < expected {
        return Err(CloudError(format!(
            "{count} points of {stride} bytes are {expected}, but only {} bytes follow the header",
            data.len()
        )));
    }
    cloud.remarks.extend(padding(&data[expected..], count)?);
    cloud.read(data, &Columns { xyz, order: ByteOrder::Little }, count)
}

/// A remark on zeros and blanks after the data.
///
/// # Errors
/// If there is anything else: the header is wrong, and points would be missing.
fn padding(left: &[u8], count: usize) -> Result<Option<String>, CloudError> {
    let follow = if left.len() == 1 { "byte follows" } else { "bytes follow" };
    let is_padding = left.iter().all(|b| *b == 0 || b.is_ascii_whitespace());
    match left.len() {
        0 => Ok(None),
        length if is_padding && length <= LONGEST_PADDING => {
            Ok(Some(format!("{length} {follow} the last point: zeros or blanks")))
        }
        length => Err(surplus(&format!("{length} {follow}"), count)),
    }
}

fn surplus(what_follows: &str, count: usize) -> CloudError {
    CloudError(format!(
        "{what_follows} after the {count} points that its header announces: the header is wrong, or two files were joined"
    ))
}

/// Compressed data: all numbers of the first field, then all of the second and so on, compressed as a whole, without padding.
fn read_compressed(
    data: &[u8],
    fields: &[Field],
    count: usize,
    cloud: &mut CloudPoints,
) -> Result<(), CloudError> {
    let length = |at: usize| -> Result<usize, CloudError> {
        let bytes = data.get(at..).and_then(|d| d.first_chunk());
        let bytes = bytes.ok_or_else(|| CloudError("the file ends before the compressed data".to_owned()))?;
        Ok(u32::from_le_bytes(*bytes) as usize)
    };
    let (packed, unpacked) = (length(0)?, length(4)?);
    let Some(packed) = data[8..].get(..packed) else {
        return Err(CloudError(format!(
            "{packed} bytes of compressed data are announced, but {} follow",
            data.len() - 8
        )));
    };
    let mut starts = Vec::new();
    let mut total = 0usize;
    for field in fields {
        starts.push(total);
        if field.name != "_" {
            let bytes = field.size.checked_mul(field.count).and_then(|b| b.checked_mul(count));
            total = bytes.and_then(|b| total.checked_add(b)).ok_or_else(too_long)?;
        }
    }
    if total != unpacked {
        return Err(CloudError(format!(
            "{count} points take {total} bytes, but the compressed data holds {unpacked}"
        )));
    }
    cloud.remarks.extend(padding(&data[8 + packed.len()..], count)?);
    let bytes = lzf::unpack(packed, unpacked)?;
    let xyz = coordinates(fields)?.map(|(field, kind)| {
        let place = fields.iter().position(|f| std::ptr::eq(f, field)).unwrap_or_default();
        Column { first: starts[place], stride: kind.size(), kind }
    });
    cloud.read(&bytes, &Columns { xyz, order: ByteOrder::Little }, count)
}

#[cfg(test)]
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // small numbers
mod tests;
