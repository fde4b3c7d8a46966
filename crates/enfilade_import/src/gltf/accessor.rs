//! Accessors: typed rows of elements in the buffers, checked before anything is read.
//!
//! An accessor is checked against what its view and buffer say of themselves, in integers that cannot overflow; a
//! buffer is checked against its bytes when it is loaded. Together: every element lies in bytes that are there.
//! Source: glTF 2.0 Specification, section 3.6.2.

use super::buffers::Buffers;
use super::document::{Accessor, Document, find, short};
use crate::BrokenRule;

/// A row of elements, known to lie inside their buffer.
#[derive(Clone, Debug)]
pub(super) struct Row {
    /// Where the elements lie; `None` where all are zero.
    place: Option<RowPlace>,
    /// How many elements there are.
    pub(super) count: u64,
    component: Component,
}

#[derive(Clone, Copy, Debug)]
struct RowPlace {
    buffer: u32,
    start: u64,
    stride: u64,
}

/// What an accessor is wanted for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Wanted {
    Positions,
    Indices,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Component {
    U8,
    U16,
    U32,
    F32,
}

impl Row {
    /// Checks an accessor and everything it names.
    pub(super) fn new(
        document: &Document,
        index: u32,
        wanted: Wanted,
        user: impl FnOnce() -> String,
    ) -> Result<Row, BrokenRule> {
        let accessor = find(&document.accessors, index, "accessor", user)?;
        let place = || format!("accessor {index}");
        let component = component(accessor, wanted).ok_or_else(|| wrong_type(place(), accessor, wanted))?;
        if accessor.sparse.is_some() {
            let remedy = "export it again without sparse accessors";
            return Err(BrokenRule::NotReadYet {
                place: place(),
                what: "sparse",
                remedy,
            });
        }
        let count = accessor.count;
        let Some(view_index) = accessor.buffer_view else {
            return Ok(Row {
                place: None,
                count,
                component,
            });
        };
        let view = find(&document.buffer_views, view_index, "bufferView", place)?;
        let view_place = || format!("bufferView {view_index}");
        let buffer = find(&document.buffers, view.buffer, "buffer", view_place)?;
        let end = u128::from(view.byte_offset) + u128::from(view.byte_length);
        if end > u128::from(buffer.byte_length) {
            let (buffer, length) = (view.buffer, buffer.byte_length);
            return Err(BrokenRule::ViewOutOfBuffer {
                place: view_place(),
                end,
                buffer,
                length,
            });
        }
        let element = component.element_bytes();
        let stride = view.byte_stride.unwrap_or(element);
        if stride < element {
            return Err(BrokenRule::BadStride {
                place: place(),
                view: view_index,
                stride,
                element,
            });
        }
        // The last element needs no gap behind it. Products and sums of numbers below 2⁶⁴ fit into u128 here.
        let last = u128::from(stride) * u128::from(count.saturating_sub(1));
        let last_bytes = if count > 0 { element } else { 0 };
        let end = u128::from(accessor.byte_offset) + last + u128::from(last_bytes);
        if end > u128::from(view.byte_length) {
            let length = view.byte_length;
            return Err(BrokenRule::AccessorOutOfView {
                place: place(),
                end,
                view: view_index,
                length,
            });
        }
        let start = view.byte_offset + accessor.byte_offset;
        Ok(Row {
            place: Some(RowPlace {
                buffer: view.buffer,
                start,
                stride,
            }),
            count,
            component,
        })
    }

    /// Does it stand nowhere, so that all its elements are zero?
    pub(super) fn is_zeros(&self) -> bool {
        self.place.is_none()
    }

    /// The buffer that it lies in.
    pub(super) fn buffer(&self) -> Option<u32> {
        self.place.map(|place| place.buffer)
    }

    /// The row's elements, by number. `buffers` must hold [`Row::buffer`].
    pub(super) fn elements<'b>(&self, buffers: &'b Buffers) -> Elements<'b> {
        let place = self.place.map(
            |RowPlace {
                 buffer,
                 start,
                 stride,
             }| {
                // Checked against the buffer, whose bytes are in memory: these numbers fit.
                (&buffers.bytes(buffer)[start as usize..], stride as usize)
            },
        );
        Elements { place }
    }

    /// All elements as indices.
    pub(super) fn indices(&self, buffers: &Buffers) -> Vec<u32> {
        let elements = self.elements(buffers);
        let all = 0..self.count as usize;
        match self.component {
            Component::U8 => all.map(|i| u32::from(elements.bytes::<1>(i)[0])).collect(),
            Component::U16 => all
                .map(|i| u32::from(u16::from_le_bytes(elements.bytes(i))))
                .collect(),
            Component::U32 | Component::F32 => all.map(|i| u32::from_le_bytes(elements.bytes(i))).collect(),
        }
    }
}

/// Elements that are read one by one.
pub(super) struct Elements<'b> {
    /// The bytes from the first element on, and from one element to the next.
    place: Option<(&'b [u8], usize)>,
}

impl Elements<'_> {
    /// An element that is a position.
    pub(super) fn position(&self, index: u32) -> [f32; 3] {
        let bytes: [u8; 12] = self.bytes(index as usize);
        std::array::from_fn(|axis| f32::from_le_bytes(std::array::from_fn(|byte| bytes[4 * axis + byte])))
    }

    #[inline]
    fn bytes<const SIZE: usize>(&self, index: usize) -> [u8; SIZE] {
        let Some((bytes, stride)) = self.place else {
            return [0; SIZE];
        };
        *bytes[index * stride..]
            .first_chunk()
            .expect("an element that was checked")
    }
}

impl Component {
    /// Bytes of a position of floats, or of an index.
    fn element_bytes(self) -> u64 {
        match self {
            Component::U8 => 1,
            Component::U16 => 2,
            Component::U32 => 4,
            Component::F32 => 12,
        }
    }
}

fn component(accessor: &Accessor, wanted: Wanted) -> Option<Component> {
    match (wanted, &*accessor.shape, accessor.component_type) {
        (Wanted::Positions, "VEC3", 5126) => Some(Component::F32),
        (Wanted::Indices, "SCALAR", 5121) => Some(Component::U8),
        (Wanted::Indices, "SCALAR", 5123) => Some(Component::U16),
        (Wanted::Indices, "SCALAR", 5125) => Some(Component::U32),
        _ => None,
    }
}

fn wrong_type(place: String, accessor: &Accessor, wanted: Wanted) -> BrokenRule {
    let component = match accessor.component_type {
        5120 => "BYTE".to_owned(),
        5121 => "UNSIGNED_BYTE".to_owned(),
        5122 => "SHORT".to_owned(),
        5123 => "UNSIGNED_SHORT".to_owned(),
        5125 => "UNSIGNED_INT".to_owned(),
        5126 => "FLOAT".to_owned(),
        other => format!("component type {other}"),
    };
    let found = format!("{} of {component}", short(&accessor.shape));
    let (wanted, remedy) = match wanted {
        Wanted::Positions => (
            "positions as VEC3 of FLOAT",
            "export it again without quantization (KHR_mesh_quantization)",
        ),
        Wanted::Indices => (
            "indices as SCALAR of UNSIGNED_BYTE, UNSIGNED_SHORT or UNSIGNED_INT",
            "export it again",
        ),
    };
    BrokenRule::WrongType {
        place,
        found,
        wanted,
        remedy,
    }
}
