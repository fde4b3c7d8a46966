//! What hangs below a node.

/// Nothing, a node, or a run of pieces: one word on the stack of a walk.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BspLink(u32);

/// What a link leads to.
pub(super) enum Below {
    Nothing,
    Node(u32),
    /// The first of a run.
    Pieces(u32),
}

impl BspLink {
    pub(super) const NOTHING: BspLink = BspLink(0);

    /// Numbers of nodes and pieces stay below 2³⁰.
    pub(super) fn node(number: u32) -> BspLink {
        BspLink(number << 2 | 1)
    }

    pub(super) fn pieces(first: u32) -> BspLink {
        BspLink(first << 2 | 2)
    }

    #[inline(always)]
    pub(super) fn below(self) -> Below {
        match self.0 & 3 {
            1 => Below::Node(self.0 >> 2),
            2 => Below::Pieces(self.0 >> 2),
            _ => Below::Nothing,
        }
    }
}
