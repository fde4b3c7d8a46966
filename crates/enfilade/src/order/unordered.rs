//! No order: items by their number.
//!
//! Nothing is built, so geometry may change freely; items outside the aperture are still culled.
//! Source: the z-buffer needs no order (Catmull 1974); Boreskov, Using portals to create aggregate scenes.
//! Cost: no build; a traversal O(items), and O(log faces) for each large item that is partly outside.
//! Guarantees nothing: only covers that require no order accept it.

use super::{Order, Unsorted, Visit};
use crate::geometry::{Geometry, MovedItem};
use crate::ids::ItemIndex;
use crate::traversal::{emit_item, emit_openings};
use crate::unsuited::Unsuited;
use crate::view::passage::Passage;

/// Items in order of their numbers, culled against the aperture. Needs no build; a traversal takes O(items).
pub struct Unordered;

impl Order for Unordered {
    type Gives = Unsorted;
    type Scratch = ();

    const NAME: &'static str = "Unordered";

    fn build(_geometry: &Geometry, _limit_bytes: u64) -> Result<Unordered, Unsuited> {
        Ok(Unordered)
    }

    fn needs_bytes(_geometry: &Geometry) -> u64 {
        0
    }

    fn bytes(&self) -> u64 {
        0
    }

    fn follow(&mut self, _geometry: &Geometry, _moved: &[MovedItem], _touched: &mut Vec<u32>) -> bool {
        // The order depends on item numbers only.
        true
    }

    fn visit(&self, geometry: &Geometry, passage: &Passage, _scratch: &mut (), visit: &mut impl Visit) {
        emit_openings(geometry, passage, visit);
        for item in 0..geometry.items().len() as u32 {
            emit_item(geometry, passage, ItemIndex(item), visit);
        }
    }
}
