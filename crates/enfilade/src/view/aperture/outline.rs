//! The convex outline of an aperture: an opening clipped by the openings before it.

use glam::{DVec2, DVec3};
use smallvec::{SmallVec, smallvec};

/// Maximum number of corners; an outline with more is replaced by a larger one with this many.
const MAX_CORNERS: usize = 16;

/// Corners on the screen, in pixels, y down, counter-clockwise.
pub(super) type Outline = SmallVec<[[f64; 2]; MAX_CORNERS]>;

/// Corners of an opening before and after clipping, as (X, Y, W).
type Corners = SmallVec<[DVec3; 2 * MAX_CORNERS]>;

/// Points on the screen whose convex hull is an outline.
type Points = SmallVec<[[f64; 2]; 2 * MAX_CORNERS]>;

/// Clips an opening, given by its corners as (X, Y, W), to an aperture's outline; returns the convex hull of its
/// clipped triangles.
///
/// Corners in f32 are never exactly coplanar, so an opening that is almost edge-on need not project to a convex
/// outline; hence the hull. Clips in homogeneous coordinates, by the planes through the eye and the edges of `parent`,
/// before the division by W: this removes what is behind the eye, and keeps an opening that contains the eye.
pub(super) fn within(parent: &Outline, opening: impl Iterator<Item = DVec3>) -> Outline {
    let opening: Corners = opening.collect();
    let homogeneous = |point: [f64; 2]| DVec3::new(point[0], point[1], 1.0);
    let mut hull = Points::new();
    for last in 2..opening.len() {
        let mut corners: Corners = smallvec![opening[0], opening[last - 1], opening[last]];
        for (i, &from) in parent.iter().enumerate() {
            let to = parent[(i + 1) % parent.len()];
            // The outline is counter-clockwise on a screen with y down: inside is on the left.
            let plane = homogeneous(to).cross(homogeneous(from));
            corners = clip_by(plane, &corners);
        }
        if corners.iter().any(|corner| corner.z <= 0.0) {
            // The eye is on the outline itself: all of this aperture may be visible through it.
            return parent.clone();
        }
        // Hull after each triangle: the points of all triangles would be three times as many.
        hull.extend(corners.iter().map(|c| [c.x / c.z, c.y / c.z]));
        hull = convex_hull(hull);
    }
    widen(&mut hull, MAX_CORNERS);
    hull.into_iter().collect()
}

/// As [`within`], with the opening grown by `margin` pixels first: all positions of `parent` that are at most `margin` away from
/// it along each axis. Does not grow `parent`, in which the margins of the openings before are.
pub(super) fn within_grown(parent: &Outline, opening: impl Iterator<Item = DVec3>, margin: f64) -> Outline {
    if margin == 0.0 {
        return within(parent, opening);
    }
    // Before the division by W nothing can grow, so clip what is far off first.
    let near = within(&grown(parent, margin), opening);
    let opening = grown(&near, margin).into_iter();
    within(parent, opening.map(|[x, y]| DVec3::new(x, y, 1.0)))
}

/// Returns the outline with a square of twice `margin` pixels around each corner.
fn grown(outline: &Outline, margin: f64) -> Outline {
    let corner =
        |&[x, y]: &[f64; 2]| [-margin, margin].map(|dx| [-margin, margin].map(|dy| [x + dx, y + dy]));
    let mut hull = convex_hull(outline.iter().flat_map(corner).flatten().collect());
    widen(&mut hull, MAX_CORNERS);
    hull.into_iter().collect()
}

/// Number of steps per pixel to which hull points are rounded. Triangles that share a corner clip it to positions that
/// differ by rounding; without this step the turns of the hull would be rounding errors, and it would not be convex. A
/// step is far smaller than the slack of sample tests (10⁻⁶ pixel).
const STEPS: f64 = (1 << 26) as f64;

/// Returns the convex hull of points, counter-clockwise on a screen with y down.
///
/// Source: Andrew, Another Efficient Algorithm for Convex Hulls in Two Dimensions, Information Processing Letters 9, 1979.
fn convex_hull(mut points: Points) -> Points {
    for point in &mut points {
        // Adding 0.0 removes negative zero, which `total_cmp` sorts before zero.
        *point = point.map(|place| (place * STEPS).round() / STEPS + 0.0);
    }
    points.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    let mut hull = Points::new();
    // Upper chain, then lower chain; the first point ends the second.
    let chain = |hull: &mut Points, points: &mut dyn Iterator<Item = &[f64; 2]>| {
        let first = hull.len();
        for &point in points {
            while let [.., a, b] = hull[first..] {
                let [a, b, point] = [a, b, point].map(DVec2::from);
                if (b - a).perp_dot(point - b) < 0.0 {
                    break;
                }
                hull.pop();
            }
            hull.push(point);
        }
        hull.pop();
    };
    chain(&mut hull, &mut points.iter());
    chain(&mut hull, &mut points.iter().rev());
    hull
}

/// Removes edges until `most` are left, each time the edge that adds the least area. The neighbours of a removed edge
/// are extended until they intersect, so the outline never shrinks.
fn widen(outline: &mut Points, most: usize) {
    while outline.len() > most {
        let count = outline.len();
        let corner = |i: usize| DVec2::from(outline[i % count]);
        let without = |i: usize| {
            let [before, start, end, after] = [i + count - 1, i, i + 1, i + 2].map(corner);
            let [along, back] = [start - before, end - after];
            let part = (end - start).perp_dot(back) / along.perp_dot(back);
            let tip = start + along * part;
            // Neighbours that diverge, or nearly so, never intersect.
            let meets = part >= 0.0 && (tip - end).dot(back) >= 0.0;
            let added = (end - start).perp_dot(tip - start).abs();
            (meets && added.is_finite()).then_some((added, i, tip))
        };
        let best = (0..count).filter_map(without).min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, i, tip)) = best else { return };
        outline[i] = tip.into();
        outline.remove((i + 1) % count);
    }
}

