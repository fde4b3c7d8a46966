//! Small scenes, one for each error that is easily made.

use super::*;
use crate::geom::ConvexPolygon;

/// A camera at the origin that looks along −z with a field of view of 90 degrees: the screen is 2 wide at distance 1.
fn square(side: u32) -> Passage {
    let camera = Camera {
        fov_y: 90.0_f32.to_radians(),
        ..Camera::new([0.0; 3], [0.0, 0.0, -1.0])
    };
    let view = camera.view([side, side]).expect("a valid view");
    Passage::at_the_eye(&view, SectorId(0), false)
}

/// A rectangle parallel to the screen at a distance, given by its position on the screen of [`square`], in pixels.
fn pane(passage: &Passage, [left, top, right, bottom]: [f64; 4], distance: f64) -> Polygon {
    let half = 0.5 * f64::from(passage.size[0]);
    let at = |x: f64, y: f64| DVec3::new((x - half) / half, (half - y) / half, -1.0) * distance;
    Polygon::new(
        &[at(left, top), at(left, bottom), at(right, bottom), at(right, top)],
        passage,
    )
}

/// Returns a buffer with these occluders.
fn covered(passage: &Passage, polygons: &[Polygon]) -> MaskedDepth {
    let mut cover = MaskedDepth::default();
    cover.clear(passage);
    for polygon in polygons {
        cover.hide(&polygon.occluder(), passage, &mut Stats::default());
    }
    cover
}

/// Whether a box, given by its minimum and maximum corner in the space of the sector, may be visible.
fn sees(cover: &mut MaskedDepth, passage: &Passage, min: [f64; 3], max: [f64; 3]) -> bool {
    let [min, max] = [min, max].map(DVec3::from);
    let box_to_sector = DAffine3::from_translation(min) * DAffine3::from_scale(max - min);
    region_of(passage, &box_to_sector).is_some_and(|region| cover.test(&region) != Visibility::Hidden)
}

#[test]
fn a_wall_hides_what_is_behind_it_and_nothing_else() {
    let passage = square(100);
    let mut cover = covered(&passage, &[pane(&passage, [20.0, 20.0, 80.0, 80.0], 5.0)]);
    assert!(!sees(&mut cover, &passage, [-2.0, -2.0, -9.0], [2.0, 2.0, -8.0]));
    assert!(sees(&mut cover, &passage, [-2.0, -2.0, -4.0], [2.0, 2.0, -3.0]));
    assert!(sees(&mut cover, &passage, [-2.0, -2.0, -9.0], [6.0, 2.0, -8.0]));
    assert!(
        sees(&mut cover, &passage, [-2.0, -2.0, -9.0], [2.0, 2.0, -4.9]),
        "part of it is before the wall"
    );
}

#[test]
fn a_post_near_the_eye_displaces_nothing_beside_it() {
    let passage = square(100);
    let far = pane(&passage, [0.0, 0.0, 100.0, 100.0], 100.0);
    let board = pane(&passage, [4.0, 2.0, 12.0, 14.0], 10.0);
    // In the same tile.
    let post = pane(&passage, [20.0, 0.0, 32.0, 100.0], 1.0);
    let depth_of_board = |polygons: &[Polygon]| covered(&passage, polygons).grid.rev_depth_at(8, 8);
    let alone = depth_of_board(&[far.clone(), board.clone()]);
    assert!(alone > 0.09, "{alone}");
    assert_eq!(depth_of_board(&[far, board, post]), alone);
}

#[test]
fn the_part_of_a_wall_behind_a_doorway_hides_what_is_behind_it() {
    let mut passage = square(100);
    passage.entry = Some((DVec3::Z, 2.0));
    // It crosses the plane of the doorway in the middle of the screen.
    let corners = [
        [-1.0, -9.0, -1.0],
        [7.0, -9.0, -9.0],
        [7.0, 9.0, -9.0],
        [-1.0, 9.0, -1.0],
    ];
    let wall = Polygon::new(&corners.map(DVec3::from), &passage);
    let mut cover = covered(&passage, &[wall]);
    assert!(!sees(&mut cover, &passage, [4.2, -1.0, -9.0], [4.7, 1.0, -8.5]));
    assert!(sees(&mut cover, &passage, [-4.7, -1.0, -9.0], [-4.2, 1.0, -8.5]));
}

