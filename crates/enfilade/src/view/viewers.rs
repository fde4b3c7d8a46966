//! The viewers of many cameras: their visible sets, and the buffers of the threads that look.

use super::memory::Recall;
use super::options::ViewerOptions;
use super::viewer::Viewer;
use super::visible::VisibleSet;
use crate::stats::Stats;

/// Computes what many cameras see at once: shadow cascades, faces of cube maps, split screens, probes, the players of a
/// server.
///
/// As many threads look as the pool has, each at one view at a time; each set is the same as that of a
/// [`Viewer`](crate::Viewer) with the same options. Buffers are kept per thread, visible sets and temporal coherence per view,
/// so keep views in the same places from frame to frame.
///
/// # Servers
/// To tell players only of what they can see, look for each at a low resolution, such as 256 × 144, by a strict method
/// ([`Contract::Strict`](crate::Contract::Strict)) or with a [`ViewerOptions::margin_px`] of ½: such a set holds what is visible
/// at any position in a pixel, so it is valid for any screen of the same field of view. Ask [`VisibleSet::sees`] for single
/// items.
#[doc(alias = "multi-view")]
#[doc(alias = "cascades")]
#[doc(alias = "anti-cheat")]
#[doc(alias = "anti-wallhack")]
#[derive(Default)]
pub struct Viewers {
    /// Options of the next look. [`ViewerOptions::parallel`] lets several threads look; each single look uses one.
    pub options: ViewerOptions,
    pub(crate) sets: Vec<VisibleSet>,
    pub(crate) kept: Vec<KeptView>,
    /// One per thread that ever looked.
    pub(crate) threads: Vec<Viewer>,
}

/// What is kept of a view from one look to the next, beside its set.
#[derive(Default)]
pub(crate) struct KeptView {
    pub(crate) recall: Recall,
    pub(crate) stats: Stats,
}

impl Viewers {
    /// Creates viewers with default options and empty buffers.
    pub fn new() -> Viewers {
        Viewers::default()
    }

    /// Creates viewers with the given options and empty buffers.
    pub fn with_options(options: ViewerOptions) -> Viewers {
        Viewers {
            options,
            ..Viewers::default()
        }
    }

    /// Returns the visible sets of the last look, in the order of its views.
    pub fn visible(&self) -> &[VisibleSet] {
        &self.sets
    }

    /// Iterates over the counters of the last look, in the order of its views.
    pub fn stats(&self) -> impl Iterator<Item = &Stats> {
        self.kept.iter().map(|kept| &kept.stats)
    }
}
