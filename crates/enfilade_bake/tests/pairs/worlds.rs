//! Random worlds: a box split into boxes, with holes in the walls between, optionally sheared.

use enfilade_bake::{Cells, Portal, Witness};
use glam::DVec3;

/// Random numbers, reproducible by seed.
pub(crate) struct Random(fastrand::Rng);

impl Random {
    pub(crate) fn new(seed: u64) -> Random {
        Random(fastrand::Rng::with_seed(seed))
    }

    /// Returns a number in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        self.0.f64()
    }
}

type Span = [f64; 2];

/// Creates `count` rooms. Worlds with even seeds are axis-aligned on integers, as maps are; the others are sheared.
pub(crate) fn random(seed: u64, count: usize) -> Cells {
    let random = &mut Random::new(seed);
    let mut boxes: Vec<[Span; 3]> = vec![[[0.0, 1024.0], [0.0, 1024.0], [0.0, 512.0]]];
    while boxes.len() < count {
        // Split the largest box across its longest side, near the middle.
        let size = |of: &[Span; 3]| of.iter().map(|[from, to]| to - from).product::<f64>();
        let largest = (0..boxes.len())
            .max_by(|&a, &b| size(&boxes[a]).total_cmp(&size(&boxes[b])))
            .expect("one");
        let mut low = boxes.swap_remove(largest);
        let mut high = low;
        let long = |axis: &usize| low[*axis][1] - low[*axis][0];
        let axis = (0..3).max_by(|a, b| long(a).total_cmp(&long(b))).expect("three");
        let [from, to] = low[axis];
        let at = (from + (to - from) * (0.3 + 0.4 * random.unit())).round();
        low[axis][1] = at;
        high[axis][0] = at;
        boxes.extend([low, high]);
    }
    let slant = slant(seed, random);
    let mut portals = Vec::new();
    for (a, low) in boxes.iter().enumerate() {
        for (b, high) in boxes.iter().enumerate() {
            for axis in (0..3).filter(|&axis| low[axis][1] == high[axis][0]) {
                let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
                let shared = |axis: usize| [low[axis][0].max(high[axis][0]), low[axis][1].min(high[axis][1])];
                let hole = [hole(shared(u), random), hole(shared(v), random)];
                if hole.iter().any(|[from, to]| to - from < 4.0) || random.unit() < 0.25 {
                    continue;
                }
                let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(at_u, at_v)| {
                    let mut corner = [0.0; 3];
                    corner[axis] = low[axis][1];
                    corner[u] = hole[0][at_u];
                    corner[v] = hole[1][at_v];
                    slant.map(|row: [f64; 3]| row[0] * corner[0] + row[1] * corner[1] + row[2] * corner[2])
                });
                portals.push(Portal {
                    corners: corners.to_vec(),
                    cells: [a as u32, b as u32],
                });
            }
        }
    }
    Cells::new(boxes.len() as u32, portals).expect("a world")
}

/// Returns the extent of a hole: about a third fill the shared wall, the others a part of it, on integers.
fn hole([from, to]: Span, random: &mut Random) -> Span {
    if to <= from || random.unit() < 0.3 {
        return [from, to];
    }
    let a = from + (to - from) * random.unit() * 0.6;
    let b = a + (to - a) * (0.2 + 0.8 * random.unit());
    [a.round(), b.round()]
}

/// Returns a matrix with positive determinant.
fn slant(seed: u64, random: &mut Random) -> [[f64; 3]; 3] {
    let mut rows = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    if seed % 2 == 1 {
        for row in &mut rows {
            for entry in row {
                *entry += 0.3 * (random.unit() - 0.5);
            }
        }
    }
    rows
}

/// Verifies that a line of sight passes from cell to cell, each time inside a portal and forwards.
#[track_caller]
pub(crate) fn follow(cells: &Cells, line: &Witness) {
    let [origin, direction] = [line.origin, line.direction].map(DVec3::from);
    let mut far = f64::NEG_INFINITY;
    for pair in line.cells.windows(2) {
        let crossed = cells.portals().iter().find_map(|portal| {
            let mut corners: Vec<DVec3> = portal.corners.iter().map(|&corner| corner.into()).collect();
            if portal.cells == [pair[1], pair[0]] {
                corners.reverse();
            } else if portal.cells != [pair[0], pair[1]] {
                return None;
            }
            let edges = || (0..corners.len()).map(|at| [corners[at], corners[(at + 1) % corners.len()]]);
            let normal: DVec3 = edges().map(|[from, to]| from.cross(to)).sum();
            let inside = edges().all(|[from, to]| direction.dot((from - origin).cross(to - origin)) > 0.0);
            let along = (corners[0] - origin).dot(normal) / direction.dot(normal);
            (inside && direction.dot(normal) > 0.0).then_some(along)
        });
        let along = crossed.unwrap_or_else(|| panic!("no portal from {} to {}", pair[0], pair[1]));
        assert!(along > far - 1e-6, "the line goes on");
        far = along;
    }
}
