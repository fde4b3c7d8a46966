//! A tree over boxes that move: refitted where they do, built again when it has gone bad.
//!
//! A complete binary tree in one array, as a heap: node i has the children 2i and 2i + 1, each place one leaf. Building
//! parts the boxes at the median of their middles, across the axis along which these reach farthest.
//! Source: Bentley, Multidimensional Binary Search Trees, 1975, for medians; van den Bergen, Efficient Collision Detection
//!     of Complex Deformable Models Using AABB Trees, 1997, for refitting.
//! Cost: building O(n log n); a move O(log n); a question O(log n + found) in a tree that is good.
//! Depth is log₂ n whatever the boxes are. A question counts what it wastes, and once that is more than building costs, the
//! tree is built again.

use crate::geom::Aabb;

/// A tree over boxes that are numbered by their place.
#[derive(Clone, Debug, Default)]
pub(super) struct Tree {
    /// The root is 1; leaves are the second half.
    nodes: Vec<Aabb>,
    /// The thing in each leaf; what it says of an empty one means nothing.
    thing_of: Vec<u32>,
    /// The leaf of each thing.
    leaf_of: Vec<Option<u32>>,
    /// Leaves that hold nothing.
    free: Vec<u32>,
    wasted: usize,
    order: Vec<u32>,
}

/// Nodes that a question to a good tree looks at: this for each level, and for each box found.
const EXPECTED: usize = 6;

impl Tree {
    /// Is there a leaf for so many things more, and was little wasted?
    pub(super) fn serves(&self, more: usize) -> bool {
        more <= self.free.len() && self.wasted <= self.thing_of.len() * self.levels()
    }

    pub(super) fn holds(&self, thing: u32) -> bool {
        (self.leaf_of.get(thing as usize)).is_some_and(|leaf| leaf.is_some())
    }

    fn levels(&self) -> usize {
        self.thing_of.len().max(2).ilog2() as usize
    }

    /// Builds it over all boxes that are not empty.
    pub(super) fn build(&mut self, boxes: &[Aabb]) {
        self.order.clear();
        self.order
            .extend((0..boxes.len() as u32).filter(|&thing| !boxes[thing as usize].is_empty()));
        // An eighth to spare, so that newcomers do not have it built each time.
        let leaves = (self.order.len() + self.order.len() / 8)
            .max(1)
            .next_power_of_two();
        let mut waiting = vec![(0, self.order.len(), leaves)];
        while let Some((start, end, leaves)) = waiting.pop() {
            let half = leaves / 2;
            if end - start <= half.max(1) {
                if half > 1 {
                    waiting.push((start, end, half));
                }
                continue;
            }
            let part = &mut self.order[start..end];
            let middles = Aabb::of(part.iter().map(|&thing| boxes[thing as usize].center()));
            let size = middles.size();
            let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0);
            let key = |thing: u32| boxes[thing as usize].center()[axis];
            part.select_nth_unstable_by(half, |&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
            if half > 1 {
                waiting.push((start, start + half, half));
                waiting.push((start + half, end, half));
            }
        }
        self.nodes.clear();
        self.nodes.resize(2 * leaves, Aabb::EMPTY);
        self.thing_of.clear();
        self.thing_of.resize(leaves, 0);
        self.leaf_of.clear();
        self.leaf_of.resize(boxes.len(), None);
        self.free.clear();
        self.free.extend((self.order.len() as u32..leaves as u32).rev());
        for (leaf, &thing) in self.order.iter().enumerate() {
            self.thing_of[leaf] = thing;
            self.leaf_of[thing as usize] = Some(leaf as u32);
            self.nodes[leaves + leaf] = boxes[thing as usize];
        }
        for node in (1..leaves).rev() {
            self.nodes[node] = self.nodes[2 * node].union(&self.nodes[2 * node + 1]);
        }
        self.wasted = 0;
    }

