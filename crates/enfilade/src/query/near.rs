//! Items near a location, by the length of the shortest path through open portals, not through the walls between
//! sectors.
//!
//! Idea: best-first search over chains of portals. The chain whose last opening is nearest is expanded next, and a
//!     chain is pruned if another one reaches every point of its last opening by a path that is no longer.
//! Source: Mitchell, Mount, Papadimitriou, The Discrete Geodesic Problem, 1987, for the search order and the dominance
//!     test. The shortest path through given convex outlines is found by moving one bend at a time to its optimum,
//!     which converges because the length is convex.
//! Cost: per chain kept, the items within the remaining radius; at most [`NearItems::MAX_CHAINS`] chains.
//! Mirrors cost nothing: no path by a mirror is shorter than the one without it.

use super::location::{Location, corners};
use crate::geom::{Aabb, nearest_in};
use crate::ids::{ItemId, ItemIndex, PortalId, SectorId};
use crate::scene::Scene;
use glam::{DAffine3, DMat3, DVec3};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// Item found by [`Scene::near`], with its distance and the portals on the path.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct NearItem {
    /// The sector that contains the item.
    pub sector: SectorId,
    /// The item.
    pub item: ItemId,
    /// The key of the item.
    pub key: u64,
    /// Length of the shortest path to its bounding box through open portals, in units of the space of the start. Up to
    /// 0.1 % too long if the path crosses portals.
    pub distance: f64,
    /// The portals on the path, in order.
    pub crossed: Vec<PortalId>,
}

/// Result of [`Scene::near`]: the items and the extent of the search.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct NearItems {
    /// The items, each once, sorted by distance, then by sector and item id.
    pub items: Vec<NearItem>,
    /// Whether every path within the radius was searched.
    pub complete: bool,
    /// The radius, or less if a limit ended the search. Within this distance all items are listed with correct
    /// distances; beyond it items may be missing and distances may be too long.
    pub searched: f64,
}

impl NearItems {
    /// Maximum number of chains of portals that one search follows.
    pub const MAX_CHAINS: usize = 1024;

    /// Maximum number of portals on one path.
    pub const MAX_CROSSED: usize = 64;

    /// Maximum factor by which portals may scale lengths up or down relative to the start.
    pub const MAX_SCALE: f64 = 1e9;

    /// Maximum number of openings measured. Each gives a chain, of which few are expanded.
    const MAX_MEASURED: usize = 65_536;
}

impl Scene {
    /// Finds the items whose bounding boxes are within `radius` of a location, along paths through open portals.
    /// `radius` is in scene units of the start. Walls and items within a sector are no obstacles; custom sectors report
    /// no items.
    ///
    /// Finds nothing if the position is not finite or the radius is negative or NaN. If a limit of [`NearItems`] ends
    /// the search, [`NearItems::complete`] is `false`.
    #[doc(alias = "proximity")]
    #[doc(alias = "interest management")]
    #[doc(alias = "area of interest")]
    pub fn near(&self, place: Location, radius: f32) -> NearItems {
        let mut search = Search {
            scene: self,
            start: DVec3::from(place.position.map(f64::from)),
            radius: f64::from(radius),
            chains: Vec::new(),
            found: BTreeMap::new(),
            searched: f64::from(radius),
        };
        let complete = if search.start.is_finite() && radius >= 0.0 {
            search.run(place.sector)
        } else {
            true
        };
        let mut items: Vec<NearItem> = search.found.into_values().collect();
        items.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        NearItems {
            items,
            complete,
            searched: search.searched,
        }
    }
}

/// A chain of portals. All lengths and points are in the space of the start unless said otherwise.
struct Chain {
    /// The target sector.
    sector: SectorId,
    /// The index of the chain without its last portal, and that portal; `None` at the start.
    last: Option<(usize, PortalId)>,
    crossings: usize,
    /// The opening of the last portal; empty at the start.
    window: Vec<DVec3>,
    start_from_here: DAffine3,
    here_from_start: DAffine3,
    /// Length in the target sector of a unit length at the start.
    scale: f64,
    /// Length of the shortest path to the window.
    length: f64,
}

struct Search<'a> {
    scene: &'a Scene,
    start: DVec3,
    radius: f64,
    chains: Vec<Chain>,
    found: BTreeMap<(SectorId, ItemIndex), NearItem>,
    searched: f64,
}

