//! Traversal without culling: measures an order alone.

use crate::faces::Faces;
use crate::geometry::{Geometry, ItemId};
use crate::memory::{Marks, Memory};
use crate::order::{Order, Visit};
use crate::passage::Passage;
use crate::region::{Region, Visibility};

/// Counts the faces that an order emits; culls nothing.
pub(super) struct Count<'a> {
    pub(super) faces: u64,
    marks: &'a mut Marks,
}

impl<'a> Count<'a> {
    pub(super) fn new(marks: &'a mut Marks) -> Count<'a> {
        Count { faces: 0, marks }
    }
}

impl Visit for Count<'_> {
    fn enter(&mut self, _region: &Region) -> Visibility {
        Visibility::Partial
    }

    fn first_time(&mut self, item: ItemId) -> bool {
        self.marks.first_time(item)
    }

    fn faces(&mut self, faces: &Faces) {
        self.faces += faces.count() as u64;
    }
}

/// Traverses an order and returns the number of faces emitted.
pub(super) fn count_faces<O: Order>(
    order: &O,
    geometry: &Geometry,
    passage: &Passage,
    memory: &mut Memory,
) -> u64 {
    let mut scratch = memory.take::<O::Scratch>();
    memory.marks.begin(geometry.items().len());
    let mut count = Count::new(&mut memory.marks);
    order.visit(geometry, passage, &mut scratch, &mut count);
    let faces = count.faces;
    memory.put_back(scratch);
    faces
}
