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
    /// Triangles set up, after those that hold no sample or face away were left out; of the masked cover all that it took.
    pub triangles: u64,
    /// Triangles hidden as a whole, before any of their samples was touched.
    pub triangles_hidden: u64,
    /// Samples that the other triangles cover, each triangle's counted; of the masked cover those of chosen occluders, and of
    /// triangles that its kernels leave to f64.
    pub samples: u64,
    /// Clusters that were seen first because the last look saw them.
    pub clusters_primed: u64,
    /// Occluders that covers took.
    pub occluders: u64,
    /// What s-buffers compared.
    pub spans: SpanStats,
    /// Samples reported as owned by a face; each is shaded once.
    pub samples_owned: u64,
}

/// How s-buffers found out which of two faces is before the other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct SpanStats {
    /// Spans that a face was held against.
    pub compared: u64,
    /// Those of them whose answer was known from an earlier row.
    pub by_cache: u64,
    /// Those whose answer was that of the span to the left.
    pub by_neighbour: u64,
    /// Those whose answer was that of a face which shares an edge.
    pub by_adjacency: u64,
    /// Those decided by how near the two faces come at all.
    pub by_range: u64,
    /// Those decided by the side of a plane on which a face lies.
    pub by_plane: u64,
    /// Those for which reversed depth was computed, because the faces may cross.
    pub by_depth: u64,
}

impl Stats {
    /// Adds what another part of the same look cost.
    pub(crate) fn add(&mut self, part: &Stats) {
        let Stats {
            boxes_tested,
            boxes_hidden,
            batches,
            triangles,
            triangles_hidden,
            samples,
            clusters_primed,
            occluders,
            spans,
            samples_owned,
        } = part;
        self.boxes_tested += boxes_tested;
        self.boxes_hidden += boxes_hidden;
        self.batches += batches;
        self.triangles += triangles;
        self.triangles_hidden += triangles_hidden;
        self.samples += samples;
        self.clusters_primed += clusters_primed;
        self.occluders += occluders;
        self.spans.compared += spans.compared;
        self.spans.by_cache += spans.by_cache;
        self.spans.by_neighbour += spans.by_neighbour;
        self.spans.by_adjacency += spans.by_adjacency;
        self.spans.by_range += spans.by_range;
        self.spans.by_plane += spans.by_plane;
        self.spans.by_depth += spans.by_depth;
        self.samples_owned += samples_owned;
    }

    /// Every counter with its name, in a fixed order.
    pub fn each(&self) -> [(&'static str, u64); 16] {
        [
            ("boxes_tested", self.boxes_tested),
            ("boxes_hidden", self.boxes_hidden),
            ("batches", self.batches),
            ("triangles", self.triangles),
            ("triangles_hidden", self.triangles_hidden),
            ("samples", self.samples),
            ("clusters_primed", self.clusters_primed),
            ("occluders", self.occluders),
            ("spans_compared", self.spans.compared),
            ("spans_by_cache", self.spans.by_cache),
            ("spans_by_neighbour", self.spans.by_neighbour),
            ("spans_by_adjacency", self.spans.by_adjacency),
            ("spans_by_range", self.spans.by_range),
            ("spans_by_plane", self.spans.by_plane),
            ("spans_by_depth", self.spans.by_depth),
            ("samples_owned", self.samples_owned),
        ]
    }
}