#[test]
fn a_rectangle_at_the_stored_depth_of_a_sample_is_seen_and_one_behind_it_is_not() {
    let passage = square(64);
    let panes = [
        ([0.0, 0.0, 64.0, 64.0], 7.0),
        ([3.0, 5.0, 61.0, 59.0], 7.0),
        ([16.0, 0.0, 48.0, 64.0], 3.0),
    ];
    let [far, smaller, near] = panes.map(|(rect, distance)| pane(&passage, rect, distance));
    // Each as the reference layer of some tiles, and as the working layer of others.
    for panes in [[far.clone(), near.clone()], [near.clone(), far], [smaller, near]] {
        let cover = covered(&passage, &panes);
        for (x, y) in samples(passage.aperture.rect()) {
            let stored = cover.known(x, y);
            if stored == 0.0 {
                continue;
            }
            // Of one sample, and of all up to the middle of the near pane, which hides its own.
            for middle in [x, 32] {
                let rect = Rect {
                    x0: x.min(middle),
                    y0: y,
                    x1: x.max(middle) + 1,
                    y1: y + 1,
                };
                let seen = [stored, stored.next_down()].map(|nearest| cover.sees_rect(&rect, nearest));
                assert_eq!(seen, [true, false], "sample {x} {y} of {rect:?}");
            }
        }
    }
}

#[test]
fn what_is_as_near_as_an_occluder_is_seen() {
    for distance in [0.013, 0.3, 5.0, 777.7, 1e5, 3e8] {
        let passage = square(97);
        let mut cover = covered(&passage, &[pane(&passage, [0.0, 0.0, 97.0, 97.0], distance)]);
        let flat = |z: f64| {
            let half = 0.4 * distance;
            [[-half, -half, -z], [half, half, -z]]
        };
        let [min, max] = flat(distance);
        assert!(sees(&mut cover, &passage, min, max), "a decal at {distance}");
        let [min, max] = flat(distance * (1.0 + 1e-5));
        assert!(
            !sees(&mut cover, &passage, min, max),
            "a little behind {distance}"
        );
    }
}

#[test]
fn what_is_as_near_as_a_slanting_occluder_is_seen() {
    let mut dice = Dice::new(7);
    let passage = square(97);
    for _ in 0..2000 {
        let at = DVec3::new(dice.between(-0.7, 0.7), dice.between(-0.7, 0.7), -1.0);
        let center = at * dice.by_ratio(0.1, 1000.0);
        let radius = center.length() * dice.between(0.05, 0.9);
        let polygon = Polygon::random(&mut dice, &passage, center, radius);
        let mut cover = covered(&passage, std::slice::from_ref(&polygon));
        // A flat box in the plane of the polygon.
        let corners = &polygon.corners;
        let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
        let sides = [corners[0] - middle, corners[1] - middle, DVec3::ZERO].map(|side| 0.4 * side);
        let volume = Volume {
            origin: middle,
            sides,
            is_parallel: false,
        };
        let back = passage.screen_from_sector.linear.matrix3.inverse();
        let local = DAffine3 {
            matrix3: back * glam::DMat3::from_cols(sides[0], sides[1], sides[2]),
            translation: back * middle,
        };
        let Some(region) = region_of(&passage, &local) else {
            continue;
        };
        let shows = samples(region.rect).any(|(x, y)| rev_depth_of(&volume, x, y).is_some());
        assert!(!shows || cover.test(&region) != Visibility::Hidden);
    }
}

#[test]
fn walls_that_share_edges_leave_no_crack() {
    let mut dice = Dice::new(3);
    let passage = passage([160, 90]);
    for round in 0..20 {
        const N: usize = 12;
        // A rough sheet larger than the screen; each square of it is two triangles, or one quad if it is flat.
        let step = 7.0 / N as f64;
        let mut points = [[DVec3::ZERO; N + 1]; N + 1];
        for (i, row) in points.iter_mut().enumerate() {
            for (j, point) in row.iter_mut().enumerate() {
                let jitter = |dice: &mut Dice| dice.between(-0.4, 0.4) * step;
                let [x, y] = [i, j].map(|k| k as f64 * step - 3.5 + jitter(&mut dice));
                *point = DVec3::new(x, y, -2.0 + jitter(&mut dice));
            }
        }
        let mut polygons = Vec::new();
        for i in 0..N {
            for j in 0..N {
                let [a, b] = [points[i][j], points[i + 1][j]];
                let [c, d] = [points[i + 1][j + 1], points[i][j + 1]];
                for triangle in [[a, b, c], [c, d, a]] {
                    let turned = (dice.roll() * 3.0) as usize;
                    let mut triangle = triangle;
                    triangle.rotate_left(turned);
                    polygons.push(Polygon::new(&triangle, &passage));
                }
            }
        }
        let mut cover = covered(&passage, &polygons);
        for (x, y) in samples(cover.grid.rect) {
            assert!(cover.known(x, y) > 0.0, "a crack at {x}, {y} of round {round}");
        }
        assert!(!sees(&mut cover, &passage, [-9.0, -9.0, -9.0], [9.0, 9.0, -8.0]));
    }
}

