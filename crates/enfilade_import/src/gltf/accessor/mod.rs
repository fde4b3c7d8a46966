//! Accessors: typed arrays in the buffers, validated before anything is read.
//!
//! An accessor is checked against the declared sizes of its buffer view and buffer, in integers that cannot overflow; a
//! buffer is checked against its declared size when it is loaded. Together, these keep every element within the loaded
//! bytes.
//! Source: glTF 2.0 Specification, section 3.6.2.

mod elements;
mod sparse;
mod stretch;
mod wanted;

pub(super) use elements::Elements;
pub(super) use stretch::StridedRange;
pub(super) use wanted::AccessorUse;

use super::buffers::{Buffers, Source};
use super::document::{Document, find};
use crate::BrokenRule;
use elements::{Component, Kind};
use sparse::Sparse;

/// An accessor whose elements are known to be within their buffer.
#[derive(Clone, Debug)]
pub(super) struct Row {
    accessor: u32,
    /// Position of the elements; `None` if all are zero.
    base: Option<StridedRange>,
    /// Elements that are replaced.
    sparse: Option<Sparse>,
    /// Number of elements.
    pub(super) count: u64,
    kind: Kind,
}

impl Row {
    /// Checks an accessor and everything that it references.
    pub(super) fn new(
        document: &Document,
        index: u32,
        wanted: AccessorUse,
        user: impl FnOnce() -> String,
    ) -> Result<Row, BrokenRule> {
        let accessor = find(&document.accessors, index, "accessor", user)?;
        let place = || format!("accessor {index}");
        let kind = wanted.kind(accessor, place)?;
        let element = kind.bytes();
        let base = match accessor.buffer_view {
            Some(view) => Some(StridedRange::of_elements(
                document,
                view,
                accessor.byte_offset,
                accessor.count,
                element,
                place,
            )?),
            None => None,
        };
        let sparse = match &accessor.sparse {
            Some(sparse) => Some(Sparse::new(document, sparse, accessor.count, element, &place)?),
            None => None,
        };
        Ok(Row {
            accessor: index,
            base,
            sparse,
            count: accessor.count,
            kind,
        })
    }

    /// Returns `true` if the accessor has neither a buffer view nor sparse values, so all its elements are zero.
    pub(super) fn is_zeros(&self) -> bool {
        self.base.is_none() && self.sparse.is_none()
    }

    /// Returns the number of components per element, 1 to 4, or 16.
    pub(super) fn parts(&self) -> u8 {
        self.kind.parts
    }

    /// Returns the buffers and compressed buffer views that the elements are in.
    pub(super) fn sources(&self) -> impl Iterator<Item = Source> {
        let sparse = self.sparse.iter().flat_map(Sparse::sources);
        self.base.iter().map(|base| base.source).chain(sparse)
    }

    /// Returns the index of the accessor if it is sparse. Check its sparse indices once per accessor with
    /// [`Row::check_sparse`].
    pub(super) fn sparse_accessor(&self) -> Option<u32> {
        self.sparse.as_ref().map(|_| self.accessor)
    }

    /// Checks that the sparse indices increase and are in range.
    pub(super) fn check_sparse(&self, buffers: &Buffers) -> Result<(), BrokenRule> {
        match &self.sparse {
            Some(sparse) => sparse.check(buffers, self.count, || format!("accessor {}", self.accessor)),
            None => Ok(()),
        }
    }

    /// Returns the elements. `buffers` must hold all [`Row::sources`].
    pub(super) fn elements<'b>(&self, buffers: &'b Buffers) -> Elements<'b> {
        Elements::new(
            self.base.as_ref().map(|base| base.bytes(buffers)),
            self.sparse.as_ref().map(|sparse| sparse.replacements(buffers)),
            self.kind,
        )
    }

    /// Returns all elements as vertex indices.
    pub(super) fn indices(&self, buffers: &Buffers) -> Vec<u32> {
        let elements = self.elements(buffers);
        let all = 0..self.count as usize;
        match self.kind.component {
            Component::U8 => all.map(|i| elements.u8(i)).collect(),
            Component::U16 => all.map(|i| elements.u16(i)).collect(),
            _ => all.map(|i| elements.u32(i)).collect(),
        }
    }
}