impl Search<'_> {
    /// Returns `true` if no limit ended the search.
    fn run(&mut self, sector: SectorId) -> bool {
        self.chains.push(Chain {
            sector,
            last: None,
            crossings: 0,
            window: Vec::new(),
            start_from_here: DAffine3::IDENTITY,
            here_from_start: DAffine3::IDENTITY,
            scale: 1.0,
            length: 0.0,
        });
        let mut complete = true;
        let mut kept = 0;
        let mut kept_in: BTreeMap<SectorId, Vec<usize>> = BTreeMap::new();
        // Lengths are not negative, so their bit patterns sort like the values.
        let key = |chains: &[Chain], number: usize| Reverse((chains[number].length.to_bits(), number));
        let mut waiting = BinaryHeap::from([key(&self.chains, 0)]);
        while let Some(Reverse((_, number))) = waiting.pop() {
            let rivals = kept_in.entry(self.chains[number].sector).or_default();
            if self.returns(number) || self.is_dominated(number, rivals) {
                continue;
            }
            if kept == NearItems::MAX_CHAINS {
                self.searched = self.searched.min(self.chains[number].length);
                return false;
            }
            kept += 1;
            rivals.push(number);
            self.take_items(number);
            let first = self.chains.len();
            complete &= self.extend(number);
            waiting.extend((first..self.chains.len()).map(|longer| key(&self.chains, longer)));
        }
        complete
    }

    /// Adds the chains that are one portal longer and within the radius. Returns `false` if a limit left one out.
    fn extend(&mut self, number: usize) -> bool {
        let windows = self.windows(number);
        let chain = &self.chains[number];
        let mut searched = self.searched;
        let mut complete = true;
        let mut longer = Vec::new();
        for (portal_id, outline) in self.scene.open_portals(chain.sector) {
            if (chain.last).is_some_and(|(_, came)| self.scene.leads_back(came, portal_id)) {
                continue;
            }
            let portal = &self.scene.portals()[portal_id.0 as usize];
            let outline = corners(outline);
            let window: Vec<DVec3> = (outline.iter())
                .map(|&corner| chain.start_from_here.transform_point3(corner))
                .collect();
            let (length, _) = way(self.start, &windows, |from| nearest_in(&window, from));
            if length > self.radius {
                continue;
            }
            // A mirrored transform is combined with a reflection in the opening: that changes no length and turns a
            // mirror into the identity, so that `returns` prunes paths by it.
            let there_from_here = if portal.there_from_here.mirrors() {
                portal.there_from_here.0 * reflection(&outline)
            } else {
                portal.there_from_here.0
            };
            let scale = chain.scale * portal.there_from_here.scale();
            let in_range = (1.0 / NearItems::MAX_SCALE..=NearItems::MAX_SCALE).contains(&scale);
            if !in_range
                || chain.crossings == NearItems::MAX_CROSSED
                || self.chains.len() + longer.len() == NearItems::MAX_MEASURED
            {
                complete = false;
                searched = searched.min(length);
                continue;
            }
            longer.push(Chain {
                sector: portal.to,
                last: Some((number, portal_id)),
                crossings: chain.crossings + 1,
                window,
                start_from_here: chain.start_from_here * there_from_here.inverse(),
                here_from_start: there_from_here * chain.here_from_start,
                scale,
                length,
            });
        }
        self.chains.extend(longer);
        self.searched = searched;
        complete
    }

    /// Iterates over a chain and its prefixes, down to the start.
    fn back_from(&self, number: usize) -> impl Iterator<Item = (usize, &Chain)> {
        let before = move |&number: &usize| self.chains[number].last.map(|(before, _)| before);
        std::iter::successors(Some(number), before).map(move |number| (number, &self.chains[number]))
    }

    /// Returns the windows of a chain, in order.
    fn windows(&self, number: usize) -> Vec<&[DVec3]> {
        let mut windows: Vec<&[DVec3]> = (self.back_from(number))
            .filter(|(_, chain)| chain.last.is_some())
            .map(|(_, chain)| &chain.window[..])
            .collect();
        windows.reverse();
        windows
    }

    /// Returns `true` if the chain returns to a sector of one of its prefixes with the same transform. No path by it is
    /// shorter than the straight one from where it left.
    fn returns(&self, number: usize) -> bool {
        let chain = &self.chains[number];
        let size = extent(&chain.window);
        self.back_from(number).skip(1).any(|(_, before)| {
            before.sector == chain.sector
                && chain.window.iter().all(|&corner| {
                    let here = chain.here_from_start.transform_point3(corner);
                    let rounding = corner.abs().max_element() + here.abs().max_element() / chain.scale;
                    before.start_from_here.transform_point3(here).distance(corner)
                        <= 1e-4 * size + 1e-6 * rounding
                })
        })
    }

    /// Returns `true` if one of the `rivals`, chains to the same sector, reaches every point of the chain's last window
    /// by a path that is no longer. Then it also does for everything behind the window.
    fn is_dominated(&self, number: usize, rivals: &[usize]) -> bool {
        const SLACK: f64 = 1.0 + 1e-9;
        let chain = &self.chains[number];
        let Some((before, _)) = chain.last else {
            return false;
        };
        // Lengths are convex functions on the window. That of the chain is nowhere below its tangent plane at the
        // centre, nor below its minimum; so it suffices that the rival's is below one of these, at the corners only.
        let middle = chain.window.iter().sum::<DVec3>() / chain.window.len() as f64;
        let (to_middle, bend) = way(self.start, &self.windows(before), |_| middle);
        let slope = (middle - bend).normalize_or_zero();
        // If the last bend is close to the centre, the slope there is uncertain.
        let has_slope = middle.distance(bend) > 0.01 * to_middle;
        let is_no_longer = |rival: &usize| {
            let other = &self.chains[*rival];
            // Behind the window, a larger scale makes lengths count less.
            if other.scale * SLACK < chain.scale {
                return false;
            }
            let windows = self.windows(*rival);
            let [mut below_tangent, mut below_minimum] = [has_slope, true];
            chain.window.iter().all(|&corner| {
                let tangent = (to_middle + slope.dot(corner - middle)) * SLACK;
                let minimum = chain.length * SLACK;
                let here = chain.here_from_start.transform_point3(corner);
                let target = other.start_from_here.transform_point3(here);
                // The straight line is an inexpensive lower bound.
                let mut length = self.start.distance(target);
                if (below_tangent && length <= tangent) || (below_minimum && length <= minimum) {
                    length = way(self.start, &windows, |_| target).0;
                }
                below_tangent &= length <= tangent;
                below_minimum &= length <= minimum;
                below_tangent || below_minimum
            })
        };
        rivals.iter().any(is_no_longer)
    }

    /// Adds the items of a chain's sector for which the chain gives the shortest path so far.
    fn take_items(&mut self, number: usize) {
        let chain = &self.chains[number];
        let Some(geometry) = self.scene.geometry(chain.sector) else {
            return;
        };
        let windows: Vec<Vec<DVec3>> = (self.windows(number).into_iter())
            .map(<[DVec3]>::to_vec)
            .collect();
        let windows: Vec<&[DVec3]> = windows.iter().map(Vec::as_slice).collect();
        let mut crossed: Vec<PortalId> = (self.back_from(number))
            .filter_map(|(_, chain)| Some(chain.last?.1))
            .collect();
        crossed.reverse();
        // Bounding box of the entry, in the space of the sector.
        let entry = (chain.window.iter())
            .map(|&corner| chain.here_from_start.transform_point3(corner))
            .fold(None, |sum: Option<[DVec3; 2]>, corner| {
                let [min, max] = sum.unwrap_or([corner; 2]);
                Some([min.min(corner), max.max(corner)])
            });
        let origin = chain.here_from_start.transform_point3(self.start);
        // Unfolded, the path is no shorter than the straight line.
        let reach = self.radius * chain.scale * (1.0 + 1e-9);
        let found = &mut self.found;
        geometry.items_within(origin, reach, |item| {
            let bounds = &geometry.item(item).bounds;
            let known = found.get(&(chain.sector, item)).map(|known| known.distance);
            let beyond = entry.map_or(0.0, |entry| gap(entry, bounds)) / chain.scale;
            if known.is_some_and(|known| known <= chain.length + beyond) {
                return;
            }
            let nearest = |from: DVec3| {
                let here = chain.here_from_start.transform_point3(from);
                (chain.start_from_here).transform_point3(nearest_in_box(bounds, here))
            };
            let (distance, _) = way(self.start, &windows, nearest);
            if distance <= self.radius && known.is_none_or(|known| distance < known) {
                let near = NearItem {
                    sector: chain.sector,
                    item: geometry.id_of(item),
                    key: geometry.key(item),
                    distance,
                    crossed: crossed.clone(),
                };
                found.insert((chain.sector, item), near);
            }
        });
    }
}

