//! Links from a BSP node to its subtrees.

/// Link to nothing, a node, or a run of pieces, packed into one word: the entry of the traversal stack.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BspLink(u32);

/// Decoded [`BspLink`].
pub(super) enum LinkTarget {
    Nothing,
    Node(u32),
    /// First piece of a run.
    Pieces(u32),
}

impl BspLink {
    pub(super) const NOTHING: BspLink = BspLink(0);

    /// Packs a node number; numbers of nodes and pieces must be below 2³⁰.
    pub(super) fn node(number: u32) -> BspLink {
        BspLink(number << 2 | 1)
    }

    pub(super) fn pieces(first: u32) -> BspLink {
        BspLink(first << 2 | 2)
    }

    #[inline(always)]
    pub(super) fn target(self) -> LinkTarget {
        match self.0 & 3 {
            1 => LinkTarget::Node(self.0 >> 2),
            2 => LinkTarget::Pieces(self.0 >> 2),
            _ => LinkTarget::Nothing,
        }
    }
}
