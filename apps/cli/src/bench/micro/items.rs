//! The row that asks a filled cover about items, by their boxes in space.

use super::boxes::{PASSES, REV_DEPTH_BYTES, sub_tiles};
use super::ceilings::Ceiling;
use super::screen::{BACKDROP, Screen};
use super::shapes::{Dice, NEAR};
use super::truth::Held;
use super::{Found, Work};
use enfilade::{Aabb, Rect};
use std::hint::black_box;
use std::time::Instant;

/// Squares on the screen and how near they are, as flat boxes that face the eye.
pub(super) struct Items {
    boxes: Vec<Aabb>,
    squares: Vec<(Rect, f32)>,
    seen: Vec<bool>,
}

impl Items {
    /// Of 4, 16 and 64 pixels a side, most behind what is in the cover.
    pub(super) fn new(screen: &Screen, count: usize) -> Items {
        let mut dice = Dice(5);
        let mut items = Items {
            boxes: Vec::new(),
            squares: Vec::new(),
            seen: Vec::new(),
        };
        let [small, middle, large] = [4, 16, 64].map(|side| screen.squares(side, count));
        for i in 0..count {
            let rect = [&small, &middle, &large][i % 3][i];
            // From before everything to twice as far as the backdrop.
            let share = dice.roll();
            let w = 0.5 * NEAR * (4.0 * BACKDROP / NEAR).powf(share);
            let corner = |x: u16, y: u16| screen.lens.point([x.into(), y.into()], w);
            let mut bounds = Aabb::of([corner(rect.x0, rect.y0), corner(rect.x1, rect.y1)]);
            bounds.min[2] *= 1.001;
            items.boxes.push(bounds);
            items.squares.push((rect, (1.0 / w) as f32));
        }
        items
    }
}

impl Work for Items {
    fn count(&self) -> u64 {
        self.boxes.len() as u64 * PASSES
    }

    fn run(&mut self, screen: &mut Screen) -> f64 {
        let start = Instant::now();
        for _ in 0..PASSES {
            screen
                .filled
                .sees_boxes(&screen.passage, &self.boxes, &mut self.seen);
            black_box(&self.seen);
        }
        start.elapsed().as_secs_f64()
    }

    fn hold(&mut self, screen: &mut Screen) -> Found {
        screen
            .filled
            .sees_boxes(&screen.passage, &self.boxes, &mut self.seen);
        let mut held = Held::default();
        let mut read = 0;
        for ((rect, nearest), &seen) in self.squares.iter().zip(&self.seen) {
            held.add(screen.filled_truth.hold_rect(rect, *nearest, !seen));
            read += if seen { 1 } else { sub_tiles(rect) };
        }
        Found {
            held,
            least_bytes: read * REV_DEPTH_BYTES * PASSES,
            ceiling: Ceiling::L2,
        }
    }
}