    /// A thing has moved, come or, with an empty box, gone. One that comes needs a leaf ([`Tree::serves`]).
    pub(super) fn set(&mut self, thing: u32, bounds: &Aabb) {
        if self.leaf_of.len() <= thing as usize {
            self.leaf_of.resize(thing as usize + 1, None);
        }
        let gone = bounds.is_empty();
        let leaf = match self.leaf_of[thing as usize] {
            None if gone => return,
            Some(leaf) => leaf,
            None => {
                let Some(leaf) = self.free.pop() else { return };
                self.thing_of[leaf as usize] = thing;
                leaf
            }
        };
        self.leaf_of[thing as usize] = (!gone).then_some(leaf);
        if gone {
            self.free.push(leaf);
        }
        let mut node = self.thing_of.len() + leaf as usize;
        self.nodes[node] = *bounds;
        while node > 1 {
            node /= 2;
            let held = self.nodes[2 * node].union(&self.nodes[2 * node + 1]);
            if held == self.nodes[node] {
                break;
            }
            self.nodes[node] = held;
        }
    }

    /// All things whose boxes meet this one, in no order.
    pub(super) fn meeting(&mut self, bounds: &Aabb, found: &mut Vec<u32>) {
        let leaves = self.thing_of.len();
        if leaves == 0 {
            return;
        }
        let (mut asked, before) = (0, found.len());
        // One sibling waits on each level.
        let mut waiting = [0_usize; 34];
        waiting[0] = 1;
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let node = waiting[count];
            asked += 1;
            if !self.nodes[node].meets(bounds) {
                continue;
            }
            if node >= leaves {
                found.push(self.thing_of[node - leaves]);
            } else {
                waiting[count] = 2 * node + 1;
                waiting[count + 1] = 2 * node;
                count += 2;
            }
        }
        let expected = EXPECTED * (self.levels() + found.len() - before);
        self.wasted += usize::saturating_sub(asked, expected);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(at: f32) -> Aabb {
        Aabb {
            min: [at; 3],
            max: [at + 0.5; 3],
        }
    }

    #[test]
    fn a_tree_that_things_have_left_their_places_in_is_built_again() {
        let mut boxes: Vec<Aabb> = (0..1000).map(|i| cube(i as f32)).collect();
        let mut tree = Tree::default();
        tree.build(&boxes);
        assert!(tree.serves(1048) && !tree.serves(1049));
        let mut found = Vec::new();
        let mut ask = |tree: &mut Tree, boxes: &[Aabb]| {
            for (thing, bounds) in (0..).zip(boxes) {
                found.clear();
                tree.meeting(bounds, &mut found);
                assert_eq!(found, [thing]);
            }
        };
        ask(&mut tree, &boxes);
        assert!(tree.serves(0), "{} nodes were wasted in a good tree", tree.wasted);
        // Everyone changes places: neighbours are far apart now.
        for (thing, held) in (0..).zip(&mut boxes) {
            *held = cube((thing * 617 % 1000) as f32);
            tree.set(thing, held);
        }
        ask(&mut tree, &boxes);
        assert!(!tree.serves(0), "only {} nodes were wasted", tree.wasted);
        tree.build(&boxes);
        ask(&mut tree, &boxes);
        assert!(tree.serves(0));
    }

    #[test]
    fn things_in_a_line_in_a_plane_at_one_height_or_far_apart_make_good_trees() {
        let [line, plane, levels, outlier] = [
            |i: u16| [f32::from(i), 0.0, 0.0],
            |i: u16| [f32::from(i % 50), 3.0, f32::from(i / 50)],
            |i: u16| [f32::from(i % 3), f32::from(i / 3), 0.0],
            |i: u16| [f32::from(i), 0.0, if i == 7 { 1e30 } else { 0.0 }],
        ];
        for place in [line, plane, levels, outlier] {
            let boxes: Vec<Aabb> = (0..2500)
                .map(|i| Aabb {
                    min: place(i),
                    max: place(i).map(|side| side + 0.5),
                })
                .collect();
            let mut tree = Tree::default();
            tree.build(&boxes);
            let mut found = Vec::new();
            for (thing, bounds) in (0..).zip(&boxes) {
                found.clear();
                tree.meeting(bounds, &mut found);
                assert_eq!(found, [thing]);
            }
            assert!(tree.serves(0), "{} nodes were wasted", tree.wasted);
        }
    }
}
