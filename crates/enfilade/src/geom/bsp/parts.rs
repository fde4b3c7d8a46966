//! A BSP tree built in parts, side by side.
//!
//! The top is built as ever; what is left of few polygons below it is put aside, and each such part is built by itself, for
//! no plane of one depends on what is in another. Then all is put where it would be had one thread built it in turn.
//! Source: ours.
//! Cost: the top, O(n) for each of its levels, and putting together, O(tree), take one thread; all else is shared among all.
//!     Memory while building: corners of the polygons at work twice, and the tree as well once it is put together.
//! The same tree, bit for bit, whatever is put aside. Once memory runs out it says so, and nothing is put together.

use super::build::Builder;
use super::choose::Born;
use super::link::{Below, BspLink};
use super::split::{Arena, Cut, Working};
use super::{BspOptions, BspTree, Node, Piece, Polygons};
use crate::threads;
use std::sync::atomic::AtomicU64;

/// What is left of some polygons below a node, to be built by itself.
pub(super) struct Part {
    /// The node it hangs below, and which of the node's links leads to it.
    pub(super) parent: Option<(u32, usize)>,
    pub(super) depth: u32,
    pub(super) arena: Arena,
    pub(super) members: Vec<Working>,
    /// What there was of the top when it was put aside: there it belongs. Nodes of the top have lower numbers if they stand
    /// above it, and its own are counted from here on.
    pub(super) at: Sizes,
    /// What was built of it.
    pub(super) tree: BspTree,
}

/// How much there is of a tree.
#[derive(Clone, Copy, Default)]
pub(super) struct Sizes {
    pub(super) nodes: u32,
    bounds: u32,
    pieces: u32,
    cuts: u32,
}

/// Fewer polygons are sorted sooner by one thread.
const LEAST: usize = 1 << 14;

/// Into how many parts as large as each other polygons would fall: many more than threads, for some are sorted sooner.
const PARTS: usize = 64;

/// The polygons of a part, at most; `None` where one thread does best to build all.
pub(super) fn largest(polygons: usize) -> Option<usize> {
    (threads::count() > 1 && polygons >= LEAST).then_some(polygons / PARTS)
}

/// Builds a tree whose parts have at most so many polygons; `None` where memory runs out.
pub(super) fn build(
    polygons: &Polygons,
    born: &Born,
    options: &BspOptions,
    largest_part: usize,
) -> Option<BspTree> {
    let all_bytes = AtomicU64::new(0);
    let mut top = Builder::new(born, options, &all_bytes);
    top.largest_part = largest_part;
    top.take_in(polygons);
    top.run();
    let Builder {
        tree: top, mut parts, ..
    } = top;
    threads::for_each(&mut parts, |_, part| {
        let mut builder = Builder::new(born, options, &all_bytes);
        builder.take_in_part(part);
        builder.run();
        part.tree = builder.tree;
    });
    let trees = || [&top].into_iter().chain(parts.iter().map(|part| &part.tree));
    let bytes: u64 = trees().map(BspTree::bytes).sum();
    let fits = bytes <= options.limit_bytes.min(BspTree::GREATEST) && trees().all(BspTree::is_complete);
    fits.then(|| Joining::new(&parts).join(top, parts))
}

/// Puts a top and its parts together, in the order in which one builder would have made them.
struct Joining {
    /// By part, what there was of the top when it was put aside, and what of parts stands before it; of all parts last.
    at: Vec<Sizes>,
    before: Vec<Sizes>,
    tree: BspTree,
}

impl Joining {
    fn new(parts: &[Part]) -> Joining {
        let mut sum = Sizes::default();
        let mut before = vec![sum];
        before.extend(parts.iter().map(|part| {
            sum = sum.and(&Sizes::of(&part.tree));
            sum
        }));
        Joining {
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
        let mut hung = Vec::new();
        for (number, Part { parent, tree, .. }) in parts.into_iter().enumerate() {
            let at = self.at[number];
            self.append(&top, [from, at], number, None);
            self.append(&tree, [Sizes::default(), Sizes::of(&tree)], number, Some(number));
            hung.push((parent, self.link(tree.root, Some(number))));
            self.tree.splits += tree.splits;
            self.tree.depth = self.tree.depth.max(tree.depth);
            from = at;
        }
        self.append(&top, [from, Sizes::of(&top)], self.at.len(), None);
        for (parent, link) in hung {
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

impl Joining {
    /// Appends what was built from one moment to another, before which so many parts come. `of` is the part that it belongs to;
    /// `None`: the top.
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

    /// The number of a node of a part, or of the top, in the tree that is put together.
    fn node(&self, number: u32, of: Option<usize>) -> u32 {
        let parts = match of {
            Some(part) if number >= self.at[part].nodes => part,
            _ => self.at.partition_point(|at| at.nodes <= number),
        };
        number + self.before[parts].nodes
    }

    fn link(&self, link: BspLink, of: Option<usize>) -> BspLink {
        match link.below() {
            Below::Nothing => link,
            Below::Node(number) => BspLink::node(self.node(number, of)),
            Below::Pieces(first) => {
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
    use super::super::tests::{Random, jumble};
    use super::*;

    #[test]
    fn a_tree_in_parts_is_the_one_that_is_built_in_turn() {
        for seed in 0..6 {
            let polygons = jumble(&mut Random(seed), 900);
            let options = BspOptions::default();
            let born = Born::of(&polygons);
            let in_turn = whole(&polygons, &born, &options);
            for largest_part in [1, 7, 60, 500, 900] {
                let parts = build(&polygons, &born, &options, largest_part).expect("no limit is reached");
                assert!(parts.splits > 100);
                assert_eq!(format!("{parts:?}"), format!("{in_turn:?}"), "{largest_part}");
            }
            let limit_bytes = in_turn.bytes();
            for (limit_bytes, fits) in [(limit_bytes, true), (limit_bytes - 1, false)] {
                let options = BspOptions {
                    limit_bytes,
                    ..options
                };
                assert_eq!(build(&polygons, &born, &options, 60).is_some(), fits);
            }
        }
    }
}
