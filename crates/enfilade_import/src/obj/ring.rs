//! Cuts ears off a ring of corners in the plane until nothing is left of it.
//!
//! An ear is a corner that sticks out, with no other corner of the ring in the triangle that it makes with its neighbours.
//! Corners that do not stick out are kept in a grid, and a corner that is found not to be an ear waits until what is in
//! its way is gone. Corners in line with their neighbours stay corners of triangles, since neighbours of the polygon have
//! them too, and one would see between them otherwise. A ring that crosses itself has no ears at some time; then some
//! corner is cut off as it is, so that all ends.
//! Source: Meisters. Polygons have ears. American Mathematical Monthly 82, 1975; Held. FIST: fast industrial-strength
//! triangulation of polygons. Algorithmica 30, 2001.
//! Cost: about O(corners) for outlines of things; what takes more than some thousand tests a corner is cut roughly.
//! Exact: which way three corners turn is decided without rounding.

use robust::{Coord, orient2d};
use std::collections::VecDeque;

/// A corner's place in the ring at the start.
type Place = u32;

/// Tests that each corner may cost. Combs, spirals and stars of ten thousand corners need fewer.
const TESTS_PER_CORNER: u64 = 4096;

/// A ring of corners. What it holds is used again for the next.
#[derive(Debug, Default)]
pub(super) struct Ring {
    at: Vec<[f64; 2]>,
    next: Vec<Place>,
    before: Vec<Place>,
    /// `None` where it is cut off.
    turn: Vec<Option<Turn>>,
    /// How often its neighbours have changed.
    changes: Vec<u32>,
    left: usize,
    /// Corners to be tried, with their changes at that time; what has changed since is in here again.
    waiting: VecDeque<(Place, u32)>,
    /// For each corner, the first in `held_up` that waits for it.
    holds_up: Vec<Option<u32>>,
    held_up: Vec<HeldUp>,
    /// Places in `held_up` that are free again, so that it never has more than some for each corner.
    free: Vec<u32>,
    grid: Grid,
    tests: u64,
}

/// How the ring turns at a corner, seen by one who goes round counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Turn {
    /// Left: it sticks out.
    Out,
    Straight,
    /// Right.
    In,
}

/// A corner that is no ear while another is there.
#[derive(Clone, Copy, Debug)]
struct HeldUp {
    corner: Place,
    changes: u32,
    next: Option<u32>,
}

/// Corners that did not stick out at the start, by where they are.
#[derive(Debug, Default)]
struct Grid {
    min: [f64; 2],
    cells_per_unit: [f64; 2],
    side: usize,
    starts: Vec<u32>,
    corners: Vec<Place>,
}

fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    let coord = |[x, y]: [f64; 2]| Coord { x, y };
    orient2d(coord(a), coord(b), coord(c))
}

impl Ring {
    /// Cuts the ring with corners at `at`, counter-clockwise, no two neighbours in one place. Hands out triangles as places
    /// in it, and says how many were cut as if they were ears.
    pub(super) fn cut(&mut self, at: &[[f64; 2]], mut triangle: impl FnMut([Place; 3])) -> usize {
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
        if let Some(last) = (0..at.len() as Place).find(|&corner| self.turn[corner as usize].is_some()) {
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
        let count = at.len() as Place;
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
        // From the second, so that a convex polygon of four corners is cut from its first, as everyone cuts it.
        for corner in (1..count).chain([0]) {
            self.ask_again(corner);
        }
    }

    fn next(&self, corner: Place) -> Place {
        self.next[corner as usize]
    }

    fn before(&self, corner: Place) -> Place {
        self.before[corner as usize]
    }

    fn place(&self, corner: Place) -> [f64; 2] {
        self.at[corner as usize]
    }

    fn turn_at(&self, corner: Place) -> Turn {
        let (a, c) = (self.place(self.before(corner)), self.place(self.next(corner)));
        let turn = turn(a, self.place(corner), c);
        match turn {
            _ if turn > 0.0 => Turn::Out,
            _ if turn < 0.0 => Turn::In,
            _ => Turn::Straight,
        }
    }

    fn ask_again(&mut self, corner: Place) {
        if self.turn[corner as usize] == Some(Turn::Out) {
            self.waiting.push_back((corner, self.changes[corner as usize]));
        }
    }

    /// The next corner that is an ear, if there is one and it is found in time.
    fn next_ear(&mut self, most_tests: u64) -> Option<Place> {
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

    /// A corner in the triangle that one makes with its neighbours, sides included. Corners in the same place as one of
    /// these do not count: they are where a ring meets itself.
    fn in_the_way(&mut self, corner: Place) -> Option<Place> {
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

    /// What to cut off where there is no ear, and whether it makes a triangle that can be seen: a fold, then what is in
    /// line, then what sticks out, then anything.
    fn least_bad(&mut self) -> (Place, bool) {
        let start = (0..self.at.len() as Place)
            .find(|&corner| self.turn[corner as usize].is_some())
            .expect("some are left");
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

    /// Does the ring go back from a corner the way that it came?
    fn folds(&self, corner: Place) -> bool {
        let [a, b, c] = [self.before(corner), corner, self.next(corner)].map(|corner| self.place(corner));
        (0..2)
            .map(|axis| (a[axis] - b[axis]) * (c[axis] - b[axis]))
            .sum::<f64>()
            > 0.0
            || a == b
            || b == c
    }

    fn remove(&mut self, corner: Place) {
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

    /// Lets a corner wait until another, which is in its way, is gone or sticks out.
    fn wait(&mut self, corner: Place, other: Place) {
        let place = self.free.pop().unwrap_or(self.held_up.len() as u32);
        let held = HeldUp {
            corner,
            changes: self.changes[corner as usize],
            next: self.holds_up[other as usize].replace(place),
        };
        match self.held_up.get_mut(place as usize) {
            Some(free) => *free = held,
            None => self.held_up.push(held),
        }
    }

    /// What has waited for a corner is asked again.
    fn let_go(&mut self, corner: Place) {
        let mut waits = self.holds_up[corner as usize].take();
        while let Some(number) = waits {
            let held = self.held_up[number as usize];
            self.waiting.push_back((held.corner, held.changes));
            self.free.push(number);
            waits = held.next;
        }
    }

    /// Cuts what is left from one corner; says into how many triangles.
    fn fan(&mut self, first: Place, triangle: &mut impl FnMut([Place; 3])) -> usize {
        let mut corner = self.next(first);
        for _ in 2..self.left {
            triangle([first, corner, self.next(corner)]);
            corner = self.next(corner);
        }
        self.left - 2
    }
}

impl Grid {
    /// Sorts the corners that do not stick out into cells, about one in each.
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
        // As many in each cell, then where those of each begin.
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

    /// Never less far along an axis for what is farther along it.
    fn cell(&self, at: [f64; 2]) -> [usize; 2] {
        [0, 1].map(|axis| {
            let cells = (at[axis] - self.min[axis]) * self.cells_per_unit[axis];
            (cells as usize).min(self.side - 1)
        })
    }

    fn held(&self, x: usize, y: usize) -> &[Place] {
        let cell = y * self.side + x;
        &self.corners[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }
}
