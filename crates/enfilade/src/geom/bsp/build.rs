//! BSP tree construction: choose a splitting plane, sort the polygons by it, and continue in front and behind.
//!
//! All pending polygons share one stack, and so do their corners. The side that is built last is below the other on
//! both, so that a side's memory is freed once it is built.
//! Source: Fuchs, Kedem, Naylor. On Visible Surface Generation by A Priori Tree Structures. SIGGRAPH 1980.
//! Cost: O(n) for each level, about log n levels; memory as large as the tree.
//! Always terminates: a polygon's own plane removes that polygon, a free plane leaves fewer polygons on either side,
//! and once `limit_bytes` is reached nothing is split any more.

use super::choose::{Chooser, InputPlanes};
use super::link::BspLink;
use super::parts::{self, Part, Sizes};
use super::side::{ROUNDING, Side, Splitter};
use super::split::{Arena, ClipPolygon, Cut};
use super::{BspOptions, BspTree, Node, Piece, Polygons};
use crate::geom::Aabb;
use glam::DVec3;
use std::num::NonZeroU32;
use std::sync::atomic::{AtomicU64, Ordering};

/// Minimum number of polygons for a subtree to store its AABB; for smaller ones the test costs more than it can save.
const MIN_POLYGONS_FOR_BOUNDS: usize = 8;

/// Builds a tree, or a part of one.
pub(super) struct Builder<'a> {
    options: &'a BspOptions,
    input: &'a InputPlanes,
    /// Tasks of at most this many polygons are deferred as [`Part`]s for other builders; 0 defers none.
    pub(super) largest_part: usize,
    pub(super) parts: Vec<Part>,
    /// Number of the first node built here; lower numbers belong to the tree that this part is linked into.
    first_node: u32,
    /// Bytes of all partial trees of this build, as far as their builders have reported them, and the bytes that this
    /// builder has reported.
    all_bytes: &'a AtomicU64,
    reported_bytes: u64,
    chooser: Chooser,
    arena: Arena,
    /// Polygons of all tasks, in the order of the tasks.
    stack: Vec<ClipPolygon>,
    tasks: Vec<Task>,
    pub(super) tree: BspTree,
    cuts: Vec<Cut>,
}

/// A builder reports its bytes whenever they have grown by this much.
const REPORT_BYTES: u64 = 1 << 16;

/// A subtree still to be built: the polygons from `first` to the top of the stack, once all later tasks are done.
struct Task {
    /// Parent node, and which of its links leads to this subtree.
    parent: Option<(u32, usize)>,
    first: usize,
    /// Number of corners in the arena when the task was pushed.
    corners: usize,
    depth: u32,
}

/// Polygons of a node by their side of its plane.
#[derive(Default)]
struct SideLists {
    front: Vec<ClipPolygon>,
    back: Vec<ClipPolygon>,
    on: Vec<ClipPolygon>,
}

/// See [`BspTree::build`].
pub(super) fn build(polygons: &Polygons, options: &BspOptions) -> BspTree {
    let input = InputPlanes::of(polygons);
    // If memory runs out, the polygons left unsorted must not depend on the timing of threads: then one thread builds
    // all.
    let mut tree = parts::largest(input.splitters.len())
        .and_then(|largest| parts::build(polygons, &input, options, largest))
        .unwrap_or_else(|| whole(polygons, &input, options));
    tree.shrink();
    tree
}

/// Builds the tree on one thread, from the first polygon to the last.
pub(super) fn whole(polygons: &Polygons, input: &InputPlanes, options: &BspOptions) -> BspTree {
    let all_bytes = AtomicU64::new(0);
    let mut builder = Builder::new(input, options, &all_bytes);
    builder.push_polygons(polygons);
    builder.run();
    builder.tree
}

impl InputPlanes {
    pub(super) fn of(polygons: &Polygons) -> InputPlanes {
        let corners = polygons.corners.iter().flatten();
        let largest = corners.fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let mut input = InputPlanes {
            splitters: Vec::new(),
            band: ROUNDING * largest,
        };
        let mut corners: Vec<DVec3> = Vec::new();
        for (polygon, ends) in polygons.starts.windows(2).enumerate() {
            let own = &polygons.corners[ends[0] as usize..ends[1] as usize];
            corners.clear();
            corners.extend(own.iter().map(|&corner| DVec3::from(corner)));
            input
                .splitters
                .push(Splitter::of(polygon as u32, &corners, input.band));
        }
        input
    }
}

