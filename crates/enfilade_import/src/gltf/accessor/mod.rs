//! Accessors: typed rows of elements in the buffers, checked before anything is read.
//!
//! An accessor is checked against what its view and buffer say of themselves, in integers that cannot overflow; a
//! buffer is checked against its bytes when it is loaded. Together: every element lies in bytes that are there.
//! Source: glTF 2.0 Specification, section 3.6.2.

mod elements;
mod sparse;
mod stretch;
mod wanted;

pub(super) use elements::Elements;
pub(super) use stretch::Stretch;
pub(super) use wanted::Wanted;

use super::buffers::{Buffers, Source};
use super::document::{Document, find};
use crate::BrokenRule;
use elements::{Component, Kind};
use sparse::Sparse;

/// A row of elements, known to lie inside their buffer.
#[derive(Clone, Debug)]
pub(super) struct Row {
    accessor: u32,
    /// Where the elements lie; `None` where all are zero.
    base: Option<Stretch>,
    /// Those that stand instead of some of them.
    sparse: Option<Sparse>,
    /// How many elements there are.
    pub(super) count: u64,
    kind: Kind,
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
        let kind = wanted.kind(accessor, place)?;
        let element = kind.bytes();
        let base = match accessor.buffer_view {
            Some(view) => Some(Stretch::of_elements(
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

    /// Does it stand nowhere, so that all its elements are zero?
    pub(super) fn is_zeros(&self) -> bool {
        self.base.is_none() && self.sparse.is_none()
    }

    /// Numbers in an element, 1 to 4.
    pub(super) fn parts(&self) -> u8 {
        self.kind.parts
    }

    /// What it lies in.
    pub(super) fn sources(&self) -> impl Iterator<Item = Source> {
        let sparse = self.sparse.iter().flat_map(Sparse::sources);
        self.base.iter().map(|base| base.source).chain(sparse)
    }

    /// The number of its accessor, if that has elements which stand instead of others: these are to be checked, once for
    /// all rows of the accessor, by [`Row::check_sparse`].
    pub(super) fn sparse_accessor(&self) -> Option<u32> {
        self.sparse.as_ref().map(|_| self.accessor)
    }

    /// Do the numbers of the elements that stand instead of others name some, in order?
    pub(super) fn check_sparse(&self, buffers: &Buffers) -> Result<(), BrokenRule> {
        match &self.sparse {
            Some(sparse) => sparse.check(buffers, self.count, || format!("accessor {}", self.accessor)),
            None => Ok(()),
        }
    }

    /// The row's elements, by number. `buffers` must hold all [`Row::sources`].
    pub(super) fn elements<'b>(&self, buffers: &'b Buffers) -> Elements<'b> {
        Elements::new(
            self.base.as_ref().map(|base| base.bytes(buffers)),
            self.sparse.as_ref().map(|sparse| sparse.replacements(buffers)),
            self.kind,
        )
    }

    /// All elements as indices.
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
