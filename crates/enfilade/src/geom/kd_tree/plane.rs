//! Chooses the splitting plane of a kd-tree cell: near the middle, where it cuts the fewest primitives.
//!
//! Cost: O(n log n) for the n primitives of a cell.

use crate::geom::Aabb;

/// A splitting plane and the number of primitives it cuts.
pub(super) struct Split {
    pub(super) axis: usize,
    pub(super) at: f32,
    pub(super) cuts: usize,
}

/// Maximum distance of a plane from the middle, relative to the side: a quarter leaves each half at least a quarter.
const MAX_OFFSET: f32 = 0.25;

/// Sorted interval ends of a cell's primitives along an axis.
#[derive(Default)]
pub(super) struct Ends {
    lows: Vec<f32>,
    highs: Vec<f32>,
    /// Coordinates of the primitives that are flat along the axis.
    flats: Vec<f32>,
}

impl Ends {
    fn gather(&mut self, axis: usize, members: &[u32], boxes: &impl Fn(u32) -> Aabb) {
        let Ends { lows, highs, flats } = self;
        for list in [&mut *lows, &mut *highs, &mut *flats] {
            list.clear();
        }
        for &i in members {
            let thing = boxes(i);
            let [low, high] = [thing.min[axis], thing.max[axis]];
            lows.push(low);
            highs.push(high);
            if low == high {
                flats.push(low);
            }
        }
        for list in [lows, highs, flats] {
            list.sort_unstable_by(f32::total_cmp);
        }
    }

    /// Returns the number of primitives entirely below a plane and entirely above it.
    fn beside(&self, at: f32) -> [usize; 2] {
        let before = |list: &[f32]| list.partition_point(|&end| end < at);
        let up_to = |list: &[f32]| list.partition_point(|&end| end <= at);
        let in_it = up_to(&self.flats) - before(&self.flats);
        [up_to(&self.highs), self.lows.len() - before(&self.lows) - in_it]
    }
}

/// Returns the splitting plane across the longest side along which the primitives can be separated; `None` if there is
/// no such side.
pub(super) fn best_split(
    space: &Aabb,
    members: &[u32],
    boxes: &impl Fn(u32) -> Aabb,
    ends: &mut Ends,
) -> Option<Split> {
    let size = space.size();
    let mut axes = [0, 1, 2];
    axes.sort_by(|&a, &b| size[b].total_cmp(&size[a]));
    axes.into_iter().find_map(|axis| {
        ends.gather(axis, members, boxes);
        split_along(axis, space, ends)
    })
}

/// Returns the plane that cuts the fewest primitives, the one nearest to the middle among equals; `None` if no plane
/// near the middle has a primitive entirely on either side and cuts at most half of all.
fn split_along(axis: usize, space: &Aabb, ends: &Ends) -> Option<Split> {
    let middle = space.center()[axis];
    let reach = MAX_OFFSET * (space.max[axis] - space.min[axis]);
    let all = ends.lows.len();
    let boundaries = [&ends.lows, &ends.highs].into_iter().flat_map(|list| {
        let first = list.partition_point(|&end| end < middle - reach);
        let last = list.partition_point(|&end| end <= middle + reach);
        list[first..last].chunk_by(|a, b| a == b).map(|run| run[0])
    });
    let mut best: Option<(Split, f32)> = None;
    for at in boundaries.chain([middle]) {
        let [below, above] = ends.beside(at);
        let cuts = all - below - above;
        if below == 0 || above == 0 || 2 * cuts > all {
            continue;
        }
        let off = (at - middle).abs();
        let better = |(split, least_off): &(Split, f32)| {
            let order = cuts.cmp(&split.cuts).then(off.total_cmp(least_off));
            order.then(at.total_cmp(&split.at)).is_lt()
        };
        if best.as_ref().is_none_or(better) {
            best = Some((Split { axis, at, cuts }, off));
        }
    }
    best.map(|(split, _)| split)
}