/// Returns the longest side of the bounding box of some points.
fn extent(points: &[DVec3]) -> f64 {
    let [min, max] = points
        .iter()
        .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[min, max], &point| {
            [min.min(point), max.max(point)]
        });
    (max - min).max_element()
}

/// Returns the distance between two boxes.
fn gap([min, max]: [DVec3; 2], bounds: &Aabb) -> f64 {
    let [low, high] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
    (low - max).max(min - high).max(DVec3::ZERO).length()
}

fn nearest_in_box(bounds: &Aabb, point: DVec3) -> DVec3 {
    let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
    point.max(min).min(max)
}

/// Returns the unit normal of a convex outline.
fn normal_of(outline: &[DVec3]) -> DVec3 {
    (outline[1..].windows(2))
        .map(|pair| (pair[0] - outline[0]).cross(pair[1] - outline[0]))
        .sum::<DVec3>()
        .normalize_or_zero()
}

/// Returns the reflection in the plane of an outline.
fn reflection(outline: &[DVec3]) -> DAffine3 {
    let n = normal_of(outline);
    DAffine3 {
        matrix3: DMat3::IDENTITY - 2.0 * DMat3::from_cols(n * n.x, n * n.y, n * n.z),
        translation: n * (2.0 * n.dot(outline[0])),
    }
}

