//! Counters of the work done by a look.

/// Counters of the last look or draw. They do not depend on time, so they are reproducible.
#[doc(alias = "counters")]
#[doc(alias = "statistics")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Stats {
    /// AABBs (tree nodes, items, clusters) tested against the clip region and the cover.
    pub boxes_tested: u64,
    /// Tested AABBs that the cover hid.
    pub boxes_hidden: u64,
    /// Batches of faces that covers rasterized.
    pub batches: u64,
    /// Triangles set up, without those that cover no sample or face away. The masked depth buffer counts all triangles
    /// that it received.
    pub triangles: u64,
    /// Triangles hidden as a whole, before any of their samples was visited.
    pub triangles_hidden: u64,
    /// Samples covered by the other triangles, summed over triangles. The masked depth buffer counts those of selected
    /// occluders, and of triangles that its kernels leave to f64.
    pub samples: u64,
    /// Clusters tested first because they were visible in the last look.
    pub clusters_primed: u64,
    /// Occluders rasterized into covers.
    pub occluders: u64,
    /// Span comparisons of s-buffers.
    pub spans: SpanStats,
    /// Samples owned by a face; each is shaded once.
    pub samples_owned: u64,
    /// Items that the traversal reached and that were ignored for their distance or size
    /// ([`ItemOptions::max_distance`](crate::ItemOptions::max_distance),
    /// [`ItemOptions::min_size_px`](crate::ItemOptions::min_size_px)): they may be visible.
    pub items_ignored: u64,
}

/// Span comparisons of s-buffers, by how the nearer face was determined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct SpanStats {
    /// Spans that a face was compared with.
    pub compared: u64,
    /// Comparisons resolved by the cached result of an earlier row.
    pub by_cache: u64,
    /// Comparisons resolved by the result of the span to the left.
    pub by_neighbour: u64,
    /// Comparisons resolved by the result of a face that shares an edge.
    pub by_adjacency: u64,
    /// Comparisons resolved by the depth ranges of the two faces.
    pub by_range: u64,
    /// Comparisons resolved by the side of one face's plane that the other is on.
    pub by_plane: u64,
    /// Comparisons resolved by computing the reversed depth, because the faces may intersect.
    pub by_depth: u64,
}

impl Stats {
    /// Adds the counters of another part of the same look.
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
            items_ignored,
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
        self.items_ignored += items_ignored;
    }

    /// Returns every counter with its name, in a fixed order.
    pub fn each(&self) -> [(&'static str, u64); 17] {
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
            ("items_ignored", self.items_ignored),
        ]
    }
}