/// Clips a polygon by a plane through the eye; keeps the side that `plane` points to.
fn clip_by(plane: DVec3, corners: &[DVec3]) -> Corners {
    let mut kept = Corners::new();
    for (i, &corner) in corners.iter().enumerate() {
        let next = corners[(i + 1) % corners.len()];
        let [here, there] = [plane.dot(corner), plane.dot(next)];
        if here >= 0.0 {
            kept.push(corner);
        }
        if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
            kept.push(corner + (next - corner) * (here / (here - there)));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_outline_that_is_not_convex_as_seen_is_widened_until_it_is() {
        let screen: Outline = smallvec![[0.0, 0.0], [0.0, 100.0], [100.0, 100.0], [100.0, 0.0]];
        // The third corner is bent inwards, the others are those of a square.
        let bent =
            [[20.0, 20.0], [20.0, 80.0], [30.0, 40.0], [80.0, 20.0]].map(|[x, y]| DVec3::new(x, y, 1.0));
        let outline = within(&screen, bent.into_iter());
        assert_eq!(outline[..], [[20.0, 20.0], [20.0, 80.0], [80.0, 20.0]]);
        assert_eq!(within(&screen, bent.into_iter().rev()), outline);
    }

    #[test]
    fn openings_one_behind_another_grow_once_and_no_further() {
        let square = |low: f64, high: f64| {
            [[low, low], [low, high], [high, high], [high, low]].map(|[x, y]| DVec3::new(x, y, 1.0))
        };
        let screen: Outline = smallvec![[0.0, 0.0], [0.0, 100.0], [100.0, 100.0], [100.0, 0.0]];
        let first = within_grown(&screen, square(20.0, 40.0).into_iter(), 1.0);
        assert_eq!(
            first[..],
            [[19.0, 19.0], [19.0, 41.0], [41.0, 41.0], [41.0, 19.0]]
        );
        assert_eq!(within_grown(&first, square(20.0, 40.0).into_iter(), 1.0), first);
        // Beside the first, but not farther than both grow.
        let beside = within_grown(&first, square(41.5, 60.0).into_iter(), 1.0);
        assert_eq!(
            beside[..],
            [[40.5, 40.5], [40.5, 41.0], [41.0, 41.0], [41.0, 40.5]]
        );
        assert!(within_grown(&first, square(42.5, 60.0).into_iter(), 1.0).is_empty());
    }

    #[test]
    fn a_hull_of_points_that_rounding_parts_is_convex() {
        let corner = |i: usize| {
            let angle = -(i as f64) * std::f64::consts::TAU / 20.0;
            [100.0 + 50.0 * angle.cos(), 80.0 + 30.0 * angle.sin()]
        };
        // Each corner several times, as clipped triangles that share it leave it.
        let noise = |i: usize| [(i % 3) as f64 * 1e-14, (i % 2) as f64 * 1.5e-14];
        let points = (0..80).map(|i| [0, 1].map(|axis| corner(i / 4)[axis] + noise(i)[axis]));
        let mut hull = convex_hull(points.collect());
        assert_eq!(hull.len(), 20);
        widen(&mut hull, MAX_CORNERS);
        for i in 0..20 {
            let point = DVec2::from(corner(i));
            for (side, &from) in hull.iter().enumerate() {
                let [from, to] = [from, hull[(side + 1) % hull.len()]].map(DVec2::from);
                let off = (to - from).normalize().perp_dot(point - from);
                assert!(off <= 2e-8, "corner {point:?} is {off} outside");
            }
        }
    }

    #[test]
    fn a_hull_keeps_both_ends_of_an_upright_edge() {
        // Rounding gives the corners of a vertical edge slightly different columns.
        let points: Points = [[0.0, 0.0], [1e-14, 100.0], [2e-14, 50.0], [80.0, 0.0]]
            .into_iter()
            .collect();
        assert_eq!(convex_hull(points)[..], [[0.0, 0.0], [0.0, 100.0], [80.0, 0.0]]);
    }

    #[test]
    fn an_outline_of_many_corners_becomes_a_wider_one_of_few() {
        let corner = |i: usize| {
            let angle = -(i as f64) * std::f64::consts::TAU / 40.0;
            [100.0 + 50.0 * angle.cos(), 80.0 + 30.0 * angle.sin()]
        };
        let round: Points = (0..40).map(corner).collect();
        let mut wider = round.clone();
        widen(&mut wider, MAX_CORNERS);
        assert_eq!(wider.len(), MAX_CORNERS);
        let area = |outline: &Points| -> f64 {
            let pairs = (0..outline.len()).map(|i| (outline[i], outline[(i + 1) % outline.len()]));
            0.5 * pairs.map(|(a, b)| a[1] * b[0] - a[0] * b[1]).sum::<f64>()
        };
        assert!(area(&wider) > area(&round) && area(&wider) < 1.05 * area(&round));
        for &point in &round {
            for (i, &from) in wider.iter().enumerate() {
                let [from, to] = [from, wider[(i + 1) % wider.len()]].map(DVec2::from);
                let off = (to - from).normalize().perp_dot(DVec2::from(point) - from);
                assert!(off <= 1e-9, "corner {point:?} is {off} outside");
            }
        }
    }
}
