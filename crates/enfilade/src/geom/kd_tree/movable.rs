//! Incremental insertion, removal and movement of primitives in a kd-tree.
//!
//! The planes lead a primitive to all leaves that its old and its new AABB reach. An overfull leaf is split as in
//! building; if one child of a node becomes empty the other replaces the node. Outer cells extend to infinity, so no
//! primitive is ever outside.
//! Cost: O(depth) for a change, for each leaf that the primitive reaches.
//! The AABBs of the leaves that list a primitive together contain all of it, as tightly as after building.

use super::{COPIES, Cell, Contents, KdTree, Node, cut, sides};
use crate::geom::Aabb;

/// The tree is rebuilt when its cost relative to the root's area exceeds this multiple of the cost after building.
const MAX_COST_RATIO: f64 = 1.2;

/// The old and the new AABB of a primitive.
struct Change {
    thing: u32,
    was: Aabb,
    now: Aabb,
}

/// A node that a change may affect.
struct NodeUpdate {
    node: u32,
    /// The node's cell, bounded by the planes of its ancestors.
    cell: Aabb,
    depth: u32,
    /// Whether the node may list the primitive.
    was_in: bool,
    is_in: bool,
}

impl KdTree {
    /// Moves a primitive from its old AABB `was` to its current one. An empty old AABB inserts it, an empty current one
    /// removes it. `boxes` returns the current AABB of any primitive; others whose AABBs have changed may still have to
    /// be shifted.
    ///
    /// All changed nodes and their ancestors are appended to `touched`. If a node occurs twice the last occurrence
    /// counts: its children come before it.
    pub(crate) fn shift(
        &mut self,
        thing: u32,
        was: &Aabb,
        boxes: &impl Fn(u32) -> Aabb,
        touched: &mut Vec<u32>,
    ) {
        let (was, now) = (*was, boxes(thing));
        self.apply(&Change { thing, was, now }, !now.is_empty(), boxes, touched);
    }

    /// Rebuilds the tree if it may have degraded: after changes to half of the primitives, and only if the tree costs
    /// more than [`MAX_COST_RATIO`] times as much as after building; or if the average primitive is listed in too many leaves.
    /// Returns `true` if it was rebuilt; then all nodes are new.
    ///
    /// Primitives are numbered below `count`. Call this only after all changed primitives have been shifted.
    pub(crate) fn tidy(&mut self, count: usize, boxes: &impl Fn(u32) -> Aabb) -> bool {
        self.mark_settled();
        let crowded = self.held > 2 * COPIES * self.count;
        if self.count == 0 || 2 * self.changes < self.count && !crowded {
            return false;
        }
        self.changes = 0;
        let anew = crowded || self.held > COPIES * self.count || self.cost_now() > MAX_COST_RATIO * self.cost;
        if anew {
            *self = KdTree::over(count, boxes, self.few);
        }
        anew
    }

    fn apply(&mut self, change: &Change, is_in: bool, boxes: &impl Fn(u32) -> Aabb, touched: &mut Vec<u32>) {
        let was_in = !change.was.is_empty();
        if !was_in && !is_in {
            return;
        }
        self.changes += 1;
        self.count = self.count + usize::from(is_in) - usize::from(was_in);
        if self.nodes.is_empty() {
            self.nodes.push(Node::EMPTY);
        }
        let everywhere = Aabb {
            min: [f32::NEG_INFINITY; 3],
            max: [f32::INFINITY; 3],
        };
        let root = NodeUpdate {
            node: 0,
            cell: everywhere,
            depth: 0,
            was_in,
            is_in,
        };
        self.change(change, root, boxes, touched);
    }

