//! Unordered: items as they come, by their number.
//!
//! Nothing is built, so content may change at will; what is outside the aperture is still left out.
//! Source: the z-buffer needs no order (Catmull 1974); Boreskov, Using portals to create aggregate scenes.
//! Cost: building nothing; a walk O(items), and O(log faces) for each large one that is half outside.
//! Gives nothing: only covers that need no order take it.

use super::items::{hand_out, hand_out_openings};
use super::{Order, Refusal, Unsorted, Visit};
use crate::content::{Content, ItemId, Moved};
use crate::passage::Passage;

/// Items as they come, by their number.
pub struct Unordered;

impl Order for Unordered {
    type Gives = Unsorted;
    type Scratch = ();

    fn build(_content: &Content, _limit_bytes: u64) -> Result<Unordered, Refusal> {
        Ok(Unordered)
    }

    fn needs_bytes(_content: &Content) -> u64 {
        0
    }

    fn bytes(&self) -> u64 {
        0
    }

    fn follow(&mut self, _content: &Content, _moved: &[Moved], _touched: &mut Vec<u32>) -> bool {
        // It goes by numbers alone.
        true
    }

    fn visit(&self, content: &Content, passage: &Passage, _scratch: &mut (), visit: &mut impl Visit) {
        hand_out_openings(content, passage, visit);
        for item in 0..content.items().len() as u32 {
            hand_out(content, passage, ItemId(item), visit);
        }
    }
}
