//! Rows that test boxes against a filled depth buffer.

use super::Workload;
use super::screen::{BACKDROP, Screen, are_visible};
use super::shapes::{FAR, NEAR, RandomNumbers};
use super::truth::ErrorCounts;
use enfilade::Rect;
use std::hint::black_box;
use std::time::Instant;

/// Number of times all boxes are tested in one run.
pub(super) const PASSES: u64 = 32;

/// Boxes, as screen rectangles with their maximum reversed depth.
pub(super) struct Boxes {
    rects: Vec<(Rect, f32)>,
    seen: Vec<u64>,
}

impl Boxes {
    /// Creates boxes behind everything in the buffer.
    pub(super) fn hidden(rects: Vec<Rect>) -> Boxes {
        Boxes::new(rects, 0.5 / BACKDROP)
    }

    /// Creates boxes in front of everything.
    pub(super) fn visible(rects: Vec<Rect>) -> Boxes {
        Boxes::new(rects, 2.0 / NEAR)
    }
}

impl Boxes {
    fn new(rects: Vec<Rect>, nearest: f64) -> Boxes {
        Boxes {
            seen: vec![0; rects.len().div_ceil(64)],
            rects: rects.into_iter().map(|rect| (rect, nearest as f32)).collect(),
        }
    }
}

impl Workload for Boxes {
    fn count(&self) -> u64 {
        self.rects.len() as u64 * PASSES
    }

    fn run(&mut self, screen: &mut Screen) -> f64 {
        let start = Instant::now();
        for _ in 0..PASSES {
            screen.filled.test_rects(&self.rects, &mut self.seen);
            black_box(&self.seen);
        }
        start.elapsed().as_secs_f64()
    }

    /// Also tests boxes with the same rectangles at random distances within the filled buffer.
    fn check(&mut self, screen: &mut Screen) -> ErrorCounts {
        let mut random = RandomNumbers(3);
        let mut errors = ErrorCounts::default();
        let mut among = Vec::new();
        for (rect, _) in &self.rects {
            let share = random.uniform();
            among.push((*rect, ((FAR / NEAR).powf(share) / FAR) as f32));
        }
        // Only `wrong` is added here: a box among the walls that is kept is not loose, because a buffer may know less.
        errors.wrong += tested(screen, &among, &mut self.seen).wrong;
        errors.add(tested(screen, &self.rects, &mut self.seen));
        errors
    }
}

/// Tests rectangles, and compares the results with the truth.
fn tested(screen: &Screen, rects: &[(Rect, f32)], seen: &mut [u64]) -> ErrorCounts {
    screen.filled.test_rects(rects, seen);
    let mut errors = ErrorCounts::default();
    for (&(rect, nearest), seen) in rects.iter().zip(are_visible(seen, rects.len())) {
        errors.add(screen.filled_truth.check_rect(&rect, nearest, !seen));
    }
    errors
}
