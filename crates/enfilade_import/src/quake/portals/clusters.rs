//! Groups the leafs of a map into clusters, the cells between which the PVS is computed.
//!
//! Quake 3 stores the cluster of each leaf. Quake does not, but leafs of a cluster share a PVS row. A group found this
//! way must be a complete subtree, apart from solid leafs, because only then is it convex; leafs elsewhere with an
//! equal row form another cluster. Without PVS rows, each leaf is a cluster.
//! Cost: O(nodes + leafs).

use super::ClustersFrom;
use crate::quake::BspError;
use crate::quake::bsp::{Child, Map, Tree, in_range};
use std::collections::HashMap;

/// Cluster of a subtree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SubtreeCluster {
    Solid,
    /// All non-solid leafs belong to this cluster.
    Cluster(u32),
    /// Several clusters: visit the children.
    Mixed,
}

/// The clusters of a tree.
#[derive(Debug)]
pub(super) struct Clusters {
    nodes: Vec<SubtreeCluster>,
    leafs: Vec<SubtreeCluster>,
    /// For each cluster, whether it contains open leafs, and whether it contains sky.
    fills: Vec<Fill>,
    /// Quake: the cluster of each leaf except the first.
    pub(super) of_leaf: Vec<u32>,
    pub(super) from: ClustersFrom,
    in_sight: u32,
}

#[derive(Clone, Copy, Debug, Default)]
struct Fill {
    open: bool,
    sky: bool,
}

const SOLID: i32 = -2;
const SKY: i32 = -6;

/// The clusters of the leafs below a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SubtreeClusters {
    Nothing,
    /// A single cluster: a PVS row, a separate leaf, or a cluster of Quake 3.
    One(ClusterKey),
    Several,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ClusterKey {
    Shared(i32),
    Alone(u32),
}

impl Clusters {
    /// Groups the leafs of a map.
    pub(super) fn of(map: &Map, tree: &Tree) -> Result<Clusters, BspError> {
        let is_quake3 = map.format.is_quake3;
        let world_leafs = if is_quake3 {
            0
        } else {
            in_range("model", 0, "leaf", map.world_leafs()?.into(), tree.leafs.len())?
        };
        let has_rows = !is_quake3
            && !map.lump(map.format.visibility).is_empty()
            && tree.leafs.iter().any(|leaf| leaf.row >= 0 && leaf.kind != SOLID);
        let name = |leaf: u32| {
            let of = tree.leafs[leaf as usize];
            match is_quake3 {
                true if of.kind < 0 => SubtreeClusters::Nothing,
                true => SubtreeClusters::One(ClusterKey::Shared(of.kind)),
                // A compiler may count leafs among the visible ones that have solid contents, such as those of fences.
                false if leaf == 0 || of.kind == SOLID && leaf > world_leafs => SubtreeClusters::Nothing,
                false if has_rows && of.row >= 0 => SubtreeClusters::One(ClusterKey::Shared(of.row)),
                false => SubtreeClusters::One(ClusterKey::Alone(leaf)),
            }
        };
        let (order, met) = walk(tree, |leaf| name(leaf) != SubtreeClusters::Nothing)?;
        let mut found = vec![SubtreeClusters::Nothing; tree.nodes.len()];
        let of_child = |found: &[SubtreeClusters], child| match child {
            Child::Node(node) => found[node as usize],
            Child::Leaf(leaf) => name(leaf),
        };
        for &node in order.iter().rev() {
            let [a, b] = tree.nodes[node as usize]
                .children
                .map(|child| of_child(&found, child));
            found[node as usize] = match (a, b) {
                (SubtreeClusters::Nothing, other) | (other, SubtreeClusters::Nothing) => other,
                (a, b) if a == b => a,
                _ => SubtreeClusters::Several,
            };
        }
        let mut clusters = Clusters {
            nodes: vec![SubtreeCluster::Solid; tree.nodes.len()],
            leafs: vec![SubtreeCluster::Solid; tree.leafs.len()],
            fills: Vec::new(),
            of_leaf: Vec::new(),
            from: ClustersFrom::Leafs,
            in_sight: 0,
        };
        let mut roots = Vec::new();
        let mut waiting = vec![tree.root];
        while let Some(child) = waiting.pop() {
            match (of_child(&found, child), child) {
                (SubtreeClusters::Nothing, _) => {}
                (SubtreeClusters::Several, Child::Node(node)) => {
                    clusters.nodes[node as usize] = SubtreeCluster::Mixed;
                    waiting.extend(tree.nodes[node as usize].children);
                }
                (SubtreeClusters::One(_), Child::Node(node)) => {
                    let children = tree.nodes[node as usize].children;
                    // If one child is solid, it is not part of the cluster: only the other child is.
                    let some = children.map(|child| of_child(&found, child) != SubtreeClusters::Nothing);
                    if some == [true, true] {
                        roots.push(child);
                    } else {
                        clusters.nodes[node as usize] = SubtreeCluster::Mixed;
                        waiting.extend(children);
                    }
                }
                (_, Child::Leaf(_)) => roots.push(child),
            }
        }
        let mut parts: Vec<(u32, Child, Vec<u32>)> = roots
            .into_iter()
            .map(|root| {
                let leafs = leafs_below(tree, root, |leaf| name(leaf) != SubtreeClusters::Nothing);
                (leafs.iter().copied().min().unwrap_or(0), root, leafs)
            })
            .collect();
        clusters.in_sight = parts.iter().map(|(.., leafs)| leafs.len() as u32).sum();
        parts.sort_unstable_by_key(|&(first, ..)| first);
        if is_quake3 {
            clusters.from = ClustersFrom::Map;
            clusters.number_from_map(tree, &parts)?;
        } else {
            if has_rows {
                clusters.from = ClustersFrom::Rows;
            }
            clusters.number_by_leafs(tree, &parts, &met, world_leafs)?;
        }
        Ok(clusters)
    }

