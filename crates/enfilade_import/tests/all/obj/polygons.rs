//! Polygons are cut into triangles that cover them.

use super::file::{places, reads, triangles, warnings};
use std::fmt::Write;
use std::time::{Duration, Instant};

/// A file with one polygon.
pub(crate) fn polygon(corners: &[[f32; 3]]) -> String {
    let mut text = String::new();
    for [x, y, z] in corners {
        writeln!(text, "v {x} {y} {z}").expect("into a string");
    }
    text += "f";
    for number in 1..=corners.len() {
        write!(text, " {number}").expect("into a string");
    }
    text
}

/// A polygon in the plane z = 0.
pub(crate) fn flat(corners: &[[f32; 2]]) -> String {
    let corners: Vec<[f32; 3]> = corners.iter().map(|&[x, y]| [x, y, 0.0]).collect();
    polygon(&corners)
}

/// The areas of the triangles in the plane z = 0, below 0 where they turn the other way.
pub(crate) fn areas(text: &str) -> Vec<f64> {
    let import = reads(text);
    if import.rooms[0].geometry.items().is_empty() {
        return Vec::new();
    }
    triangles(&import, 0)
        .iter()
        .map(|(corners, _)| {
            let [[ax, ay, _], [bx, by, _], [cx, cy, _]] = corners.map(|c| c.position.map(f64::from));
            ((bx - ax) * (cy - ay) - (by - ay) * (cx - ax)) / 2.0
        })
        .collect()
}

/// Twice the area of a polygon, at most about exactly.
fn area(corners: &[[f32; 2]]) -> f64 {
    let around = corners.iter().zip(corners.iter().cycle().skip(1));
    around
        .map(|(a, b)| f64::from(a[0]) * f64::from(b[1]) - f64::from(a[1]) * f64::from(b[0]))
        .sum::<f64>()
        / 2.0
}

/// A sound polygon gives triangles that all turn its way, have its area together, and use each corner.
#[track_caller]
fn covered(corners: &[[f32; 2]]) {
    for turned in [false, true] {
        let mut corners = corners.to_vec();
        if turned {
            corners.reverse();
        }
        let text = flat(&corners);
        assert_eq!(warnings(&reads(&text)), [""; 0]);
        let (areas, area) = (areas(&text), area(&corners));
        assert_eq!(areas.len(), corners.len() - 2);
        assert!(areas.iter().all(|one| one * area > 0.0), "{areas:?}");
        let sum: f64 = areas.iter().sum();
        assert!((sum - area).abs() < 1e-6 * area.abs(), "{sum} of {area}");
    }
}

