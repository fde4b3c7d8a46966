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
use super::parts::{self, Part, Sizes};
use super::side::{ROUNDING, Side, Splitter};
use super::split::{Arena, Cut, Working};
use super::{BspOptions, BspTree, Node, Piece, Polygons};
use crate::geom::Aabb;
use glam::DVec3;
use std::num::NonZeroU32;
use std::sync::atomic::{AtomicU64, Ordering};

/// Subtrees of fewer pieces have no box: asking costs more than it can save.
const FEWEST_IN_BOX: usize = 8;

/// Builds a tree, or a part of one.
pub(super) struct Builder<'a> {
    options: &'a BspOptions,
    born: &'a Born,
    /// Of how few polygons what is left is put aside, for others to build; 0: of none.
    pub(super) largest_part: usize,
    pub(super) parts: Vec<Part>,
    /// The number of its first node: lower ones are of the tree that it builds a part of.
    first_node: u32,
    /// Bytes of all trees that are built for one, as far as their builders have told, and what this one has told.
    all_bytes: &'a AtomicU64,
    told_bytes: u64,
    chooser: Chooser,
    arena: Arena,
    /// The polygons of all tasks, in the order of these.
    stack: Vec<Working>,
    tasks: Vec<Task>,
    pub(super) tree: BspTree,
    cuts: Vec<Cut>,
}

/// A tree's bytes are told when they have grown by so many.
const TELL_BYTES: u64 = 1 << 16;

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
    let born = Born::of(polygons);
    // Where memory runs out, what is left unsorted must not depend on who builds first.
    let mut tree = parts::largest(born.splitters.len())
        .and_then(|largest| parts::build(polygons, &born, options, largest))
        .unwrap_or_else(|| whole(polygons, &born, options));
    tree.shrink();
    tree
}

/// The same by one thread, from the first polygon to the last.
pub(super) fn whole(polygons: &Polygons, born: &Born, options: &BspOptions) -> BspTree {
    let all_bytes = AtomicU64::new(0);
    let mut builder = Builder::new(born, options, &all_bytes);
    builder.take_in(polygons);
    builder.run();
    builder.tree
}

impl Born {
    pub(super) fn of(polygons: &Polygons) -> Born {
        let corners = polygons.corners.iter().flatten();
        let largest = corners.fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let mut born = Born {
            splitters: Vec::new(),
            band: ROUNDING * largest,
        };
        let mut corners: Vec<DVec3> = Vec::new();
        for (polygon, ends) in polygons.starts.windows(2).enumerate() {
            let own = &polygons.corners[ends[0] as usize..ends[1] as usize];
            corners.clear();
            corners.extend(own.iter().map(|&corner| DVec3::from(corner)));
            born.splitters
                .push(Splitter::of(polygon as u32, &corners, born.band));
        }
        born
    }
}

impl<'a> Builder<'a> {
    pub(super) fn new(born: &'a Born, options: &'a BspOptions, all_bytes: &'a AtomicU64) -> Builder<'a> {
        Builder {
            options,
            born,
            largest_part: 0,
            parts: Vec::new(),
            first_node: 0,
            all_bytes,
            told_bytes: 0,
            chooser: Chooser::new(),
            arena: Arena::default(),
            stack: Vec::new(),
            tasks: Vec::new(),
            tree: BspTree::default(),
            cuts: Vec::new(),
        }
    }

    pub(super) fn take_in(&mut self, polygons: &Polygons) {
        for (polygon, ends) in polygons.starts.windows(2).enumerate() {
            let corners = &polygons.corners[ends[0] as usize..ends[1] as usize];
            let corners = corners.iter().map(|&corner| DVec3::from(corner));
            let working = self.arena.add(polygon as u32, corners);
            self.stack.push(working);
        }
        if !self.stack.is_empty() {
            self.put_off(None, 0, 1);
        }
    }

    /// Takes in what another builder put aside.
    pub(super) fn take_in_part(&mut self, part: &mut Part) {
        self.first_node = part.at.nodes;
        self.arena = std::mem::take(&mut part.arena);
        self.stack = std::mem::take(&mut part.members);
        self.put_off(None, 0, part.depth);
    }

    /// Leaves a task to another builder.
    fn put_aside(&mut self, task: &Task) {
        let mut arena = Arena::default();
        let members = self.stack.drain(task.first..);
        let members = members.map(|working| arena.copy(&self.arena, &working)).collect();
        self.parts.push(Part {
            parent: task.parent,
            depth: task.depth,
            arena,
            members,
            at: Sizes::of(&self.tree),
            tree: BspTree::default(),
        });
    }

    /// Bytes of all that is built for one tree, and of the pieces that there will be of what waits here.
    fn bytes(&mut self, at_least: u64) -> u64 {
        let own = self.tree.bytes();
        if own - self.told_bytes >= at_least {
            self.all_bytes.fetch_add(own - self.told_bytes, Ordering::Relaxed);
            self.told_bytes = own;
        }
        let others = self.all_bytes.load(Ordering::Relaxed) - self.told_bytes;
        own + others + (self.stack.len() * size_of::<Piece>()) as u64
    }

    pub(super) fn run(&mut self) {
        let most_bytes = self.options.limit_bytes.min(BspTree::GREATEST);
        let mut sorted = Sorted::default();
        while let Some(task) = self.tasks.pop() {
            self.arena.forget(task.corners);
            self.tree.depth = self.tree.depth.max(task.depth);
            if self.stack.len() - task.first <= self.largest_part {
                self.put_aside(&task);
                continue;
            }
            let full = self.bytes(TELL_BYTES) > most_bytes;
            let members = &self.stack[task.first..];
            let splitter = if members.len() < 2 || full {
                self.tree.incomplete |= members.len() > 1;
                None
            } else {
                self.chooser.choose(members, &self.arena, self.born, self.options)
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
        self.bytes(0);
    }

    /// Makes a node of a task, and a task of each side.
    fn split(&mut self, task: Task, splitter: &Splitter, sorted: &mut Sorted) {
        let node = self.first_node + self.tree.nodes.len() as u32;
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
            // One that is bent is drawn as triangles: a plane within its bend does not cut those as it cuts the outline.
            let own = self.born.splitters[polygon].map_or(0.0, |own| own.band);
            let band = splitter.band.max(own);
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
            Some((node, side)) => self.tree.nodes[(node - self.first_node) as usize].links[side] = link,
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
