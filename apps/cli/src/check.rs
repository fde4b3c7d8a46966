//! Holds every method's answers against the reference: once per view, shared by all methods.

use crate::prepare::{Prepared, in_files};
use crate::progress::Progress;
use anyhow::{Result, bail};
use enfilade::laws::{OwnerPicture, Reference, Truth, Verdict};
use enfilade::{Contract, ItemId, Scene, SectorId, View, Viewer};

/// What was found at a view.
pub(crate) struct Found {
    pub(crate) reference_visible: usize,
    /// From the look, the drawing or both.
    pub(crate) missed: Vec<(SectorId, ItemId)>,
    pub(crate) extra: usize,
    pub(crate) pixels_different: u64,
    pub(crate) pixels_contested: u64,
    pub(crate) pixels: u64,
    pub(crate) contested: Vec<Contested>,
}

/// Items that may own the same samples, and how many; most often their faces coincide.
pub(crate) type Contested = (Vec<(SectorId, ItemId)>, u64);

/// So many groups of contested items are named for a view.
const MAX_CONTESTED: usize = 8;

/// Checks all views; for each of the prepared, one found for each view.
///
/// `viewers` are those that looked before, so that what they remember is put to the test too. Strict methods are also
/// held to what is seen at `places` by chance in each pixel, if that is more than one.
pub(crate) fn check(
    prepared: &[Prepared],
    viewers: &mut [Viewer],
    views: &[View],
    places: u32,
) -> Result<Vec<Vec<Found>>> {
    let mut found: Vec<Vec<Found>> = prepared.iter().map(|_| Vec::new()).collect();
    let Some(first) = prepared.first().filter(|_| !views.is_empty()) else {
        return Ok(found);
    };
    let reference = reference(&first.scene)?;
    let progress = Progress::steps("checking", views.len());
    for view in views {
        let truth = reference.see(&first.scene, view, &viewers[0].limits());
        let strict = |prepared: &Prepared| places > 1 && prepared.contract == Contract::Strict;
        let anywhere = prepared.iter().any(strict).then(|| {
            let limits = viewers[0].limits();
            reference.see_anywhere(&first.scene, view, &limits, places, 0)
        });
        for ((prepared, viewer), found) in prepared.iter().zip(&mut *viewers).zip(&mut found) {
            let (mut held, _) = hold(&truth, prepared, viewer, view);
            if let Some(anywhere) = anywhere.as_ref().filter(|_| strict(prepared)) {
                let verdict = anywhere.check(viewer.visible(), None);
                held.reference_visible = verdict.reference_visible;
                held.extra = verdict.extra;
                held.missed.extend(verdict.missed);
                held.missed.sort_unstable();
                held.missed.dedup();
            }
            found.push(held);
        }
        progress.step();
    }
    Ok(found)
}

/// The reference over a scene, which takes a while.
///
/// # Errors
/// Terrain that stays in its file, of which the reference knows nothing.
pub(crate) fn reference(scene: &Scene) -> Result<Reference> {
    if let Some(name) = in_files(scene).next() {
        bail!(
            "{name}: the reference needs terrain as meshes, and this does not fit in --memory as such; raise --memory, or do \
             not compare with the reference"
        );
    }
    let _building = Progress::spinner("building the reference");
    Ok(Reference::new(scene))
}

/// Looks at a view and draws it, and holds both against the truth; the owners that were painted are given back.
pub(crate) fn hold(
    truth: &Truth,
    prepared: &Prepared,
    viewer: &mut Viewer,
    view: &View,
) -> (Found, OwnerPicture) {
    let looked = truth.check(viewer.look(&prepared.scene, view), None);
    let mut picture = OwnerPicture::new(view.size);
    viewer.draw(&prepared.scene, view, &mut picture);
    let drawn = truth.check(viewer.visible(), Some(&picture));
    let mut contested = truth.contested();
    contested.truncate(MAX_CONTESTED);
    (both(looked, drawn, contested), picture)
}

fn both(looked: Verdict, drawn: Verdict, contested: Vec<Contested>) -> Found {
    let mut missed = looked.missed;
    missed.extend(drawn.missed);
    missed.sort_unstable();
    missed.dedup();
    Found {
        reference_visible: drawn.reference_visible,
        missed,
        extra: looked.extra.max(drawn.extra),
        pixels_different: drawn.pixels_different,
        pixels_contested: drawn.pixels_contested,
        pixels: drawn.pixels,
        contested,
    }
}
