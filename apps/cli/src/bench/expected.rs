//! Compares the visible set of every method at every view with the expected one.
//!
//! The set of a z-buffer is expected: it is exact, builds almost nothing, and is the simplest method. Exact methods
//! must return the same set, strict and conservative ones at least its items. Coplanar items, and items whose edges hit
//! a sample, are contested: sets may differ in them and still be right. So the reference decides where sets differ, and
//! only there.

use crate::check;
use crate::measure::distinct;
use crate::names::Names;
use crate::prepare::{PreparedScene, drawn_by};
use crate::progress::Progress;
use crate::report::{ExpectedReport, Report};
use anyhow::Result;
use enfilade::{Contract, ItemIndex, Method, SectorId, View, Viewer};

/// Looks at all views once more, with the timed viewers, and adds to the reports how the sets compare with those of the
/// pass before and with the expected ones.
pub(super) fn check_sets(
    reports: &mut [Report],
    prepared: &[PreparedScene],
    viewers: &mut [Viewer],
    views: &[View],
) -> Result<()> {
    let Some(first) = prepared.first() else {
        return Ok(());
    };
    let baseline = drawn_by(first, Method::ZBuffer)?;
    let mut baseline_viewer = baseline.viewer();
    let limits = baseline_viewer.options.limits;
    let mut reference = None;
    let progress = Progress::steps("checking", views.len());
    for (number, view) in views.iter().enumerate() {
        let expected = distinct(baseline_viewer.look(&baseline.scene, view));
        let mut truth = None;
        for ((prepared, viewer), report) in prepared.iter().zip(&mut *viewers).zip(&mut *reports) {
            let names = Names::new(&prepared.scene);
            let set = viewer.look(&prepared.scene, view);
            let seen = distinct(set);
            let mut comparison = ExpectedReport {
                items_visible: expected.len(),
                missed: Vec::new(),
                extra: 0,
                same_again: true,
            };
            if !is_plainly_right(prepared.contract, &seen, &expected) {
                if reference.is_none() {
                    reference = Some(check::reference(&first.scene)?);
                }
                let seen = || Some(reference.as_ref()?.see(&first.scene, view, &limits));
                truth = truth.or_else(seen);
                let Some(truth) = &truth else { continue };
                let verdict = truth.check(set, None);
                comparison.missed = verdict.missed.iter().map(|&item| names.of(item)).collect();
                if prepared.contract == Contract::Exact {
                    comparison.extra = verdict.extra;
                }
            }
            let shown = &mut report.views[number];
            comparison.same_again = seen
                .iter()
                .map(|&item| names.of(item))
                .eq(shown.visible.iter().map(|name| &**name));
            shown.expected = Some(comparison);
        }
        progress.step();
    }
    Ok(())
}

/// Returns `true` if a set satisfies its contract even if no item is contested. Both sets are sorted.
fn is_plainly_right(
    contract: Contract,
    seen: &[(SectorId, ItemIndex)],
    expected: &[(SectorId, ItemIndex)],
) -> bool {
    match contract {
        Contract::Exact => seen == expected,
        Contract::Approximate => true,
        _ => expected.iter().all(|item| seen.binary_search(item).is_ok()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_sets_are_equal_others_hold_what_is_expected_and_approximate_ones_promise_nothing() {
        let set =
            |items: &[u32]| -> Vec<_> { items.iter().map(|&item| (SectorId(0), ItemIndex(item))).collect() };
        let right = |contract, seen: &[u32]| is_plainly_right(contract, &set(seen), &set(&[1, 3]));
        assert!(right(Contract::Exact, &[1, 3]));
        assert!(!right(Contract::Exact, &[1, 2, 3]));
        assert!(right(Contract::Conservative, &[1, 2, 3]));
        assert!(!right(Contract::Conservative, &[1, 2]));
        assert!(right(Contract::Strict, &[1, 3, 9]));
        assert!(!right(Contract::Strict, &[]));
        assert!(right(Contract::Approximate, &[]));
    }
}
