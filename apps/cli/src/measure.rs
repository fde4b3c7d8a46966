//! Times looks, drawing and traversal: one warm-up pass over all views, then three timed passes; the median per view.
//!
//! All passes run in the order of the views, so temporal coherence always uses the view before.

use crate::picture::draw;
use crate::prepare::PreparedScene;
use crate::progress::Progress;
use enfilade::{Contract, ItemIndex, OpeningId, Passage, Scene, SectorId, View, Viewer, VisibleSet};
use enfilade_draw::Settings;
use std::time::Instant;

/// Number of timed passes.
pub(crate) const PASSES: usize = 3;

/// Result and cost of one look.
pub(crate) struct LookResult {
    /// Median time of the passes, in milliseconds.
    pub(crate) ms: f64,
    pub(crate) passages: Vec<LookPassage>,
    pub(crate) items_in_frustum: usize,
    pub(crate) triangles_in_frustum: u64,
    pub(crate) triangles_visible: u64,
    pub(crate) complete: bool,
    /// Visible items over all passages, each once, sorted.
    pub(crate) visible: Vec<(SectorId, ItemIndex)>,
    /// For each visible item the longer side of its screen rectangle, in pixels: the maximum over all passages.
    pub(crate) sizes_px: Vec<u16>,
}

/// A passage of a look, in the order of the set.
pub(crate) struct LookPassage {
    pub(crate) sector: SectorId,
    /// The opening of its last portal; `None` for the passage that starts at the eye.
    pub(crate) through: Option<(SectorId, OpeningId)>,
    pub(crate) crossings: u16,
    pub(crate) contract: Contract,
    pub(crate) items_visible: usize,
}

/// The looks at all views, and the counters of the last pass, summed over the views.
pub(crate) struct LookResults {
    pub(crate) each: Vec<LookResult>,
    pub(crate) stats: Vec<(&'static str, u64)>,
}

/// Looks at a view once, without timing it.
pub(crate) fn look(prepared: &PreparedScene, viewer: &mut Viewer, view: &View) -> LookResult {
    LookResult::of(viewer.look(&prepared.scene, view), &prepared.scene)
}

/// Looks at all views: once for the results, then in timed passes.
pub(crate) fn looks(
    prepared: &PreparedScene,
    views: &[View],
    viewer: &mut Viewer,
    progress: &Progress,
) -> LookResults {
    let scene = &prepared.scene;
    let mut each: Vec<LookResult> = views
        .iter()
        .map(|view| {
            progress.step();
            LookResult::of(viewer.look(scene, view), scene)
        })
        .collect();
    let mut stats: Vec<(&'static str, u64)> = viewer.stats().each().map(|(name, _)| (name, 0)).into();
    let times = timed(views, progress, |pass, view| {
        viewer.look(scene, view);
        if pass + 1 == PASSES {
            for (sum, (_, cost)) in stats.iter_mut().zip(viewer.stats().each()) {
                sum.1 += cost;
            }
        }
    });
    each.iter_mut().zip(times).for_each(|(look, ms)| look.ms = ms);
    LookResults { each, stats }
}

/// Draws all views, shading included, and returns the milliseconds of each. The viewer must have looked at all of them
/// once before, as warm-up.
pub(crate) fn draws(
    prepared: &PreparedScene,
    views: &[View],
    viewer: &mut Viewer,
    settings: &Settings,
    progress: &Progress,
) -> Vec<f64> {
    timed(views, progress, |_, view| {
        draw(prepared, viewer, view, settings);
    })
}

/// Walks the traversal orders of each view's passages with nothing culled, and returns the milliseconds of each view.
pub(crate) fn walks(
    prepared: &PreparedScene,
    views: &[View],
    viewer: &mut Viewer,
    progress: &Progress,
) -> Vec<f64> {
    medians(views, progress, |_, view| {
        viewer.look(&prepared.scene, view);
        took(|| {
            viewer.walk(&prepared.scene);
        })
    })
}

/// Runs the timed passes, and returns the median of each view, in milliseconds.
pub(crate) fn timed(views: &[View], progress: &Progress, mut run: impl FnMut(usize, &View)) -> Vec<f64> {
    medians(views, progress, |pass, view| took(|| run(pass, view)))
}

fn took(run: impl FnOnce()) -> f64 {
    let start = Instant::now();
    run();
    start.elapsed().as_secs_f64() * 1e3
}

fn medians(views: &[View], progress: &Progress, mut run: impl FnMut(usize, &View) -> f64) -> Vec<f64> {
    let mut times = vec![[0.0; PASSES]; views.len()];
    for pass in 0..PASSES {
        for (view, times) in views.iter().zip(&mut times) {
            times[pass] = run(pass, view);
            progress.step();
        }
    }
    times.iter().map(|times| median(times)).collect()
}

/// Returns the median; of an even number of values the mean of the middle two, of none 0.
pub(crate) fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => 0.0,
        count if count % 2 == 1 => sorted[count / 2],
        count => 0.5 * (sorted[count / 2 - 1] + sorted[count / 2]),
    }
}

