//! The portals of a map, rebuilt from what was compiled of it: its tree of planes alone says where its leafs touch.
//!
//! What a node's plane cuts of its part of the world is laid down both sides of the tree; where a piece comes to lie, two
//! clusters touch, and if neither is solid one sees through.
//! Source: the idea is that of all compilers of such maps; Naylor, Amanatides, Thibault. Merging BSP Trees Yields Polyhedral
//! Set Operations. SIGGRAPH 1990, for what is laid down a tree.
//! Cost: O(nodes · sides of their parts + pieces · depth).
//! Never smaller than what one sees through: pieces are cut to 10⁻⁷ unit where compilers cut to 0.1, and kept down to a
//! width of 0.001 where compilers let go what is thinner than 0.2. A hole too many costs time, one too few hides a room.
//! Hostile: no recursion, memory is asked for before it is taken, and a leaf that stands in two places is refused.

mod clusters;
mod outline;
mod polygon;
mod region;

use super::bsp::{Child, Map, Tree, int};
use super::{BspError, PortalFile, PrtKind};
use crate::budget::Budget;
use crate::{BrokenRule, ImportError, ReadOptions, read_file};
use clusters::{Clusters, Part};
use enfilade_bake::{Cells, Portal};
use glam::DVec3;
use outline::{enlarged, tidy, width};
use polygon::{Corner, HALF, Side};
use region::Region;
use std::path::Path;

/// The portals of a map, rebuilt.
#[derive(Clone, Debug)]
pub struct RebuiltPortals {
    /// As a compiler would have left them.
    pub file: PortalFile,
    /// What said which leafs are one cluster.
    pub clusters_from: ClustersFrom,
    /// Leafs of the world that are not solid.
    pub leafs: u32,
    /// Holes thinner than 0.001 unit, which are left out: the numbers of the file are too coarse to say whether they are
    /// there.
    pub slivers: usize,
}

/// What said which leafs of a map are one cluster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClustersFrom {
    /// The map: leafs of Quake 3 have their clusters' numbers.
    Map,
    /// Rows of what is visible, which the leafs of a cluster share.
    Rows,
    /// Nothing: each leaf is a cluster. Finer than the compiler's where that had several leafs in one, and no less right.
    Leafs,
}

/// Thinner than this is no hole, in units: the planes of a file are numbers of 32 bits, which put what is 4,096 units from
/// the middle up to 0.0007 beside its place, so that leafs that only meet along an edge overlap by as much.
const NO_HOLE: f64 = 0.001;

/// Rebuilds the portals of a compiled map: BSP29, BSP2 or IBSP46.
///
/// # Errors
/// An [`ImportError`] that names the file and the rule; the same one every time.
pub fn rebuild_portals(path: &Path, options: &ReadOptions) -> Result<RebuiltPortals, ImportError> {
    read_file(path, options, |bytes, _, budget| rebuild(bytes, budget))
}

/// Rebuilds the portals of a compiled map out of its bytes.
///
/// # Errors
/// As [`rebuild_portals`].
pub fn rebuild_portals_bytes(map: &[u8], options: &ReadOptions) -> Result<RebuiltPortals, ImportError> {
    let rebuilt = rebuild(map, Budget::new(options.limit_bytes));
    rebuilt.map_err(|rule| ImportError {
        file: "the bytes given".to_owned(),
        rule,
    })
}

fn rebuild(map: &[u8], mut budget: Budget) -> Result<RebuiltPortals, BrokenRule> {
    // The bytes once more, the tree, and what its parts are.
    budget.take(map.len() as u64 * 6, || "its tree".to_owned())?;
    let map = Map::read(map)?;
    let tree = Tree::read(&map)?;
    let clusters = Clusters::of(&map, &tree)?;
    let mut portals = Portals {
        tree: &tree,
        clusters: &clusters,
        sides: tree.planes.iter().map(Side::before).collect(),
        found: Vec::new(),
        slivers: 0,
        budget,
    };
    portals.find(Region::of_box(world(&map)))?;
    let Portals {
        mut found, slivers, ..
    } = portals;
    found.sort_by_key(|portal| (portal.cells[0].min(portal.cells[1]), portal.cells));
    let cells = Cells::new(clusters.count(), found).map_err(BspError::from)?;
    let is_quake3 = map.format.is_quake3;
    let has_leafs_alone = clusters.of_leaf.len() == clusters.count() as usize;
    let kind = match (is_quake3, has_leafs_alone) {
        (true, _) => PrtKind::Quake3,
        (false, true) => PrtKind::Prt1,
        (false, false) => PrtKind::Prt2,
    };
    Ok(RebuiltPortals {
        leafs: clusters.leafs_in_sight(),
        clusters_from: clusters.from,
        slivers,
        file: PortalFile {
            kind,
            cells,
            cluster_of_leaf: (kind == PrtKind::Prt2).then_some(clusters.of_leaf),
        },
    })
}

