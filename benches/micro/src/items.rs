//! The row that tests the AABBs of items against a filled depth buffer.

use super::Workload;
use super::boxes::PASSES;
use super::screen::{BACKDROP, Screen, are_visible};
use super::shapes::{NEAR, RandomNumbers};
use super::truth::ErrorCounts;
use enfilade::{Aabb, Rect};
use std::hint::black_box;
use std::time::Instant;

/// Flat boxes that face the eye, with their screen squares and reversed depths.
pub(super) struct Items {
    boxes: Vec<Aabb>,
    squares: Vec<(Rect, f32)>,
    seen: Vec<u64>,
}

impl Items {
    /// Creates items of 4, 16 and 64 pixels a side, most of them behind the contents of the buffer.
    pub(super) fn new(screen: &Screen, count: usize) -> Items {
        let mut random = RandomNumbers(5);
        let mut items = Items {
            boxes: Vec::new(),
            squares: Vec::new(),
            seen: vec![0; count.div_ceil(64)],
        };
        let [small, middle, large] = [4, 16, 64].map(|side| screen.squares(side, count));
        for i in 0..count {
            let rect = [&small, &middle, &large][i % 3][i];
            // From in front of everything to twice as far as the backdrop.
            let share = random.uniform();
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

impl Workload for Items {
    fn count(&self) -> u64 {
        self.boxes.len() as u64 * PASSES
    }

    fn run(&mut self, screen: &mut Screen) -> f64 {
        let start = Instant::now();
        for _ in 0..PASSES {
            screen.filled.test_boxes(&self.boxes, &mut self.seen);
            black_box(&self.seen);
        }
        start.elapsed().as_secs_f64()
    }

    fn check(&mut self, screen: &mut Screen) -> ErrorCounts {
        screen.filled.test_boxes(&self.boxes, &mut self.seen);
        let mut errors = ErrorCounts::default();
        for ((rect, nearest), seen) in self.squares.iter().zip(are_visible(&self.seen, self.boxes.len())) {
            errors.add(screen.filled_truth.check_rect(rect, *nearest, !seen));
        }
        errors
    }
}
