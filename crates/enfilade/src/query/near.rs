//! What is near by, as one walks: distances go through open portals, not through walls between fragments.
//!
//! Source: a shortest path through given convex outlines bends only at their edges; found by moving one bend at a time to
//!     its best place, which goes down to the least, for the length is convex.
//! Cost: what is within the radius, for each chain of portals within it.

use super::place::{Place, corners};
use crate::content::ItemId;
use crate::geom::{Aabb, nearest_in};
use crate::scene::{FragmentId, PortalId, Scene};
use glam::DVec3;
use std::collections::BTreeMap;

/// An item near by.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Near {
    /// The fragment that it stands in.
    pub fragment: FragmentId,
    /// Which.
    pub item: ItemId,
    /// How far its box is, along the shortest way through open portals, in units of the space where the way begins.
    pub distance: f64,
    /// The portals on that way, in order.
    pub crossed: Vec<PortalId>,
}

/// A chain of portals, all in the space that it leads to.
struct Chain {
    fragment: FragmentId,
    origin: DVec3,
    windows: Vec<Vec<DVec3>>,
    /// Lengths here for one where the way begins.
    scale: f64,
    crossed: Vec<PortalId>,
}

impl Scene {
    /// The items whose boxes are within `radius` of a place, each once by its shortest way, the nearest first. Walls and
    /// things within a fragment are not in the way; fragments of the user's own tell of no items.
    pub fn near(&self, place: Place, radius: f32) -> Vec<Near> {
        let radius = f64::from(radius);
        let mut found: BTreeMap<(FragmentId, ItemId), Near> = BTreeMap::new();
        let mut waiting = vec![Chain {
            fragment: place.fragment,
            origin: DVec3::from(place.position.map(f64::from)),
            windows: Vec::new(),
            scale: 1.0,
            crossed: Vec::new(),
        }];
        let mut chains = 1;
        while let Some(chain) = waiting.pop() {
            self.take_items(&chain, radius, &mut found);
            if chain.crossed.len() == MOST_CROSSED {
                continue;
            }
            for (portal, _) in self.ways_out(chain.fragment) {
                if let Some(longer) = self
                    .longer(&chain, portal, radius)
                    .filter(|_| chains < MOST_CHAINS)
                {
                    chains += 1;
                    waiting.push(longer);
                }
            }
        }
        let mut found: Vec<Near> = found.into_values().collect();
        found.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        found
    }

    fn take_items(&self, chain: &Chain, radius: f64, found: &mut BTreeMap<(FragmentId, ItemId), Near>) {
        let Some(content) = self.content(chain.fragment) else {
            return;
        };
        // Unfolded, the way is no shorter than the straight line.
        let reach = radius * chain.scale * (1.0 + 1e-12);
        content.items_within(chain.origin, reach, |item| {
            let bounds = &content.item(item).bounds;
            let distance = way(chain, |from| nearest_in_box(bounds, from)) / chain.scale;
            let known = found.get(&(chain.fragment, item));
            if distance <= radius && known.is_none_or(|known| distance < known.distance) {
                let near = Near {
                    fragment: chain.fragment,
                    item,
                    distance,
                    crossed: chain.crossed.clone(),
                };
                found.insert((chain.fragment, item), near);
            }
        });
    }

    /// The chain that goes on through a portal, if that is within the radius.
    fn longer(&self, chain: &Chain, portal_id: PortalId, radius: f64) -> Option<Chain> {
        if (chain.crossed.last()).is_some_and(|&came| self.leads_back(came, portal_id)) {
            return None;
        }
        let portal = &self.portals()[portal_id.0 as usize];
        let outline = corners(&self.fragment(portal.from).openings()[usize::from(portal.opening.0)].outline);
        if way(chain, |from| nearest_in(&outline, from)) > radius * chain.scale {
            return None;
        }
        let there = portal.there_from_here.0;
        let moved = |window: &Vec<DVec3>| {
            window
                .iter()
                .map(|&corner| there.transform_point3(corner))
                .collect()
        };
        let mut crossed = chain.crossed.clone();
        crossed.push(portal_id);
        Some(Chain {
            fragment: portal.to,
            origin: there.transform_point3(chain.origin),
            windows: chain.windows.iter().chain([&outline]).map(moved).collect(),
            scale: chain.scale * portal.there_from_here.scale(),
            crossed,
        })
    }
}

