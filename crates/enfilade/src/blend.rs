//! In which order to blend glass: for engines that draw items, not samples.
//!
//! Glass behind an opening comes before the glass of the sector that the opening is in. Within a passage, of two boxes
//! that a plane across an axis parts, the one on the far side of it from the eye comes first: nothing in it can lie over the
//! other. Boxes that overlap cannot be told apart so: the one whose middle is farther comes first, and where what is in
//! them crosses, no order of items is right. Pictures drawn here are sorted sample by sample instead.
//! Source: the planes are those of Schumacker and others, Study for Applying Computer-Generated Images to Visual
//!     Simulation, 1969, with boxes for clusters; sorted as Kahn, Topological Sorting of Large Networks, 1962.
//! Cost: O(n²) for n items of glass in one passage.
//! Right for boxes that do not overlap, unless they cover each other in a cycle: then some two of those are not.

use crate::geom::Aabb;
use crate::geometry::Geometry;
use crate::passage::{Passage, PassageId};
use crate::scene::Scene;
use crate::visible::{VisibleItem, VisibleSet};

impl VisibleSet {
    /// The items with glass ([`VisibleItem::blends`]) in the order in which to blend them, after everything opaque.
    pub fn blend_order(&self, scene: &Scene) -> Vec<VisibleItem> {
        let mut glass: Vec<VisibleItem> = self.items().iter().filter(|item| item.blends).copied().collect();
        let depth_first = self.children_first();
        glass.sort_by_key(|item| depth_first[item.passage.0 as usize]);
        for same in glass.chunk_by_mut(|a, b| a.passage == b.passage) {
            let passage = self.passage(same[0].passage);
            if let Some(geometry) = scene.geometry(passage.sector) {
                far_to_near(same, passage, geometry);
            }
        }
        glass
    }

    /// For each passage its place in an order in which those behind its openings come before it.
    fn children_first(&self) -> Vec<u32> {
        let mut places = vec![0; self.passages().len()];
        let mut next = 0;
        let mut ancestors: Vec<PassageId> = Vec::new();
        // They are listed as they were entered, each after its parent and next to its brothers' descendants.
        for (id, passage) in (0..).map(PassageId).zip(self.passages()) {
            while let Some(last) = ancestors.pop_if(|last| Some(*last) != passage.parent) {
                places[last.0 as usize] = next;
                next += 1;
            }
            ancestors.push(id);
        }
        while let Some(last) = ancestors.pop() {
            places[last.0 as usize] = next;
            next += 1;
        }
        places
    }
}

/// Sorts the items of one passage.
fn far_to_near(items: &mut [VisibleItem], passage: &Passage, geometry: &Geometry) {
    let eye = passage.eye();
    let away = |bounds: &Aabb| -> f64 {
        let middle = bounds.center();
        (0..3)
            .map(|axis| (f64::from(middle[axis]) - eye[axis]).powi(2))
            .sum()
    };
    items.sort_by(|a, b| {
        let [a, b] = [a, b].map(|item| (away(&geometry.item(item.item).bounds), item.item));
        b.0.total_cmp(&a.0).then(a.1.cmp(&b.1))
    });
    let sorted: Vec<(VisibleItem, Aabb)> = items
        .iter()
        .map(|item| (*item, geometry.item(item.item).bounds))
        .collect();
    // How many of those that are left must come before each.
    let must_come_first = |a: &Aabb, b: &Aabb| may_lie_over(b, a, eye) && !may_lie_over(a, b, eye);
    let mut waits: Vec<usize> = sorted
        .iter()
        .map(|(_, b)| sorted.iter().filter(|(_, a)| must_come_first(a, b)).count())
        .collect();
    let mut left: Vec<usize> = (0..sorted.len()).collect();
    for place in items {
        // The farthest that nothing must come before; in a cycle, the farthest.
        let next = left.iter().position(|&number| waits[number] == 0).unwrap_or(0);
        let next = left.remove(next);
        *place = sorted[next].0;
        for &number in &left {
            waits[number] -= usize::from(must_come_first(&sorted[next].1, &sorted[number].1));
        }
    }
}

/// May something in `a` lie over something in `b`, as seen from an eye? Not if a plane parts them, with `b` on the eye's
/// side.
fn may_lie_over(a: &Aabb, b: &Aabb, eye: [f64; 3]) -> bool {
    !(0..3).any(|axis| {
        let beyond = a.min[axis] >= b.max[axis] && eye[axis] <= f64::from(a.min[axis]);
        let before = a.max[axis] <= b.min[axis] && eye[axis] >= f64::from(a.max[axis]);
        beyond || before
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_pane_behind_a_small_one_comes_first_though_its_middle_is_nearer() {
        let long = Aabb {
            min: [-1.0, 0.0, -4.0],
            max: [100.0, 2.0, -3.9],
        };
        let small = Aabb {
            min: [-0.5, 0.0, -3.0],
            max: [0.5, 2.0, -2.9],
        };
        assert!(may_lie_over(&small, &long, [0.0; 3]));
        assert!(!may_lie_over(&long, &small, [0.0; 3]));
        // Between the two neither lies over the other.
        let between = [0.0, 1.0, -3.5];
        assert!(!may_lie_over(&small, &long, between) && !may_lie_over(&long, &small, between));
        // What overlaps may do either.
        assert!(may_lie_over(&long, &long, between));
    }
}
