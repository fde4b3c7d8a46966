//! Building a BSP tree: choose a plane, put every polygon where it lies, and so on in front and behind.
//!
//! Polygons at work lie on one stack, and so do corners: what belongs to the side that is done last lies below, so
//! that a side's memory is free again once it is done.
//! Source: Fuchs, Kedem, Naylor. On Visible Surface Generation by A Priori Tree Structures. SIGGRAPH 1980.
//! Cost: O(n) for each level, about log n levels; memory as large as the tree.
//! Ends always: a plane of a polygon takes that polygon, a free one leaves fewer on either side, and once
//! `limit_bytes` is reached nothing is split any more.

use super::choose::{Born, Chooser};
use super::link::BspLink;
use super::side::{ROUNDING, Side, Splitter};
use super::split::{Arena, Cut, Working};
use super::{BspOptions, BspTree, Node, Piece, Polygons};
use crate::geom::Aabb;
use glam::DVec3;
use std::num::NonZeroU32;

/// Subtrees of fewer pieces have no box: asking costs more than it can save.
const FEWEST_IN_BOX: usize = 8;

struct Builder<'a> {
    options: &'a BspOptions,
    born: Born,
    chooser: Chooser,
    arena: Arena,
    /// The polygons of all tasks, in the order of these.
    stack: Vec<Working>,
    tasks: Vec<Task>,
    tree: BspTree,
    cuts: Vec<Cut>,
}

/// What is still to be split: all that stands on the stack from here on, once the later tasks are done.
struct Task {
    /// The node it hangs below, and which of the node's links leads to it.
    parent: Option<(u32, usize)>,
    first: usize,
    /// Corners that were there when it was put off.
    corners: usize,
    depth: u32,
}

/// Where a node's polygons go.
#[derive(Default)]
struct Sorted {
    front: Vec<Working>,
    back: Vec<Working>,
    on: Vec<Working>,
}

/// See [`BspTree::build`].
pub(super) fn build(polygons: &Polygons, options: &BspOptions) -> BspTree {
    let corners = polygons.corners.iter().flatten();
    let largest = corners.fold(0.0_f64, |largest, value| largest.max(value.abs()));
    let mut builder = Builder {
        options,
        born: Born {
            splitters: Vec::new(),
            slack: Vec::new(),
            band: ROUNDING * largest,
        },
        chooser: Chooser::new(),
        arena: Arena::default(),
        stack: Vec::new(),
        tasks: Vec::new(),
        tree: BspTree::default(),
        cuts: Vec::new(),
    };
    builder.take_in(polygons);
    builder.run();
    builder.tree.shrink();
    builder.tree
}