const MOST_CROSSED: usize = 64;
const MOST_CHAINS: usize = 65_536;

fn nearest_in_box(bounds: &Aabb, point: DVec3) -> DVec3 {
    let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
    point.max(min).min(max)
}

/// The length of the shortest way from a chain's origin through all of its windows to the nearest place of a target.
fn way(chain: &Chain, nearest: impl Fn(DVec3) -> DVec3) -> f64 {
    const ROUNDS: usize = 64;
    let mut bends: Vec<DVec3> = Vec::with_capacity(chain.windows.len() + 2);
    bends.push(chain.origin);
    for window in &chain.windows {
        bends.push(nearest_in(window, bends[bends.len() - 1]));
    }
    bends.push(nearest(bends[bends.len() - 1]));
    let length = |bends: &[DVec3]| {
        bends
            .windows(2)
            .map(|pair| pair[0].distance(pair[1]))
            .sum::<f64>()
    };
    let mut least = length(&bends);
    let last = bends.len() - 1;
    for _ in 0..ROUNDS {
        for (i, window) in (1..).zip(&chain.windows) {
            bends[i] = best_between(window, bends[i - 1], bends[i + 1]);
        }
        bends[last] = nearest(bends[last - 1]);
        let now = length(&bends);
        if now >= least * (1.0 - 1e-9) {
            return now.min(least);
        }
        least = now;
    }
    least
}

/// The point of a convex outline by which the way from one point to another is shortest.
fn best_between(window: &[DVec3], from: DVec3, to: DVec3) -> DVec3 {
    let normal = (window[1..].windows(2))
        .map(|pair| (pair[0] - window[0]).cross(pair[1] - window[0]))
        .sum::<DVec3>()
        .normalize_or_zero();
    let [here, there] = [from, to].map(|point| normal.dot(point - window[0]));
    // Both on one side: as long as to the other's mirror image.
    let [here, there] = [here.abs(), there.abs()];
    let [below_from, below_to] = [from, to].map(|point| point - normal * normal.dot(point - window[0]));
    if here + there > 0.0 {
        let straight = below_from.lerp(below_to, here / (here + there));
        let held = nearest_in(window, straight);
        if held.distance(straight) <= 1e-12 * (1.0 + straight.length()) {
            return straight;
        }
    }
    let through = |point: DVec3| from.distance(point) + point.distance(to);
    let best_on = |i: usize| {
        let [start, end] = [window[i], window[(i + 1) % window.len()]];
        let along = (end - start).normalize_or_zero();
        let at = |point: DVec3| along.dot(point - start);
        let off = |point: DVec3| (point - start - along * at(point)).length();
        let [far_from, far_to] = [off(from), off(to)];
        let sum = far_from + far_to;
        let best = if sum > 0.0 {
            (at(from) * far_to + at(to) * far_from) / sum
        } else {
            at(from)
        };
        start + along * best.clamp(0.0, start.distance(end))
    };
    (0..window.len())
        .map(best_on)
        .min_by(|a, b| through(*a).total_cmp(&through(*b)))
        .unwrap_or(from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_round_the_post_of_a_door_bends_at_the_post() {
        // A doorway from x = 0 to 1 in the plane z = 0; both ends stand to the left of it.
        let door = [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        let chain = Chain {
            fragment: FragmentId(0),
            origin: DVec3::new(-3.0, 1.0, 4.0),
            windows: vec![door.into()],
            scale: 1.0,
            crossed: Vec::new(),
        };
        let target = DVec3::new(-8.0, 1.0, -6.0);
        assert!((way(&chain, |_| target) - (5.0 + 10.0)).abs() < 1e-9);
        let straight = DVec3::new(4.0, 1.0, -4.0);
        assert!((way(&chain, |_| straight) - DVec3::new(7.0, 0.0, 8.0).length()).abs() < 1e-9);
    }
}
