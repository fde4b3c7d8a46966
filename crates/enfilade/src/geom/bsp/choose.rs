//! Which plane splits a node: that of one of its polygons, or a free one, across an axis or upright on an edge.
//!
//! Small nodes score every polygon on every polygon; large ones score some, spread over all, on a sample. Planes on
//! edges are asked where all others cut something.
//! Source: thesis "Painter's algorithm and binary space partitioning", 2.3.4 (the score); the rest is ours.
//! Cost: O(candidates · sample) in large nodes, O(n²) in small ones.
//! Sampling changes how good the tree is, never whether it is right.

use super::BspOptions;
use super::score::{Sample, Scored};
use super::side::Splitter;
use super::split::{Arena, Working};
use super::sweep::Sweep;
use super::upright::on_edges;
use crate::simd::level;
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};

/// Polygons that a plane is tried on; with four times as many, trees came out the same within a percent.
const SAMPLE: usize = 256;
/// Smaller nodes are not split across axes: there, a polygon's plane that cuts nothing is found nearly always.
const FEWEST_FOR_AXES: usize = 8;

/// The planes of polygons as they were born.
pub(super) struct Born {
    /// By polygon; `None` for those without area.
    pub(super) splitters: Vec<Option<Splitter>>,
    /// What no farther off counts as on a plane.
    pub(super) band: f64,
}

/// Buffers for one node after the other.
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

    /// The best splitter for these polygons; `None` where none has an area.
    pub(super) fn choose(
        &mut self,
        members: &[Working],
        arena: &Arena,
        born: &Born,
        options: &BspOptions,
    ) -> Option<Splitter> {
        let all = options.candidates == u32::MAX;
        let size = if all { members.len() } else { SAMPLE };
        let axes = members.len() >= FEWEST_FOR_AXES && options.free_splits.is_finite();
        self.sample.clear();
        self.sweep.clear();
        for member in spread(members.len(), size).map(|place| &members[place]) {
            // What has no area is never cut, so it has no say.
            let Some(splitter) = &born.splitters[member.polygon as usize] else {
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
            best = self.sweep.best(&free, born.band);
        }
        let candidates = options.candidates.max(2);
        let some = |wanted: u32| {
            let places = spread(members.len(), wanted as usize);
            places.filter_map(|place| {
                let member = &members[place];
                Some((member, born.splitters[member.polygon as usize].as_ref()?))
            })
        };
        let sample = &self.sample;
        let planes = some(candidates).map(|(_, splitter)| *splitter);
        best = dispatch!(self.level, simd => lowest(simd, planes, sample, options, best));
        if options.free_splits.is_finite() && best.as_ref().is_some_and(|best| best.cut > 0) {
            // Half as many polygons have more than half as many edges.
            let planes = some(candidates / 2)
                .flat_map(|(member, splitter)| on_edges(member, arena, splitter, born.band));
            best = dispatch!(self.level, simd => lowest(simd, planes, sample, &free, best));
        }
        // Of a few candidates, none may have an area.
        let any = || {
            let mut all = members.iter();
            all.find_map(|member| born.splitters[member.polygon as usize])
        };
        best.map(|best| best.splitter).or_else(any)
    }
}

/// The candidate with the lowest score, or else the best so far.
#[inline(always)]
fn lowest<S: Simd>(
    simd: S,
    candidates: impl Iterator<Item = Splitter>,
    sample: &Sample,
    options: &BspOptions,
    mut best: Option<Scored>,
) -> Option<Scored> {
    for splitter in candidates {
        let least = best.as_ref().map_or(f32::INFINITY, |best| best.score);
        if let Some(tally) = sample.tally(simd, &splitter, options, least) {
            let score = tally.score(options);
            if score < least && (splitter.polygon.is_some() || tally.parts()) {
                best = Some(Scored {
                    score,
                    cut: tally.cut,
                    splitter,
                });
            }
        }
    }
    best
}

/// So many places among `count`, one in each of as many equal parts; not evenly, so that a pattern in the polygons'
/// order is not met in step. All places where that is enough.
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
