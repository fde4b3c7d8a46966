//! Compares the results of all methods with the reference. All methods share one ray-cast picture per view.

use crate::open::in_files;
use crate::prepare::PreparedScene;
use crate::progress::Progress;
use anyhow::{Result, bail};
use enfilade::laws::{OwnerPicture, Reference, Truth, Verdict};
use enfilade::{Contract, ItemIndex, Scene, SectorId, View, Viewer};

/// Result of the check of one method at one view.
pub(crate) struct CheckResult {
    pub(crate) reference_visible: usize,
    /// False culls of the look, of the drawing or of both.
    pub(crate) missed: Vec<(SectorId, ItemIndex)>,
    pub(crate) extra: usize,
    pub(crate) pixels_different: u64,
    pub(crate) pixels_contested: u64,
    pub(crate) pixels: u64,
    pub(crate) contested: Vec<Contested>,
}

/// Items that may own the same samples, and the number of those samples; most often their faces coincide.
pub(crate) type Contested = (Vec<(SectorId, ItemIndex)>, u64);

/// Maximum number of contested groups that are listed per view.
const MAX_CONTESTED: usize = 8;

/// Checks all methods at all views. Returns the results by method, then by view.
///
/// `viewers` are those of the timed looks, so that their temporal coherence is tested too. If `samples` is above 1,
/// strict methods are also checked at that many random samples per pixel.
pub(crate) fn check(
    prepared: &[PreparedScene],
    viewers: &mut [Viewer],
    views: &[View],
    samples: u32,
) -> Result<Vec<Vec<CheckResult>>> {
    let mut found: Vec<Vec<CheckResult>> = prepared.iter().map(|_| Vec::new()).collect();
    let Some(first) = prepared.first().filter(|_| !views.is_empty()) else {
        return Ok(found);
    };
    let reference = reference(&first.scene)?;
    let progress = Progress::steps("checking", views.len());
    for view in views {
        let results = check_methods(&reference, prepared, viewers, view, samples);
        found
            .iter_mut()
            .zip(results)
            .for_each(|(found, result)| found.push(result));
        progress.step();
    }
    Ok(found)
}

/// Checks all methods, at least one, at one view. See [`check`].
pub(crate) fn check_methods(
    reference: &Reference,
    prepared: &[PreparedScene],
    viewers: &mut [Viewer],
    view: &View,
    samples: u32,
) -> Vec<CheckResult> {
    let (scene, limits) = (&prepared[0].scene, viewers[0].options.limits);
    let truth = reference.see(scene, view, &limits);
    let strict = |prepared: &PreparedScene| samples > 1 && prepared.contract == Contract::Strict;
    let anywhere = prepared
        .iter()
        .any(strict)
        .then(|| reference.see_anywhere(scene, view, &limits, samples, 0));
    let results = prepared.iter().zip(viewers).map(|(prepared, viewer)| {
        let (mut result, _) = check_view(&truth, prepared, viewer, view);
        if let Some(anywhere) = anywhere.as_ref().filter(|_| strict(prepared)) {
            let verdict = anywhere.check(viewer.visible(), None);
            result.reference_visible = verdict.reference_visible;
            result.extra = verdict.extra;
            result.missed.extend(verdict.missed);
            result.missed.sort_unstable();
            result.missed.dedup();
        }
        result
    });
    results.collect()
}

/// Builds the reference of a scene. Slow.
///
/// # Errors
/// Fails if the scene has terrain that is read from its file on demand: the reference needs meshes.
pub(crate) fn reference(scene: &Scene) -> Result<Reference> {
    if let Some(name) = in_files(scene).next() {
        bail!(
            "{name}: the reference needs terrain as meshes, and these do not fit in --memory; raise --memory, or do not \
             compare with the reference"
        );
    }
    let _building = Progress::spinner("building the reference");
    Ok(Reference::new(scene))
}

/// Looks at a view, draws it, and compares both with the truth. Also returns the owners that were drawn.
pub(crate) fn check_view(
    truth: &Truth,
    prepared: &PreparedScene,
    viewer: &mut Viewer,
    view: &View,
) -> (CheckResult, OwnerPicture) {
    let looked = truth.check(viewer.look(&prepared.scene, view), None);
    let mut picture = OwnerPicture::new(view.size());
    viewer.draw(&prepared.scene, view, &mut picture);
    let drawn = truth.check(viewer.visible(), Some(&picture));
    let mut contested = truth.contested();
    contested.truncate(MAX_CONTESTED);
    (merged(looked, drawn, contested), picture)
}

/// Merges the verdicts of the look and of the drawing.
fn merged(looked: Verdict, drawn: Verdict, contested: Vec<Contested>) -> CheckResult {
    let mut missed = looked.missed;
    missed.extend(drawn.missed);
    missed.sort_unstable();
    missed.dedup();
    CheckResult {
        reference_visible: drawn.reference_visible,
        missed,
        extra: looked.extra.max(drawn.extra),
        pixels_different: drawn.pixels_different,
        pixels_contested: drawn.pixels_contested,
        pixels: drawn.pixels,
        contested,
    }
}
