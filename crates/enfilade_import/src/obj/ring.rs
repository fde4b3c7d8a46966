//! Triangulates a simple polygon in the plane by ear clipping.
//!
//! An ear is a convex corner whose triangle with its two neighbours contains no other corner. Reflex corners are kept
//! in a grid. A corner that is not an ear waits for the corner that blocks it. Collinear corners remain corners of
//! triangles, because adjacent polygons have them too and cracks (T-junctions) would appear otherwise; the crate
//! `earcut` drops them and is therefore not used. A
//! self-intersecting polygon runs out of ears; then another corner is clipped, so that the algorithm terminates.
//! Source: Meisters. Polygons have ears. American Mathematical Monthly 82, 1975; Held. FIST: fast industrial-strength
//! triangulation of polygons. Algorithmica 30, 2001.
//! Cost: about O(corners) for typical outlines; after some thousand tests per corner the rest is triangulated as a fan.
//! Exact: orientation tests are computed without rounding error.

use robust::{Coord, orient2d};
use std::collections::VecDeque;

/// Index of a corner in the original polygon.
type CornerIndex = u32;

/// Maximum number of tests per corner. Combs, spirals and stars with ten thousand corners need fewer.
const TESTS_PER_CORNER: u64 = 4096;

/// A linked ring of corners; reuses its memory for the next polygon.
#[derive(Debug, Default)]
pub(super) struct Ring {
    at: Vec<[f64; 2]>,
    next: Vec<CornerIndex>,
    before: Vec<CornerIndex>,
    /// `None` once the corner is clipped.
    turn: Vec<Option<Turn>>,
    /// Number of times that the neighbours of each corner have changed.
    changes: Vec<u32>,
    left: usize,
    /// Corners to be tested, each with its number of changes when it was queued; stale entries are skipped, because the
    /// corner was queued again.
    waiting: VecDeque<(CornerIndex, u32)>,
    /// For each corner, the head of the list in `held_up` of the corners that it blocks.
    holds_up: Vec<Option<u32>>,
    held_up: Vec<BlockedCorner>,
    /// Unused entries of `held_up`, which bound its length by the number of corners.
    free: Vec<u32>,
    grid: Grid,
    tests: u64,
}

/// Orientation of a corner in a counter-clockwise polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Turn {
    /// Left turn: a convex corner.
    Out,
    Straight,
    /// Right turn: a reflex corner.
    In,
}

/// A corner that is not an ear as long as another one blocks it.
#[derive(Clone, Copy, Debug)]
struct BlockedCorner {
    corner: CornerIndex,
    changes: u32,
    next: Option<u32>,
}

/// A uniform grid of the corners that were reflex or straight at the start.
#[derive(Debug, Default)]
struct Grid {
    min: [f64; 2],
    cells_per_unit: [f64; 2],
    side: usize,
    starts: Vec<u32>,
    corners: Vec<CornerIndex>,
}

/// Exact orientation test: positive for a left turn.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    let coord = |[x, y]: [f64; 2]| Coord { x, y };
    orient2d(coord(a), coord(b), coord(c))
}

impl Ring {
    /// Triangulates the counter-clockwise polygon with corners at `at`, no two consecutive ones equal. Passes triangles
    /// as corner indices to `triangle`; returns the number of clipped triangles that were not ears.
    pub(super) fn cut(&mut self, at: &[[f64; 2]], mut triangle: impl FnMut([CornerIndex; 3])) -> usize {
        self.begin(at);
        let most_tests = TESTS_PER_CORNER * at.len() as u64;
        let mut rough = 0;
        while self.left > 3 {
            let Some(ear) = self.next_ear(most_tests) else {
                let (corner, shows) = self.least_bad();
                if self.tests > most_tests {
                    rough += self.fan(corner, &mut triangle);
                    return rough;
                }
                if shows {
                    rough += 1;
                    triangle([self.before(corner), corner, self.next(corner)]);
                }
                self.remove(corner);
                continue;
            };
            triangle([self.before(ear), ear, self.next(ear)]);
            self.remove(ear);
        }
        if let Some(last) = (0..at.len() as CornerIndex).find(|&corner| self.turn[corner as usize].is_some())
        {
            match self.turn_at(last) {
                Turn::Straight => {}
                turn => {
                    triangle([last, self.next(last), self.before(last)]);
                    rough += usize::from(turn == Turn::In);
                }
            }
        }
        rough
    }

