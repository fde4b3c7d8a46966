//! Parallel BSP tree construction in independent parts.
//!
//! One thread builds the top of the tree and defers every subtree with few polygons. The deferred parts are built in
//! parallel, because no plane of one depends on the polygons of another. Then all parts are merged in the order in
//! which a single thread would have built them.
//! Source: ours.
//! Cost: the top (O(n) for each of its levels) and the merge (O(tree)) run on one thread, all else on all threads.
//! Memory while building: the corners of pending polygons twice, and the tree a second time during the merge.
//! Deterministic: the same tree, bit for bit, however it is divided. If the memory limit is reached, nothing is merged
//! and `build` returns `None`.

use super::build::Builder;
use super::choose::InputPlanes;
use super::link::{BspLink, LinkTarget};
use super::split::{Arena, ClipPolygon, Cut};
use super::{BspOptions, BspTree, Node, Piece, Polygons};
use crate::threads;
use std::sync::atomic::AtomicU64;

/// A subtree with few polygons, to be built independently.
pub(super) struct Part {
    /// Parent node in the top, and which of its links leads to this part.
    pub(super) parent: Option<(u32, usize)>,
    pub(super) depth: u32,
    pub(super) arena: Arena,
    pub(super) members: Vec<ClipPolygon>,
    /// Sizes of the top when this part was deferred; the part is inserted there. Node numbers below `at.nodes` refer to
    /// the top, higher ones to this part.
    pub(super) at: Sizes,
    /// The finished subtree.
    pub(super) tree: BspTree,
}

/// Array lengths of a tree.
#[derive(Clone, Copy, Default)]
pub(super) struct Sizes {
    pub(super) nodes: u32,
    bounds: u32,
    pieces: u32,
    cuts: u32,
}

/// Minimum number of polygons for a parallel build; one thread sorts fewer ones faster.
const MIN_POLYGONS: usize = 1 << 14;

/// Number of parts if all were equally large: many more than threads, because some take less time than others.
const PARTS: usize = 64;

/// Returns the maximum number of polygons of a part; `None` if one thread should build the whole tree.
pub(super) fn largest(polygons: usize) -> Option<usize> {
    (threads::count() > 1 && polygons >= MIN_POLYGONS).then_some(polygons / PARTS)
}

/// Builds a tree from parts of at most `largest_part` polygons; `None` if the memory limit is reached.
pub(super) fn build(
    polygons: &Polygons,
    input: &InputPlanes,
    options: &BspOptions,
    largest_part: usize,
) -> Option<BspTree> {
    let all_bytes = AtomicU64::new(0);
    let mut top = Builder::new(input, options, &all_bytes);
    top.largest_part = largest_part;
    top.push_polygons(polygons);
    top.run();
    let Builder {
        tree: top, mut parts, ..
    } = top;
    threads::for_each(&mut parts, |_, part| {
        let mut builder = Builder::new(input, options, &all_bytes);
        builder.load_part(part);
        builder.run();
        part.tree = builder.tree;
    });
    let trees = || [&top].into_iter().chain(parts.iter().map(|part| &part.tree));
    let bytes: u64 = trees().map(BspTree::bytes).sum();
    let fits =
        bytes <= options.limit_bytes.min(BspTree::MAX_PIECE_BYTES) && trees().all(BspTree::is_complete);
    fits.then(|| PartMerger::new(&parts).join(top, parts))
}

/// Merges the top and the parts in the order in which a single builder would have made them.
struct PartMerger {
    /// By part: the sizes of the top when it was deferred, and the total sizes of the parts before it (one entry more,
    /// for the total of all).
    at: Vec<Sizes>,
    before: Vec<Sizes>,
    tree: BspTree,
}

impl PartMerger {
    fn new(parts: &[Part]) -> PartMerger {
        let mut sum = Sizes::default();
        let mut before = vec![sum];
        before.extend(parts.iter().map(|part| {
            sum = sum.and(&Sizes::of(&part.tree));
            sum
        }));
        PartMerger {
            at: parts.iter().map(|part| part.at).collect(),
            before,
            tree: BspTree::default(),
        }
    }

