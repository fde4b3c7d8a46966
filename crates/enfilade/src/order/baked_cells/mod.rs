//! Baked PVS cells: visits only the items in cells that may be visible from the cells where lines of sight begin.
//!
//! The cell tree finds the cells in which lines of sight begin. The union of their PVS rows is the set of visible
//! cells, whose item lists are emitted. If a line of sight may begin outside every cell, all items are emitted.
//! Source: Teller, Séquin, Visibility Preprocessing for Interactive Walkthroughs, SIGGRAPH 1991, section 4; Boreskov,
//!     Using portals to create aggregate scenes, on potentially visible sets.
//! Cost: building O(faces · depth), more if faces cross many cells; a traversal O(cells / 64 + items in visible cells).
//! Guarantees no order; as strict as the PVS rows are.

mod item_cells;
mod start;

use super::{Order, Unsorted, Visit};
use crate::faces::{FaceSource, Faces};
use crate::geometry::{BakedCells, Geometry, MovedItem, Room};
use crate::ids::ItemIndex;
use crate::sector::{BuildStats, Requirement};
use crate::traversal::{emit_item, emit_openings};
use crate::unsuited::Unsuited;
use crate::view::passage::Passage;
use item_cells::{ItemCells, cells_of_openings};
use start::cells_at_start;
use std::sync::Arc;

/// Traversal of items by baked PVS cells; only for a geometry with baked cells.
pub struct BakedCellsOrder {
    cells: Arc<BakedCells>,
    item_cells: ItemCells,
    /// By opening: the cells it is in; empty if it counts as being everywhere.
    openings: Vec<Vec<u32>>,
}

/// Scratch memory of a traversal.
#[derive(Default)]
pub struct BakedCellsScratch {
    room: Room,
    /// Visible cells, one bit each.
    seen: Vec<u64>,
}

impl BakedCellsScratch {
    fn is_seen(&self, cell: u32) -> bool {
        self.seen[cell as usize / 64] >> (cell % 64) & 1 == 1
    }
}

impl BakedCellsOrder {
    /// Marks the cells that may be visible; returns `false` if everything may be.
    fn mark(&self, geometry: &Geometry, passage: &Passage, scratch: &mut BakedCellsScratch) -> bool {
        let BakedCellsScratch { room, seen } = scratch;
        seen.clear();
        seen.resize(self.cells.cell_count().div_ceil(64), 0);
        // Through an opening that is a plain hole, a line of sight leaves all cells and may enter again anywhere.
        if passage.flat && !geometry.openings().is_empty() {
            return false;
        }
        let mut all = false;
        let known = cells_at_start(&self.cells, passage, room, |cell| {
            put(seen, [cell.0, cell.0 + 1]);
            match self.cells.seen_from(cell) {
                Some(runs) => runs.iter().for_each(|&run| put(seen, run)),
                None => all = true,
            }
        });
        known && !all
    }
}

/// Sets the bits of a run of cells.
fn put(seen: &mut [u64], [first, end]: [u32; 2]) {
    let [first, end] = [first as usize, end as usize];
    let from = first / 64;
    for (word, bits) in (from..).zip(&mut seen[from..end.div_ceil(64)]) {
        let low = first.saturating_sub(64 * word);
        let high = (end - 64 * word).min(64);
        *bits |= (!0 >> (64 - (high - low))) << low;
    }
}

impl Order for BakedCellsOrder {
    type Gives = Unsorted;
    type Scratch = BakedCellsScratch;

    const NAME: &'static str = "BakedCellsOrder";
    const REQUIRES: Option<Requirement> = Some(Requirement::BakedCells);
    const INCLUDES_OPENINGS: bool = true;

    fn suits(geometry: &Geometry) -> bool {
        geometry.cells().is_some()
    }

    fn build(geometry: &Geometry, limit_bytes: u64) -> Result<BakedCellsOrder, Unsuited> {
        let cells = Arc::clone(geometry.cells().ok_or(Unsuited::NotBaked)?);
        let item_cells =
            ItemCells::new(&cells, geometry, limit_bytes).ok_or_else(|| Unsuited::exceeds(limit_bytes))?;
        let openings = cells_of_openings(&cells, geometry);
        Ok(BakedCellsOrder {
            cells,
            item_cells,
            openings,
        })
    }

    fn needs_bytes(geometry: &Geometry) -> u64 {
        // Most items are in one or two cells. If they are in more, building measures it and returns `TooLarge`.
        const EACH_ITEM: u64 = 48;
        const EACH_CELL: u64 = 32;
        let cells = geometry.cells().map_or(0, |cells| cells.cell_count() as u64);
        geometry.items().len() as u64 * EACH_ITEM + cells * EACH_CELL
    }

    fn bytes(&self) -> u64 {
        // The geometry owns the cells.
        let of_opening = |cells: &Vec<u32>| (size_of_val(&**cells) + size_of::<Vec<u32>>()) as u64;
        self.item_cells.bytes() + self.openings.iter().map(of_opening).sum::<u64>()
    }

    fn build_stats(&self, geometry: &Geometry) -> BuildStats {
        BuildStats {
            faces: geometry.face_count(),
            depth: self.cells.depth(),
            ..BuildStats::default()
        }
    }

    fn follow(&mut self, geometry: &Geometry, moved: &[MovedItem], touched: &mut Vec<u32>) -> bool {
        self.item_cells.follow(&self.cells, geometry, moved, touched);
        true
    }

    fn visit(
        &self,
        geometry: &Geometry,
        passage: &Passage,
        scratch: &mut BakedCellsScratch,
        visit: &mut impl Visit,
    ) {
        if !self.mark(geometry, passage, scratch) {
            emit_openings(geometry, passage, visit);
            for item in 0..geometry.items().len() as u32 {
                emit_item(geometry, passage, ItemIndex(item), visit);
            }
            return;
        }
        Faces::of_openings(geometry, passage, |faces| {
            let FaceSource::Opening(opening) = faces.source else {
                return;
            };
            let cells = &self.openings[usize::from(opening.0)];
            // PVS rows hold from the near plane on, or from the last portal; an opening before the near plane is always
            // emitted.
            let bounds = geometry.openings()[usize::from(opening.0)].outline.bounds();
            let region = passage.region_around_openings(&bounds);
            if cells.is_empty()
                || region.is_some_and(|region| passage.is_before_near(&region))
                || cells.iter().any(|&cell| scratch.is_seen(cell))
            {
                visit.faces(faces);
            }
        });
        for &item in self.item_cells.everywhere() {
            emit_item(geometry, passage, ItemIndex(item), visit);
        }
        for (word, &cells) in scratch.seen.iter().enumerate() {
            let mut left = cells;
            while left != 0 {
                let cell = 64 * word as u32 + left.trailing_zeros();
                left &= left - 1;
                for &item in self.item_cells.in_cell(cell) {
                    emit_item(geometry, passage, ItemIndex(item), visit);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_of_cells_sets_its_bits_in_every_word_it_crosses() {
        for run in [[3, 5], [0, 64], [63, 65], [70, 200], [128, 192], [191, 192]] {
            let mut seen = [0; 4];
            put(&mut seen, run);
            for cell in 0..256_u32 {
                let is_set = seen[cell as usize / 64] >> (cell % 64) & 1 == 1;
                assert_eq!(is_set, (run[0]..run[1]).contains(&cell), "cell {cell} of {run:?}");
            }
        }
    }
}