    fn begin(&mut self, at: &[[f64; 2]]) {
        let count = at.len() as CornerIndex;
        self.at.clear();
        self.at.extend(at);
        self.next.clear();
        self.next.extend((1..count).chain([0]));
        self.before.clear();
        self.before.extend([count - 1].into_iter().chain(0..count - 1));
        self.turn.clear();
        self.turn.resize(at.len(), Some(Turn::Straight));
        for corner in 0..count {
            self.turn[corner as usize] = Some(self.turn_at(corner));
        }
        self.changes.clear();
        self.changes.resize(at.len(), 0);
        self.holds_up.clear();
        self.holds_up.resize(at.len(), None);
        self.held_up.clear();
        self.free.clear();
        self.left = at.len();
        self.tests = 0;
        self.grid.fill(at, &self.turn);
        self.waiting.clear();
        // Starts at the second corner, so that a convex quad is split from its first corner, as is customary.
        for corner in (1..count).chain([0]) {
            self.ask_again(corner);
        }
    }

    fn next(&self, corner: CornerIndex) -> CornerIndex {
        self.next[corner as usize]
    }

    fn before(&self, corner: CornerIndex) -> CornerIndex {
        self.before[corner as usize]
    }

    fn place(&self, corner: CornerIndex) -> [f64; 2] {
        self.at[corner as usize]
    }

    fn turn_at(&self, corner: CornerIndex) -> Turn {
        let (a, c) = (self.place(self.before(corner)), self.place(self.next(corner)));
        let turn = turn(a, self.place(corner), c);
        match turn {
            _ if turn > 0.0 => Turn::Out,
            _ if turn < 0.0 => Turn::In,
            _ => Turn::Straight,
        }
    }

    /// Queues a convex corner to be tested.
    fn ask_again(&mut self, corner: CornerIndex) {
        if self.turn[corner as usize] == Some(Turn::Out) {
            self.waiting.push_back((corner, self.changes[corner as usize]));
        }
    }

    /// Returns the next ear; `None` if there is none, or if the test limit is reached.
    fn next_ear(&mut self, most_tests: u64) -> Option<CornerIndex> {
        while let Some((corner, changes)) = self.waiting.pop_front() {
            if self.turn[corner as usize].is_none() || self.changes[corner as usize] != changes {
                continue;
            }
            if self.tests > most_tests {
                return None;
            }
            match self.in_the_way(corner) {
                None => return Some(corner),
                Some(other) => self.wait(corner, other),
            }
        }
        None
    }

    /// Returns a corner inside the triangle of a corner and its neighbours, or on its edges. Corners that coincide with
    /// one of the three do not count: there, the polygon touches itself.
    fn in_the_way(&mut self, corner: CornerIndex) -> Option<CornerIndex> {
        let [a, b, c] = [self.before(corner), corner, self.next(corner)].map(|corner| self.place(corner));
        let min = [0, 1].map(|axis| a[axis].min(b[axis]).min(c[axis]));
        let max = [0, 1].map(|axis| a[axis].max(b[axis]).max(c[axis]));
        let [[first_x, first_y], [last_x, last_y]] = [self.grid.cell(min), self.grid.cell(max)];
        for y in first_y..=last_y {
            for x in first_x..=last_x {
                let held = self.grid.held(x, y);
                self.tests += 1 + held.len() as u64;
                for &other in held {
                    let p = self.at[other as usize];
                    let in_box = (0..2).all(|axis| min[axis] <= p[axis] && p[axis] <= max[axis]);
                    if in_box
                        && !matches!(self.turn[other as usize], None | Some(Turn::Out))
                        && ![a, b, c].contains(&p)
                        && turn(a, b, p) >= 0.0
                        && turn(b, c, p) >= 0.0
                        && turn(c, a, p) >= 0.0
                    {
                        return Some(other);
                    }
                }
            }
        }
        None
    }

    /// Returns the corner to clip if there is no ear, and whether its triangle has area. Prefers folded corners, then
    /// straight ones, then convex ones.
    fn least_bad(&mut self) -> (CornerIndex, bool) {
        let start = (0..self.at.len() as CornerIndex)
            .find(|&corner| self.turn[corner as usize].is_some())
            .expect("more than three corners are left");
        self.tests += 2 * self.at.len() as u64;
        let mut best = (3, start);
        let mut corner = start;
        for _ in 0..self.left {
            let rank = match self.turn[corner as usize] {
                Some(Turn::Straight) if self.folds(corner) => 0,
                Some(Turn::Straight) => 1,
                Some(Turn::Out) => 2,
                _ => 3,
            };
            best = best.min((rank, corner));
            corner = self.next(corner);
        }
        (best.1, best.0 >= 2)
    }