    /// Quake 3: uses the cluster numbers of the leafs.
    fn number_from_map(&mut self, tree: &Tree, parts: &[(u32, Child, Vec<u32>)]) -> Result<(), BspError> {
        let kinds = tree.leafs.iter().map(|leaf| leaf.kind).enumerate();
        let (at, most) = kinds.max_by_key(|&(_, kind)| kind).unwrap_or((0, -1));
        // Compilers number clusters without gaps, so there cannot be more clusters than leafs.
        if most >= 0 {
            in_range("leaf", at, "cluster", most.into(), tree.leafs.len())?;
        }
        self.fills = vec![
            Fill {
                open: true,
                sky: false
            };
            (most.max(-1) + 1) as usize
        ];
        for (leaf, part) in tree.leafs.iter().zip(&mut self.leafs) {
            if leaf.kind >= 0 {
                *part = SubtreeCluster::Cluster(leaf.kind as u32);
            }
        }
        for (first, root, _) in parts {
            if let Child::Node(node) = root {
                self.nodes[*node as usize] = self.leafs[*first as usize];
            }
        }
        Ok(())
    }

    /// Quake: numbers clusters by their first leafs. World leafs that no node references become clusters too, because
    /// the PVS rows of a map include them.
    fn number_by_leafs(
        &mut self,
        tree: &Tree,
        parts: &[(u32, Child, Vec<u32>)],
        met: &[bool],
        world_leafs: u32,
    ) -> Result<(), BspError> {
        let mut root_of = HashMap::new();
        for (_, root, leafs) in parts {
            for &leaf in leafs {
                in_range("model", 0, "leaf", leaf.into(), world_leafs as usize + 1)?;
                root_of.insert(leaf, *root);
            }
        }
        let mut number_of = HashMap::new();
        for leaf in 1..=world_leafs {
            let fresh = self.fills.len() as u32;
            let root = root_of.get(&leaf).filter(|_| met[leaf as usize]);
            let number = match root {
                Some(&root) => *number_of.entry(root).or_insert(fresh),
                None => fresh,
            };
            if number == fresh {
                self.fills.push(Fill::default());
            }
            self.of_leaf.push(number);
            let Some(&root) = root else { continue };
            let fill = &mut self.fills[number as usize];
            let is_sky = tree.leafs[leaf as usize].kind == SKY;
            fill.sky |= is_sky;
            fill.open |= !is_sky;
            self.leafs[leaf as usize] = SubtreeCluster::Cluster(number);
            if let Child::Node(node) = root {
                self.nodes[node as usize] = SubtreeCluster::Cluster(number);
            }
        }
        Ok(())
    }

    /// Returns the number of clusters.
    pub(super) fn count(&self) -> u32 {
        self.fills.len() as u32
    }

    /// Returns the number of world leafs that belong to a cluster.
    pub(super) fn leafs_in_sight(&self) -> u32 {
        self.in_sight
    }

    /// Returns the cluster of a subtree.
    pub(super) fn part(&self, child: Child) -> SubtreeCluster {
        match child {
            Child::Node(node) => self.nodes[node as usize],
            Child::Leaf(leaf) => self.leafs[leaf as usize],
        }
    }

    /// Returns `true` if adjacent clusters can see each other. Water is treated as transparent, because a map does not
    /// say. Sky is opaque from outside: only sky is visible from sky.
    pub(super) fn see_through(&self, a: u32, b: u32) -> bool {
        let [a, b] = [a, b].map(|cluster| self.fills[cluster as usize]);
        a.open && b.open || a.sky && b.sky
    }
}

/// Returns the nodes of the world, parents first, and which leafs are reached; an error if a leaf that `is_wanted` is
/// reached twice.
fn walk(tree: &Tree, is_wanted: impl Fn(u32) -> bool) -> Result<(Vec<u32>, Vec<bool>), BspError> {
    let mut order = Vec::new();
    let mut met = vec![false; tree.leafs.len()];
    let mut waiting = vec![tree.root];
    while let Some(child) = waiting.pop() {
        match child {
            Child::Node(node) => {
                order.push(node);
                waiting.extend(tree.nodes[node as usize].children);
            }
            Child::Leaf(leaf) => {
                let again = std::mem::replace(&mut met[leaf as usize], true);
                if again && is_wanted(leaf) {
                    return Err(BspError::LeafTwice { leaf });
                }
            }
        }
    }
    Ok((order, met))
}

/// Returns the leafs below a subtree that `is_wanted` accepts.
fn leafs_below(tree: &Tree, root: Child, is_wanted: impl Fn(u32) -> bool) -> Vec<u32> {
    let mut leafs = Vec::new();
    let mut waiting = vec![root];
    while let Some(child) = waiting.pop() {
        match child {
            Child::Node(node) => waiting.extend(tree.nodes[node as usize].children),
            Child::Leaf(leaf) if is_wanted(leaf) => leafs.push(leaf),
            Child::Leaf(_) => {}
        }
    }
    leafs
}
