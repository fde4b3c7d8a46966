//! Options of a viewer.

/// Options of a [`Viewer`](crate::Viewer).
///
/// ```
/// use enfilade::{Viewer, ViewerOptions};
/// let viewer = Viewer::with_options(ViewerOptions { parallel: false, ..ViewerOptions::default() });
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
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
    /// Whether anything hides what is behind it. Default `true`. Without, items are culled by the clip regions of their
    /// passages alone: by the frustum and by portals. Such sets are strict, hold many hidden items, and cost least: for views
    /// in which little is hidden, such as that of a sun over a city. `pvs` still culls by its baked rows.
    #[doc(alias = "frustum culling")]
    pub occlusion: bool,
    /// Maximum number of occluders per passage, for methods that select occluders. Default `None`: a suitable number
    /// for each method ([`Method::occluders`](crate::Method::occluders)).
    ///
    /// Affects the number of hidden items in the set; no visible item is ever missed. With 0, trees cull by the clip
    /// region only, and the masked depth buffer has only the faces that it finds during traversal.
    pub occluders: Option<u32>,
    /// Columns and rows of the covers, for methods that can use fewer samples than the screen
    /// ([`Method::takes_cover_size`](crate::Method::takes_cover_size)). Default `None`: the resolution of the screen.
    ///
    /// A lower resolution reports more hidden items: such a method is conservative. It is seldom faster, because faces that
    /// end in a cell are more work there than at a sample: measure it. Half the samples on each side cost several times as
    /// much as all of them, and `masked` is fastest at the resolution of the screen. Values are clamped to 1 to the
    /// screen's size.
    pub cover_size: Option<[u32; 2]>,
    /// How closely methods without a picture test what they found, once all occluders are known. Default
    /// [`Tightness::Boxes`]. Changes the number of hidden items in the set, and how long a look takes. Only
    /// [`Method::Masked`](crate::Method::Masked) without a margin and with a cover of the resolution of the screen uses it.
    pub tightness: Tightness,
    /// How far the renderer may move a vertex on the screen, in pixels along each axis. Default 0: a set is true of the
    /// samples of the exact picture.
    ///
    /// GPUs snap vertices to a grid of 1/256 pixel (some to 1/16), and compute them in `f32`. Then an item may show up at a
    /// sample that its exact outline just misses, or an occluder may miss one that it should just cover. With a margin, boxes
    /// and faces that are tested grow by it, and outlines of occluders shrink by it: nothing is missed that any such picture
    /// shows. Set it to the step of the grid, 1/256 or 1/16. Values are clamped to 0 to ½. Here and not in the view, because
    /// it belongs to the renderer, not to where the camera is.
    ///
    /// Methods that take a cover size ([`Method::takes_cover_size`](crate::Method::takes_cover_size)) are conservative with
    /// a margin, and cost about as much as with a cover of another size. All others but `pvs` then cull by the clip region
    /// alone; `pvs` is strict, so the margin changes nothing.
    #[doc(alias = "sub-pixel precision")]
    #[doc(alias = "vertex snapping")]
    #[doc(alias = "conservative rasterization")]
    pub margin_px: f32,
    /// How far the boxes that `masked` tests, and the outlines of portals, grow on the screen, in pixels on each side.
    /// Default 0. Values are clamped to 0 to 8.
    ///
    /// For renderers with other samples than pixel centres (multisampling), or that snap vertices: with 1 or more, what shows
    /// beside the outline of an occluder is found, at little cost. Unlike with [`ViewerOptions::margin_px`], occluders stay
    /// as they are, so that an item can be missed that is seen only through a gap narrower than the growth. Faces are not
    /// tested then, whatever [`ViewerOptions::tightness`] says. Other methods than `masked`, and covers of another size or
    /// with a margin, ignore it.
    #[doc(alias = "anti-aliasing")]
    #[doc(alias = "MSAA")]
    pub growth_px: f32,
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
            occlusion: true,
            occluders: None,
            cover_size: None,
            tightness: Tightness::Boxes,
            margin_px: 0.0,
            growth_px: 0.0,
            layers: u32::MAX,
        }
    }
}

impl ViewerOptions {
    /// Returns the margin within its range, in pixels.
    pub(crate) fn margin(&self) -> f64 {
        // NaN is an unknown margin: the maximum.
        if self.margin_px >= 0.0 {
            f64::from(self.margin_px.min(0.5))
        } else if self.margin_px < 0.0 {
            0.0
        } else {
            0.5
        }
    }

    /// Returns the growth of tested boxes within its range, in pixels.
    pub(crate) fn growth(&self) -> f64 {
        // NaN is an unknown growth: the maximum.
        if self.growth_px <= 8.0 {
            f64::from(self.growth_px.max(0.0))
        } else {
            8.0
        }
    }

    /// Returns columns and rows of a cover that is rasterized by cells: one of another size than the screen, or any cover
    /// that keeps a margin.
    pub(crate) fn cells(&self, screen: [u32; 2]) -> Option<[u32; 2]> {
        self.cover_size.or((self.margin() > 0.0).then_some(screen))
    }
}

/// What is tested against the finished cover: see [`ViewerOptions::tightness`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Tightness {
    /// The boxes of items and clusters.
    #[default]
    Boxes,
    /// The faces of what passes by its box, at each sample, until one may be visible. An item that covers no sample is left
    /// out, as by exact methods. Items of more than 512 faces are kept without this test.
    Faces,
    /// As [`Tightness::Faces`]. An item that passes at few samples, up to one in 14,400 of the screen's, is tested once more
    /// at these, against the exact depths of the occluders there. Leaves the fewest hidden items, and costs most.
    Resolved,
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
