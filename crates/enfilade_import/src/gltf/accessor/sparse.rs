//! Sparse accessors: some elements are replaced by values that are stored separately, with their indices.
//!
//! The indices are checked once, and then binary-searched in the buffer: nothing is copied, however many rows use them.
//! Cost: O(indices) to check; O(log indices) for each element that is read.
//! Source: glTF 2.0 Specification, section 3.6.2.3.

use super::StridedRange;
use super::elements::{Component, Replacements};
use crate::BrokenRule;
use crate::gltf::buffers::{Buffers, Source};
use crate::gltf::document::{self, Document};

/// The replacement values of a sparse accessor.
#[derive(Clone, Debug)]
pub(super) struct Sparse {
    count: u64,
    numbers: StridedRange,
    number_kind: Component,
    values: StridedRange,
}

impl Sparse {
    pub(super) fn new(
        document: &Document,
        sparse: &document::Sparse,
        elements: u64,
        element_bytes: u64,
        place: &dyn Fn() -> String,
    ) -> Result<Sparse, BrokenRule> {
        let document::Sparse {
            count,
            indices,
            values,
        } = sparse;
        if *count > elements {
            return Err(BrokenRule::SparseCount {
                place: place(),
                count: *count,
                elements,
            });
        }
        let number_kind =
            Component::of_index(indices.component_type).ok_or_else(|| BrokenRule::WrongType {
                place: format!("{}.sparse.indices", place()),
                found: format!("component type {}", indices.component_type),
                wanted: "UNSIGNED_BYTE, UNSIGNED_SHORT or UNSIGNED_INT",
                remedy: "export it again",
            })?;
        let numbers = StridedRange::packed(
            document,
            indices.buffer_view,
            indices.byte_offset,
            *count,
            number_kind.bytes(),
            || format!("{}.sparse.indices", place()),
        )?;
        let values = StridedRange::packed(
            document,
            values.buffer_view,
            values.byte_offset,
            *count,
            element_bytes,
            || format!("{}.sparse.values", place()),
        )?;
        Ok(Sparse {
            count: *count,
            numbers,
            number_kind,
            values,
        })
    }

    pub(super) fn sources(&self) -> impl Iterator<Item = Source> {
        [self.numbers.source, self.values.source].into_iter()
    }

    /// Checks that the sparse indices increase and are below `elements`.
    pub(super) fn check(
        &self,
        buffers: &Buffers,
        elements: u64,
        place: impl Fn() -> String,
    ) -> Result<(), BrokenRule> {
        let found = self.replacements(buffers);
        let mut least = 0_u64;
        for at in 0..found.count {
            let number = u64::from(found.number(at));
            if number < least || number >= elements {
                return Err(BrokenRule::SparseIndex {
                    place: place(),
                    at,
                    number,
                    elements,
                });
            }
            least = number + 1;
        }
        Ok(())
    }

    pub(super) fn replacements<'b>(&self, buffers: &'b Buffers) -> Replacements<'b> {
        Replacements {
            count: self.count as usize,
            numbers: self.numbers.bytes(buffers).0,
            number_kind: self.number_kind,
            values: self.values.bytes(buffers).0,
        }
    }
}
