//! The flow without optimizations: every chain, every plane through an edge and a corner, no caches.

use enfilade_bake::Cells;
use glam::DVec3;

struct Way {
    corners: Vec<DVec3>,
    from: usize,
    to: usize,
}

/// Larger than any rounding error in these worlds.
const SLACK: f64 = 1e-7;

/// Returns for each pair of cells whether they may see each other.
pub(crate) fn pairs(cells: &Cells) -> Vec<Vec<bool>> {
    let mut ways = Vec::new();
    for portal in cells.portals() {
        let corners: Vec<DVec3> = portal.corners.iter().map(|&corner| corner.into()).collect();
        let [from, to] = portal.cells.map(|cell| cell as usize);
        let back = corners.iter().rev().copied().collect();
        ways.push(Way { corners, from, to });
        ways.push(Way {
            corners: back,
            from: to,
            to: from,
        });
    }
    let count = cells.count() as usize;
    let mut seen = vec![vec![false; count]; count];
    (0..count).for_each(|cell| seen[cell][cell] = true);
    for source in &ways {
        let row = &mut seen[source.from];
        row[source.to] = true;
        follow(
            &ways,
            source,
            &source.corners,
            None,
            &mut vec![source.from, source.to],
            row,
        );
    }
    // Keep a pair if either end does: the optimized flow runs from one end only, whichever is cheaper.
    let one_end = seen.clone();
    for (to, row) in one_end.iter().enumerate() {
        let seers = row.iter().enumerate().filter(|&(_, &sees)| sees);
        seers.for_each(|(from, _)| seen[from][to] = true);
    }
    seen
}

fn follow(
    ways: &[Way],
    first: &Way,
    source: &[DVec3],
    pass: Option<&[DVec3]>,
    chain: &mut Vec<usize>,
    row: &mut [bool],
) {
    let cell = chain[chain.len() - 1];
    for way in ways.iter().filter(|way| way.from == cell) {
        if chain.contains(&way.to) {
            continue;
        }
        let Some(mut target) = cut(&way.corners, &plane(&first.corners)) else {
            continue;
        };
        let away = plane(&way.corners);
        let Some(mut left) = cut(source, &(-away.0, -away.1)) else {
            continue;
        };
        if let Some(pass) = pass {
            let Some(seen) = cut_all(&target, &planes(source, pass)) else {
                continue;
            };
            target = seen;
            let Some(rest) = cut_all(&left, &planes(&target, pass)) else {
                continue;
            };
            left = rest;
        }
        row[way.to] = true;
        chain.push(way.to);
        follow(ways, first, &left, Some(&target), chain, row);
        chain.pop();
    }
}

fn plane(corners: &[DVec3]) -> (DVec3, f64) {
    let normal = (corners[1] - corners[0])
        .cross(corners[2] - corners[0])
        .normalize();
    (normal, normal.dot(corners[0]))
}

/// Returns all planes through an edge of one and a corner of the other with the first below and the second above.
fn planes(below: &[DVec3], above: &[DVec3]) -> Vec<(DVec3, f64)> {
    let mut found = Vec::new();
    for (edged, other) in [(below, above), (above, below)] {
        for at in 0..edged.len() {
            let [from, to] = [edged[at], edged[(at + 1) % edged.len()]];
            for &corner in other {
                let cross = (to - from).cross(corner - from);
                if cross.length() < 1e-3 * (to - from).length() {
                    continue;
                }
                for normal in [cross.normalize(), -cross.normalize()] {
                    let offset = normal.dot(from);
                    let parts = below.iter().all(|&at| normal.dot(at) <= offset + SLACK * 0.1)
                        && above.iter().all(|&at| normal.dot(at) >= offset - SLACK * 0.1);
                    if parts {
                        found.push((normal, offset));
                    }
                }
            }
        }
    }
    found
}

fn cut_all(corners: &[DVec3], planes: &[(DVec3, f64)]) -> Option<Vec<DVec3>> {
    planes
        .iter()
        .try_fold(corners.to_vec(), |left, plane| cut(&left, plane))
}

fn cut(corners: &[DVec3], &(normal, offset): &(DVec3, f64)) -> Option<Vec<DVec3>> {
    let above = |at: DVec3| normal.dot(at) - offset + SLACK;
    let mut left = Vec::new();
    for at in 0..corners.len() {
        let [here, next] = [corners[at], corners[(at + 1) % corners.len()]];
        if above(here) >= 0.0 {
            left.push(here);
        }
        if (above(here) >= 0.0) != (above(next) >= 0.0) {
            left.push(here.lerp(next, above(here) / (above(here) - above(next))));
        }
    }
    (left.len() >= 3).then_some(left)
}