/// Returns the 99th percentile: the smallest value that at least 99 % do not exceed; of none 0.
pub(crate) fn p99(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = (0.99 * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
}

impl LookResult {
    fn of(set: &VisibleSet, scene: &Scene) -> LookResult {
        let (items_in_frustum, triangles_in_frustum) = set.in_frustum(scene);
        let visible = distinct(set);
        LookResult {
            ms: 0.0,
            passages: ways(set, scene),
            items_in_frustum,
            triangles_in_frustum,
            triangles_visible: set.triangle_count(scene),
            complete: set.complete(),
            sizes_px: sizes_px(set, &visible),
            visible,
        }
    }
}

fn ways(set: &VisibleSet, scene: &Scene) -> Vec<LookPassage> {
    let way = |passage: &Passage| {
        let portal = passage.portal.map(|portal| &scene.portals()[portal.0 as usize]);
        LookPassage {
            sector: passage.sector,
            through: portal.map(|portal| (portal.from, portal.opening)),
            crossings: passage.crossings,
            contract: passage.contract,
            items_visible: 0,
        }
    };
    let mut ways: Vec<LookPassage> = set.passages().iter().map(way).collect();
    for item in set.items() {
        ways[item.passage.0 as usize].items_visible += 1;
    }
    ways
}

/// Returns the items of a set over all passages, each once, sorted.
pub(crate) fn distinct(set: &VisibleSet) -> Vec<(SectorId, ItemIndex)> {
    let mut items: Vec<_> = set
        .items()
        .iter()
        .map(|seen| (set.passage(seen.passage).sector, seen.item.index))
        .collect();
    items.sort_unstable();
    items.dedup();
    items
}

/// Returns the sizes of the items in `visible`, in pixels; `visible` is the result of [`distinct`] for `set`.
fn sizes_px(set: &VisibleSet, visible: &[(SectorId, ItemIndex)]) -> Vec<u16> {
    let mut sizes = vec![0; visible.len()];
    for seen in set.items() {
        let item = (set.passage(seen.passage).sector, seen.item.index);
        if let Ok(index) = visible.binary_search(&item) {
            sizes[index] = seen.size_px.max(sizes[index]);
        }
    }
    sizes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_and_the_last_hundredth() {
        assert_eq!(
            [&[][..], &[3.0], &[3.0, 1.0], &[9.0, 1.0, 2.0]].map(median),
            [0.0, 3.0, 2.0, 2.0]
        );
        let hundred: Vec<f64> = (1..=200).map(f64::from).collect();
        assert_eq!((p99(&hundred), p99(&[5.0, 7.0]), p99(&[])), (198.0, 7.0, 0.0));
    }
}
