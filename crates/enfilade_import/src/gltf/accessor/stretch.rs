//! Strided ranges: elements of equal size at a constant stride, known to be within their buffer view and buffer.

use crate::BrokenRule;
use crate::gltf::buffers::{Buffers, Source};
use crate::gltf::compressed::Compressed;
use crate::gltf::document::{BufferView, Document, find};

/// The position of elements in a buffer or a decoded buffer view.
#[derive(Clone, Copy, Debug)]
pub(in crate::gltf) struct StridedRange {
    pub(in crate::gltf) source: Source,
    start: u64,
    stride: u64,
}

impl StridedRange {
    /// Returns the range of an accessor's elements; without a `byteStride`, they are tightly packed.
    pub(super) fn of_elements(
        document: &Document,
        view: u32,
        offset: u64,
        count: u64,
        element: u64,
        place: impl Fn() -> String,
    ) -> Result<StridedRange, BrokenRule> {
        let held = find(&document.buffer_views, view, "bufferView", &place)?;
        let stride = held.byte_stride.unwrap_or(element);
        if stride < element {
            return Err(BrokenRule::BadStride {
                place: place(),
                view,
                stride,
                element,
            });
        }
        StridedRange::new(document, view, offset, [count, element, stride], place)
    }

    /// Returns a range of tightly packed elements.
    pub(super) fn packed(
        document: &Document,
        view: u32,
        offset: u64,
        count: u64,
        element: u64,
        place: impl Fn() -> String,
    ) -> Result<StridedRange, BrokenRule> {
        StridedRange::new(document, view, offset, [count, element, element], place)
    }

    /// Returns the bytes of a whole buffer view, and their number.
    pub(in crate::gltf) fn whole_view(
        document: &Document,
        view: u32,
        place: impl Fn() -> String,
    ) -> Result<(StridedRange, u64), BrokenRule> {
        let length = find(&document.buffer_views, view, "bufferView", &place)?.byte_length;
        Ok((
            StridedRange::new(document, view, 0, [length, 1, 1], place)?,
            length,
        ))
    }

    fn new(
        document: &Document,
        view: u32,
        offset: u64,
        [count, element, stride]: [u64; 3],
        place: impl Fn() -> String,
    ) -> Result<StridedRange, BrokenRule> {
        let held = find(&document.buffer_views, view, "bufferView", &place)?;
        let (source, view_start) = match Compressed::of(document, view)? {
            Some(_) => (Source::View(view), 0),
            None => (Source::Buffer(held.buffer), in_buffer(document, view, held)?),
        };
        // The last element needs no padding after it. Products and sums of numbers below 2⁶⁴ fit into u128 here.
        let last = u128::from(stride) * u128::from(count.saturating_sub(1));
        let last_bytes = if count > 0 { element } else { 0 };
        let end = u128::from(offset) + last + u128::from(last_bytes);
        if end > u128::from(held.byte_length) {
            let length = held.byte_length;
            return Err(BrokenRule::AccessorOutOfView {
                place: place(),
                end,
                view,
                length,
            });
        }
        Ok(StridedRange {
            source,
            start: view_start + offset,
            stride,
        })
    }

    /// Returns the bytes from the first element on, and the stride.
    pub(in crate::gltf) fn bytes<'b>(&self, buffers: &'b Buffers) -> (&'b [u8], usize) {
        // Both numbers fit into usize: they were checked against the source, whose bytes are in memory.
        let bytes = &buffers.bytes(self.source)[self.start as usize..];
        (bytes, self.stride as usize)
    }
}

/// Returns the offset of a buffer view in its buffer, after checking that it is within the buffer.
fn in_buffer(document: &Document, number: u32, view: &BufferView) -> Result<u64, BrokenRule> {
    let place = || format!("bufferView {number}");
    let buffer = find(&document.buffers, view.buffer, "buffer", place)?;
    let end = u128::from(view.byte_offset) + u128::from(view.byte_length);
    if end > u128::from(buffer.byte_length) {
        return Err(BrokenRule::ViewOutOfBuffer {
            place: place(),
            end,
            buffer: view.buffer,
            length: buffer.byte_length,
        });
    }
    Ok(view.byte_offset)
}
