//! The viewer of one camera: options, the last visible set, and the buffers kept between frames. What a look does is in
//! `look.rs`, which knows scenes.

use super::View;
use super::collector::Collector;
use super::memory::Memory;
use super::options::ViewerOptions;
use super::visible::VisibleSet;
use crate::ids::PassageId;
use crate::stats::Stats;

/// Computes what one camera sees, and keeps buffers and temporal coherence from frame to frame.
///
/// Keep one viewer per camera. Several viewers can look at the same scene at the same time, from several threads.
///
/// [`Viewer::look`] returns the visible items; [`Viewer::draw`] also emits the picture.
#[doc(alias = "culler")]
#[doc(alias = "camera")]
#[derive(Default)]
pub struct Viewer {
    /// Options of the next look.
    pub options: ViewerOptions,
    pub(crate) memory: Memory,
    pub(crate) set: VisibleSet,
    /// The set of the second pass, where drawing needs one.
    pub(crate) painted: VisibleSet,
    /// Stack of passages whose openings are being followed, each behind an opening of the one before; empty between
    /// looks.
    pub(crate) entered: Vec<(PassageId, Collector)>,
    pub(crate) spare: Vec<Collector>,
}

impl Viewer {
    /// Creates a viewer with default options and empty buffers.
    pub fn new() -> Viewer {
        Viewer::default()
    }

    /// Creates a viewer with the given options and empty buffers.
    pub fn with_options(options: ViewerOptions) -> Viewer {
        Viewer {
            options,
            ..Viewer::default()
        }
    }

    /// Returns the visible set of the last look or draw.
    pub fn visible(&self) -> &VisibleSet {
        &self.set
    }

    /// Returns the counters of the last look or draw.
    pub fn stats(&self) -> &Stats {
        &self.memory.stats
    }

    /// Returns the options, with the cover size that a view allows.
    pub(crate) fn options_for(&self, view: &View) -> ViewerOptions {
        let clamp = |size: [u32; 2]| [0, 1].map(|axis| size[axis].clamp(1, view.size()[axis]));
        let cover_size = self.options.cover_size.map(clamp);
        ViewerOptions {
            cover_size: cover_size.filter(|&cells| cells != view.size()),
            ..self.options
        }
    }
}
