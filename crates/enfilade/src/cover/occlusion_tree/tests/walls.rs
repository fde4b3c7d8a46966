//! Walls of many occluders: no cracks along their seams, and every hole is kept.

use super::*;

/// A wall of squares with the given corners, `[along, up]` on a plane through `at`.
fn wall(tiles: &[&[[f64; 2]]], [at, along, up]: [DVec3; 3]) -> Vec<Polygon> {
    let place = |&[a, b]: &[f64; 2]| (at + along * a + up * b).into();
    let polygon = |tile: &&[[f64; 2]]| Polygon::new(&tile.iter().map(place).collect::<Vec<_>>());
    tiles.iter().filter_map(polygon).collect()
}

/// A square from −1 to 1, cut into `n` × `n`.
fn grid(n: usize) -> Vec<Vec<[f64; 2]>> {
    let at = |i: usize| -1.0 + 2.0 * i as f64 / n as f64;
    let tile = |i: usize| {
        let [x, y] = [i % n, i / n];
        [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]]
            .map(|[x, y]| [at(x), at(y)])
            .to_vec()
    };
    (0..n * n).map(tile).collect()
}

/// Rows of bricks, each row shifted against the one below: every corner is in the interior of another brick's edge.
fn bricks(n: usize) -> Vec<Vec<[f64; 2]>> {
    let mut bricks = Vec::new();
    for row in 0..n {
        let [low, high] = [row, row + 1].map(|i| -1.0 + 2.0 * i as f64 / n as f64);
        let shift = 0.5 * (row % 2) as f64 + 0.1 / (row + 1) as f64;
        let ends: Vec<f64> = std::iter::once(-1.0)
            .chain((0..n).map(|i| -1.0 + 2.0 * (i as f64 + shift) / n as f64))
            .chain([1.0])
            .collect();
        for pair in ends.windows(2).filter(|pair| pair[0] < pair[1]) {
            bricks.push([[pair[0], low], [pair[1], low], [pair[1], high], [pair[0], high]].to_vec());
        }
    }
    bricks
}

/// A triangle fan around a point, with its other corners on the border.
fn fan(n: usize) -> Vec<Vec<[f64; 2]>> {
    let border = |i: usize| {
        let t = 8.0 * i as f64 / n as f64;
        let (side, along) = (t.floor() as usize / 2 % 4, t % 2.0 - 1.0);
        [[along, -1.0], [1.0, along], [-along, 1.0], [-1.0, -along]][side]
    };
    let middle = [0.123, -0.271];
    (0..n)
        .map(|i| [middle, border(i), border((i + 1) % n)].to_vec())
        .collect()
}

#[test]
fn walls_of_tiles_have_no_cracks_at_any_scale_and_slope() {
    let mut chance = Chance(42);
    let [mut asked, mut by_box_too] = [0; 2];
    let patterns = [grid(1), grid(7), bricks(6), fan(8), fan(64), grid(20)];
    for scale in [1e-5, 1e-2, 1.0, 1e3, 1e7] {
        for slope in [0.0, 0.3, 1.2, 5.0] {
            for pattern in &patterns {
                let tiles: Vec<&[[f64; 2]]> = pattern.iter().map(|tile| &tile[..]).collect();
                let plane = [
                    DVec3::new(0.3, 0.1, 4.0),
                    DVec3::new(3.0, 0.2, 0.3 * slope),
                    DVec3::new(-0.1, 3.0, 0.4 * slope),
                ];
                let tiles = shuffled(&wall(&tiles, plane.map(|v| v * scale)), &mut chance);
                let mut both = Both::new(&[]);
                for tile in &tiles {
                    both.hide(&tile.occluder(), 1e-4 * scale, None);
                }
                let what = format!(
                    "{} tiles at {scale}, slope {slope}, nodes {}",
                    tiles.len(),
                    both.faces.tree.nodes.len()
                );
                for half in [0.01, 0.3, 1.0] {
                    for off in [[0.0, 0.0], [0.31, -0.22], [-0.4, 0.4]] {
                        let [x, y] = off.map(|v| 6.0 * v);
                        let [min, max] = [-1.0, 1.0].map(|s| [x + half * s, y + half * s, 14.0 + half * s]);
                        let volume = volume(min.map(|v| v * scale), max.map(|v| v * scale));
                        let [by_faces, by_box] = both.see(&volume);
                        assert_eq!(by_faces, Visibility::Hidden, "{what}: a box of {half} at {off:?}");
                        asked += 1;
                        by_box_too += usize::from(by_box == Visibility::Hidden);
                    }
                }
            }
        }
    } // Where 64 lines meet in one point, a box may reach a thin leaf that none of its faces reaches.
    assert!(by_box_too * 100 > asked * 99, "{by_box_too} of {asked}");
}

#[test]
fn a_needle_hole_shows_what_is_behind_it() {
    // Four squares around a square hole, much wider than a slit and much narrower than a pixel.
    for hole in [1e-1, 1e-4, 1e-8] {
        let to = |a: [f64; 2], b: [f64; 2]| [[a[0], a[1]], [b[0], a[1]], [b[0], b[1]], [a[0], b[1]]];
        let ends = [-1.0, -hole, hole, 1.0];
        let tiles = [
            to([ends[0], ends[0]], [ends[2], ends[1]]),
            to([ends[2], ends[0]], [ends[3], ends[2]]),
            to([ends[1], ends[2]], [ends[3], ends[3]]),
            to([ends[0], ends[1]], [ends[1], ends[3]]),
        ];
        let tiles: Vec<&[[f64; 2]]> = tiles.iter().map(|tile| &tile[..]).collect();
        let tiles = wall(
            &tiles,
            [DVec3::new(0.0, 0.0, 2.0), 2.0 * DVec3::X, 2.0 * DVec3::Y],
        );
        let mut both = Both::new(&tiles);
        // It is visible through the hole: entirely, in part, or not at all.
        assert_eq!(
            both.see(&volume([-hole, -hole, 9.0], [hole, hole, 9.0])),
            [Visibility::Full; 2],
            "{hole}"
        );
        assert_eq!(
            both.see(&volume([-1.0, -1.0, 9.0], [1.0, 1.0, 10.0])),
            [Visibility::Partial; 2],
            "{hole}"
        );
        let beside = volume([-1.0, 9.5 * hole, 9.0], [1.0, 1.0, 9.1]);
        assert_eq!(both.see(&beside), [Visibility::Hidden; 2], "{hole}");
    }
}

#[test]
fn a_slit_between_two_walls_shows_a_slice() {
    let halves = [[-9.0, -1e-6], [1e-6, 9.0]].map(|[low, high]| {
        Polygon::new(&[
            [low, -9.0, 3.0],
            [high, -9.0, 3.0],
            [high, 9.0, 3.0],
            [low, 9.0, 3.0],
        ])
        .expect("the eye is not in its plane")
    });
    let mut both = Both::new(&halves);
    assert_eq!(
        both.see(&volume([-1.0, -1.0, 5.0], [1.0, 1.0, 6.0])),
        [Visibility::Partial; 2]
    );
    assert_eq!(
        both.see(&volume([0.1, -1.0, 5.0], [1.0, 1.0, 6.0])),
        [Visibility::Hidden; 2]
    );
}
