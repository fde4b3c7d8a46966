//! Cells computed ahead: the items that stand in a cell which may be seen from where sight begins, and no others.
//!
//! The cells in which lines of sight begin are looked up in the tree; their rows together say which cells are seen, and the
//! lists of those which items are in them. Where lines may begin in no cell, all items come.
//! Source: Teller, Séquin, Visibility Preprocessing for Interactive Walkthroughs, SIGGRAPH 1991, section 4; Boreskov, Using
//!     portals to create aggregate scenes, on potentially visible sets.
//! Cost: building O(faces · depth), and more where faces cross many cells; a walk O(cells / 64 + items in cells seen).
//! Gives no order; strict as the rows are.

mod stands;
mod start;

use super::items::{hand_out, hand_out_openings};
use super::{Order, Refusal, Unsorted, Visit};
use crate::faces::{FaceSource, Faces};
use crate::geometry::{BakedCells, Geometry, ItemId, MovedItem, Room};
use crate::passage::Passage;
use crate::sector::BuildStats;
use stands::{Stands, cells_of_openings};
use start::cells_at_start;
use std::sync::Arc;

/// Items by the cells that they stand in; only for a geometry that has cells.
pub struct BakedCellsOrder {
    cells: Arc<BakedCells>,
    stands: Stands,
    /// By opening: the cells that it stands in; none where it is everywhere.
    openings: Vec<Vec<u32>>,
}

/// What a walk needs.
#[derive(Default)]
pub struct BakedCellsScratch {
    room: Room,
    /// The cells that are seen, a bit for each.
    seen: Vec<u64>,
}

impl BakedCellsScratch {
    fn is_seen(&self, cell: u32) -> bool {
        self.seen[cell as usize / 64] >> (cell % 64) & 1 == 1
    }
}

impl BakedCellsOrder {
    /// Marks the cells that may be seen; `false` where that is everything.
    fn mark(&self, geometry: &Geometry, passage: &Passage, scratch: &mut BakedCellsScratch) -> bool {
        let BakedCellsScratch { room, seen } = scratch;
        seen.clear();
        seen.resize(self.cells.cell_count().div_ceil(64), 0);
        // Through an opening that is a plain hole one sees what is outside of all cells, and in again by another.
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

    fn build(geometry: &Geometry, limit_bytes: u64) -> Result<BakedCellsOrder, Refusal> {
        let cells = Arc::clone(geometry.cells().ok_or(Refusal::NotBaked)?);
        let stands = Stands::new(&cells, geometry, limit_bytes).ok_or(Refusal::TooLarge)?;
        let openings = cells_of_openings(&cells, geometry);
        Ok(BakedCellsOrder {
            cells,
            stands,
            openings,
        })
    }

    fn needs_bytes(geometry: &Geometry) -> u64 {
        // Most items stand in a cell or two; what stands in more is found out, and refused, while it is built.
        const EACH_ITEM: u64 = 48;
        const EACH_CELL: u64 = 32;
        let cells = geometry.cells().map_or(0, |cells| cells.cell_count() as u64);
        geometry.items().len() as u64 * EACH_ITEM + cells * EACH_CELL
    }

    fn bytes(&self) -> u64 {
        // The cells are the geometry's.
        let of_opening = |cells: &Vec<u32>| (size_of_val(&**cells) + size_of::<Vec<u32>>()) as u64;
        self.stands.bytes() + self.openings.iter().map(of_opening).sum::<u64>()
    }

    fn build_stats(&self, geometry: &Geometry) -> BuildStats {
        BuildStats {
            faces: geometry.face_count(),
            depth: self.cells.depth(),
            ..BuildStats::default()
        }
    }

    fn follow(&mut self, geometry: &Geometry, moved: &[MovedItem], touched: &mut Vec<u32>) -> bool {
        self.stands.follow(&self.cells, geometry, moved, touched);
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
            hand_out_openings(geometry, passage, visit);
            for item in 0..geometry.items().len() as u32 {
                hand_out(geometry, passage, ItemId(item), visit);
            }
            return;
        }
        Faces::of_openings(geometry, passage, |faces| {
            let FaceSource::Opening(opening) = faces.source else {
                return;
            };
            let cells = &self.openings[usize::from(opening.0)];
            // Rows say what is seen from the near distance on, or from the last portal; openings come before, too.
            let bounds = geometry.openings()[usize::from(opening.0)].outline.bounds();
            let region = passage.region_around_openings(&bounds);
            if cells.is_empty()
                || region.is_some_and(|region| passage.is_before_near(&region))
                || cells.iter().any(|&cell| scratch.is_seen(cell))
            {
                visit.faces(faces);
            }
        });
        for &item in self.stands.everywhere() {
            hand_out(geometry, passage, ItemId(item), visit);
        }
        for (word, &cells) in scratch.seen.iter().enumerate() {
            let mut left = cells;
            while left != 0 {
                let cell = 64 * word as u32 + left.trailing_zeros();
                left &= left - 1;
                for &item in self.stands.in_cell(cell) {
                    hand_out(geometry, passage, ItemId(item), visit);
                }
            }
        }
    }
}