/// How far the world goes, from its least to its greatest corner.
///
/// Maps of Quake are closed, so that it does not matter. Maps of Quake 3 may be open to what is around them; that ends where
/// the first node says, eight units and more beyond what is drawn.
fn world(map: &Map) -> [DVec3; 2] {
    let all = [DVec3::splat(-HALF), DVec3::splat(HALF)];
    let first = map.lump(map.format.nodes).get(..map.format.node_bytes);
    let Some(first) = first.filter(|_| map.format.is_quake3) else {
        return all;
    };
    let corner = |at: usize| DVec3::from([0, 4, 8].map(|axis| f64::from(int(first, at + axis))));
    let [least, most] = [corner(12), corner(24)];
    let is_box = least.cmplt(most).all() && least.cmpge(all[0]).all() && most.cmple(all[1]).all();
    if is_box { [least, most] } else { all }
}

/// A walk through the tree that finds them.
#[derive(Debug)]
struct Portals<'a> {
    tree: &'a Tree,
    clusters: &'a Clusters,
    /// Of each plane the side before it.
    sides: Vec<Side>,
    found: Vec<Portal>,
    slivers: usize,
    budget: Budget,
}

impl Portals<'_> {
    fn find(&mut self, world: Region) -> Result<(), BrokenRule> {
        let mut waiting = vec![(self.tree.root, world)];
        let [mut bytes, mut most] = [0u64, 0u64];
        while let Some((child, region)) = waiting.pop() {
            bytes = bytes.saturating_sub(region.bytes());
            let Child::Node(node) = child else { continue };
            let node = self.tree.nodes[node as usize];
            let side = self.sides[node.plane as usize];
            let across = region.across(&side);
            if !across.is_empty() {
                self.lay_down(&side, node.children, &across)?;
            }
            for (child, side) in node.children.into_iter().zip([side, side.behind()]) {
                if self.clusters.part(child) != Part::Mixed {
                    continue;
                }
                let part = region.part(&side, &across);
                if part.is_empty() {
                    continue;
                }
                bytes += part.bytes();
                if bytes > most {
                    self.budget
                        .take(bytes - most, || "the parts of its tree".to_owned())?;
                    most = bytes;
                }
                waiting.push((child, part));
            }
        }
        Ok(())
    }

    /// The pieces of a node's polygon that lie between two clusters.
    fn lay_down(&mut self, side: &Side, children: [Child; 2], across: &[Corner]) -> Result<(), BrokenRule> {
        for (front, piece) in self.spread(children[0], across) {
            for (back, mut corners) in self.spread(children[1], &piece) {
                if front == back || !self.clusters.see_through(front, back) {
                    continue;
                }
                tidy(&mut corners);
                if corners.len() < 3 || width(&corners) < NO_HOLE {
                    self.slivers += 1;
                    continue;
                }
                let takes = size_of::<Portal>() + corners.len() * size_of::<[f64; 3]>();
                self.budget.take(takes as u64, || "its portals".to_owned())?;
                self.found.push(Portal {
                    corners: enlarged(&corners, side).into_iter().map(Into::into).collect(),
                    cells: [back, front],
                });
            }
        }
        Ok(())
    }

    /// The clusters below a part of the tree that a polygon comes to lie in, with the piece that does.
    fn spread(&self, child: Child, polygon: &[Corner]) -> Vec<(u32, Vec<Corner>)> {
        let mut pieces = Vec::new();
        let mut waiting = vec![(child, polygon.to_vec())];
        while let Some((child, polygon)) = waiting.pop() {
            match (self.clusters.part(child), child) {
                (Part::Cluster(cluster), _) => pieces.push((cluster, polygon)),
                (Part::Mixed, Child::Node(node)) => {
                    let node = self.tree.nodes[node as usize];
                    let side = self.sides[node.plane as usize];
                    for (child, side) in node.children.into_iter().zip([side, side.behind()]) {
                        if self.clusters.part(child) == Part::Solid {
                            continue;
                        }
                        let piece = side.cut(polygon.clone());
                        if !piece.is_empty() {
                            waiting.push((child, piece));
                        }
                    }
                }
                (Part::Solid | Part::Mixed, _) => {}
            }
        }
        pieces
    }
}
