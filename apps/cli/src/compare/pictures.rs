//! The pictures of a view: what is really seen, and what each method makes of it.

use super::contested::Neighbours;
use super::difference::{dimmed, marked};
use super::embed::{data_uri, shrunk, step};
use crate::draw::{draw, settings};
use crate::prepare::{Prepared, drawn_by};
use anyhow::Result;
use enfilade::laws::{OwnerPicture, Truth};
use enfilade::{Method, View, Viewer};
use enfilade_draw::{RgbImage, Show};

/// The pictures of a view, as data URIs.
pub(super) struct ViewPictures {
    pub(super) image: String,
    pub(super) items: String,
    /// Columns and rows of each picture.
    pub(super) size: [u32; 2],
    /// Samples of the reference's own picture that the reference does not allow.
    pub(super) wrong: u64,
    /// Contested samples that are marked, each once.
    pub(super) marked: usize,
    pub(super) methods: Vec<MethodPictures>,
}

/// What one method makes of a view, as data URIs.
pub(super) struct MethodPictures {
    pub(super) image: String,
    pub(super) difference: String,
    pub(super) overdraw: String,
}

/// Draws views, one after the other, by all methods.
pub(super) struct Artist<'a> {
    prepared: &'a [Prepared],
    /// Draws what the reference is shown as: it has owners but no surfaces.
    baseline: Prepared,
    /// Of their own, for what they remember must be the view before, as it was when times were taken.
    overdraw: Vec<Viewer>,
}

/// One view at work.
pub(super) struct Sitting<'a, 'b> {
    artist: &'b mut Artist<'a>,
    view: &'b View,
    truth: &'b Truth,
    step: u32,
    dimmed: RgbImage,
    contested: Vec<[u32; 2]>,
    pictures: ViewPictures,
}

impl<'a> Artist<'a> {
    /// Of methods that have been prepared, at least one, for views of which there is at least one.
    pub(super) fn new(prepared: &'a [Prepared], views: &[View]) -> Result<Artist<'a>> {
        let mut overdraw: Vec<Viewer> = prepared.iter().map(Prepared::viewer).collect();
        for (viewer, prepared) in overdraw.iter_mut().zip(prepared) {
            // The view before the first is the last, as in the passes that are timed.
            if let Some(last) = views.last() {
                viewer.look(&prepared.scene, last);
            }
        }
        Ok(Artist {
            baseline: drawn_by(&prepared[0], Method::ZBuffer)?,
            prepared,
            overdraw,
        })
    }

    /// Draws the reference's pictures of a view, and makes ready for those of the methods.
    pub(super) fn sit<'b>(&'b mut self, view: &'b View, truth: &'b Truth) -> Result<Sitting<'a, 'b>> {
        let baseline = &self.baseline;
        let mut viewer = baseline.viewer();
        let mut neighbours = Neighbours::new(view.size);
        viewer.draw(&baseline.scene, view, &mut neighbours);
        let step = step(view.size);
        let image = shrunk(&picture(baseline, &mut viewer, view, Show::Image), step);
        let items = shrunk(&picture(baseline, &mut viewer, view, Show::Items), step);
        let contested = neighbours.contested(truth);
        Ok(Sitting {
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
            artist: self,
        })
    }
}

/// A view as a method draws it.
fn picture(prepared: &Prepared, viewer: &mut Viewer, view: &View, show: Show) -> RgbImage {
    draw(prepared, viewer, view, &settings(show)).image
}

impl Sitting<'_, '_> {
    /// Draws what the method of this number makes of the view; `owners` is what it painted when it was checked.
    pub(super) fn draw(&mut self, method: usize, viewer: &mut Viewer, owners: &OwnerPicture) -> Result<()> {
        let prepared = &self.artist.prepared[method];
        let image = picture(prepared, viewer, self.view, Show::Image);
        let overdraw = picture(
            prepared,
            &mut self.artist.overdraw[method],
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

    /// All pictures of the view.
    pub(super) fn into_pictures(self) -> ViewPictures {
        self.pictures
    }
}
