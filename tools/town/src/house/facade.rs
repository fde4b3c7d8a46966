//! One outer wall of a house: strips with holes for windows and doors, and the mouldings that cover their joints.
//!
//! The frame of a facade has its origin at the lower left corner seen from outside, x to the right, y up and z
//! outward.

use super::House;
use crate::material::Material;
use crate::mesh::{End, Mesh, arc};
use crate::vector::{Frame, v};

/// Thickness of outer walls.
pub(super) const WALL: f64 = 0.3;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Use {
    Window,
    Balcony,
    Door,
    Shop,
    Passage,
}

/// A hole in a facade; its upper end is below the next floor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Opening {
    pub(super) low: [f64; 2],
    pub(super) high: [f64; 2],
    pub(super) kind: Use,
}

/// The openings of one facade, by storey.
pub(super) struct Facade {
    pub(super) frame: Frame,
    pub(super) width: f64,
    pub(super) faces_street: bool,
    /// Ends of cornices, left and right: mitred at a corner between two streets.
    pub(super) ends: [End; 2],
    pub(super) storeys: Vec<Vec<Opening>>,
}

impl Facade {
    /// Returns how far rooms behind the facade keep from its ends: at a street corner the niches of the other
    /// facade's windows are between.
    pub(super) fn clearance(&self) -> [f64; 2] {
        self.ends
            .map(|end| if end == End::Mitre { WALL + 0.4 } else { WALL / 2.0 })
    }
}

/// Adds a wall between two heights, with holes, without T-junctions within the strip.
pub(super) fn strip(mesh: &mut Mesh, width: f64, [bottom, top]: [f64; 2], z: f64, holes: &[Opening]) {
    let cuts = |axis: usize, ends: [f64; 2]| {
        let mut cuts = ends.to_vec();
        cuts.extend(holes.iter().flat_map(|hole| [hole.low[axis], hole.high[axis]]));
        cuts.sort_by(f64::total_cmp);
        cuts.dedup_by(|a, b| (*a - *b).abs() < 1e-3);
        cuts
    };
    let [across, up] = [cuts(0, [0.0, width]), cuts(1, [bottom, top])];
    for x in across.windows(2) {
        for y in up.windows(2) {
            let middle = [(x[0] + x[1]) / 2.0, (y[0] + y[1]) / 2.0];
            let open = holes.iter().any(|hole| {
                (0..2).all(|axis| hole.low[axis] < middle[axis] && middle[axis] < hole.high[axis])
            });
            if !open {
                mesh.quad(
                    v(x[0], y[0], z),
                    v(x[1], y[0], z),
                    v(x[1], y[1], z),
                    v(x[0], y[1], z),
                );
            }
        }
    }
}

/// Adds the wall of a facade from the ground to the eaves.
pub(super) fn wall(mesh: &mut Mesh, house: &House, facade: &Facade) {
    mesh.frame = facade.frame;
    for (storey, openings) in facade.storeys.iter().enumerate() {
        let bottom = if storey == 0 { 0.0 } else { house.floors[storey] };
        let top = house.floors.get(storey + 1).copied().unwrap_or(house.eaves);
        mesh.material = if storey == 0 { house.base } else { house.wall };
        strip(mesh, facade.width, [bottom, top], 0.0, openings);
    }
    mesh.material = Material::Stone;
    plinth(mesh, house, facade);
    for &floor in &house.floors[1..] {
        let mut course = vec![(floor - 0.1, 0.0), (floor - 0.1, 0.04)];
        let round = mesh.segments(3.0, 1);
        course.extend(arc((floor, 0.04), 0.05, [2.0, 0.0], round + 1));
        course.push((floor + 0.055, 0.0));
        mesh.extrude([0.0, facade.width], &course, facade.ends);
    }
    cornice(mesh, house, facade);
    if facade.faces_street {
        quoins(mesh, house, facade);
    }
}

/// Adds a base of stones, interrupted by what reaches the ground.
fn plinth(mesh: &mut Mesh, house: &House, facade: &Facade) {
    let mut gaps: Vec<[f64; 2]> = (facade.storeys[0].iter())
        .filter(|opening| opening.low[1] < house.floors[0] + 0.2)
        .map(|opening| [opening.low[0] - 0.15, opening.high[0] + 0.15])
        .collect();
    gaps.push([facade.width; 2]);
    let top = house.floors[0] - 0.04;
    let profile = [(0.0, 0.0), (0.0, 0.06), (top - 0.05, 0.06), (top, 0.0)];
    let mut start = 0.0;
    for [from, to] in gaps {
        let length = from - start;
        if length > 0.1 {
            let size = mesh.piece(0.7, [0.3, 1.5]);
            let count = (length / size).round().max(1.0) as usize;
            for i in 0..count {
                let [x0, x1] = [i, i + 1].map(|i| start + length * i as f64 / count as f64);
                let joint = |end: End, at_end: bool| {
                    if at_end && end == End::Mitre {
                        end
                    } else {
                        End::Cap
                    }
                };
                let first = joint(facade.ends[0], start == 0.0 && i == 0);
                let last = joint(facade.ends[1], from == facade.width && i + 1 == count);
                let x0 = if first == End::Cap { x0 + 0.006 } else { x0 };
                mesh.extrude([x0, x1], &profile, [first, last]);
            }
        }
        start = to;
    }
}

/// Adds the moulding below the eaves, with a row of dentils.
fn cornice(mesh: &mut Mesh, house: &House, facade: &Facade) {
    let y = house.soffit() + 0.2;
    let round = mesh.segments(5.0, 1);
    let mut profile = vec![(y - 0.62, 0.0), (y - 0.62, 0.03), (y - 0.5, 0.03)];
    profile.extend(arc((y - 0.5, 0.15), 0.1, [-1.0, 0.0], round));
    profile.extend([(y - 0.36, 0.15), (y - 0.36, 0.2)]);
    profile.extend(arc((y - 0.34, 0.3), 0.1, [-1.0, 0.0], round));
    profile.extend([(y - 0.2, 0.3), (y - 0.2, 0.0)]);
    mesh.extrude([0.0, facade.width], &profile, facade.ends);
    let size = mesh.piece(0.16, [0.1, 0.5]);
    let count = (facade.width / size) as usize;
    for i in 0..count {
        let x = (i as f64 + 0.3) * facade.width / count as f64;
        mesh.cuboid(v(x, y - 0.45, 0.0), v(x + 0.45 * size, y - 0.37, 0.19));
    }
}

/// Adds corner stones at both ends, long and short in turn.
fn quoins(mesh: &mut Mesh, house: &House, facade: &Facade) {
    let [bottom, top] = [house.floors[0], house.soffit() - 0.45];
    let size = mesh.piece(0.36, [0.25, 0.6]);
    let count = ((top - bottom) / size) as usize;
    for i in 0..count {
        let [y0, y1] = [i, i + 1].map(|i| bottom + (top - bottom) * i as f64 / count as f64);
        let length = if i % 2 == 0 { 0.45 } else { 0.3 };
        let out = 0.03 + mesh.random.between(0.0, 0.01);
        let profile = [
            (y0 + 0.01, 0.0),
            (y0 + 0.02, out),
            (y1 - 0.01, out),
            (y1 - 0.005, 0.0),
        ];
        let inner = |end: End| if end == End::Mitre { end } else { End::Cap };
        mesh.extrude([0.0, length], &profile, [inner(facade.ends[0]), End::Cap]);
        let right = [facade.width - length, facade.width];
        mesh.extrude(right, &profile, [End::Cap, inner(facade.ends[1])]);
    }
}
