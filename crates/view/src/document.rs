//! Geometry document for a browser: a JSON text, followed by the binary data of large arrays.
//!
//! | bytes | content |
//! |---|---|
//! | 4 | length of the text in bytes, a multiple of four |
//! | that many | the text, padded with spaces |
//! | the rest | float32 and uint32, all little-endian; the text contains the range of each array |

use hyper::body::Bytes;
use serde::Serialize;

/// Range of an array of one number type: index of the first element, and count.
pub type Span = [usize; 2];

/// Binary part of a document.
#[derive(Debug, Default)]
pub struct Numbers(Vec<u8>);

impl Numbers {
    pub fn floats(&mut self, numbers: impl IntoIterator<Item = f32>) -> Span {
        self.append(numbers.into_iter().map(f32::to_le_bytes))
    }

    pub fn integers(&mut self, numbers: impl IntoIterator<Item = u32>) -> Span {
        self.append(numbers.into_iter().map(u32::to_le_bytes))
    }

    fn append(&mut self, numbers: impl Iterator<Item = [u8; 4]>) -> Span {
        let first = self.0.len() / 4;
        numbers.for_each(|bytes| self.0.extend(bytes));
        [first, self.0.len() / 4 - first]
    }

    /// Puts the text before the arrays.
    pub fn document(self, text: &impl Serialize) -> Bytes {
        // serialising plain structs of numbers and names cannot fail
        let mut text = serde_json::to_vec(text).unwrap_or_default();
        text.resize(text.len().next_multiple_of(4), b' ');
        let length = u32::try_from(text.len()).unwrap_or_default();
        [&length.to_le_bytes(), text.as_slice(), &self.0].concat().into()
    }
}
