//! Unordered: items as they come, by their number.
//!
//! Nothing is built, so geometry may change at will; what is outside the aperture is still left out.
//! Source: the z-buffer needs no order (Catmull 1974); Boreskov, Using portals to create aggregate scenes.
//! Cost: building nothing; a walk O(items), and O(log faces) for each large one that is half outside.
//! Gives nothing: only covers that need no order take it.

use super::items::{hand_out, hand_out_openings};
use super::{Order, Refusal, Unsorted, Visit};
use crate::geometry::{Geometry, ItemId, MovedItem};
use crate::passage::Passage;

/// Items as they come, by their number.
pub struct Unordered;

impl Order for Unordered {
    type Gives = Unsorted;
    type Scratch = ();

    fn build(_geometry: &Geometry, _limit_bytes: u64) -> Result<Unordered, Refusal> {
        Ok(Unordered)
    }

    fn needs_bytes(_geometry: &Geometry) -> u64 {
        0
    }

    fn bytes(&self) -> u64 {
        0
    }

    fn follow(&mut self, _geometry: &Geometry, _moved: &[MovedItem], _touched: &mut Vec<u32>) -> bool {
        // It goes by numbers alone.
        true
    }

    fn visit(&self, geometry: &Geometry, passage: &Passage, _scratch: &mut (), visit: &mut impl Visit) {
        hand_out_openings(geometry, passage, visit);
        for item in 0..geometry.items().len() as u32 {
            hand_out(geometry, passage, ItemId(item), visit);
        }
    }
}
