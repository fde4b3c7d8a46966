//! Unique item names: the node's name if no other node has it, otherwise with the node's index.

use super::document::{Document, Node};
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

/// Unique names of some nodes of a file.
///
/// Counts the nodes of the whole file, so that a name does not depend on the scene that is read.
pub(super) struct Names<'d> {
    /// Number of nodes with each name.
    bearers: HashMap<&'d str, u32>,
    /// Names without their last two numbers, such as `NAME` of `NAME 3 7`.
    like_blocks: HashSet<&'d str>,
}

impl<'d> Names<'d> {
    /// Counts the names of the nodes that `meant` accepts.
    pub(super) fn of(document: &'d Document, meant: impl Fn(u32, &Node) -> bool) -> Names<'d> {
        let mut bearers: HashMap<&'d str, u32> = HashMap::new();
        let nodes = (0..).zip(&document.nodes);
        for (_, node) in nodes.filter(|&(number, node)| meant(number, node)) {
            *bearers.entry(&*node.name).or_default() += 1;
        }
        let like_blocks = bearers.keys().filter_map(|&name| before_two_numbers(name));
        Names {
            like_blocks: like_blocks.collect(),
            bearers,
        }
    }

    /// Returns the name of one of those nodes: `NAME`, `NAME#index` or `node#index`.
    ///
    /// Generated names differ by their index. So a generated name can only collide with the unique name of another
    /// node; then the index is appended again.
    pub(super) fn name(&self, number: u32, node: &'d Node) -> Cow<'d, str> {
        let is_taken = |name: &str| !name.is_empty() && self.bearers.get(name) == Some(&1);
        if is_taken(&node.name) {
            return Cow::Borrowed(&node.name);
        }
        let own = if node.name.is_empty() { "node" } else { &*node.name };
        let mut name = format!("{own}#{number}");
        while is_taken(&name) {
            name = format!("{name}#{number}");
        }
        Cow::Owned(name)
    }

    /// Returns the prefix of a terrain's block names, which are `NAME ROW COLUMN`.
    ///
    /// Appends the index, as above, if a node is named like one of the blocks.
    pub(super) fn terrain(&self, name: &str, number: u32) -> String {
        let mut name = name.to_owned();
        while self.like_blocks.contains(&*name) {
            name = format!("{name}#{number}");
        }
        name
    }

    /// Returns the name of an instance: `NAME[7]`.
    ///
    /// Appends the node's index, as above, if a node has that name.
    pub(super) fn instance(&self, name: &str, number: u32, instance: usize) -> String {
        let mut name = format!("{name}[{instance}]");
        while self.bearers.contains_key(&*name) {
            name = format!("{name}#{number}");
        }
        name
    }
}

/// Returns a name without its last two words, if both are numbers.
fn before_two_numbers(name: &str) -> Option<&str> {
    let mut words = name.rsplitn(3, ' ');
    let is_number = |word: &str| !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_digit());
    let are_numbers = is_number(words.next()?) && is_number(words.next()?);
    words.next().filter(|_| are_numbers)
}
