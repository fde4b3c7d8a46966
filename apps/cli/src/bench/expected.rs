//! Holds the set of every method at every view against the one that is expected there.
//!
//! Expected is what a z-buffer sees: it is exact, builds next to nothing, and is the simplest. Exact methods must see the
//! same, others that promise something at least that. Items that lie in one plane, or whose edges meet a sample, are
//! contested: sets may differ in them and be right. So where sets differ, and only there, the reference is asked.

use crate::check;
use crate::measure::distinct;
use crate::names::Names;
use crate::prepare::{Prepared, drawn_by};
use crate::progress::Progress;
use crate::report::{ExpectedReport, Report};
use anyhow::Result;
use enfilade::{Contract, ItemId, Method, SectorId, View, Viewer};

/// Looks at all views once more, by the viewers that were timed, and adds to the reports how what they see compares with
/// what they saw before and with what is expected.
pub(super) fn hold(
    reports: &mut [Report],
    prepared: &[Prepared],
    viewers: &mut [Viewer],
    views: &[View],
) -> Result<()> {
    let Some(first) = prepared.first() else {
        return Ok(());
    };
    let yardstick = drawn_by(first, Method::ZBuffer)?;
    let mut measuring = yardstick.viewer();
    let limits = measuring.limits();
    let mut reference = None;
    let progress = Progress::steps("checking", views.len());
    for (number, view) in views.iter().enumerate() {
        let expected = distinct(measuring.look(&yardstick.scene, view));
        let mut truth = None;
        for ((prepared, viewer), report) in prepared.iter().zip(&mut *viewers).zip(&mut *reports) {
            let names = Names::new(&prepared.scene);
            let set = viewer.look(&prepared.scene, view);
            let seen = distinct(set);
            let mut held = ExpectedReport {
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
                held.missed = verdict.missed.iter().map(|&item| names.of(item)).collect();
                if prepared.contract == Contract::Exact {
                    held.extra = verdict.extra;
                }
            }
            let shown = &mut report.views[number];
            held.same_again = seen
                .iter()
                .map(|&item| names.of(item))
                .eq(shown.visible.iter().map(|name| &**name));
            shown.expected = Some(held);
        }
        progress.step();
    }
    Ok(())
}

/// Is a set what it must be, even if nothing were contested? Both are in order.
fn is_plainly_right(
    contract: Contract,
    seen: &[(SectorId, ItemId)],
    expected: &[(SectorId, ItemId)],
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
            |items: &[u32]| -> Vec<_> { items.iter().map(|&item| (SectorId(0), ItemId(item))).collect() };
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
