//! Chooses the splitting plane of a BSP node: the plane of one of its polygons (auto-partition), or a free plane,
//! axis-aligned or perpendicular to a polygon along one of its edges.
//!
//! Small nodes score the plane of every polygon against every polygon; large nodes score a spread of candidates against
//! a sample. Planes through edges are scored only if every other plane cuts something.
//! Source: Painter's algorithm and binary space partitioning (a thesis in Russian, author unknown), section 2.3.4, for
//!     the score; the rest is original.
//! Cost: O(candidates · sample) in large nodes, O(n²) in small ones.
//! Sampling affects the quality of the tree, never its correctness.

use super::BspOptions;
use super::score::{Sample, ScoredSplitter};
use super::side::Splitter;
use super::split::{Arena, ClipPolygon};
use super::sweep::Sweep;
use super::upright::planes_through_edges;
use crate::simd::{dispatch, level};
use fearless_simd::Level;
use fearless_simd::prelude::*;

/// Number of polygons that a plane is scored against; four times as many changed the trees by less than one percent.
const SAMPLE: usize = 256;
/// Minimum number of polygons for axis-aligned planes; smaller nodes nearly always have a polygon whose plane cuts
/// nothing.
const MIN_POLYGONS_FOR_AXES: usize = 8;

/// Planes of the input polygons, before any cut.
pub(super) struct InputPlanes {
    /// By polygon; `None` for polygons without area.
    pub(super) splitters: Vec<Option<Splitter>>,
    /// Points within this distance of a plane count as on it.
    pub(super) band: f64,
}

/// Buffers, reused from node to node.
pub(super) struct Chooser {
    level: Level,
    sample: Sample,
    sweep: Sweep,
}

impl Chooser {
    pub(super) fn new() -> Chooser {
        Chooser {
            level: level(),
            sample: Sample::default(),
            sweep: Sweep::default(),
        }
    }

    /// Returns the splitter with the lowest score for these polygons; `None` if none of them has an area.
    pub(super) fn choose(
        &mut self,
        members: &[ClipPolygon],
        arena: &Arena,
        input: &InputPlanes,
        options: &BspOptions,
    ) -> Option<Splitter> {
        let all = options.candidates == u32::MAX;
        let size = if all { members.len() } else { SAMPLE };
        let axes = members.len() >= MIN_POLYGONS_FOR_AXES && options.free_splits.is_finite();
        self.sample.clear();
        self.sweep.clear();
        for member in spread(members.len(), size).map(|place| &members[place]) {
            // A polygon without area is never cut, so it does not affect the score.
            let Some(splitter) = &input.splitters[member.polygon as usize] else {
                continue;
            };
            let corners = arena.corners(member);
            self.sample.push(corners, splitter.band);
            if axes {
                self.sweep.push(corners);
            }
        }
        let free = BspOptions {
            splits: options.splits * options.free_splits,
            ..*options
        };
        let mut best = None;
        if axes {
            best = self.sweep.best(&free, input.band);
        }
        let candidates = options.candidates.max(2);
        let some = |wanted: u32| {
            let places = spread(members.len(), wanted as usize);
            places.filter_map(|place| {
                let member = &members[place];
                Some((member, input.splitters[member.polygon as usize].as_ref()?))
            })
        };
        let sample = &self.sample;
        let planes = some(candidates).map(|(_, splitter)| *splitter);
        best = dispatch!(self.level, simd => best_candidate(simd, planes, sample, options, best));
        if options.free_splits.is_finite() && best.as_ref().is_some_and(|best| best.cut > 0) {
            // Half as many polygons still give more than half as many edges.
            let planes = some(candidates / 2)
                .flat_map(|(member, splitter)| planes_through_edges(member, arena, splitter, input.band));
            best = dispatch!(self.level, simd => best_candidate(simd, planes, sample, &free, best));
        }
        // None of a few sampled candidates may have an area; then any polygon's plane will do.
        let any = || {
            let mut all = members.iter();
            all.find_map(|member| input.splitters[member.polygon as usize])
        };
        best.map(|best| best.splitter).or_else(any)
    }
}

/// Returns the candidate with the lowest score if it beats `best`, else `best`.
#[inline(always)]
fn best_candidate<S: Simd>(
    simd: S,
    candidates: impl Iterator<Item = Splitter>,
    sample: &Sample,
    options: &BspOptions,
    mut best: Option<ScoredSplitter>,
) -> Option<ScoredSplitter> {
    for splitter in candidates {
        let least = best.as_ref().map_or(f32::INFINITY, |best| best.score);
        if let Some(tally) = sample.tally(simd, &splitter, options, least) {
            let score = tally.score(options);
            if score < least && (splitter.polygon.is_some() || tally.separates()) {
                best = Some(ScoredSplitter {
                    score,
                    cut: tally.cut,
                    splitter,
                });
            }
        }
    }
    best
}

/// Returns `wanted` indices below `count`, one from each of `wanted` equal ranges; all indices if there are no more.
/// They are jittered, so that a regular pattern in the order of the polygons is not sampled in step.
fn spread(count: usize, wanted: usize) -> impl Iterator<Item = usize> {
    let wanted = wanted.min(count);
    (0..wanted).map(move |part| {
        let [first, end] = [part, part + 1].map(|part| (part as u64 * count as u64 / wanted as u64) as usize);
        let jumbled = (part as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 33;
        first + jumbled as usize % (end - first)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_takes_all_of_a_few_and_some_of_each_part_of_many() {
        assert_eq!(spread(5, 9).collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
        let some: Vec<usize> = spread(1000, 10).collect();
        assert!(some.iter().enumerate().all(|(part, place)| place / 100 == part));
        assert_eq!(spread(0, 10).count(), 0);
    }
}