    fn join(mut self, top: BspTree, parts: Vec<Part>) -> BspTree {
        let all = Sizes::of(&top).and(&self.before[parts.len()]);
        self.tree.nodes.reserve_exact(all.nodes as usize);
        self.tree.planes.reserve_exact(all.nodes as usize);
        self.tree.bounds.reserve_exact(all.bounds as usize);
        self.tree.pieces.reserve_exact(all.pieces as usize);
        self.tree.cuts.reserve_exact(all.cuts as usize);
        self.tree.root = self.link(top.root, None);
        (self.tree.splits, self.tree.depth) = (top.splits, top.depth);
        let mut from = Sizes::default();
        let mut pending_links = Vec::new();
        for (number, Part { parent, tree, .. }) in parts.into_iter().enumerate() {
            let at = self.at[number];
            self.append(&top, [from, at], number, None);
            self.append(&tree, [Sizes::default(), Sizes::of(&tree)], number, Some(number));
            pending_links.push((parent, self.link(tree.root, Some(number))));
            self.tree.splits += tree.splits;
            self.tree.depth = self.tree.depth.max(tree.depth);
            from = at;
        }
        self.append(&top, [from, Sizes::of(&top)], self.at.len(), None);
        for (parent, link) in pending_links {
            match parent {
                None => self.tree.root = link,
                Some((node, side)) => {
                    let node = self.node(node, None);
                    self.tree.nodes[node as usize].links[side] = link;
                }
            }
        }
        self.tree
    }
}

impl PartMerger {
    /// Appends the range of `tree` between two sizes, after the first `parts` parts. `of` is the part that the range
    /// belongs to; `None` for the top.
    fn append(&mut self, tree: &BspTree, [from, to]: [Sizes; 2], parts: usize, of: Option<usize>) {
        let before = match of {
            Some(_) => self.at[parts].and(&self.before[parts]),
            None => self.before[parts],
        };
        let nodes = from.nodes as usize..to.nodes as usize;
        for node in &tree.nodes[nodes.clone()] {
            let links = node.links.map(|link| self.link(link, of));
            let bounds = node.bounds.map(|place| place.saturating_add(before.bounds));
            self.tree.nodes.push(Node { links, bounds });
        }
        self.tree.planes.extend_from_slice(&tree.planes[nodes]);
        let bounds = from.bounds as usize..to.bounds as usize;
        self.tree.bounds.extend_from_slice(&tree.bounds[bounds]);
        let pieces = from.pieces as usize..to.pieces as usize;
        let pieces = tree.pieces[pieces].iter().map(|piece| Piece {
            first_cut: piece.first_cut + before.cuts,
            ..*piece
        });
        self.tree.pieces.extend(pieces);
        let cuts = from.cuts as usize..to.cuts as usize;
        for cut in &tree.cuts[cuts] {
            self.tree
                .cuts
                .push(Cut::new(self.node(cut.node(), of), cut.back()));
        }
    }

    /// Converts a node number of a part, or of the top, to the merged tree.
    fn node(&self, number: u32, of: Option<usize>) -> u32 {
        let parts = match of {
            Some(part) if number >= self.at[part].nodes => part,
            _ => self.at.partition_point(|at| at.nodes <= number),
        };
        number + self.before[parts].nodes
    }

    fn link(&self, link: BspLink, of: Option<usize>) -> BspLink {
        match link.target() {
            LinkTarget::Nothing => link,
            LinkTarget::Node(number) => BspLink::node(self.node(number, of)),
            LinkTarget::Pieces(first) => {
                let before = match of {
                    Some(part) => self.at[part].pieces + self.before[part].pieces,
                    None => self.before[self.at.partition_point(|at| at.pieces <= first)].pieces,
                };
                BspLink::pieces(first + before)
            }
        }
    }
}

impl Sizes {
    pub(super) fn of(tree: &BspTree) -> Sizes {
        Sizes {
            nodes: tree.nodes.len() as u32,
            bounds: tree.bounds.len() as u32,
            pieces: tree.pieces.len() as u32,
            cuts: tree.cuts.len() as u32,
        }
    }

    fn and(&self, more: &Sizes) -> Sizes {
        Sizes {
            nodes: self.nodes + more.nodes,
            bounds: self.bounds + more.bounds,
            pieces: self.pieces + more.pieces,
            cuts: self.cuts + more.cuts,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::build::whole;
    use super::super::tests::jumble;
    use super::*;
    use crate::chance::Dice;

    #[test]
    fn a_tree_in_parts_is_the_one_that_is_built_in_turn() {
        for seed in 0..4 {
            let polygons = jumble(&mut Dice::new(seed), 500);
            let options = BspOptions::default();
            let input = InputPlanes::of(&polygons);
            let in_turn = whole(&polygons, &input, &options);
            let expected = format!("{in_turn:?}");
            for largest_part in [1, 7, 60, 500] {
                let parts = build(&polygons, &input, &options, largest_part).expect("no limit is reached");
                assert!(parts.splits > 100);
                assert!(format!("{parts:?}") == expected, "{largest_part}");
            }
            let limit_bytes = in_turn.bytes();
            for (limit_bytes, fits) in [(limit_bytes, true), (limit_bytes - 1, false)] {
                let options = BspOptions {
                    limit_bytes,
                    ..options
                };
                assert_eq!(build(&polygons, &input, &options, 60).is_some(), fits);
            }
        }
    }
}
