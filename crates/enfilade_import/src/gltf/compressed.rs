//! Views that are compressed by meshoptimizer: checked before anything is decoded.
//!
//! What decoders are given is checked here, so that they are never asked for what they do not know; what they make of
//! damaged bytes may be anything, and is checked like anything else in a file.
//! Source: EXT_meshopt_compression and KHR_meshopt_compression, which differ in one filter.

use super::document::{Compression, Document, find};
use crate::BrokenRule;

/// Two names of one thing.
pub(super) const COMPRESSION: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// A view whose bytes are to be decoded.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(
    not(feature = "meshopt"),
    allow(dead_code, reason = "nothing is decoded then")
)]
pub(super) struct Compressed {
    view: u32,
    /// Where the compressed bytes lie.
    pub(super) buffer: u32,
    start: u64,
    length: u64,
    pub(super) stride: usize,
    pub(super) count: usize,
    pub(super) mode: Mode,
    pub(super) filter: Filter,
}

/// What was encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    Attributes,
    Triangles,
    Indices,
}

/// What is done with what is decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

impl Compressed {
    /// Can compressed views be read by this program?
    pub(super) const ARE_READ: bool = cfg!(feature = "meshopt");

    /// What there is to decode for a view; nothing where it is not compressed, or where that cannot be read and the
    /// view's own bytes must serve.
    pub(super) fn of(document: &Document, view: u32) -> Result<Option<Compressed>, BrokenRule> {
        let place = || format!("bufferView {view}");
        let held = find(&document.buffer_views, view, "bufferView", || {
            "the document".to_owned()
        })?;
        let extensions = &held.extensions;
        let Some(source) = extensions.meshopt.as_ref().or(extensions.meshopt_khr.as_ref()) else {
            return Ok(None);
        };
        if !Compressed::ARE_READ {
            return Ok(None);
        }
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
            stride: addressed(byte_stride),
            count: addressed(count),
            mode,
            filter,
        }))
    }

    /// Bytes that it decodes to.
    pub(super) fn decoded_bytes(&self) -> u64 {
        (self.count as u64).saturating_mul(self.stride as u64)
    }

    /// Decodes what lies in the bytes of its buffer, which are as long as the document says.
    #[cfg(feature = "meshopt")]
    pub(super) fn decode(&self, buffer: &[u8]) -> Result<Vec<u8>, BrokenRule> {
        let encoded = &buffer[self.start as usize..][..self.length as usize];
        super::meshopt::decode(self, encoded).ok_or_else(|| BrokenRule::BadCompression {
            place: format!("bufferView {}", self.view),
            why: "its bytes are damaged".to_owned(),
        })
    }

    /// Nothing is compressed for who cannot decode it.
    #[cfg(not(feature = "meshopt"))]
    pub(super) fn decode(&self, _: &[u8]) -> Result<Vec<u8>, BrokenRule> {
        Ok(Vec::new())
    }
}
