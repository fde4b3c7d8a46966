//! Options of a viewer.

/// Options of a [`Viewer`](crate::Viewer).
///
/// ```
/// use enfilade::{Viewer, ViewerOptions};
/// let viewer = Viewer::with_options(ViewerOptions { parallel: false, ..ViewerOptions::default() });
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ViewerOptions {
    /// Recursion limits.
    pub limits: Limits,
    /// Whether the clusters that were visible in the last look are tested first. Default `true`.
    ///
    /// Affects speed only, never the result.
    #[doc(alias = "temporal coherence")]
    pub coherence: bool,
    /// Whether a look may use all threads of the current rayon pool (the one it is called in, else the global one).
    /// Default `true`.
    ///
    /// Has an effect with feature `rayon` and a pool of at least two threads. Affects speed and
    /// [`Viewer::stats`](crate::Viewer::stats), never the result.
    ///
    /// Turn it off in programs that look by many viewers in parallel, or must not wait for the pool. While a look waits
    /// for other threads, rayon may run unrelated work of the pool on the calling thread; hold no lock that such work
    /// takes. The threads' buffers together take about as much memory as those of one thread. Drawing uses the calling
    /// thread only.
    pub parallel: bool,
    /// Maximum number of occluders per passage, for methods that select occluders. Default `None`: a suitable number
    /// for each method ([`Method::occluders`](crate::Method::occluders)).
    ///
    /// Affects the number of hidden items in the set; no visible item is ever missed. With 0, trees cull by the clip
    /// region only, and the masked depth buffer has only the faces that it finds during traversal.
    pub occluders: Option<u32>,
    /// Columns and rows of the covers, for methods that can use fewer samples than the screen
    /// ([`Method::takes_cover_size`](crate::Method::takes_cover_size)). Default `None`: the resolution of the screen.
    ///
    /// A lower resolution is faster and reports more hidden items: such a method is conservative. Values are clamped to
    /// 1 to the screen's size.
    pub cover_size: Option<[u32; 2]>,
    /// The layers to look at, one bit each; items that are in none of them ([`ItemOptions::layers`]) are neither visible
    /// nor occluders. Default: all. Here and not in the view, because it belongs to what the viewer is for (a shadow map,
    /// a minimap), not to where its camera is. Custom sectors find it in [`Passage::options`](crate::Passage::options).
    ///
    /// [`ItemOptions::layers`]: crate::ItemOptions::layers
    #[doc(alias = "culling mask")]
    #[doc(alias = "layer mask")]
    pub layers: u32,
}

impl Default for ViewerOptions {
    fn default() -> ViewerOptions {
        ViewerOptions {
            limits: Limits::default(),
            coherence: true,
            parallel: true,
            occluders: None,
            cover_size: None,
            layers: u32::MAX,
        }
    }
}

/// Recursion limits of a look. If one is hit, items may be missing and [`VisibleSet::complete`](crate::VisibleSet::complete) returns `false`.
#[doc(alias = "recursion limit")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// Maximum number of portals in a row from the eye, 0 to 65,535. Default 64.
    #[doc(alias = "portal depth")]
    pub max_crossings: u16,
    /// Maximum number of passages of one look, at least 1. Default 65,536.
    pub max_passages: u32,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits {
            max_crossings: 64,
            max_passages: 65_536,
        }
    }
}