#[test]
fn each_sample_belongs_to_exactly_one_of_two_that_share_an_edge() {
    let mut dice = Dice::new(11);
    let passage = square(64);
    for _ in 0..2000 {
        // Include edges through sample centres.
        let mut coordinate = || {
            let value = dice.between(4.0, 60.0);
            if dice.roll() < 0.5 {
                value.floor() + 0.5
            } else {
                value
            }
        };
        let [a, b, c, d] = [(); 4].map(|()| [coordinate(), coordinate()]);
        let at = |[x, y]: [f64; 2]| DVec3::new((x - 32.0) / 32.0, (32.0 - y) / 32.0, -1.0) * 4.0;
        let side = |p: [f64; 2]| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
        if side(c) * side(d) >= 0.0 {
            continue;
        }
        let each = [[a, b, c], [b, a, d]].map(|corners| Polygon::new(&corners.map(at), &passage));
        let covers = each.map(|polygon| covered(&passage, &[polygon]));
        let mut union = 0;
        for (x, y) in samples(covers[0].grid.rect) {
            let both = [0, 1].map(|i| covers[i].known(x, y) > 0.0);
            assert_ne!(both, [true, true], "{x}, {y}: {a:?} {b:?} {c:?} {d:?}");
            union += u32::from(both != [false, false]);
        }
        let area = 0.5 * (side(c).abs() + side(d).abs());
        assert!((f64::from(union) - area).abs() < 0.1 * area + 150.0);
    }
}

#[test]
fn a_slit_of_one_sample_shows_what_is_behind_it() {
    let passage = square(128);
    for column in 0..127_u16 {
        let slit = f64::from(column);
        let walls = [
            pane(&passage, [-9.0, -9.0, slit, 137.0], 2.0),
            pane(&passage, [slit + 1.0, -9.0, 137.0, 137.0], 3.0),
        ];
        let mut cover = covered(&passage, &walls);
        assert!(
            sees(&mut cover, &passage, [-9.0, -9.0, -9.0], [9.0, 9.0, -8.0]),
            "column {column}"
        );
        let upright = [walls[0].clone(), walls[1].clone()].map(|wall| Polygon {
            corners: wall.corners.iter().map(|c| DVec3::new(c.y, c.x, c.z)).collect(),
            plane: wall.plane,
        });
        let mut cover = covered(&passage, &upright);
        assert!(
            sees(&mut cover, &passage, [-9.0, -9.0, -9.0], [9.0, 9.0, -8.0]),
            "row {column}"
        );
        // A slit between the sample centres shows nothing.
        let walls = [
            pane(&passage, [-9.0, -9.0, slit + 0.6, 137.0], 2.0),
            pane(&passage, [slit + 1.4, -9.0, 137.0, 137.0], 3.0),
        ];
        let mut cover = covered(&passage, &walls);
        assert!(!sees(&mut cover, &passage, [-9.0, -9.0, -9.0], [9.0, 9.0, -8.0]));
    }
}

#[test]
fn what_is_not_a_number_hides_nothing() {
    let passage = square(64);
    let wall = pane(&passage, [0.0, 0.0, 64.0, 64.0], 2.0);
    let mut broken = Vec::new();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e200, -1e300] {
        for corner in 0..4 {
            for axis in 0..3 {
                let mut polygon = wall.clone();
                polygon.corners[corner][axis] = bad;
                broken.push(polygon);
            }
        }
        for plane in [
            (DVec3::splat(bad * bad), 1.0),
            (DVec3::Z, bad * 1e200),
            (DVec3::new(0.0, -bad * bad, 1.0), 2.0),
        ] {
            broken.push(Polygon {
                plane,
                ..wall.clone()
            });
        }
    }
    for distance in [0.0, -2.0, 1e-320] {
        broken.push(Polygon {
            plane: (DVec3::Z, distance),
            ..wall.clone()
        });
    }
    for corners in [0, 1, 2] {
        let mut polygon = wall.clone();
        polygon.corners.truncate(corners);
        broken.push(polygon);
    }
    for polygon in broken {
        let cover = covered(&passage, std::slice::from_ref(&polygon));
        for (x, y) in samples(cover.grid.rect) {
            let [stored, truth] = [f64::from(cover.known(x, y)), 0.5];
            assert!(stored <= truth, "{stored} at {x}, {y} by {polygon:?}");
        }
    }
}