#[test]
fn convex_polygons_are_cut_from_their_first_corner() {
    let square = flat(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    assert_eq!(
        places(&reads(&square), 0),
        ["0,0,0 1,0,0 1,1,0", "0,0,0 1,1,0 0,1,0"]
    );
    let turned = flat(&[[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
    assert_eq!(
        places(&reads(&turned), 0),
        ["0,0,0 0,1,0 1,0,0", "0,1,0 1,1,0 1,0,0"]
    );
    let disc: Vec<[f32; 2]> = (0..100)
        .map(|n| {
            let (sin, cos) = (n as f32 * 0.062_831_85).sin_cos();
            [cos, sin]
        })
        .collect();
    covered(&disc);
}

#[test]
fn concave_polygons_are_covered_and_nothing_beside_them() {
    let dart = [[0.0, 0.0], [4.0, 1.0], [1.0, 1.0], [1.0, 4.0]];
    for first in 0..4 {
        let mut corners = dart;
        corners.rotate_left(first);
        covered(&corners);
    }
    assert_eq!(
        places(&reads(&flat(&dart)), 0),
        ["0,0,0 1,1,0 1,4,0", "0,0,0 4,1,0 1,1,0"]
    );
    covered(&[
        [0.0, 0.0],
        [2.0, 0.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [0.0, 2.0],
    ]);
    // A star, a comb, a spiral.
    let star: Vec<[f32; 2]> = (0..20)
        .map(|n| {
            let (sin, cos) = (n as f32 * 0.314_159_27).sin_cos();
            let far = if n % 2 == 0 { 5.0 } else { 1.0 };
            [far * cos, far * sin]
        })
        .collect();
    covered(&star);
    covered(&comb(30));
    covered(&spiral(40));
}

/// Teeth upwards from a back below; between the teeth corners on one line.
fn comb(teeth: usize) -> Vec<[f32; 2]> {
    let mut corners = vec![[0.0, -1.0], [teeth as f32, -1.0]];
    for tooth in (0..teeth).rev() {
        let x = tooth as f32;
        corners.extend([[x + 1.0, 0.0], [x + 0.5, 8.0]]);
    }
    corners.push([0.0, 0.0]);
    corners
}

/// A band rolled up, to the middle and back.
fn spiral(steps: usize) -> Vec<[f32; 2]> {
    let at = |step: usize, inward: f32| {
        let far = 1.0 + step as f32 * 0.1 - inward;
        let (sin, cos) = (step as f32 * 0.5).sin_cos();
        [far * cos, far * sin]
    };
    let outer = (0..steps).map(|step| at(step, 0.0));
    outer.chain((0..steps).rev().map(|step| at(step, 0.3))).collect()
}

#[test]
fn corners_in_line_stay_corners_so_that_neighbours_meet_them() {
    covered(&[
        [0.0, 0.0],
        [1.0, 0.0],
        [2.0, 0.0],
        [2.0, 2.0],
        [1.0, 2.0],
        [0.0, 2.0],
        [0.0, 1.0],
    ]);
    covered(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [0.0, 3.0]]);
}

#[test]
fn polygons_that_touch_themselves_are_sound() {
    // A square with a square hole, joined by a cut from corner to corner, as programs without holes write it.
    let frame = [
        [0.0, 0.0],
        [4.0, 0.0],
        [4.0, 4.0],
        [0.0, 4.0],
        [0.0, 0.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [3.0, 3.0],
        [3.0, 1.0],
        [1.0, 1.0],
    ];
    covered(&frame);
    // Two squares that meet in a corner, of which no triangle needs to know.
    let corners = [
        [0.0, 0.0],
        [1.0, 0.0],
        [1.0, 1.0],
        [2.0, 1.0],
        [2.0, 2.0],
        [1.0, 2.0],
        [1.0, 1.0],
        [0.0, 1.0],
    ];
    assert_eq!(areas(&flat(&corners)), [0.5; 4]);
    assert_eq!(warnings(&reads(&flat(&corners))), [""; 0]);
}

#[test]
fn polygons_without_area_show_nothing() {
    let p = [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [3.0, 3.0]];
    for corners in [
        &[p[0], p[0], p[0], p[0]][..],
        &[p[0], p[1], p[2], p[3]],
        &[p[0], p[2], p[1], p[3]],
        &[p[0], p[1], p[0], p[1]],
        &[p[0], p[1], p[1], p[0], p[0]],
    ] {
        assert_eq!(areas(&flat(corners)), [0.0; 0], "{corners:?}");
    }
    // A triangle is taken as it is.
    assert_eq!(areas(&flat(&[p[0], p[1], p[2]])), [0.0]);
    assert_eq!(areas(&flat(&[p[0], p[0], p[0]])), [0.0]);
}

#[test]
fn corners_named_twice_and_spikes_add_nothing() {
    let sum = |corners: &[[f32; 2]]| areas(&flat(corners)).iter().sum::<f64>();
    let [a, b, c, d] = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
    assert_eq!(sum(&[a, a, b, b, b, c, d, d, a]), 4.0);
    assert_eq!(areas(&flat(&[a, a, b, b, b, c, d, d, a])).len(), 2);
    for spike in [[4.0, 0.0], [1.0, 0.0], [3.0, -1.0]] {
        assert_eq!(sum(&[a, b, spike, b, c, d]), 4.0, "{spike:?}");
    }
}

#[test]
fn polygons_that_cross_themselves_are_cut_somehow_and_named() {
    let bow_tie = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]];
    let pentagram: Vec<[f32; 2]> = (0..5)
        .map(|n| {
            let (sin, cos) = (n as f32 * 2.513_274).sin_cos();
            [cos, sin]
        })
        .collect();
    for corners in [&bow_tie[..], &pentagram] {
        let import = reads(&flat(corners));
        assert!(!triangles(&import, 0).is_empty());
        let line = corners.len() + 1;
        assert_eq!(
            warnings(&import),
            [format!(
                "self-intersecting polygons are triangulated approximately (line {line})"
            )]
        );
    }
}

#[test]
fn polygons_that_are_not_flat_are_cut_as_they_are_seen_from_in_front() {
    // A saddle, its plan a square with a notch.
    let saddle = [
        [0.0, 0.0, 0.0],
        [4.0, 0.0, 1.0],
        [4.0, 4.0, 0.0],
        [2.0, 1.0, 0.5],
        [0.0, 4.0, 1.0],
    ];
    let sum = areas(&polygon(&saddle));
    assert!(
        sum.iter().all(|&one| one > 0.0) && sum.iter().sum::<f64>() == 10.0,
        "{sum:?}"
    );
    // Tilted, in each of the planes that two axes span.
    for turn in 0..3 {
        let mut tilted = saddle.map(|[x, y, z]| [x, y, z + 0.25 * x]);
        tilted.iter_mut().for_each(|corner| corner.rotate_left(turn));
        let import = reads(&polygon(&tilted));
        assert_eq!((triangles(&import, 0).len(), import.warnings.len()), (3, 0));
    }
}

#[test]
fn a_bent_polygon_that_crosses_itself_along_an_axis_is_cut_along_its_normal() {
    // A square with a slit, one side of which is pushed off the plane so far that from above it covers the other.
    let normal = [0.7, 0.0, 0.714];
    let place = |u: f32, v: f32, off: f32| [0.714 * u + off * normal[0], v, -0.7 * u + off * normal[2]];
    let slit = [
        place(0.0, 0.0, 0.0),
        place(10.0, 0.0, 0.0),
        place(10.0, 10.0, 0.0),
        place(5.1, 10.0, -0.5),
        place(5.1, 5.0, -0.5),
        place(4.9, 5.0, 0.0),
        place(4.9, 10.0, 0.0),
        place(0.0, 10.0, 0.0),
    ];
    let import = reads(&polygon(&slit));
    assert_eq!(warnings(&import), [""; 0]);
    let all = triangles(&import, 0);
    assert_eq!(all.len(), 6);
    for (corners, _) in all {
        let [a, b, c] = corners.map(|corner| corner.position);
        let [p, q] = [b, c].map(|to| [0, 1, 2].map(|axis| to[axis] - a[axis]));
        let cross = [0, 1, 2].map(|n| p[(n + 1) % 3] * q[(n + 2) % 3] - p[(n + 2) % 3] * q[(n + 1) % 3]);
        let faces = (0..3).map(|axis| cross[axis] * normal[axis]).sum::<f32>();
        assert!(faces > 0.0, "{:?}", [a, b, c]);
    }
}

#[test]
fn a_polygon_of_ten_thousand_corners_takes_no_time() {
    const PATIENCE: Duration = Duration::from_secs(20);
    let zigzag: Vec<[f32; 2]> = (0..5000)
        .map(|n| [n as f32, (n % 2) as f32 * 50.0])
        .chain((0..5000).rev().map(|n| [n as f32, (n % 2) as f32 * 50.0 + 1.0]))
        .collect();
    let star: Vec<[f32; 2]> = (0..10_000_u32)
        .map(|n| {
            let (sin, cos) = (f64::from(n) * std::f64::consts::TAU / 1e4).sin_cos();
            let far = f64::from(1 + n.wrapping_mul(2_654_435_761) % 1000);
            [(far * cos) as f32, (far * sin) as f32]
        })
        .collect();
    for (what, corners) in [
        ("comb", comb(5000)),
        ("spiral", spiral(5000)),
        ("zigzag", zigzag),
        ("star", star),
    ] {
        let start = Instant::now();
        covered(&corners);
        assert!(start.elapsed() < PATIENCE, "{what}: {:?}", start.elapsed());
    }
}

#[test]
fn nonsense_of_a_hundred_thousand_corners_comes_to_an_end() {
    const PATIENCE: Duration = Duration::from_secs(60);
    let mut number = super::file::numbers(5);
    let corners: Vec<[f32; 2]> = (0..100_000)
        .map(|_| [number(1000) as f32, number(1000) as f32])
        .collect();
    let start = Instant::now();
    let import = reads(&flat(&corners));
    assert_eq!(import.warnings.len(), 1);
    assert!(start.elapsed() < PATIENCE, "{:?}", start.elapsed());
}
