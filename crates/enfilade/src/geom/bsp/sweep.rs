//! Axis-aligned splitting planes that balance both sides and cut few polygons.
//!
//! Such a plane removes no polygon from its node, but in a large node it separates rooms that no wall's plane
//! separates. One pass over the sorted ends of the sample's polygons scores every plane through one of their corners.
//! Source: the event sweep of kd-trees (MacDonald, Booth 1990; Wald, Havran 2006) with the score of the BSP tree.
//! Cost: O(n log n) for each axis.
//! Each side gets fewer polygons than the node has, so building ends.

use super::BspOptions;
use super::score::{ScoredSplitter, Tally};
use super::side::{Plane, Splitter};
use glam::DVec3;

/// Intervals of the sample's polygons along each axis; buffers are reused from node to node.
#[derive(Default)]
pub(super) struct Sweep {
    spans: Vec<[DVec3; 2]>,
    lows: Vec<f64>,
    highs: Vec<f64>,
    /// Coordinates of the polygons that are in a plane perpendicular to the axis.
    flat: Vec<f64>,
}

impl Sweep {
    pub(super) fn clear(&mut self) {
        self.spans.clear();
    }

    pub(super) fn push(&mut self, corners: &[DVec3]) {
        let [mut low, mut high] = [corners[0]; 2];
        for &corner in &corners[1..] {
            low = low.min(corner);
            high = high.max(corner);
        }
        self.spans.push([low, high]);
    }

    /// Returns the axis-aligned plane with the lowest score; `None` if none cuts few and separates anything.
    pub(super) fn best(&mut self, options: &BspOptions, band: f64) -> Option<ScoredSplitter> {
        let mut best: Option<ScoredSplitter> = None;
        for axis in 0..3 {
            self.sort(axis, band);
            self.each_plane(band, |at, tally| {
                let score = tally.score(options);
                if tally.cuts_few() && best.as_ref().is_none_or(|best| score < best.score) {
                    let splitter = Splitter {
                        plane: Plane::across(axis, at),
                        band,
                        polygon: None,
                    };
                    best = Some(ScoredSplitter {
                        score,
                        cut: tally.cut,
                        splitter,
                    });
                }
            });
        }
        best
    }

    fn sort(&mut self, axis: usize, band: f64) {
        for list in [&mut self.lows, &mut self.highs, &mut self.flat] {
            list.clear();
        }
        for [low, high] in &self.spans {
            let [low, high] = [low[axis], high[axis]];
            self.lows.push(low);
            self.highs.push(high);
            if high - low <= band {
                self.flat.push(low);
            }
        }
        for list in [&mut self.lows, &mut self.highs, &mut self.flat] {
            list.sort_unstable_by(f64::total_cmp);
        }
    }

    fn each_plane(&self, band: f64, mut each: impl FnMut(f64, Tally)) {
        let all = self.lows.len();
        let count = |list: &[f64], from: &mut usize, is_before: &dyn Fn(f64) -> bool| {
            while list.get(*from).is_some_and(|&value| is_before(value)) {
                *from += 1;
            }
            *from
        };
        let [mut next_low, mut next_high] = [0; 2];
        let [mut begun, mut ended, mut flat_begun, mut flat_ended] = [0; 4];
        while next_high < all {
            let high = self.highs[next_high];
            let at = self.lows.get(next_low).map_or(high, |&low| low.min(high));
            let begun = count(&self.lows, &mut begun, &|low| low - at < -band);
            let ended = count(&self.highs, &mut ended, &|high| high - at <= band);
            let on = count(&self.flat, &mut flat_ended, &|v| v - at <= band)
                - count(&self.flat, &mut flat_begun, &|v| v - at < -band);
            // Neither side may get all polygons. This is tested on exact counts: the tally is only approximate for
            // polygons as thin as the band.
            if begun < all && ended > 0 {
                // Behind or cut: all polygons that begin before the plane. Behind or on: all that end before it.
                let cut = (begun + on).saturating_sub(ended).min(begun);
                let tally = Tally {
                    front: (all - begun).saturating_sub(on) as u32,
                    back: (begun - cut) as u32,
                    on: on as u32,
                    cut: cut as u32,
                };
                each(at, tally);
            }
            count(&self.lows, &mut next_low, &|low| low <= at);
            count(&self.highs, &mut next_high, &|high| high <= at);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sweep(spans: &[[f64; 2]]) -> Sweep {
        let mut sweep = Sweep::default();
        for [low, high] in spans {
            sweep.push(&[DVec3::new(*low, 0.0, 0.0), DVec3::new(*high, 1.0, 1.0)]);
        }
        sweep.sort(0, 0.01);
        sweep
    }

    #[test]
    fn places_where_a_polygon_begins_or_ends_are_tallied_unless_all_would_be_on_one_side() {
        let mut tallies = Vec::new();
        sweep(&[[0.0, 2.0], [1.0, 1.0], [2.0, 3.0], [2.5, 4.0]]).each_plane(0.01, |at, tally| {
            tallies.push((at, [tally.back, tally.cut, tally.on, tally.front]));
        });
        let expected = [(1.0, [0, 1, 1, 2]), (2.0, [2, 0, 0, 2]), (2.5, [2, 1, 0, 1])];
        assert_eq!(tallies, expected);
    }

    #[test]
    fn polygons_thinner_than_the_band_that_reach_beyond_it_are_tallied_without_going_below_nothing() {
        // At 0, two polygons begin within the band and end beyond it: more are on the plane than have ended.
        let spans = [[-5.0, 0.0], [0.008, 0.016], [0.008, 0.016], [1.0, 2.0]];
        sweep(&spans).each_plane(0.01, |at, tally| {
            let parts = [tally.back, tally.cut, tally.on, tally.front];
            assert!(parts.iter().all(|&part| part <= 4), "at {at}: {parts:?}");
        });
    }

    #[test]
    fn no_plane_is_found_where_none_parts_anything() {
        sweep(&[[0.0, 1.0], [0.0, 1.0]]).each_plane(0.01, |at, _| panic!("{at}"));
        assert!(sweep(&[]).best(&BspOptions::default(), 0.01).is_none());
    }
}
