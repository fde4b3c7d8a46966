//! Tests the leaves found for polygons and boxes against random points of them.

use super::tree::{Leaf, Room};
use super::{BakedCells, CellNode, CellSide, CellTree};
use crate::chance::Dice;
use crate::geom::Aabb;
use crate::ids::CellId;
use glam::DVec3;
use std::collections::BTreeSet;

/// Returns a number from −1 to 1; often a multiple of ¼, so that points are exactly in planes.
fn unit(dice: &mut Dice) -> f64 {
    let value = dice.within(1.0);
    if dice.below(2) == 0 {
        value
    } else {
        (value * 4.0).round() / 4.0
    }
}

fn point(dice: &mut Dice) -> DVec3 {
    DVec3::new(unit(dice), unit(dice), unit(dice))
}

/// Returns a tree of random planes, in which every leaf is a separate cell.
fn random_cells(dice: &mut Dice, size: f64) -> BakedCells {
    const NODES: u32 = 63;
    let mut next_cell = 0;
    let mut side = |child: u32| {
        if child < NODES {
            return CellSide::Node(child);
        }
        next_cell += 1;
        CellSide::Cell(CellId(next_cell - 1))
    };
    let nodes = (0..NODES).map(|number| {
        let mut normal = point(dice);
        if normal.length() < 0.1 {
            normal = DVec3::X;
        }
        CellNode {
            normal: normal.to_array(),
            distance: size * normal.dot(point(dice)),
            front: side(2 * number + 1),
            back: side(2 * number + 2),
        }
    });
    let nodes: Vec<CellNode> = nodes.collect();
    let tree = CellTree {
        root: CellSide::Node(0),
        nodes,
        tolerance: 0.0,
    };
    BakedCells::new(tree, &[None; NODES as usize + 1], [[]; 0]).expect("a full tree")
}

#[test]
fn every_cell_that_a_point_of_a_triangle_is_in_is_touched_and_few_others() {
    let mut dice = Dice::new(1);
    let [mut in_cells, mut touched, mut in_hulls] = [0; 3];
    for round in 0..400 {
        let size = [1.0, 1e-3, 1e6, 1e30][round % 4];
        let cells = random_cells(&mut dice, size);
        let mut room = Room::default();
        for _ in 0..20 {
            let corners = [point(&mut dice), point(&mut dice), point(&mut dice)].map(|corner| corner * size);
            let mut found: [BTreeSet<CellId>; 2] = Default::default();
            for (is_hull, found) in found.iter_mut().enumerate() {
                if is_hull == 1 {
                    room.hull(corners);
                } else {
                    room.outline(corners);
                }
                let all = cells.touched(cells.tree().root, &mut room, |leaf| {
                    found.extend(match leaf {
                        Leaf::Cell(cell) => Some(cell),
                        Leaf::Solid { .. } => None,
                    });
                    true
                });
                assert!(all);
            }
            let mut really = BTreeSet::new();
            for _ in 0..200 {
                let [a, b] = [unit(&mut dice).abs(), unit(&mut dice).abs()];
                let [a, b] = if a + b > 1.0 { [1.0 - a, 1.0 - b] } else { [a, b] };
                let point = corners[0] + (corners[1] - corners[0]) * a + (corners[2] - corners[0]) * b;
                really.extend(cells.cell_at(point.to_array()));
            }
            assert!(
                really.is_subset(&found[0]),
                "{corners:?}: {really:?}, but {:?}",
                found[0]
            );
            assert!(found[0].is_subset(&found[1]));
            in_cells += really.len();
            touched += found[0].len();
            in_hulls += found[1].len();
        }
    }
    assert!(
        in_cells > 8000 && 2 * touched < 3 * in_cells,
        "{in_cells}, {touched}, {in_hulls}"
    );
    assert!(touched < in_hulls, "{touched}, {in_hulls}");
}

#[test]
fn all_that_a_box_reaches_into_is_below_what_is_around_it() {
    let mut dice = Dice::new(2);
    let mut below = 0;
    for _ in 0..200 {
        let cells = random_cells(&mut dice, 1.0);
        for _ in 0..20 {
            let corner = point(&mut dice).as_vec3();
            let bounds = Aabb::of([corner, corner + point(&mut dice).as_vec3() * 0.1].map(Into::into));
            let top = cells.around(&bounds);
            below += usize::from(top != cells.tree().root);
            let mut room = Room::default();
            let mut all: [BTreeSet<CellId>; 2] = Default::default();
            for (top, all) in [cells.tree().root, top].into_iter().zip(&mut all) {
                room.hull(bounds.corners().map(|corner| DVec3::from(corner.map(f64::from))));
                cells.touched(top, &mut room, |leaf| {
                    all.extend(match leaf {
                        Leaf::Cell(cell) => Some(cell),
                        Leaf::Solid { .. } => None,
                    });
                    true
                });
            }
            assert_eq!(all[0], all[1]);
        }
    }
    assert!(below > 3000, "{below}");
}

#[test]
fn what_is_no_number_is_everywhere() {
    let cells = random_cells(&mut Dice::new(3), 1.0);
    let mut room = Room::default();
    for bad in [f64::NAN, f64::INFINITY] {
        room.outline([DVec3::ZERO, DVec3::X, DVec3::new(bad, 0.0, 0.0)]);
        assert!(!cells.touched(cells.tree().root, &mut room, |_| true));
    }
}