impl<'a> Builder<'a> {
    pub(super) fn new(
        input: &'a InputPlanes,
        options: &'a BspOptions,
        all_bytes: &'a AtomicU64,
    ) -> Builder<'a> {
        Builder {
            options,
            input,
            largest_part: 0,
            parts: Vec::new(),
            first_node: 0,
            all_bytes,
            reported_bytes: 0,
            chooser: Chooser::new(),
            arena: Arena::default(),
            stack: Vec::new(),
            tasks: Vec::new(),
            tree: BspTree::default(),
            cuts: Vec::new(),
        }
    }

    pub(super) fn push_polygons(&mut self, polygons: &Polygons) {
        for (polygon, ends) in polygons.starts.windows(2).enumerate() {
            let corners = &polygons.corners[ends[0] as usize..ends[1] as usize];
            let corners = corners.iter().map(|&corner| DVec3::from(corner));
            let working = self.arena.add(polygon as u32, corners);
            self.stack.push(working);
        }
        if !self.stack.is_empty() {
            self.push_task(None, 0, 1);
        }
    }

    /// Loads a part that another builder deferred.
    pub(super) fn load_part(&mut self, part: &mut Part) {
        self.first_node = part.at.nodes;
        self.arena = std::mem::take(&mut part.arena);
        self.stack = std::mem::take(&mut part.members);
        self.push_task(None, 0, part.depth);
    }

    /// Defers a task, to be built by another builder.
    fn defer(&mut self, task: &Task) {
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

    /// Returns the bytes of all partial trees of this build plus those of the pieces that pending polygons will become.
    /// Reports the bytes of this builder if they have grown by `at_least`.
    fn bytes(&mut self, at_least: u64) -> u64 {
        let own = self.tree.bytes();
        if own - self.reported_bytes >= at_least {
            self.all_bytes
                .fetch_add(own - self.reported_bytes, Ordering::Relaxed);
            self.reported_bytes = own;
        }
        let others = self.all_bytes.load(Ordering::Relaxed) - self.reported_bytes;
        own + others + (self.stack.len() * size_of::<Piece>()) as u64
    }

    pub(super) fn run(&mut self) {
        let max_bytes = self.options.limit_bytes.min(BspTree::MAX_PIECE_BYTES);
        let mut sorted = SideLists::default();
        while let Some(task) = self.tasks.pop() {
            self.arena.forget(task.corners);
            self.tree.depth = self.tree.depth.max(task.depth);
            if self.stack.len() - task.first <= self.largest_part {
                self.defer(&task);
                continue;
            }
            let full = self.bytes(REPORT_BYTES) > max_bytes;
            let members = &self.stack[task.first..];
            let splitter = if members.len() < 2 || full {
                self.tree.incomplete |= members.len() > 1;
                None
            } else {
                self.chooser
                    .choose(members, &self.arena, self.input, self.options)
            };
            match splitter {
                Some(splitter) => self.split(task, &splitter, &mut sorted),
                None => {
                    sorted.on.extend(self.stack.drain(task.first..));
                    let link = self.push_pieces(&mut sorted.on);
                    self.link_to_parent(task.parent, link);
                }
            }
        }
        self.bytes(0);
    }

    /// Makes a node of a task, and a task of each nonempty side.
    fn split(&mut self, task: Task, splitter: &Splitter, sorted: &mut SideLists) {
        let node = self.first_node + self.tree.nodes.len() as u32;
        let members = &self.stack[task.first..];
        let bounds = (members.len() >= MIN_POLYGONS_FOR_BOUNDS).then(|| self.bounds(members));
        self.sort(task.first, splitter, node, sorted);
        let own = self.push_pieces(&mut sorted.on);
        if sorted.front.is_empty() && sorted.back.is_empty() {
            // All polygons are coplanar: a leaf, which needs no plane.
            self.link_to_parent(task.parent, own);
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
        self.link_to_parent(task.parent, BspLink::node(node));
        for (link, side) in [(0, &mut sorted.back), (2, &mut sorted.front)] {
            if !side.is_empty() {
                let first = self.stack.len();
                self.stack.append(side);
                self.push_task(Some((node, link)), first, task.depth + 1);
            }
        }
    }

    /// Pops all polygons from `first` on and sorts them by side; polygons that straddle the plane are cut.
    fn sort(&mut self, first: usize, splitter: &Splitter, node: u32, sorted: &mut SideLists) {
        for working in self.stack.drain(first..) {
            let polygon = working.polygon as usize;
            // A polygon that is not quite planar is drawn as triangles, and a plane within its deviation cuts those
            // differently from the outline. Hence the wider band.
            let own = self.input.splitters[polygon].map_or(0.0, |own| own.band);
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
                // Thinner than rounding: never visible, so it may go to either side without being cut.
                Side::Both if self.input.splitters[polygon].is_none() => sorted.front.push(working),
                Side::Both => {
                    let [front, back] = self.arena.split(working, &splitter.plane, band, node);
                    self.tree.splits += 1;
                    sorted.front.push(front);
                    sorted.back.push(back);
                }
            }
        }
    }

    fn push_task(&mut self, parent: Option<(u32, usize)>, first: usize, depth: u32) {
        self.tasks.push(Task {
            parent,
            first,
            corners: self.arena.len(),
            depth,
        });
    }

    fn link_to_parent(&mut self, parent: Option<(u32, usize)>, link: BspLink) {
        match parent {
            None => self.tree.root = link,
            Some((node, side)) => self.tree.nodes[(node - self.first_node) as usize].links[side] = link,
        }
    }

    /// Returns the AABB, rounded outward and enlarged by the error of corners made by cuts.
    fn bounds(&self, members: &[ClipPolygon]) -> Aabb {
        let [mut low, mut high] = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        for &corner in members.iter().flat_map(|member| self.arena.corners(member)) {
            low = low.min(corner);
            high = high.max(corner);
        }
        let [low, high] = [low - self.input.band, high + self.input.band];
        Aabb {
            min: low.to_array().map(|value| (value as f32).next_down()),
            max: high.to_array().map(|value| (value as f32).next_up()),
        }
    }

    /// Adds a run of pieces for polygons that stay together.
    fn push_pieces(&mut self, together: &mut Vec<ClipPolygon>) -> BspLink {
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
            // One plane may have made two edges if rounding bent a thin polygon.
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
