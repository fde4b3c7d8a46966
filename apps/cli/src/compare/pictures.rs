//! Renders the pictures of a view: the reference, and those of each method.

use super::contested::Neighbours;
use super::difference::{dimmed, marked};
use super::embed::{data_uri, shrunk, step};
use crate::picture::{draw, settings};
use crate::prepare::{PreparedScene, drawn_by};
use anyhow::Result;
use enfilade::laws::{OwnerPicture, Truth};
use enfilade::{Method, View, Viewer};
use enfilade_draw::{RgbImage, Show};

/// The pictures of a view, as data URIs.
pub(super) struct ViewPictures {
    pub(super) image: String,
    pub(super) items: String,
    /// Width and height of each picture, in pixels.
    pub(super) size: [u32; 2],
    /// Number of samples of the baseline picture that the reference does not allow.
    pub(super) wrong: u64,
    /// Number of contested samples that are marked.
    pub(super) marked: usize,
    pub(super) methods: Vec<MethodPictures>,
}

/// The pictures of one method, as data URIs.
pub(super) struct MethodPictures {
    pub(super) image: String,
    pub(super) difference: String,
    pub(super) overdraw: String,
}

/// Renders views, one after the other, with all methods.
pub(super) struct ViewRenderer<'a> {
    prepared: &'a [PreparedScene],
    /// Renders the picture that represents the reference, which itself has owners but no shading.
    baseline: PreparedScene,
    /// Separate viewers, so that temporal coherence uses the view before, as in the timed passes.
    overdraw: Vec<Viewer>,
}

/// One view while it is being rendered.
pub(super) struct ViewRendering<'a, 'b> {
    renderer: &'b mut ViewRenderer<'a>,
    view: &'b View,
    truth: &'b Truth,
    step: u32,
    dimmed: RgbImage,
    contested: Vec<[u32; 2]>,
    pictures: ViewPictures,
}

impl<'a> ViewRenderer<'a> {
    /// Creates a renderer; `prepared` must not be empty. Looks at the last view, so that the first has a view before
    /// it.
    pub(super) fn new(prepared: &'a [PreparedScene], views: &[View]) -> Result<ViewRenderer<'a>> {
        let mut overdraw: Vec<Viewer> = prepared.iter().map(PreparedScene::viewer).collect();
        for (viewer, prepared) in overdraw.iter_mut().zip(prepared) {
            // The view before the first is the last, as in the passes that are timed.
            if let Some(last) = views.last() {
                viewer.look(&prepared.scene, last);
            }
        }
        Ok(ViewRenderer {
            baseline: drawn_by(&prepared[0], Method::ZBuffer)?,
            prepared,
            overdraw,
        })
    }

    /// Renders the pictures of the reference, and returns the state that renders those of the methods.
    pub(super) fn begin<'b>(&'b mut self, view: &'b View, truth: &'b Truth) -> Result<ViewRendering<'a, 'b>> {
        let baseline = &self.baseline;
        let mut viewer = baseline.viewer();
        let mut neighbours = Neighbours::new(view.size());
        viewer.draw(&baseline.scene, view, &mut neighbours);
        let step = step(view.size());
        let image = shrunk(&picture(baseline, &mut viewer, view, Show::Image), step);
        let items = shrunk(&picture(baseline, &mut viewer, view, Show::Items), step);
        let contested = neighbours.contested(truth);
        Ok(ViewRendering {
            view,
            truth,
            step,
            dimmed: dimmed(&image),
            pictures: ViewPictures {
                image: data_uri(&image)?,
                items: data_uri(&items)?,
                size: [image.width(), image.height()],
                wrong: truth.different(neighbours.owners()).count() as u64,
                marked: contested.len(),
                methods: Vec::new(),
            },
            contested,
            renderer: self,
        })
    }
}

/// Renders a view with a method.
fn picture(prepared: &PreparedScene, viewer: &mut Viewer, view: &View, show: Show) -> RgbImage {
    draw(prepared, viewer, view, &settings(show)).image
}

impl ViewRendering<'_, '_> {
    /// Renders the pictures of a method, by its index. `owners` are those it drew when it was checked.
    pub(super) fn draw(&mut self, method: usize, viewer: &mut Viewer, owners: &OwnerPicture) -> Result<()> {
        let prepared = &self.renderer.prepared[method];
        let image = picture(prepared, viewer, self.view, Show::Image);
        let overdraw = picture(
            prepared,
            &mut self.renderer.overdraw[method],
            self.view,
            Show::Overdraw,
        );
        let wrong = self.truth.different(owners);
        let difference = marked(&self.dimmed, self.step, &self.contested, wrong);
        self.pictures.methods.push(MethodPictures {
            image: data_uri(&shrunk(&image, self.step))?,
            difference: data_uri(&difference)?,
            overdraw: data_uri(&shrunk(&overdraw, self.step))?,
        });
        Ok(())
    }

    /// Returns all pictures of the view.
    pub(super) fn into_pictures(self) -> ViewPictures {
        self.pictures
    }
}