impl Builder<'_> {
    fn take_in(&mut self, polygons: &Polygons) {
        for (polygon, ends) in polygons.starts.windows(2).enumerate() {
            let corners = &polygons.corners[ends[0] as usize..ends[1] as usize];
            let slack = polygons.slack.get(polygon).copied().unwrap_or(0.0);
            let corners = corners.iter().map(|&corner| DVec3::from(corner));
            let working = self.arena.add(polygon as u32, corners);
            let corners = self.arena.corners(&working);
            let splitter = Splitter::of(polygon as u32, corners, self.born.band, slack);
            self.born.splitters.push(splitter);
            self.born.slack.push(slack);
            self.stack.push(working);
        }
        if !self.stack.is_empty() {
            self.put_off(None, 0, 1);
        }
    }

    fn run(&mut self) {
        let mut sorted = Sorted::default();
        while let Some(task) = self.tasks.pop() {
            self.arena.forget(task.corners);
            self.tree.depth = self.tree.depth.max(task.depth);
            let members = &self.stack[task.first..];
            // A piece for each polygon that waits will be there too.
            let bytes = self.tree.bytes() + (self.stack.len() * size_of::<Piece>()) as u64;
            let full = bytes > self.options.limit_bytes.min(BspTree::GREATEST);
            let splitter = if members.len() < 2 || full {
                self.tree.incomplete |= members.len() > 1;
                None
            } else {
                self.chooser
                    .choose(members, &self.arena, &self.born, self.options)
            };
            match splitter {
                Some(splitter) => self.split(task, &splitter, &mut sorted),
                None => {
                    sorted.on.extend(self.stack.drain(task.first..));
                    let link = self.finish(&mut sorted.on);
                    self.hang(task.parent, link);
                }
            }
        }
    }

    /// Makes a node of a task, and a task of each side.
    fn split(&mut self, task: Task, splitter: &Splitter, sorted: &mut Sorted) {
        let node = self.tree.nodes.len() as u32;
        let members = &self.stack[task.first..];
        let bounds = (members.len() >= FEWEST_IN_BOX).then(|| self.bounds(members));
        self.sort(task.first, splitter, node, sorted);
        let own = self.finish(&mut sorted.on);
        if sorted.front.is_empty() && sorted.back.is_empty() {
            // All in one plane: a leaf, which needs none.
            self.hang(task.parent, own);
            return;
        }
        self.tree.bounds.extend(bounds);
        self.tree.nodes.push(Node {
            links: [BspLink::NOTHING, own, BspLink::NOTHING],
            bounds: bounds.and_then(|_| NonZeroU32::new(self.tree.bounds.len() as u32)),
        });
        let normal = splitter.plane.normal;
        self.tree
            .planes
            .push([normal.x, normal.y, normal.z, splitter.plane.offset]);
        self.hang(task.parent, BspLink::node(node));
        for (link, side) in [(0, &mut sorted.back), (2, &mut sorted.front)] {
            if !side.is_empty() {
                let first = self.stack.len();
                self.stack.append(side);
                self.put_off(Some((node, link)), first, task.depth + 1);
            }
        }
    }

    /// Takes all polygons from `first` on off the stack; those that are across are cut.
    fn sort(&mut self, first: usize, splitter: &Splitter, node: u32, sorted: &mut Sorted) {
        for working in self.stack.drain(first..) {
            let polygon = working.polygon as usize;
            let band = splitter.band_for(self.born.slack[polygon]);
            let side = if splitter.polygon == Some(working.polygon) {
                Side::On
            } else {
                splitter.side(self.arena.corners(&working), band)
            };
            match side {
                Side::Front => sorted.front.push(working),
                Side::Back => sorted.back.push(working),
                Side::On => sorted.on.push(working),
                // It is thinner than rounding: wherever it is, it is not seen.
                Side::Both if self.born.splitters[polygon].is_none() => sorted.front.push(working),
                Side::Both => {
                    let [front, back] = self.arena.split(working, &splitter.plane, band, node);
                    self.tree.splits += 1;
                    sorted.front.push(front);
                    sorted.back.push(back);
                }
            }
        }
    }

    fn put_off(&mut self, parent: Option<(u32, usize)>, first: usize, depth: u32) {
        self.tasks.push(Task {
            parent,
            first,
            corners: self.arena.len(),
            depth,
        });
    }

    fn hang(&mut self, parent: Option<(u32, usize)>, link: BspLink) {
        match parent {
            None => self.tree.root = link,
            Some((node, side)) => self.tree.nodes[node as usize].links[side] = link,
        }
    }

    /// Rounded outward, and wider by what corners that were made by a cut may be off.
    fn bounds(&self, members: &[Working]) -> Aabb {
        let [mut low, mut high] = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        for &corner in members.iter().flat_map(|member| self.arena.corners(member)) {
            low = low.min(corner);
            high = high.max(corner);
        }
        let [low, high] = [low - self.born.band, high + self.born.band];
        Aabb {
            min: low.to_array().map(|value| (value as f32).next_down()),
            max: high.to_array().map(|value| (value as f32).next_up()),
        }
    }

    /// Makes pieces of polygons that stay together.
    fn finish(&mut self, together: &mut Vec<Working>) -> BspLink {
        together.sort_by_key(|working| working.polygon);
        let first = self.tree.pieces.len() as u32;
        let link = if together.is_empty() {
            BspLink::NOTHING
        } else {
            BspLink::pieces(first)
        };
        let last = together.len().saturating_sub(1);
        for (place, working) in together.drain(..).enumerate() {
            self.cuts.clear();
            self.cuts.extend(self.arena.cuts(&working));
            // One plane may have made two edges, where rounding bent a thin polygon.
            self.cuts.sort_unstable();
            self.cuts.dedup();
            let first_cut = self.tree.cuts.len() as u32;
            self.tree.cuts.append(&mut self.cuts);
            let cuts = self.tree.cuts.len() as u32 - first_cut;
            self.tree
                .pieces
                .push(Piece::new(working.polygon, first_cut, cuts, place == last));
        }
        link
    }
}
