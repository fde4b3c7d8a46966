//! Names of items: a node's own where it is the only one, with its number where it is not.

use super::document::{Document, Node};
use std::collections::{HashMap, HashSet};

/// The names of all nodes of the file that are `meant`, by their numbers; no two are equal.
///
/// The whole file counts, not one scene, so that a name does not depend on which scene is read.
pub(super) fn unique(document: &Document, meant: impl Fn(&Node) -> bool) -> HashMap<u32, String> {
    let nodes = || (0_u32..).zip(&document.nodes).filter(|(_, node)| meant(node));
    let mut bearers: HashMap<&str, u32> = HashMap::new();
    for (_, node) in nodes() {
        *bearers.entry(&node.name).or_default() += 1;
    }
    let stands_alone = |node: &Node| !node.name.is_empty() && bearers[&*node.name] == 1;
    let mut given: HashSet<String> = HashSet::new();
    given.extend(nodes().filter(|(_, node)| stands_alone(node)).map(|(_, node)| node.name.to_string()));
    let mut names = HashMap::new();
    for (number, node) in nodes() {
        let mut name = node.name.to_string();
        if !stands_alone(node) {
            if name.is_empty() {
                name.push_str("node");
            }
            name = format!("{name}#{number}");
            // Another node may already be called so; its own name goes before a made one.
            while !given.insert(name.clone()) {
                name = format!("{name}#{number}");
            }
        }
        names.insert(number, name);
    }
    names
}