#[test]
fn what_is_edge_on_hides_nothing() {
    let passage = square(64);
    let floor = [
        [-5.0, 0.0, -1.0],
        [5.0, 0.0, -1.0],
        [5.0, 0.0, -9.0],
        [-5.0, 0.0, -9.0],
    ];
    let polygon = Polygon {
        plane: (DVec3::Y, 1e-30),
        ..Polygon::new(&floor.map(DVec3::from), &passage)
    };
    let cover = covered(&passage, &[polygon]);
    assert!(samples(cover.grid.rect).all(|(x, y)| cover.known(x, y) == 0.0));
}

#[test]
fn what_is_before_the_near_distance_hides_nothing() {
    let mut passage = square(64);
    passage.z_near = 1.0;
    let mut cover = covered(&passage, &[pane(&passage, [0.0, 0.0, 64.0, 64.0], 0.99)]);
    assert!(sees(&mut cover, &passage, [-1.0, -1.0, -9.0], [1.0, 1.0, -8.0]));
    // A floor that begins under the eye: the rows where it is too near stay open.
    let floor = [
        [-90.0, -0.5, 3.0],
        [90.0, -0.5, 3.0],
        [90.0, -0.5, -90.0],
        [-90.0, -0.5, -90.0],
    ];
    let floor = Polygon::new(&floor.map(DVec3::from), &passage);
    let cover = covered(&passage, &[floor]);
    for (x, y) in samples(cover.grid.rect) {
        // The margin for a pushed-back plane ends at W = 4, which is at row 36.
        let known = cover.known(x, y);
        assert!(known <= 1.0, "{known} at {x}, {y}");
        assert_eq!(known > 0.0, (32..36).contains(&y), "{x}, {y}");
    }
}

#[test]
fn what_is_before_the_last_portal_hides_nothing() {
    let mut passage = square(64);
    passage.entry = Some((DVec3::Z, 5.0));
    for (distance, hides) in [(4.0, false), (4.999, false), (5.0, false), (5.1, true)] {
        let mut cover = covered(&passage, &[pane(&passage, [0.0, 0.0, 64.0, 64.0], distance)]);
        let seen = sees(&mut cover, &passage, [-1.0, -1.0, -9.0], [1.0, 1.0, -8.0]);
        assert_eq!(!seen, hides, "{distance}");
    }
}

#[test]
fn outside_the_aperture_nothing_is_seen_however_near() {
    let mut passage = square(64);
    let door = ConvexPolygon::rectangle([-0.1, -0.1, -1.0], [0.2, 0.0, 0.0], [0.0, 0.2, 0.0]);
    let behind = passage.aperture_behind(&door.expect("a door"), None, 0.0);
    passage.aperture = behind.expect("the door is in view");
    let mut cover = covered(&passage, &[]);
    let rect = Rect {
        x0: 0,
        y0: 0,
        x1: 64,
        y1: 20,
    };
    assert!(!cover.sees_rect(&rect, f32::INFINITY));
    assert!(
        sees(&mut cover, &passage, [-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]),
        "the eye is inside the box"
    );
    assert!(cover.sees_rect(&Rect { y1: 40, ..rect }, 1e-30));
}

#[test]
fn a_cover_may_take_screens_of_any_size_one_after_the_other() {
    let mut cover = MaskedDepth::default();
    for size in [[640, 360], [1, 1], [33, 9], [16_384, 1], [1, 16_384], [640, 360]] {
        let passage = passage(size);
        cover.clear(&passage);
        let all = passage.aperture.rect();
        assert!(cover.sees_rect(&all, 1e-6));
        let wall = [
            [-9.0, -9.0, -1.0],
            [9.0, -9.0, -1.0],
            [9.0, 9.0, -1.0],
            [-9.0, 9.0, -1.0],
        ];
        let wide = wall.map(|c| DVec3::from(c) * DVec3::new(1e5, 1e5, 1.0));
        let mut stats = Stats::default();
        cover.hide(&Polygon::new(&wide, &passage).occluder(), &passage, &mut stats);
        assert_eq!(stats.samples, u64::from(size[0]) * u64::from(size[1]));
        assert!(!cover.sees_rect(&all, 0.9));
        assert!(cover.sees_rect(&all, 1.0));
        assert!(MaskedDepth::needs_bytes(size) >= 132);
    }
}
