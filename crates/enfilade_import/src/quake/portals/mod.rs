//! Rebuilds the portals of a map from its compiled BSP tree, whose planes determine where its leafs touch.
//!
//! The plane of each node is clipped to the node's region and pushed down both subtrees; where a piece ends up between
//! two clusters, they touch, and if light can pass between them, the piece is a portal.
//! Compilers push linked lists of portals down instead. Here each node has its own polygon and region: nothing is
//! shared between nodes, and depth costs nothing. The file does not tell which walls the author marked as detail: a
//! compiler's portals extend into such walls, these do not.
//! Source: the method of all compilers of such maps; for pushing polygons down a tree, Naylor, Amanatides, Thibault.
//! Merging BSP Trees Yields Polyhedral Set Operations. SIGGRAPH 1990.
//! Cost: O(nodes · sides of their regions + pieces · depth).
//! Conservative: a portal is never smaller than the true opening. Pieces are clipped with a tolerance of 10⁻⁷ unit,
//! where compilers use 0.1, and kept down to a width of 0.001, where compilers drop those thinner than 0.2. A surplus
//! portal costs time; a missing one culls a visible room.
//! Hostile input: no recursion; memory is reserved from the budget before it is allocated; a leaf with two parents is
//! an error.

mod clusters;
mod leak;
mod outline;
mod polygon;
mod region;

pub use leak::{Leak, find_leak};

use super::bsp::{Child, Map, Tree, int};
use super::{BspError, PortalFile, PrtKind};
use crate::budget::Budget;
use crate::{BrokenRule, ImportError, ReadOptions, read_file};
use clusters::{Clusters, SubtreeCluster};
use enfilade_bake::{Cells, Portal};
use glam::DVec3;
use outline::{enlarged, tidy, width};
use polygon::{Corner, HALF, Side};
use region::Region;
use std::path::Path;

/// Portals that were rebuilt from a compiled map.
#[derive(Clone, Debug)]
pub struct RebuiltPortals {
    /// The same data as in the compiler's portal file.
    pub file: PortalFile,
    /// Source of the grouping of leafs into clusters.
    pub clusters_from: ClustersFrom,
    /// Number of non-solid leafs of the world.
    pub leafs: u32,
    /// Number of openings thinner than 0.001 unit, which are left out: the precision of the file is too low to decide
    /// whether they exist.
    pub slivers: usize,
}

/// Source of the grouping of leafs into clusters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClustersFrom {
    /// From the map: Quake 3 leafs store their cluster.
    Map,
    /// By PVS rows, which the leafs of a cluster share.
    Rows,
    /// Not grouped: each leaf is a cluster. Finer than the compiler's clusters, but equally correct.
    Leafs,
}

/// Minimum width of an opening, in units. The planes of a file are 32-bit floats, which are off by up to 0.0007 units
/// at 4,096 units from the origin, so leafs that meet only along an edge may seem to overlap by that much.
const NO_HOLE: f64 = 0.001;

/// Rebuilds the portals of a compiled map: BSP29, BSP2 or IBSP46.
///
/// # Errors
/// Returns an [`ImportError`] that names the file and the rule, deterministically.
pub fn rebuild_portals(path: &Path, options: &ReadOptions) -> Result<RebuiltPortals, ImportError> {
    read_file(path, options, |bytes, _, budget| rebuild(bytes, budget))
}

/// Rebuilds the portals of a compiled map in memory.
///
/// # Errors
/// The same as [`rebuild_portals`].
pub fn rebuild_portals_bytes(map: &[u8], options: &ReadOptions) -> Result<RebuiltPortals, ImportError> {
    let rebuilt = rebuild(map, Budget::new(options.limit_bytes));
    rebuilt.map_err(|rule| ImportError {
        file: "the bytes given".to_owned(),
        rule,
    })
}

fn rebuild(map: &[u8], mut budget: Budget) -> Result<RebuiltPortals, BrokenRule> {
    // A copy of the bytes, the tree, and the cluster of each of its subtrees.
    budget.take(map.len() as u64 * 6, || "its tree".to_owned())?;
    let map = Map::read(map)?;
    let tree = Tree::read(&map)?;
    let clusters = Clusters::of(&map, &tree)?;
    let portals = Portals::find_all(&map, &tree, &clusters, budget)?;
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

/// Returns the minimum and maximum corner of the world.
///
/// Quake maps are closed, so any large enough box works. Quake 3 maps may be open to the void; there, the bounds of the
/// first node end the world, at least eight units beyond the drawn geometry.
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

/// A traversal of the tree that collects the portals.
#[derive(Debug)]
struct Portals<'a> {
    tree: &'a Tree,
    clusters: &'a Clusters,
    /// For each plane, its front side.
    sides: Vec<Side>,
    found: Vec<Portal>,
    slivers: usize,
    budget: Budget,
}

impl<'m> Portals<'m> {
    /// Finds the portals of a map.
    fn find_all(
        map: &Map,
        tree: &'m Tree,
        clusters: &'m Clusters,
        budget: Budget,
    ) -> Result<Portals<'m>, BrokenRule> {
        let mut portals = Portals {
            tree,
            clusters,
            sides: tree.planes.iter().map(Side::before).collect(),
            found: Vec::new(),
            slivers: 0,
            budget,
        };
        portals.find(Region::of_box(world(map)))?;
        Ok(portals)
    }

    /// Traverses the tree from its root and adds the portals at each node.
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
                self.add_portals(&side, node.children, &across)?;
            }
            for (child, side) in node.children.into_iter().zip([side, side.behind()]) {
                if self.clusters.part(child) != SubtreeCluster::Mixed {
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

    /// Adds the portals among the pieces of a node's polygon.
    fn add_portals(
        &mut self,
        side: &Side,
        children: [Child; 2],
        across: &[Corner],
    ) -> Result<(), BrokenRule> {
        for (front, piece) in self.push_down(children[0], across) {
            for (back, mut corners) in self.push_down(children[1], &piece) {
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

    /// Pushes a polygon down a subtree; returns the clusters that it ends up in, each with its piece.
    fn push_down(&self, child: Child, polygon: &[Corner]) -> Vec<(u32, Vec<Corner>)> {
        let mut pieces = Vec::new();
        let mut waiting = vec![(child, polygon.to_vec())];
        while let Some((child, polygon)) = waiting.pop() {
            match (self.clusters.part(child), child) {
                (SubtreeCluster::Cluster(cluster), _) => pieces.push((cluster, polygon)),
                (SubtreeCluster::Mixed, Child::Node(node)) => {
                    let node = self.tree.nodes[node as usize];
                    let side = self.sides[node.plane as usize];
                    for (child, side) in node.children.into_iter().zip([side, side.behind()]) {
                        if self.clusters.part(child) == SubtreeCluster::Solid {
                            continue;
                        }
                        let piece = side.cut(polygon.clone());
                        if !piece.is_empty() {
                            waiting.push((child, piece));
                        }
                    }
                }
                (SubtreeCluster::Solid | SubtreeCluster::Mixed, _) => {}
            }
        }
        pieces
    }
}
