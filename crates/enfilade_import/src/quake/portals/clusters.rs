//! Which leafs of a map are one cluster: the cells that sight is computed between.
//!
//! Quake 3 says it in each leaf. Quake says it nowhere but in what was made of it: leafs of a cluster share a row of what is
//! visible. A cluster that is found so must be all of a part of the tree, but for what is solid there, for only then is it
//! convex; leafs elsewhere that have an equal row are another. Without rows, each leaf is a cluster.
//! Cost: O(nodes + leafs).

use super::ClustersFrom;
use crate::quake::BspError;
use crate::quake::bsp::{Child, Map, Tree, in_range};
use std::collections::HashMap;

/// What a part of the tree is to sight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Solid,
    /// All of one cluster.
    Cluster(u32),
    /// To be looked into.
    Mixed,
}

/// Which parts of a tree are which clusters.
#[derive(Debug)]
pub(super) struct Clusters {
    nodes: Vec<Part>,
    leafs: Vec<Part>,
    /// Of each cluster whether sight goes through it, and whether through its sky.
    fills: Vec<Fill>,
    /// Of Quake, the cluster of each leaf but the first.
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

/// What the leafs below a node say of the cluster that they are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Says {
    Nothing,
    /// A row, a leaf of its own, or a cluster of Quake 3.
    One(Name),
    Several,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Name {
    Shared(i32),
    Alone(u32),
}

impl Clusters {
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
                true if of.kind < 0 => Says::Nothing,
                true => Says::One(Name::Shared(of.kind)),
                // What a compiler numbers among the leafs that see may look solid and be a fence.
                false if leaf == 0 || of.kind == SOLID && leaf > world_leafs => Says::Nothing,
                false if has_rows && of.row >= 0 => Says::One(Name::Shared(of.row)),
                false => Says::One(Name::Alone(leaf)),
            }
        };
        let (order, met) = walk(tree, |leaf| name(leaf) != Says::Nothing)?;
        let mut says = vec![Says::Nothing; tree.nodes.len()];
        let of_child = |says: &[Says], child| match child {
            Child::Node(node) => says[node as usize],
            Child::Leaf(leaf) => name(leaf),
        };
        for &node in order.iter().rev() {
            let [a, b] = tree.nodes[node as usize]
                .children
                .map(|child| of_child(&says, child));
            says[node as usize] = match (a, b) {
                (Says::Nothing, other) | (other, Says::Nothing) => other,
                (a, b) if a == b => a,
                _ => Says::Several,
            };
        }
        let mut clusters = Clusters {
            nodes: vec![Part::Solid; tree.nodes.len()],
            leafs: vec![Part::Solid; tree.leafs.len()],
            fills: Vec::new(),
            of_leaf: Vec::new(),
            from: ClustersFrom::Leafs,
            in_sight: 0,
        };
        let mut roots = Vec::new();
        let mut waiting = vec![tree.root];
        while let Some(child) = waiting.pop() {
            match (of_child(&says, child), child) {
                (Says::Nothing, _) => {}
                (Says::Several, Child::Node(node)) => {
                    clusters.nodes[node as usize] = Part::Mixed;
                    waiting.extend(tree.nodes[node as usize].children);
                }
                (Says::One(_), Child::Node(node)) => {
                    let children = tree.nodes[node as usize].children;
                    // What is solid above the cluster's parts is none of it.
                    let some = children.map(|child| of_child(&says, child) != Says::Nothing);
                    if some == [true, true] {
                        roots.push(child);
                    } else {
                        clusters.nodes[node as usize] = Part::Mixed;
                        waiting.extend(children);
                    }
                }
                (_, Child::Leaf(_)) => roots.push(child),
            }
        }
        let mut parts: Vec<(u32, Child, Vec<u32>)> = roots
            .into_iter()
            .map(|root| {
                let leafs = leafs_below(tree, root, |leaf| name(leaf) != Says::Nothing);
                (leafs.iter().copied().min().unwrap_or(0), root, leafs)
            })
            .collect();
        clusters.in_sight = parts.iter().map(|(.., leafs)| leafs.len() as u32).sum();
        parts.sort_unstable_by_key(|&(first, ..)| first);
        if is_quake3 {
            clusters.from = ClustersFrom::Map;
            clusters.number_as_said(tree, &parts)?;
        } else {
            if has_rows {
                clusters.from = ClustersFrom::Rows;
            }
            clusters.number_by_leafs(tree, &parts, &met, world_leafs)?;
        }
        Ok(clusters)
    }

    /// Quake 3: leafs name clusters by their numbers.
    fn number_as_said(&mut self, tree: &Tree, parts: &[(u32, Child, Vec<u32>)]) -> Result<(), BspError> {
        let kinds = tree.leafs.iter().map(|leaf| leaf.kind).enumerate();
        let (at, most) = kinds.max_by_key(|&(_, kind)| kind).unwrap_or((0, -1));
        // Compilers number clusters without gaps.
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
                *part = Part::Cluster(leaf.kind as u32);
            }
        }
        for (first, root, _) in parts {
            if let Child::Node(node) = root {
                self.nodes[*node as usize] = self.leafs[*first as usize];
            }
        }
        Ok(())
    }

    /// Quake: clusters are numbered as their first leafs are. Leafs of the world that stand nowhere are clusters too, for
    /// the rows of a map are for all of them.
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
            self.leafs[leaf as usize] = Part::Cluster(number);
            if let Child::Node(node) = root {
                self.nodes[node as usize] = Part::Cluster(number);
            }
        }
        Ok(())
    }

    /// How many there are.
    pub(super) fn count(&self) -> u32 {
        self.fills.len() as u32
    }

    /// How many leafs of the world are in one.
    pub(super) fn leafs_in_sight(&self) -> u32 {
        self.in_sight
    }

    /// What a part of the tree is.
    pub(super) fn part(&self, child: Child) -> Part {
        match child {
            Child::Node(node) => self.nodes[node as usize],
            Child::Leaf(leaf) => self.leafs[leaf as usize],
        }
    }

    /// Whether one sees from one cluster into another where they touch. Into water and out of it one does, as far as
    /// anyone can tell from the map; sky is painted where it begins, and only sky is behind it.
    pub(super) fn see_through(&self, a: u32, b: u32) -> bool {
        let [a, b] = [a, b].map(|cluster| self.fills[cluster as usize]);
        a.open && b.open || a.sky && b.sky
    }
}

/// The nodes of the world, each before those below it, and which leafs are met; one that is wanted is met once.
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
