//! Which plane splits a node: that of one of its polygons, or one across an axis.
//!
//! Small nodes score every polygon on every polygon; large ones score some, spread over all, on a sample.
//! Source: thesis "Painter's algorithm and binary space partitioning", 2.3.4 (the score); the sample is ours.
//! Cost: O(candidates · sample) in large nodes, O(n²) in small ones.
//! Sampling changes how good the tree is, never whether it is right.

use super::BspOptions;
use super::score::Sample;
use super::side::Splitter;
use super::split::{Arena, Working};
use super::sweep::Sweep;
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};

/// Polygons that a plane is tried on; with four times as many, trees came out the same within a percent.
const SAMPLE: usize = 256;
/// Smaller nodes are not split across axes: there, a polygon's plane that cuts nothing is found nearly always.
const FEWEST_FOR_AXES: usize = 8;

/// The planes of polygons as they were born, and how exact their corners are.
pub(super) struct Born {
    /// By polygon; `None` for those without area.
    pub(super) splitters: Vec<Option<Splitter>>,
    /// By polygon.
    pub(super) slack: Vec<f32>,
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
            level: Level::new(),
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
        let axes = members.len() >= FEWEST_FOR_AXES && options.axis_splits.is_finite();
        self.sample.clear();
        self.sweep.clear();
        for member in spread(members.len(), size).map(|place| &members[place]) {
            // What has no area is never cut, so it has no say.
            let Some(splitter) = &born.splitters[member.polygon as usize] else {
                continue;
            };
            let corners = arena.corners(member);
            self.sample.push(corners, splitter.slack);
            if axes {
                self.sweep.push(corners);
            }
        }
        let across = axes.then(|| self.sweep.best(options, born.band)).flatten();
        let candidates = spread(members.len(), options.candidates.max(1) as usize)
            .filter_map(|place| born.splitters[members[place].polygon as usize].as_ref());
        let best = across.map_or(f32::INFINITY, |(score, _)| score);
        let sample = &self.sample;
        let of_polygon = dispatch!(self.level, simd => best_of(simd, candidates, sample, options, best));
        let of_axis = || {
            let (_, plane) = across?;
            Some(Splitter {
                plane,
                band: born.band,
                slack: 0.0,
                polygon: None,
            })
        };
        // Of a few candidates, none may have an area.
        let of_any = || {
            let mut all = members.iter();
            all.find_map(|member| born.splitters[member.polygon as usize])
        };
        of_polygon.or_else(of_axis).or_else(of_any)
    }
}

/// The candidate with the lowest score, if that is below `best`.
#[inline(always)]
fn best_of<'a, S: Simd>(
    simd: S,
    candidates: impl Iterator<Item = &'a Splitter>,
    sample: &Sample,
    options: &BspOptions,
    mut best: f32,
) -> Option<Splitter> {
    let mut chosen = None;
    for candidate in candidates {
        if let Some(tally) = sample.tally(simd, candidate, options, best) {
            let score = tally.score(options);
            if score < best {
                best = score;
                chosen = Some(*candidate);
            }
        }
    }
    chosen
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
