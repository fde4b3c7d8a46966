//! Which rooms may see each other through open doors.
//!
//! Follows chains of doors as long as a straight line may pass the boxes of all of them. A line in space that passes them
//! also does so in the three projections along the axes, where the test is exact.
//! Source: Luebke, Georges, Portals and Mirrors: Simple, Fast Evaluation of Potentially Visible Sets, I3D 1995: chains of
//!     portals as boxes; stabbing lines through vertices: Teller, Séquin, Visibility Preprocessing for Interactive
//!     Walkthroughs, SIGGRAPH 1991, section 4.
//! Cost: O(chains · doors³) for a chain; chains are limited.
//! Conservative: a pair is left out only if no line passes the boxes of any chain. A line that enters a room twice also
//!     passes the chain without the loop, so rooms are entered once. Beyond the limit, holes between the same rooms count as
//!     one, then every room that can be reached is added. Holes smaller than a voxel are found by sampling (`holes`).

use super::graph::{DoorId, RoomGraph, RoomId};
use std::collections::{BTreeMap, BTreeSet};

/// Maximum number of chains that are followed from a room: by single holes, then by boxes around them.
const MAX_CHAINS: usize = 10_000;

/// Axes of the three projections.
const PROJECTIONS: [[usize; 2]; 3] = [[0, 2], [0, 1], [1, 2]];

/// A box in a projection: lower and upper corner.
type Rect = [[f64; 2]; 2];

/// A way for lines from a room into another.
#[derive(Clone, Copy)]
struct Link {
    beyond: RoomId,
    axis: u8,
    /// Whether lines go up the axis.
    goes_up: bool,
    bounds: [[f64; 3]; 2],
}

struct Search<'a> {
    /// Links out of each room.
    links: &'a [Vec<Link>],
    found: BTreeSet<RoomId>,
    /// Rooms of the chain, and the boxes of its links in each projection.
    entered: Vec<RoomId>,
    boxes: [Vec<Rect>; 3],
    /// Whether the line goes up each axis, as far as a link on the way requires it.
    ways: [Option<bool>; 3],
    chains: usize,
    /// Number of rooms that can be reached, whatever the line: when all are found, the rest is known.
    reachable: usize,
}

pub(super) fn relevant(rooms: &RoomGraph, from: RoomId, shows: impl Fn(DoorId) -> bool) -> Vec<RoomId> {
    let links = links(rooms, shows);
    let reachable = reachable(&links, from);
    let found = search(&links, from, reachable.len())
        // Many holes in a wall make many chains; one box around them makes few.
        .or_else(|| search(&merged(&links), from, reachable.len()));
    found.unwrap_or(reachable).into_iter().collect()
}

/// Returns the links out of each room.
fn links(rooms: &RoomGraph, shows: impl Fn(DoorId) -> bool) -> Vec<Vec<Link>> {
    let of_room = |room: u32| {
        let doors = rooms.neighbours(RoomId(room)).filter(|&(door, _)| shows(door));
        let links = doors.flat_map(|(door, beyond)| {
            let door = &rooms.doors[door.0 as usize];
            let is_first = door.rooms[0] == RoomId(room);
            door.sights.iter().map(move |sight| Link {
                beyond,
                axis: sight.axis,
                goes_up: sight.goes_up == is_first,
                bounds: sight.bounds,
            })
        });
        links.collect()
    };
    (0..rooms.rooms.len() as u32).map(of_room).collect()
}

/// Replaces links between the same rooms and in the same direction by one.
fn merged(links: &[Vec<Link>]) -> Vec<Vec<Link>> {
    let merge = |links: &Vec<Link>| {
        let mut merged: BTreeMap<(RoomId, u8, bool), Link> = BTreeMap::new();
        for link in links {
            let [low, high] = &mut merged
                .entry((link.beyond, link.axis, link.goes_up))
                .or_insert(*link)
                .bounds;
            *low = [0, 1, 2].map(|axis| low[axis].min(link.bounds[0][axis]));
            *high = [0, 1, 2].map(|axis| high[axis].max(link.bounds[1][axis]));
        }
        merged.into_values().collect()
    };
    links.iter().map(merge).collect()
}

/// Returns every room that can be reached.
fn reachable(links: &[Vec<Link>], from: RoomId) -> BTreeSet<RoomId> {
    let mut reached = BTreeSet::from([from]);
    let mut waiting = vec![from];
    while let Some(room) = waiting.pop() {
        for link in &links[room.0 as usize] {
            if reached.insert(link.beyond) {
                waiting.push(link.beyond);
            }
        }
    }
    reached
}

