//! Rows that ask a filled cover about boxes.

use super::ceilings::Ceiling;
use super::screen::{BACKDROP, Screen};
use super::shapes::{Dice, FAR, NEAR};
use super::truth::{Held, SUB_TILE};
use super::{Found, Work};
use enfilade::Rect;
use std::hint::black_box;
use std::time::Instant;

/// What must be read of a sub-tile to know that all of it hides something: one reversed depth.
pub(super) const REV_DEPTH_BYTES: u64 = 4;
/// How often all boxes are asked about for one figure.
pub(super) const PASSES: u64 = 32;

/// How many sub-tiles a rectangle reaches into.
pub(super) fn sub_tiles(&Rect { x0, y0, x1, y1 }: &Rect) -> u64 {
    let [width, height] = SUB_TILE.map(|side| side as u16);
    u64::from(x1.div_ceil(width) - x0 / width) * u64::from(y1.div_ceil(height) - y0 / height)
}

/// Boxes, as the rectangles that they have on the screen and how near they come.
pub(super) struct Boxes {
    rects: Vec<(Rect, f32)>,
    seen: Vec<bool>,
    visible: bool,
}

impl Boxes {
    /// Behind everything that is in the cover.
    pub(super) fn hidden(rects: Vec<Rect>) -> Boxes {
        Boxes::new(rects, 0.5 / BACKDROP, false)
    }

    /// Before everything.
    pub(super) fn visible(rects: Vec<Rect>) -> Boxes {
        Boxes::new(rects, 2.0 / NEAR, true)
    }
}

impl Boxes {
    fn new(rects: Vec<Rect>, nearest: f64, visible: bool) -> Boxes {
        Boxes {
            rects: rects.into_iter().map(|rect| (rect, nearest as f32)).collect(),
            seen: Vec::new(),
            visible,
        }
    }
}

impl Work for Boxes {
    fn count(&self) -> u64 {
        self.rects.len() as u64 * PASSES
    }

    fn run(&mut self, screen: &mut Screen) -> f64 {
        let start = Instant::now();
        for _ in 0..PASSES {
            screen.filled.sees_rects(&self.rects, &mut self.seen);
            black_box(&self.seen);
        }
        start.elapsed().as_secs_f64()
    }

    /// Besides the boxes of the row others, in the same places and as near as some of what is in the cover.
    fn hold(&mut self, screen: &mut Screen) -> Found {
        let mut dice = Dice(3);
        let mut held = Held::default();
        let mut among = Vec::new();
        for (rect, _) in &self.rects {
            let share = dice.roll();
            among.push((*rect, ((FAR / NEAR).powf(share) / FAR) as f32));
        }
        // Of covers that are less than the truth many are right: what is among the walls is not loose.
        held.wrong += answers(screen, &among, &mut self.seen).wrong;
        held.add(answers(screen, &self.rects, &mut self.seen));
        // Of what is seen the first sub-tile may tell.
        let read: u64 = match self.visible {
            true => self.rects.len() as u64,
            false => self.rects.iter().map(|(rect, _)| sub_tiles(rect)).sum(),
        };
        Found {
            held,
            least_bytes: read * REV_DEPTH_BYTES * PASSES,
            ceiling: Ceiling::L2,
        }
    }
}

/// Asks about rectangles, and holds the answers against the truth.
fn answers(screen: &Screen, rects: &[(Rect, f32)], seen: &mut Vec<bool>) -> Held {
    screen.filled.sees_rects(rects, seen);
    let mut held = Held::default();
    for (&(rect, nearest), seen) in rects.iter().zip(seen) {
        held.add(screen.filled_truth.hold_rect(&rect, nearest, !*seen));
    }
    held
}
