//! Rows that test boxes against a filled depth buffer.

use super::ceilings::Ceiling;
use super::screen::{BACKDROP, Screen, are_visible};
use super::shapes::{FAR, NEAR, RandomNumbers};
use super::truth::{ErrorCounts, SUB_TILE};
use super::{Verification, Workload};
use enfilade::Rect;
use std::hint::black_box;
use std::time::Instant;

/// Bytes of a sub-tile that must be read to decide that it occludes a box: one reversed depth.
pub(super) const REV_DEPTH_BYTES: u64 = 4;
/// Number of times all boxes are tested in one run.
pub(super) const PASSES: u64 = 32;

/// Returns the number of sub-tiles that a rectangle overlaps.
pub(super) fn sub_tiles(&Rect { x0, y0, x1, y1 }: &Rect) -> u64 {
    let [width, height] = SUB_TILE.map(|side| side as u16);
    u64::from(x1.div_ceil(width) - x0 / width) * u64::from(y1.div_ceil(height) - y0 / height)
}

/// Boxes, as screen rectangles with their maximum reversed depth.
pub(super) struct Boxes {
    rects: Vec<(Rect, f32)>,
    seen: Vec<u64>,
    visible: bool,
}

impl Boxes {
    /// Creates boxes behind everything in the buffer.
    pub(super) fn hidden(rects: Vec<Rect>) -> Boxes {
        Boxes::new(rects, 0.5 / BACKDROP, false)
    }

    /// Creates boxes in front of everything.
    pub(super) fn visible(rects: Vec<Rect>) -> Boxes {
        Boxes::new(rects, 2.0 / NEAR, true)
    }
}

impl Boxes {
    fn new(rects: Vec<Rect>, nearest: f64, visible: bool) -> Boxes {
        Boxes {
            seen: vec![0; rects.len().div_ceil(64)],
            rects: rects.into_iter().map(|rect| (rect, nearest as f32)).collect(),
            visible,
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
    fn check(&mut self, screen: &mut Screen) -> Verification {
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
        // For a visible box, the first sub-tile may decide.
        let read: u64 = match self.visible {
            true => self.rects.len() as u64,
            false => self.rects.iter().map(|(rect, _)| sub_tiles(rect)).sum(),
        };
        Verification {
            errors,
            min_bytes: read * REV_DEPTH_BYTES * PASSES,
            ceiling: Ceiling::L2,
        }
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