/// Returns the rooms at the ends of chains that a line may pass; `None` if there are too many chains.
fn search(links: &[Vec<Link>], from: RoomId, reachable: usize) -> Option<BTreeSet<RoomId>> {
    let mut search = Search {
        links,
        found: BTreeSet::from([from]),
        entered: vec![from],
        boxes: Default::default(),
        ways: [None; 3],
        chains: 0,
        reachable,
    };
    search.follow(from);
    (search.chains < MAX_CHAINS || search.found.len() == reachable).then_some(search.found)
}

impl Search<'_> {
    fn follow(&mut self, room: RoomId) {
        let links = self.links;
        for link in &links[room.0 as usize] {
            if self.chains >= MAX_CHAINS || self.found.len() == self.reachable {
                return;
            }
            let axis = link.axis as usize;
            // A line does not turn round.
            if self.ways[axis] == Some(!link.goes_up) || self.entered.contains(&link.beyond) {
                continue;
            }
            let before = self.ways[axis].replace(link.goes_up);
            self.chains += 1;
            let [min, max] = link.bounds;
            for (boxes, [a, b]) in self.boxes.iter_mut().zip(PROJECTIONS) {
                boxes.push([[min[a], min[b]], [max[a], max[b]]]);
            }
            if self.boxes.iter().all(|boxes| is_stabbed(boxes)) {
                self.found.insert(link.beyond);
                self.entered.push(link.beyond);
                self.follow(link.beyond);
                self.entered.pop();
            }
            for boxes in &mut self.boxes {
                boxes.pop();
            }
            self.ways[axis] = before;
        }
    }
}

/// Returns `true` if a line passes all rectangles: if one does, one does that touches a corner of two of them.
fn is_stabbed(boxes: &[Rect]) -> bool {
    if boxes.len() <= 2 {
        return true;
    }
    let corners = |&[[x0, y0], [x1, y1]]: &Rect| [[x0, y0], [x0, y1], [x1, y0], [x1, y1]];
    boxes.iter().enumerate().any(|(number, one)| {
        boxes[number..].iter().any(|other| {
            corners(one).iter().any(|from| {
                corners(other)
                    .iter()
                    .any(|to| from != to && boxes.iter().all(|rect| touches(from, to, rect)))
            })
        })
    })
}

/// Returns `true` if the line through two points touches a rectangle, or almost.
fn touches([ax, ay]: &[f64; 2], [bx, by]: &[f64; 2], [[x0, y0], [x1, y1]]: &Rect) -> bool {
    /// Generous bound on the relative rounding error.
    const ROUNDING: f64 = 1e-9;
    let [dx, dy] = [bx - ax, by - ay];
    let side = |x: f64, y: f64| dx * (y - ay) - dy * (x - ax);
    let sides = [side(*x0, *y0), side(*x0, *y1), side(*x1, *y0), side(*x1, *y1)];
    let reach = [x0, x1, ax, bx].into_iter().chain([y0, y1, ay, by]);
    let size = reach.fold(1.0, |size: f64, value| size.max(value.abs()));
    let slack = ROUNDING * size * (dx.abs() + dy.abs());
    let [least, most] = [f64::min, f64::max].map(|pick| sides.into_iter().reduce(pick).unwrap_or(0.0));
    least <= slack && most >= -slack
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_passes_doors_in_line_and_no_others() {
        let door = |x: f64, y: f64| [[x, y], [x + 0.2, y + 1.0]];
        assert!(is_stabbed(&[door(0.0, 0.0), door(5.0, 0.5), door(10.0, 1.0)]));
        assert!(is_stabbed(&[door(0.0, 0.0), door(5.0, 2.4), door(10.0, 5.0)]));
        assert!(!is_stabbed(&[door(0.0, 0.0), door(5.0, 3.0), door(10.0, 0.0)]));
    }

    #[test]
    fn random_lines_pass_what_they_pass() {
        let mut random = fastrand::Rng::with_seed(5);
        let mut number = || 20.0 * random.f64() - 10.0;
        for _ in 0..20_000 {
            let [from, to] = [[number(), number()], [number(), number()]];
            let boxes: Vec<Rect> = (0..5)
                .map(|_| {
                    let share = number();
                    let at = [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
                    let [below, above] = [[number(), number()], [number(), number()]];
                    [
                        [0, 1].map(|axis| at[axis] - 0.05 * below[axis].abs()),
                        [0, 1].map(|axis| at[axis] + 0.05 * above[axis].abs()),
                    ]
                })
                .collect();
            assert!(is_stabbed(&boxes), "{boxes:?}");
        }
    }
}
