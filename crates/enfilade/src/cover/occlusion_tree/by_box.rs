//! How a box is asked after as it is: held against the planes, never cut.
//!
//! Where a plane goes through it, it is on both sides, even if other planes say that only one of them is left. So what
//! its faces come to, it comes to as well: what is hidden by box is hidden by faces.

use super::{Link, OcclusionTree, Plane};
use crate::region::{Sight, Volume};
use glam::DVec3;

/// What a height may be wrong by, as a part of the sum that it is; more than pieces of faces may be off by.
const ROUNDING: f64 = 1.0 / (1_u64 << 44) as f64;

/// What the leaves that a box came to say of it.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    lit: bool,
    shadow: bool,
}

/// A box by its middle.
struct Middle {
    center: DVec3,
    halves: [DVec3; 3],
    /// The greatest coordinates that a corner can have, and more.
    sum: DVec3,
}

impl<A> OcclusionTree<A> {
    /// What the box alone tells.
    pub(super) fn sees_box(&mut self, volume: &Volume) -> Sight {
        let middle = Middle::of(volume);
        let mut found = Found::default();
        for line in &self.tree.aperture {
            let [inside, outside] = middle.reach(line.normal, 0.0);
            if !inside {
                return Sight::Hidden;
            }
            found.shadow |= outside;
        }
        self.links.clear();
        self.links.push(self.tree.root);
        while let Some(link) = self.links.pop() {
            match link {
                Link::Lit => found.lit = true,
                Link::Shadow => found.shadow = true,
                Link::Node(node) => {
                    let node = &self.tree.nodes[node as usize];
                    let [inside, outside] = match &node.plane {
                        Plane::Line(line) => middle.reach(line.normal, 0.0),
                        Plane::Back(back) => middle.reach(back.normal, back.distance),
                    };
                    self.links.extend(inside.then_some(node.inside));
                    self.links.extend(outside.then_some(node.outside));
                }
            }
            if found.lit && found.shadow {
                return Sight::Partly;
            }
        }
        if found.lit { Sight::Fully } else { Sight::Hidden }
    }
}

impl Middle {
    fn of(volume: &Volume) -> Middle {
        let halves = volume.sides.map(|side| 0.5 * side);
        let [x, y, z] = halves;
        Middle {
            center: volume.origin + x + y + z,
            halves,
            sum: volume.origin.abs() + 2.0 * (x.abs() + y.abs() + z.abs()),
        }
    }

    /// Has the box anything where n · p > d, and where n · p < d? Yes when unsure.
    #[inline(always)]
    fn reach(&self, normal: DVec3, distance: f64) -> [bool; 2] {
        let [x, y, z] = self.halves.map(|half| normal.dot(half).abs());
        let height = normal.dot(self.center) - distance;
        let radius = x + y + z + ROUNDING * (normal.abs().dot(self.sum) + distance);
        // Not the other way round: what is no number is everywhere.
        [height + radius < 0.0, height - radius > 0.0].map(|is_not| !is_not)
    }
}
