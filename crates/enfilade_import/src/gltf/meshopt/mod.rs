//! Decodes buffer views compressed by meshoptimizer: vertex attributes, triangles and index sequences.
//!
//! One decoder per mode reads its stream from front to back; a filter then turns attributes into their final numbers.
//! Source: KHR_meshopt_compression, appendices A (bitstream) and B (filters); EXT_meshopt_compression is its version 0.
//! Cost: O(decoded bytes). Memory: the decoded bytes, at most 1,024 times the encoded ones.
//! Any bytes give an error or exactly `count` elements, never a panic; the result is the same on every machine.

mod filters;
mod indices;
#[cfg(test)]
mod tests;
mod vertices;

use super::compressed::{Filter, Mode};

/// The layout of a compressed buffer view, checked by [`Compressed::of`](super::compressed::Compressed::of).
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    pub(super) mode: Mode,
    pub(super) filter: Filter,
    /// Number of elements; a multiple of 3 for triangles. Times `stride` it fits into memory.
    pub(super) count: usize,
    /// Bytes per element: 2 or 4 for indices; for attributes a multiple of 4 up to 256, 4 or 8 if a filter needs that.
    pub(super) stride: usize,
}

/// The rule that an encoded stream breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum Damage {
    #[error("the stream ends too early")]
    TooShort,
    #[error("{0} bytes are left over")]
    LeftOver(usize),
    #[error("the stream begins with the byte {0:#04x}, which is not a header of its mode")]
    Header(u8),
    #[error("channel mode {0:#04x} does not exist")]
    ChannelMode(u8),
    #[error("its table of triangle codes has an entry {0:#04x}, which is not allowed")]
    CodeTable(u8),
    #[error("a triangle refers to a recent vertex or edge before there is one")]
    NotYetSeen,
    #[error("a number is longer than 5 bytes")]
    LongNumber,
}

/// Decodes `layout.count` elements of `layout.stride` bytes, whose numbers are little-endian.
pub(super) fn decode(layout: Layout, encoded: &[u8]) -> Result<Vec<u8>, Damage> {
    let Layout { count, stride, .. } = layout;
    // Encoders write no bytes at all for no elements, not even a header.
    if count == 0 {
        return Ok(Vec::new());
    }
    match layout.mode {
        Mode::Attributes => {
            let mut decoded = vertices::decode(encoded, count, stride)?;
            filters::apply(layout.filter, stride, &mut decoded);
            Ok(decoded)
        }
        Mode::Triangles => indices::decode_triangles(encoded, count, stride),
        Mode::Indices => indices::decode_sequence(encoded, count, stride),
    }
}

/// Encoded bytes that are not read yet.
struct Stream<'a>(&'a [u8]);

impl<'a> Stream<'a> {
    /// Splits an encoded view into its version, the stream between header and tail, and the tail.
    ///
    /// The header is one byte: `mode` in the high four bits, the version, 0 or 1, in the low four. `tail` returns the length
    /// of the tail by the version.
    fn open(encoded: &'a [u8], mode: u8, tail: impl Fn(u8) -> usize) -> Result<(u8, Self, &'a [u8]), Damage> {
        let (&header, rest) = encoded.split_first().ok_or(Damage::TooShort)?;
        let version = header ^ mode;
        if version > 1 {
            return Err(Damage::Header(header));
        }
        let length = rest.len().checked_sub(tail(version)).ok_or(Damage::TooShort)?;
        let (stream, tail) = rest.split_at(length);
        Ok((version, Stream(stream), tail))
    }

    fn take(&mut self, bytes: usize) -> Result<&'a [u8], Damage> {
        let (taken, rest) = self.0.split_at_checked(bytes).ok_or(Damage::TooShort)?;
        self.0 = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Result<u8, Damage> {
        let (&byte, rest) = self.0.split_first().ok_or(Damage::TooShort)?;
        self.0 = rest;
        Ok(byte)
    }

    /// An LEB128 number of at most 5 bytes; bits beyond 32 are dropped.
    fn number(&mut self) -> Result<u32, Damage> {
        let mut number = 0;
        for shift in (0..35).step_by(7) {
            let byte = self.byte()?;
            number |= u32::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(number);
            }
        }
        Err(Damage::LongNumber)
    }

    /// Checks that all bytes are read: a stream does not store its length, so bytes left over are damage.
    fn finish(self) -> Result<(), Damage> {
        match self.0.len() {
            0 => Ok(()),
            left => Err(Damage::LeftOver(left)),
        }
    }
}
