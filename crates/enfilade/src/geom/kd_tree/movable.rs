//! Putting things into a kd-tree, taking them out, and moving them, without building it anew.
//!
//! A thing is led by the planes to all leaves that it reaches into, by its old box and by its new one. A leaf of too many
//! is split as when building; of a node whose one half is empty the other takes the place. Cells at the sides reach to
//! infinity, so nothing is ever outside.
//! Cost: O(depth) for a change, and for each leaf that the thing reaches into.
//! Every thing stands in leaves whose boxes together hold it whole, and these are as tight as after building.

use super::{COPIES, Cell, Holds, KdTree, Node, cut, sides};
use crate::geom::Aabb;

/// A tree is built anew when its cost in parts of the whole's area is so many times that which it had when it was built.
const WORSE: f64 = 1.2;

/// Where a thing stood and where it is.
struct Change {
    thing: u32,
    was: Aabb,
    now: Aabb,
}

/// A node that a change may concern.
struct Place {
    node: u32,
    /// What the planes above leave of space.
    cell: Aabb,
    depth: u32,
    /// May the thing stand in it, does it reach into it now?
    stood: bool,
    comes: bool,
}

impl KdTree {
    /// Moves a thing from where its box `was` to where it is: from nowhere, or to nowhere, where that is empty. `boxes` tells
    /// the boxes as they are now, of all things; others whose boxes have changed may still wait to be shifted.
    ///
    /// `touched` gets the nodes of which something has changed, and all those above them; of one that is there twice
    /// the last counts: then its children come before it.
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

    /// Builds the tree anew where so much has changed that it may have become bad: when half of the things have, and
    /// then only if it costs more than when it was built, or when things stand in too many leaves. Says whether; all
    /// nodes are new then.
    ///
    /// Things are numbered below `count`. To be called when all that changed was told, none being left to be shifted.
    pub(crate) fn tidy(&mut self, count: usize, boxes: &impl Fn(u32) -> Aabb) -> bool {
        self.settled();
        let crowded = self.held > 2 * COPIES * self.count;
        if self.count == 0 || 2 * self.changes < self.count && !crowded {
            return false;
        }
        self.changes = 0;
        let anew = crowded || self.held > COPIES * self.count || self.cost_now() > WORSE * self.cost;
        if anew {
            *self = KdTree::over(count, boxes, self.few);
        }
        anew
    }

    fn apply(&mut self, change: &Change, comes: bool, boxes: &impl Fn(u32) -> Aabb, touched: &mut Vec<u32>) {
        let stood = !change.was.is_empty();
        if !stood && !comes {
            return;
        }
        self.changes += 1;
        self.count = self.count + usize::from(comes) - usize::from(stood);
        if self.nodes.is_empty() {
            self.nodes.push(Node::EMPTY);
        }
        let everywhere = Aabb {
            min: [f32::NEG_INFINITY; 3],
            max: [f32::INFINITY; 3],
        };
        let root = Place {
            node: 0,
            cell: everywhere,
            depth: 0,
            stood,
            comes,
        };
        self.change(change, root, boxes, touched);
    }

    /// Brings a node and what is below it up to date; says whether nothing is in it any more.
    fn change(
        &mut self,
        change: &Change,
        place: Place,
        boxes: &impl Fn(u32) -> Aabb,
        touched: &mut Vec<u32>,
    ) -> bool {
        let node = place.node as usize;
        let Holds::Halves { axis, at, low, new } = self.nodes[node].holds else {
            self.change_leaf(change.thing, &place, boxes, touched);
            touched.push(place.node);
            return matches!(self.nodes[node].holds, Holds::Things(run) if run.len() == 0);
        };
        let axis = usize::from(axis);
        let cells = cut(&place.cell, axis, at);
        let [was, now] = [&change.was, &change.now].map(|held| sides(held, axis, at));
        let mut empty = [false; 2];
        for half in 0..2 {
            let below = Place {
                node: low + half as u32,
                cell: cells[half],
                depth: place.depth + 1,
                // Where a leaf was split when the box had changed already, the thing went where it is now.
                stood: place.stood && (was[half] || new && now[half]),
                comes: place.comes && now[half],
            };
            if below.stood || below.comes {
                empty[half] = self.change(change, below, boxes, touched);
            }
        }
        let halves = [low, low + 1].map(|half| self.nodes[half as usize]);
        match empty {
            [false, false] => {
                self.nodes[node].bounds = halves[0].bounds.union(&halves[1].bounds);
                self.merge(place.node);
            }
            // What is left of the cell takes over all of it: nothing reaches into the other half.
            [low_is_empty, _] => {
                self.nodes[node] = halves[usize::from(low_is_empty)];
                self.drop_pair(low);
            }
        }
        touched.push(place.node);
        empty == [true; 2]
    }

    fn change_leaf(
        &mut self,
        thing: u32,
        place: &Place,
        boxes: &impl Fn(u32) -> Aabb,
        touched: &mut Vec<u32>,
    ) {
        let node = place.node as usize;
        let Holds::Things(mut run) = self.nodes[node].holds else {
            return;
        };
        let stands = self.things.get(run).contains(&thing);
        if stands && !place.comes {
            self.things.remove(&mut run, thing);
            self.held -= 1;
        } else if place.comes && !stands {
            self.things.push(&mut run, thing);
            self.held += 1;
        }
        self.nodes[node].holds = Holds::Things(run);
        // What still waits to be shifted may be elsewhere by now.
        let inside =
            |&thing: &u32| Some(boxes(thing).intersection(&place.cell)).filter(|held| !held.is_empty());
        let bounds = self.things.get(run).iter().filter_map(inside);
        let bounds = bounds.fold(Aabb::EMPTY, |sum, held| sum.union(&held));
        self.nodes[node].bounds = bounds;
        // What no plane parts is not tried again with each thing that comes; and one that waits to be taken out is on no
        // side of a plane.
        let too_many = run.len() > self.few && (run.len() - self.few).is_power_of_two();
        let goes = |&thing: &u32| boxes(thing).is_empty();
        if !place.comes || stands || !too_many || self.things.get(run).iter().any(goes) {
            return;
        }
        let members = self.things.get(run).to_vec();
        self.things.clear(&mut run);
        self.held -= members.len();
        let most = (COPIES * self.count).saturating_sub(self.held + members.len());
        let cell = Cell {
            node: place.node,
            space: bounds,
            spare: most.min((COPIES - 1) * members.len()),
            members,
            depth: place.depth,
        };
        let mut made = Vec::new();
        self.split(cell, boxes, &mut made);
        touched.extend(made.into_iter().rev());
    }

    /// Makes a node whose halves are leaves one of their things, if these are few. Fewer than make a leaf when building:
    /// a thing that goes to and fro shall not split and merge it every time.
    fn merge(&mut self, node: u32) {
        let Holds::Halves { low, .. } = self.nodes[node as usize].holds else {
            return;
        };
        let [Holds::Things(mut below), Holds::Things(mut above)] =
            [low, low + 1].map(|half| self.nodes[half as usize].holds)
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
        self.nodes[node as usize].holds = Holds::Things(below);
        self.drop_pair(low);
    }

    fn drop_pair(&mut self, low: u32) {
        for half in [low, low + 1] {
            self.nodes[half as usize] = Node::EMPTY;
        }
        self.spare_pairs.push(low);
    }
}
