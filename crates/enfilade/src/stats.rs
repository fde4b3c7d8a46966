//! What a look cost, counted.

/// What the last look or draw cost, counted. Nothing here depends on the clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Stats {
    /// Boxes (nodes, items, clusters) held against the aperture and the cover.
    pub boxes_tested: u64,
    /// Those of them that the cover hid.
    pub boxes_hidden: u64,
    /// Batches of faces that covers took.
    pub batches: u64,
    /// Triangles set up, after those that hold no sample or face away were left out.
    pub triangles: u64,
    /// Triangles hidden as a whole, before any of their samples was touched.
    pub triangles_hidden: u64,
    /// Samples that the other triangles cover, each triangle's counted.
    pub samples: u64,
    /// Items that were seen first because the last look saw them.
    pub items_primed: u64,
}

impl Stats {
    /// Every counter with its name, in a fixed order.
    pub fn each(&self) -> [(&'static str, u64); 7] {
        [
            ("boxes_tested", self.boxes_tested),
            ("boxes_hidden", self.boxes_hidden),
            ("batches", self.batches),
            ("triangles", self.triangles),
            ("triangles_hidden", self.triangles_hidden),
            ("samples", self.samples),
            ("items_primed", self.items_primed),
        ]
    }
}
