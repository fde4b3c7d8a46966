//! Meshes of marked nodes that are one or more nodes below them.
//!
//! A portal, mirror or terrain without a mesh has the meshes of all nodes below it, except those of other marked nodes and
//! of what is below these. Packers put the mesh of a named node into an unnamed child, since quantized positions need a
//! transform; authors mark an empty above several meshes.
//! Cost: O(nodes): the nearest marked node above a node decides.

use super::document::Document;
use super::hints::Hint;
use std::collections::BTreeMap;

/// The nodes with meshes that belong to marked nodes above them.
pub(super) struct Below {
    /// By marked node without a mesh, in node order.
    meshes: BTreeMap<u32, Vec<u32>>,
    /// By node with a mesh.
    marked: BTreeMap<u32, u32>,
}

impl Below {
    pub(super) fn new(document: &Document, hints: &BTreeMap<u32, Hint>) -> Below {
        let mut below = Below {
            meshes: BTreeMap::new(),
            marked: BTreeMap::new(),
        };
        for (&marked, hint) in hints {
            let has_mesh = document.nodes[marked as usize].mesh.is_some();
            if has_mesh || !matches!(hint, Hint::Opening { .. } | Hint::Hole | Hint::Terrain) {
                continue;
            }
            let mut meshes = Vec::new();
            visit(document, marked, |node| {
                if hints.contains_key(&node) {
                    return false;
                }
                if document.nodes[node as usize].mesh.is_some() {
                    meshes.push(node);
                }
                true
            });
            meshes.sort_unstable();
            below.marked.extend(meshes.iter().map(|&node| (node, marked)));
            below.meshes.insert(marked, meshes);
        }
        below
    }

    /// Returns the nodes whose meshes a marked node has: itself, or those below it.
    pub(super) fn holders<'b>(&'b self, marked: &'b u32) -> &'b [u32] {
        match self.meshes.get(marked) {
            Some(meshes) => meshes,
            None => std::slice::from_ref(marked),
        }
    }

    /// Returns `true` if the node is marked, has no mesh, and has meshes below it.
    pub(super) fn lends_to(&self, marked: u32) -> bool {
        self.meshes.get(&marked).is_some_and(|meshes| !meshes.is_empty())
    }

    /// Returns the marked node that has the mesh of a node: one above it, or itself.
    pub(super) fn marked(&self, node: u32) -> u32 {
        self.marked.get(&node).copied().unwrap_or(node)
    }

    /// Returns the meshes that belong to a marked node, in words.
    pub(super) fn found(&self, document: &Document, hints: &BTreeMap<u32, Hint>, marked: u32) -> String {
        if let Some(meshes) = self.meshes.get(&marked).filter(|meshes| !meshes.is_empty()) {
            return format!("the meshes of {} have no triangles", named(document, meshes));
        }
        if document.nodes[marked as usize].mesh.is_some() {
            return "its mesh has no triangles".to_owned();
        }
        let (mut count, mut others) = (0_u64, Vec::new());
        visit(document, marked, |node| {
            count += 1;
            if !hints.contains_key(&node) {
                return true;
            }
            others.push(node);
            false
        });
        match (count, &*others) {
            (0, _) => "it has no mesh and no node below it".to_owned(),
            (_, []) => format!("neither it nor any of the {count} nodes below it has a mesh"),
            (_, others) => format!(
                "it has no mesh, and below it only {} with marks of their own",
                named(document, others)
            ),
        }
    }
}

/// Returns the first few of some nodes, in words.
pub(super) fn named(document: &Document, nodes: &[u32]) -> String {
    const FEW: usize = 4;
    let mut names: Vec<String> = nodes
        .iter()
        .take(FEW)
        .map(|&node| document.node_name(node))
        .collect();
    if nodes.len() > FEW {
        names.push(format!("{} more", nodes.len() - FEW));
    }
    match names.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => names.concat(),
    }
}

/// Visits the nodes below one, and those below each for which `enters` returns `true`.
fn visit(document: &Document, above: u32, mut enters: impl FnMut(u32) -> bool) {
    let mut waiting: Vec<u32> = document.nodes[above as usize].children.to_vec();
    waiting.reverse();
    while let Some(node) = waiting.pop() {
        if enters(node) {
            waiting.extend(document.nodes[node as usize].children.iter().rev());
        }
    }
}
