//! AABB tree over moving boxes: refitted on moves, rebuilt when its quality degrades.
//!
//! Idea: a complete binary tree in one array, laid out as a heap: node i has the children 2i and 2i + 1, and each leaf
//!     holds one box. Building splits the boxes at the median of their centres along the axis of largest extent.
//! Source: Bentley, Multidimensional Binary Search Trees, 1975, for medians; van den Bergen, Efficient Collision
//!     Detection of Complex Deformable Models Using AABB Trees, 1997, for refitting.
//! Cost: building O(n log n); a move O(log n); a query O(log n + found) in a good tree.
//! The depth is log₂ n for any boxes. Queries count the nodes that they test in vain; once those exceed the cost of
//! building, the tree is rebuilt.

use enfilade::Aabb;

/// AABB tree over boxes that are identified by slot.
#[derive(Clone, Debug, Default)]
pub(super) struct Tree {
    /// The root is 1; leaves are the second half.
    nodes: Vec<Aabb>,
    /// The slot of the box in each leaf; undefined for an empty leaf.
    box_of: Vec<u32>,
    /// The leaf of each box.
    leaf_of: Vec<Option<u32>>,
    /// Empty leaves.
    free: Vec<u32>,
    wasted: usize,
    order: Vec<u32>,
}

/// Expected number of nodes tested by a query in a good tree, per level and per box found.
const EXPECTED: usize = 6;

impl Tree {
    /// Returns `true` if there are leaves for `more` boxes and few node tests were wasted.
    pub(super) fn serves(&self, more: usize) -> bool {
        more <= self.free.len() && self.wasted <= self.box_of.len() * self.levels()
    }

    pub(super) fn holds(&self, slot: u32) -> bool {
        (self.leaf_of.get(slot as usize)).is_some_and(|leaf| leaf.is_some())
    }

    fn levels(&self) -> usize {
        self.box_of.len().max(2).ilog2() as usize
    }

    /// Builds the tree over all boxes that are not empty.
    pub(super) fn build(&mut self, boxes: &[Aabb]) {
        self.order.clear();
        self.order
            .extend((0..boxes.len() as u32).filter(|&slot| !boxes[slot as usize].is_empty()));
        // An eighth spare, so that additions do not cause a rebuild each time.
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
            let middles = Aabb::of(part.iter().map(|&slot| boxes[slot as usize].center()));
            let size = middles.size();
            let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0);
            let key = |slot: u32| boxes[slot as usize].center()[axis];
            part.select_nth_unstable_by(half, |&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
            if half > 1 {
                waiting.push((start, start + half, half));
                waiting.push((start + half, end, half));
            }
        }
        self.nodes.clear();
        self.nodes.resize(2 * leaves, Aabb::EMPTY);
        self.box_of.clear();
        self.box_of.resize(leaves, 0);
        self.leaf_of.clear();
        self.leaf_of.resize(boxes.len(), None);
        self.free.clear();
        self.free.extend((self.order.len() as u32..leaves as u32).rev());
        for (leaf, &slot) in self.order.iter().enumerate() {
            self.box_of[leaf] = slot;
            self.leaf_of[slot as usize] = Some(leaf as u32);
            self.nodes[leaves + leaf] = boxes[slot as usize];
        }
        for node in (1..leaves).rev() {
            self.nodes[node] = self.nodes[2 * node].union(&self.nodes[2 * node + 1]);
        }
        self.wasted = 0;
    }

    /// Moves, adds or, with an empty box, removes a box. Adding needs a free leaf ([`Tree::serves`]).
    pub(super) fn set(&mut self, slot: u32, bounds: &Aabb) {
        if self.leaf_of.len() <= slot as usize {
            self.leaf_of.resize(slot as usize + 1, None);
        }
        let gone = bounds.is_empty();
        let leaf = match self.leaf_of[slot as usize] {
            None if gone => return,
            Some(leaf) => leaf,
            None => {
                let Some(leaf) = self.free.pop() else { return };
                self.box_of[leaf as usize] = slot;
                leaf
            }
        };
        self.leaf_of[slot as usize] = (!gone).then_some(leaf);
        if gone {
            self.free.push(leaf);
        }
        let mut node = self.box_of.len() + leaf as usize;
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

    /// Finds all boxes that overlap `bounds`, in no order.
    pub(super) fn meeting(&mut self, bounds: &Aabb, found: &mut Vec<u32>) {
        let leaves = self.box_of.len();
        if leaves == 0 {
            return;
        }
        let (mut tested, before) = (0, found.len());
        // One pending sibling per level.
        let mut waiting = [0_usize; 34];
        waiting[0] = 1;
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let node = waiting[count];
            tested += 1;
            if !self.nodes[node].meets(bounds) {
                continue;
            }
            if node >= leaves {
                found.push(self.box_of[node - leaves]);
            } else {
                waiting[count] = 2 * node + 1;
                waiting[count + 1] = 2 * node;
                count += 2;
            }
        }
        let expected = EXPECTED * (self.levels() + found.len() - before);
        self.wasted += usize::saturating_sub(tested, expected);
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
            for (slot, bounds) in (0..).zip(boxes) {
                found.clear();
                tree.meeting(bounds, &mut found);
                assert_eq!(found, [slot]);
            }
        };
        ask(&mut tree, &boxes);
        assert!(tree.serves(0), "{} nodes were wasted in a good tree", tree.wasted);
        // All boxes are permuted: neighbours in the tree are far apart now.
        for (slot, held) in (0..).zip(&mut boxes) {
            *held = cube((slot * 617 % 1000) as f32);
            tree.set(slot, held);
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
            for (slot, bounds) in (0..).zip(&boxes) {
                found.clear();
                tree.meeting(bounds, &mut found);
                assert_eq!(found, [slot]);
            }
            assert!(tree.serves(0), "{} nodes were wasted", tree.wasted);
        }
    }
}
