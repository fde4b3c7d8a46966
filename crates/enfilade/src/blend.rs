//! Sorts transparent items back to front, for engines that draw items rather than samples.
//!
//! Items behind an opening come before the items of the sector that the opening is in. Within a passage, if an
//! axis-aligned plane separates two boxes, the one on the far side from the eye comes first: nothing in it can overlap
//! the other on the screen. Boxes that intersect are sorted by the distance of their centres; where their geometry
//! intersects, no order of items is right. [`Viewer::draw`](crate::Viewer::draw) sorts sample by sample instead.
//! Source: the planes are those of Schumacker and others, Study for Applying Computer-Generated Images to Visual
//!     Simulation, 1969, with boxes for clusters; sorted as Kahn, Topological Sorting of Large Networks, 1962.
//! Cost: O(n²) for n transparent items in one passage.
//! Exact for disjoint boxes that do not overlap in a cycle; in a cycle at least one pair is in the wrong order.

use crate::geom::Aabb;
use crate::geometry::Geometry;
use crate::ids::PassageId;
use crate::scene::Scene;
use crate::view::passage::Passage;
use crate::view::visible::{VisibleItem, VisibleSet};

impl VisibleSet {
    /// Returns the alpha-blended items ([`VisibleItem::blends`]) back to front: draw them in this order, after all
    /// opaque items.
    #[doc(alias = "transparency")]
    #[doc(alias = "back to front")]
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

    /// Returns, for each passage, its rank in an order in which children come before their parent.
    fn children_first(&self) -> Vec<u32> {
        let mut places = vec![0; self.passages().len()];
        let mut next = 0;
        let mut ancestors: Vec<PassageId> = Vec::new();
        // Passages are listed in depth-first order: each after its parent, followed by its own descendants.
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

/// Sorts the items of one passage back to front.
fn far_to_near(items: &mut [VisibleItem], passage: &Passage, geometry: &Geometry) {
    let eye = passage.viewpoint();
    let away = |bounds: &Aabb| -> f64 {
        let middle = bounds.center();
        (0..3)
            .map(|axis| (f64::from(middle[axis]) - eye[axis]).powi(2))
            .sum()
    };
    items.sort_by(|a, b| {
        let [a, b] = [a, b].map(|item| (away(&geometry.item(item.item.index).bounds), item.item));
        b.0.total_cmp(&a.0).then(a.1.cmp(&b.1))
    });
    let sorted: Vec<(VisibleItem, Aabb)> = items
        .iter()
        .map(|item| (*item, geometry.item(item.item.index).bounds))
        .collect();
    // For each item, the number of remaining items that must come before it.
    let must_come_first = |a: &Aabb, b: &Aabb| may_lie_over(b, a, eye) && !may_lie_over(a, b, eye);
    let mut waits: Vec<usize> = sorted
        .iter()
        .map(|(_, b)| sorted.iter().filter(|(_, a)| must_come_first(a, b)).count())
        .collect();
    let mut left: Vec<usize> = (0..sorted.len()).collect();
    for place in items {
        // The farthest item that has no predecessor left; in a cycle, the farthest.
        let next = left.iter().position(|&number| waits[number] == 0).unwrap_or(0);
        let next = left.remove(next);
        *place = sorted[next].0;
        for &number in &left {
            waits[number] -= usize::from(must_come_first(&sorted[next].1, &sorted[number].1));
        }
    }
}

/// Returns `true` if geometry in `a` may overlap geometry in `b` on the screen and be in front of it: unless an
/// axis-aligned plane separates them with `b` on the eye's side.
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
        // With the eye between the two, neither overlaps the other.
        let between = [0.0, 1.0, -3.5];
        assert!(!may_lie_over(&small, &long, between) && !may_lie_over(&long, &small, between));
        // Boxes that intersect may overlap either way.
        assert!(may_lie_over(&long, &long, between));
    }
}
