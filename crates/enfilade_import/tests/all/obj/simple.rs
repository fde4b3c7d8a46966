//! Random polygons that do not cross themselves, against a rule that knows nothing of triangles: a point is inside where a
//! ray from it meets the outline an odd number of times.

use super::file::{numbers, reads, triangles, warnings};
use super::polygons::polygon;
use std::collections::HashMap;

type Point = [i64; 2];

fn turn(a: Point, b: Point, c: Point) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Have two segments a point in common?
fn meet([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let in_box = |p: Point, [a, b]: [Point; 2]| {
        (0..2).all(|axis| a[axis].min(b[axis]) <= p[axis] && p[axis] <= a[axis].max(b[axis]))
    };
    let on = |p, [a, b]: [Point; 2]| turn(a, b, p) == 0 && in_box(p, [a, b]);
    let apart = |x: i64, y: i64| x.signum() * y.signum() < 0;
    (apart(turn(a, b, c), turn(a, b, d)) && apart(turn(c, d, a), turn(c, d, b)))
        || on(c, [a, b])
        || on(d, [a, b])
        || on(a, [c, d])
        || on(b, [c, d])
}

/// A random polygon of different corners on a grid, counter-clockwise: crossings are undone until there are none.
fn simple(number: &mut impl FnMut(usize) -> usize, count: usize, size: usize) -> Option<Vec<Point>> {
    let mut corners: Vec<Point> = Vec::new();
    while corners.len() < count {
        let corner = [number(size) as i64, number(size) as i64];
        if !corners.contains(&corner) {
            corners.push(corner);
        }
    }
    let side = |corners: &[Point], n: usize| [corners[n], corners[(n + 1) % corners.len()]];
    'again: for _ in 0..2000 {
        for i in 0..count {
            for j in i + 1..count {
                let (first, second) = (side(&corners, i), side(&corners, j));
                let next = j == i + 1 || (i == 0 && j == count - 1);
                // Neighbours may only meet where they join.
                let bad = if next {
                    let [a, b, c] = if j == i + 1 {
                        [first[0], first[1], second[1]]
                    } else {
                        [second[0], second[1], first[1]]
                    };
                    turn(a, b, c) == 0 && (a[0] - b[0]) * (c[0] - b[0]) + (a[1] - b[1]) * (c[1] - b[1]) > 0
                } else {
                    meet(first, second)
                };
                if bad && next {
                    return None;
                }
                if bad {
                    corners[i + 1..=j].reverse();
                    continue 'again;
                }
            }
        }
        let around = (0..count).map(|n| side(&corners, n));
        let area: i64 = around.map(|[a, b]| a[0] * b[1] - a[1] * b[0]).sum();
        if area < 0 {
            corners.reverse();
        }
        return (area != 0).then_some(corners);
    }
    None
}

/// Returns `true` if a point between grid points is inside.
fn inside(corners: &[Point], [x, y]: [f64; 2]) -> bool {
    let around = corners.iter().zip(corners.iter().cycle().skip(1));
    let crossed = around.filter(|(a, b)| {
        let [[ax, ay], [bx, by]] = [a, b].map(|p| p.map(|value| value as f64));
        (ay > y) != (by > y) && x < ax + (y - ay) * (bx - ax) / (by - ay)
    });
    crossed.count() % 2 == 1
}

/// Lays a plane into space without rounding.
type Lay = fn(Point) -> [f32; 3];
/// And back.
type Unlay = fn([f32; 3]) -> Point;

const LAID: [(Lay, Unlay); 4] = [
    (|[x, y]| [x as f32, y as f32, 7.0], |p| [p[0] as i64, p[1] as i64]),
    (|[x, y]| [3.0, x as f32, y as f32], |p| [p[1] as i64, p[2] as i64]),
    (
        |[x, y]| [x as f32, (3 * x - 5 * y) as f32, y as f32],
        |p| [p[0] as i64, p[2] as i64],
    ),
    (
        |[x, y]| [(2 * x + y) as f32, x as f32, y as f32],
        |p| [p[1] as i64, p[2] as i64],
    ),
];

#[test]
fn triangles_cover_what_is_inside_once_and_nothing_else() {
    let mut number = numbers(11);
    let mut tried = 0;
    for round in 0..1500 {
        let count = 4 + number(if round % 10 == 0 { 40 } else { 14 });
        // Small grids have many corners in line.
        let size = [5, 8, 12, 100][number(4)].max((count as f64).sqrt() as usize + 3);
        let Some(mut corners) = simple(&mut number, count, size) else {
            continue;
        };
        tried += 1;
        let (lay, back) = LAID[number(4)];
        let turned = number(2) == 1;
        if turned {
            corners.reverse();
        }
        let text = polygon(&corners.iter().map(|&corner| lay(corner)).collect::<Vec<_>>());
        let import = reads(&text);
        assert_eq!(warnings(&import), [""; 0], "{text}");
        let cut: Vec<[Point; 3]> = triangles(&import, 0)
            .iter()
            .map(|(corners, _)| corners.map(|corner| back(corner.position)))
            .collect();
        check(&corners, &cut, turned, &text, &mut number);
    }
    assert!(tried > 1000, "only {tried} polygons");
}

fn check(
    corners: &[Point],
    cut: &[[Point; 3]],
    turned: bool,
    text: &str,
    number: &mut impl FnMut(usize) -> usize,
) {
    let sign = if turned { -1 } else { 1 };
    assert_eq!(cut.len(), corners.len() - 2, "{text}");
    for &[a, b, c] in cut {
        assert!(sign * turn(a, b, c) > 0, "{:?} is turned\n{text}", [a, b, c]);
    }
    // Each side of the polygon is a side of one triangle; all others have a neighbour across them.
    let mut sides: HashMap<[Point; 2], i32> = HashMap::new();
    for [a, b, c] in cut {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *sides.entry([*from, *to]).or_default() += 1;
            *sides.entry([*to, *from]).or_default() -= 1;
        }
    }
    for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        *sides.entry([*from, *to]).or_default() -= 1;
        *sides.entry([*to, *from]).or_default() += 1;
    }
    assert!(sides.values().all(|&count| count == 0), "{text}");
    for _ in 0..20 {
        let corner = corners[number(corners.len())];
        // Apart from each other, so that the point is on no diagonal.
        let apart = [1e-4, 1.7e-4];
        let [x, y] =
            [0, 1].map(|axis| corner[axis] as f64 + (number(4000) as f64 - 2000.0) / 997.0 + apart[axis]);
        let times = cut
            .iter()
            .filter(|triangle| inside(&triangle[..], [x, y]))
            .count();
        assert_eq!(times, usize::from(inside(corners, [x, y])), "{x}, {y}\n{text}");
    }
}
