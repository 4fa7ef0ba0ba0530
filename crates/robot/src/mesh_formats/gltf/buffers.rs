//! The buffers of a glTF: in the GLB itself, in the document as `data:`, or in files beside it.

use std::borrow::Cow;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use super::document::{Buffer, Document};
use crate::decimal_numbers::shortened;
use crate::mesh_formats::Parts;

/// Programs write base64 with or without padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Buffers, read at their first use.
pub struct Buffers<'d> {
    described: &'d [Buffer],
    in_file: Option<&'d [u8]>,
    parts: Parts<'d>,
    loaded: Vec<Option<Cow<'d, [u8]>>>,
}

impl<'d> Buffers<'d> {
    pub fn new(document: &'d Document, in_file: Option<&'d [u8]>, parts: Parts<'d>) -> Self {
        let described = &document.buffers[..];
        Self { described, in_file, parts, loaded: described.iter().map(|_| None).collect() }
    }

    /// Reads a buffer, if that has not happened yet.
    ///
    /// # Errors
    /// If there is no such buffer, it cannot be read, or it is shorter than the document declares.
    pub fn load(&mut self, index: usize) -> Result<(), String> {
        let Some(buffer) = self.described.get(index) else {
            return Err(format!("names buffer {index}, but there are {}", self.described.len()));
        };
        if self.loaded[index].is_some() {
            return Ok(());
        }
        let bytes = self.bytes(index, buffer).map_err(|reason| format!("buffer {index}: {reason}"))?;
        let (says, has) = (buffer.byte_length, bytes.len());
        if has < says {
            return Err(format!(
                "buffer {index}: the document says {says} bytes, but there are {has}: it is cut"
            ));
        }
        self.loaded[index] = Some(bytes);
        Ok(())
    }

    /// A part of a buffer that was read; `None` when it does not reach so far.
    pub fn slice(&self, index: usize, offset: usize, length: usize) -> Option<&[u8]> {
        let says = self.described.get(index)?.byte_length;
        let bytes = self.loaded.get(index)?.as_ref()?;
        bytes.get(..says)?.get(offset..offset.checked_add(length)?)
    }

    /// Total size (bytes) of all buffers as declared in the document.
    pub fn total(&self) -> usize {
        self.described.iter().fold(0, |sum: usize, buffer| sum.saturating_add(buffer.byte_length))
    }

    fn bytes(&mut self, index: usize, buffer: &'d Buffer) -> Result<Cow<'d, [u8]>, String> {
        match &buffer.uri {
            None if index == 0 => self
                .in_file
                .map(Cow::Borrowed)
                .ok_or_else(|| "has no uri, and the file is no GLB that holds it".to_owned()),
            None => Err("has no uri".to_owned()),
            Some(uri) if uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:")) => {
                data_uri(&uri[5..]).map(Cow::Owned)
            }
            Some(uri) => (self.parts)(uri).map(Cow::Owned),
        }
    }
}

/// The content of `data:[type][;base64],content`.
fn data_uri(text: &str) -> Result<Vec<u8>, String> {
    let Some((kind, content)) = text.split_once(',') else {
        return Err(format!("'data:{}' has no comma before its content", shortened(text)));
    };
    if kind.to_ascii_lowercase().ends_with(";base64") {
        BASE64.decode(content).map_err(|e| format!("is no base64: {e}"))
    } else {
        Ok(percent_encoding::percent_decode_str(content).collect())
    }
}
