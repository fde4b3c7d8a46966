//! Names of items: a node's own where it is the only one, with its number where it is not.

use super::document::{Document, Node};
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

/// The names of some nodes of a file, no two of them equal.
///
/// The whole file counts, not one scene, so that a name does not depend on which scene is read.
pub(super) struct Names<'d> {
    /// How many of the nodes have a name.
    bearers: HashMap<&'d str, u32>,
    /// What stands before two numbers in a name.
    like_blocks: HashSet<&'d str>,
}

impl<'d> Names<'d> {
    /// Counts the names of the nodes that are `meant`.
    pub(super) fn of(document: &'d Document, meant: impl Fn(&Node) -> bool) -> Names<'d> {
        let mut bearers: HashMap<&'d str, u32> = HashMap::new();
        for node in document.nodes.iter().filter(|node| meant(node)) {
            *bearers.entry(&*node.name).or_default() += 1;
        }
        let like_blocks = bearers.keys().filter_map(|&name| before_two_numbers(name));
        Names {
            like_blocks: like_blocks.collect(),
            bearers,
        }
    }

    /// The name of one of those nodes: `NAME`, `NAME#number` or `node#number`.
    ///
    /// Two names that end in numbers differ there. So a made name can only be that of a node which has its name for
    /// itself; then the number is set behind it once more.
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

    /// The name that the blocks of a terrain begin with, which are called `NAME ROW COLUMN`.
    ///
    /// As above, where a node is called as if it were one of them.
    pub(super) fn terrain(&self, name: &str, number: u32) -> String {
        let mut name = name.to_owned();
        while self.like_blocks.contains(&*name) {
            name = format!("{name}#{number}");
        }
        name
    }

    /// The name of one of several things that such a node shows: `NAME[7]`.
    ///
    /// A node may be called so; then the number of the node is set behind it, as above.
    pub(super) fn instance(&self, name: &str, number: u32, instance: usize) -> String {
        let mut name = format!("{name}[{instance}]");
        while self.bearers.contains_key(&*name) {
            name = format!("{name}#{number}");
        }
        name
    }
}

fn before_two_numbers(name: &str) -> Option<&str> {
    let mut words = name.rsplitn(3, ' ');
    let is_number = |word: &str| !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_digit());
    let are_numbers = is_number(words.next()?) && is_number(words.next()?);
    words.next().filter(|_| are_numbers)
}
