//! Buffer views compressed by meshoptimizer: the JSON is checked before anything is decoded.
//!
//! The decoders get only modes, filters and strides that go together. Damaged bytes may still decode to wrong numbers,
//! which are checked like any other numbers in a file.
//! Source: EXT_meshopt_compression and KHR_meshopt_compression, which adds a filter and a version.

use super::document::{Compression, Document, find};
use super::meshopt::{Layout, decode};
use crate::BrokenRule;

/// Two names of one thing.
pub(super) const COMPRESSION: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// A compressed buffer view.
#[derive(Clone, Copy, Debug)]
pub(super) struct Compressed {
    view: u32,
    /// The buffer that has the compressed bytes.
    pub(super) buffer: u32,
    start: u64,
    length: u64,
    layout: Layout,
}

/// The codec of a compressed view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    Attributes,
    Triangles,
    Indices,
}

/// The encoding of the numbers in decoded attributes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

impl Compressed {
    /// Returns the compressed form of a view; `None` if it is not compressed.
    pub(super) fn of(document: &Document, view: u32) -> Result<Option<Compressed>, BrokenRule> {
        let place = || format!("bufferView {view}");
        let held = find(&document.buffer_views, view, "bufferView", || {
            "the document".to_owned()
        })?;
        let extensions = &held.extensions;
        let Some(source) = extensions.meshopt.as_ref().or(extensions.meshopt_khr.as_ref()) else {
            return Ok(None);
        };
        let bad = |why: String| BrokenRule::BadCompression { place: place(), why };
        let [mode, filter] = [&source.mode, &source.filter].map(|word| &**word);
        let mode = match mode {
            "ATTRIBUTES" => Mode::Attributes,
            "TRIANGLES" => Mode::Triangles,
            "INDICES" => Mode::Indices,
            _ => {
                return Err(bad(
                    "its mode is none of ATTRIBUTES, TRIANGLES and INDICES".to_owned()
                ));
            }
        };
        let filter = match filter {
            "NONE" | "" => Filter::None,
            "OCTAHEDRAL" => Filter::Octahedral,
            "QUATERNION" => Filter::Quaternion,
            "EXPONENTIAL" => Filter::Exponential,
            "COLOR" => Filter::Color,
            _ => {
                return Err(bad(
                    "its filter is none of NONE, OCTAHEDRAL, QUATERNION, EXPONENTIAL and COLOR".to_owned(),
                ));
            }
        };
        let Compression {
            count, byte_stride, ..
        } = **source;
        let stride_serves = match (mode, filter) {
            (Mode::Attributes, Filter::None | Filter::Exponential) => {
                byte_stride.is_multiple_of(4) && (4..=256).contains(&byte_stride)
            }
            (Mode::Attributes, Filter::Octahedral | Filter::Color) => matches!(byte_stride, 4 | 8),
            (Mode::Attributes, Filter::Quaternion) => byte_stride == 8,
            (_, Filter::None) => matches!(byte_stride, 2 | 4),
            _ => return Err(bad("indices have no filter".to_owned())),
        };
        if !stride_serves {
            return Err(bad(format!(
                "its elements of {byte_stride} bytes do not go with its mode and filter"
            )));
        }
        if mode == Mode::Triangles && !count.is_multiple_of(3) {
            return Err(bad(format!("{count} indices make no triangles")));
        }
        let decoded = u128::from(count) * u128::from(byte_stride);
        if decoded != u128::from(held.byte_length) {
            return Err(bad(format!(
                "it decodes to {decoded} bytes, but should have {}",
                held.byte_length
            )));
        }
        let buffer = find(&document.buffers, source.buffer, "buffer", place)?;
        let end = u128::from(source.byte_offset) + u128::from(source.byte_length);
        if end > u128::from(buffer.byte_length) {
            return Err(BrokenRule::ViewOutOfBuffer {
                place: place(),
                end,
                buffer: source.buffer,
                length: buffer.byte_length,
            });
        }
        // What is larger than the machine can address is refused by the budget, before these numbers are used.
        let addressed = |number: u64| usize::try_from(number).unwrap_or(usize::MAX);
        Ok(Some(Compressed {
            view,
            buffer: source.buffer,
            start: source.byte_offset,
            length: source.byte_length,
            layout: Layout {
                mode,
                filter,
                count: addressed(count),
                stride: addressed(byte_stride),
            },
        }))
    }

    /// Number of bytes that it decodes to.
    pub(super) fn decoded_bytes(&self) -> u64 {
        (self.layout.count as u64).saturating_mul(self.layout.stride as u64)
    }

    /// Decodes the view from the bytes of its buffer, which are as long as the document says.
    pub(super) fn decode(&self, buffer: &[u8]) -> Result<Vec<u8>, BrokenRule> {
        let encoded = &buffer[self.start as usize..][..self.length as usize];
        decode(self.layout, encoded).map_err(|damage| BrokenRule::BadCompression {
            place: format!("bufferView {}", self.view),
            why: format!("its bytes are damaged: {damage}"),
        })
    }
}