    /// Returns `true` if the outline reverses its direction at a corner.
    fn folds(&self, corner: CornerIndex) -> bool {
        let [a, b, c] = [self.before(corner), corner, self.next(corner)].map(|corner| self.place(corner));
        (0..2)
            .map(|axis| (a[axis] - b[axis]) * (c[axis] - b[axis]))
            .sum::<f64>()
            > 0.0
            || a == b
            || b == c
    }

    /// Removes a corner from the ring and updates its neighbours.
    fn remove(&mut self, corner: CornerIndex) {
        let (before, next) = (self.before(corner), self.next(corner));
        self.next[before as usize] = next;
        self.before[next as usize] = before;
        self.turn[corner as usize] = None;
        self.left -= 1;
        self.let_go(corner);
        for neighbour in [before, next] {
            self.changes[neighbour as usize] += 1;
            let turn = self.turn_at(neighbour);
            self.turn[neighbour as usize] = Some(turn);
            if turn == Turn::Out {
                self.let_go(neighbour);
            }
            self.ask_again(neighbour);
        }
    }

    /// Makes a corner wait until the corner that blocks it is clipped or becomes convex.
    fn wait(&mut self, corner: CornerIndex, other: CornerIndex) {
        let place = self.free.pop().unwrap_or(self.held_up.len() as u32);
        let held = BlockedCorner {
            corner,
            changes: self.changes[corner as usize],
            next: self.holds_up[other as usize].replace(place),
        };
        match self.held_up.get_mut(place as usize) {
            Some(free) => *free = held,
            None => self.held_up.push(held),
        }
    }

    /// Queues the corners that a corner blocked.
    fn let_go(&mut self, corner: CornerIndex) {
        let mut waits = self.holds_up[corner as usize].take();
        while let Some(number) = waits {
            let held = self.held_up[number as usize];
            self.waiting.push_back((held.corner, held.changes));
            self.free.push(number);
            waits = held.next;
        }
    }

    /// Triangulates the remaining polygon as a fan; returns the number of triangles.
    fn fan(&mut self, first: CornerIndex, triangle: &mut impl FnMut([CornerIndex; 3])) -> usize {
        let mut corner = self.next(first);
        for _ in 2..self.left {
            triangle([first, corner, self.next(corner)]);
            corner = self.next(corner);
        }
        self.left - 2
    }
}

impl Grid {
    /// Sorts the corners that are not convex into cells, about one per cell.
    fn fill(&mut self, at: &[[f64; 2]], turns: &[Option<Turn>]) {
        const MAX_CELLS: usize = 1 << 20;
        let kept = || (0..).zip(turns).filter(|(_, turn)| **turn != Some(Turn::Out));
        let count = kept().count();
        self.side = (1..)
            .find(|side| side * side >= count.min(MAX_CELLS))
            .unwrap_or(1);
        self.min = at[0];
        let mut max = at[0];
        for place in at {
            for axis in 0..2 {
                self.min[axis] = self.min[axis].min(place[axis]);
                max[axis] = max[axis].max(place[axis]);
            }
        }
        self.cells_per_unit = [0, 1].map(|axis| match max[axis] - self.min[axis] {
            size if size > 0.0 => self.side as f64 / size,
            _ => 0.0,
        });
        // First the number of corners per cell, then the start of each cell.
        self.starts.clear();
        self.starts.resize(self.side * self.side + 1, 0);
        for (_, place) in kept().map(|(corner, _)| (corner, at[corner as usize])) {
            let [x, y] = self.cell(place);
            self.starts[y * self.side + x] += 1;
        }
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        self.corners.clear();
        self.corners.resize(count, 0);
        for (corner, _) in kept() {
            let [x, y] = self.cell(at[corner as usize]);
            let start = &mut self.starts[y * self.side + x];
            *start -= 1;
            self.corners[*start as usize] = corner;
        }
    }

    /// Returns the cell of a point; monotonic along each axis.
    fn cell(&self, at: [f64; 2]) -> [usize; 2] {
        [0, 1].map(|axis| {
            let cells = (at[axis] - self.min[axis]) * self.cells_per_unit[axis];
            (cells as usize).min(self.side - 1)
        })
    }

    fn held(&self, x: usize, y: usize) -> &[CornerIndex] {
        let cell = y * self.side + x;
        &self.corners[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }
}