    /// Updates the subtree of a node; returns `true` if it is empty now.
    fn change(
        &mut self,
        change: &Change,
        update: NodeUpdate,
        boxes: &impl Fn(u32) -> Aabb,
        touched: &mut Vec<u32>,
    ) -> bool {
        let node = update.node as usize;
        let Contents::Halves { axis, at, low, new } = self.nodes[node].contents else {
            self.change_leaf(change.thing, &update, boxes, touched);
            touched.push(update.node);
            return matches!(self.nodes[node].contents, Contents::Things(run) if run.len() == 0);
        };
        let axis = usize::from(axis);
        let cells = cut(&update.cell, axis, at);
        let [was, now] = [&change.was, &change.now].map(|held| sides(held, axis, at));
        let mut empty = [false; 2];
        for half in 0..2 {
            let below = NodeUpdate {
                node: low + half as u32,
                cell: cells[half],
                depth: update.depth + 1,
                // A leaf split after the primitive's AABB had changed placed the primitive by its current AABB.
                was_in: update.was_in && (was[half] || new && now[half]),
                is_in: update.is_in && now[half],
            };
            if below.was_in || below.is_in {
                empty[half] = self.change(change, below, boxes, touched);
            }
        }
        let halves = [low, low + 1].map(|half| self.nodes[half as usize]);
        match empty {
            [false, false] => {
                self.nodes[node].bounds = halves[0].bounds.union(&halves[1].bounds);
                self.merge(update.node);
            }
            // The nonempty child takes over the whole cell: nothing reaches into the other half.
            [low_is_empty, _] => {
                self.nodes[node] = halves[usize::from(low_is_empty)];
                self.drop_pair(low);
            }
        }
        touched.push(update.node);
        empty == [true; 2]
    }

    fn change_leaf(
        &mut self,
        thing: u32,
        update: &NodeUpdate,
        boxes: &impl Fn(u32) -> Aabb,
        touched: &mut Vec<u32>,
    ) {
        let node = update.node as usize;
        let Contents::Things(mut run) = self.nodes[node].contents else {
            return;
        };
        let is_listed = self.things.get(run).contains(&thing);
        if is_listed && !update.is_in {
            self.things.remove(&mut run, thing);
            self.held -= 1;
        } else if update.is_in && !is_listed {
            self.things.push(&mut run, thing);
            self.held += 1;
        }
        self.nodes[node].contents = Contents::Things(run);
        // A primitive that still has to be shifted may be elsewhere by now.
        let inside =
            |&thing: &u32| Some(boxes(thing).intersection(&update.cell)).filter(|held| !held.is_empty());
        let bounds = self.things.get(run).iter().filter_map(inside);
        let bounds = bounds.fold(Aabb::EMPTY, |sum, held| sum.union(&held));
        self.nodes[node].bounds = bounds;
        // A leaf that no plane separates is not tried again for each new primitive. And a primitive that waits to be
        // removed has an empty box, which is on neither side of a plane.
        let too_many = run.len() > self.few && (run.len() - self.few).is_power_of_two();
        let has_no_box = |&thing: &u32| boxes(thing).is_empty();
        if !update.is_in || is_listed || !too_many || self.things.get(run).iter().any(has_no_box) {
            return;
        }
        let members = self.things.get(run).to_vec();
        self.things.clear(&mut run);
        self.held -= members.len();
        let most = (COPIES * self.count).saturating_sub(self.held + members.len());
        let cell = Cell {
            node: update.node,
            space: bounds,
            spare: most.min((COPIES - 1) * members.len()),
            members,
            depth: update.depth,
        };
        let mut made = Vec::new();
        self.split(cell, boxes, &mut made);
        touched.extend(made.into_iter().rev());
    }

    /// Merges two leaf children into their parent if they have few primitives. The limit is lower than for a split in
    /// building, so that a primitive moving back and forth does not split and merge a node every time.
    fn merge(&mut self, node: u32) {
        let Contents::Halves { low, .. } = self.nodes[node as usize].contents else {
            return;
        };
        let [Contents::Things(mut below), Contents::Things(mut above)] =
            [low, low + 1].map(|half| self.nodes[half as usize].contents)
        else {
            return;
        };
        let most = (2 * self.few).div_ceil(3);
        if below.len().max(above.len()) > most {
            return;
        }
        let [few, some] = [below, above].map(|run| self.things.get(run));
        let more: Vec<u32> = some
            .iter()
            .copied()
            .filter(|thing| !few.contains(thing))
            .collect();
        if below.len() + more.len() > most {
            return;
        }
        self.held -= above.len() - more.len();
        self.things.clear(&mut above);
        for thing in more {
            self.things.push(&mut below, thing);
        }
        self.nodes[node as usize].contents = Contents::Things(below);
        self.drop_pair(low);
    }

    fn drop_pair(&mut self, low: u32) {
        for half in [low, low + 1] {
            self.nodes[half as usize] = Node::EMPTY;
        }
        self.free_pairs.push(low);
    }
}