/// Returns the length of the shortest path from a point through all windows to the nearest point of a target, and its
/// last bend before the target. The length is up to 0.1 % too long.
fn way(start: DVec3, windows: &[&[DVec3]], nearest: impl Fn(DVec3) -> DVec3) -> (f64, DVec3) {
    if windows.is_empty() {
        return (start.distance(nearest(start)), start);
    }
    let mut bends: Vec<DVec3> = Vec::with_capacity(windows.len() + 2);
    bends.push(start);
    for window in windows {
        bends.push(nearest_in(window, bends[bends.len() - 1]));
    }
    bends.push(nearest(bends[bends.len() - 1]));
    let mut length = shorten(&mut bends, windows, &nearest);
    // Where bends coincide, in windows or items that touch, moving one of them alone never shortens the path.
    let is_stuck = (bends[1..].windows(2)).any(|pair| pair[0].distance(pair[1]) < 0.01 * length);
    if is_stuck {
        smooth(&mut bends, windows, &nearest, length);
        length = length.min(shorten(&mut bends, windows, &nearest));
    }
    (length, bends[windows.len()])
}

/// Returns the length of a path: the sum of the distances between consecutive bends.
fn length_of(bends: &[DVec3]) -> f64 {
    (bends.windows(2)).map(|pair| pair[0].distance(pair[1])).sum()
}

/// Moves one bend at a time to its optimum until the path gets no shorter. Returns its length.
fn shorten(bends: &mut [DVec3], windows: &[&[DVec3]], nearest: impl Fn(DVec3) -> DVec3) -> f64 {
    const ROUNDS: usize = 64;
    let last = bends.len() - 1;
    let mut length = length_of(bends);
    for _ in 0..ROUNDS {
        for (i, window) in (1..).zip(windows) {
            bends[i] = best_between(window, bends[i - 1], bends[i + 1]);
        }
        bends[last] = nearest(bends[last - 1]);
        let before = std::mem::replace(&mut length, length_of(bends));
        if length >= before * (1.0 - 1e-9) {
            break;
        }
    }
    length
}

/// Moves the bends to the minimum of the sum of √(distance² + slack²), for a slack that shrinks from a tenth of the
/// `length` of the path to nearly 0. That sum has no points where bends get stuck.
///
/// Source: Weiszfeld, 1937: each bend moves to the mean of its neighbours, weighted by inverse distance.
fn smooth(bends: &mut [DVec3], windows: &[&[DVec3]], nearest: impl Fn(DVec3) -> DVec3, length: f64) {
    let last = bends.len() - 1;
    let mut slack = 0.1 * length;
    while slack > 1e-5 * length {
        for (i, window) in (1..).zip(windows) {
            let [from, to] = [bends[i - 1], bends[i + 1]];
            let [back, on] = [from, to].map(|end| 1.0 / end.distance(bends[i]).hypot(slack));
            bends[i] = nearest_in(window, (from * back + to * on) / (back + on));
        }
        bends[last] = nearest(bends[last - 1]);
        slack *= 0.85;
    }
}

/// Returns the point of a convex outline on the shortest path from one point to another.
fn best_between(window: &[DVec3], from: DVec3, to: DVec3) -> DVec3 {
    let normal = normal_of(window);
    let [here, there] = [from, to].map(|point| normal.dot(point - window[0]));
    // If both are on one side, the length equals that to the mirror image of the other.
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
        // A doorway from x = 0 to 1 in the plane z = 0; both ends are to the left of it.
        let door = [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        let start = DVec3::new(-3.0, 1.0, 4.0);
        let target = DVec3::new(-8.0, 1.0, -6.0);
        let (length, bend) = way(start, &[&door[..]], |_| target);
        assert!((length - (5.0 + 10.0)).abs() < 1e-9);
        assert!(bend.distance(DVec3::new(0.0, 1.0, 0.0)) < 1e-6);
        let straight = DVec3::new(4.0, 1.0, -4.0);
        let (length, _) = way(start, &[&door[..]], |_| straight);
        assert!((length - DVec3::new(7.0, 0.0, 8.0).length()).abs() < 1e-9);
    }
}
