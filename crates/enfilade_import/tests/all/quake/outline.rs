//! Helpers that compare convex polygons.

type Point = [f64; 3];

pub(crate) fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Point, b: Point) -> Point {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Twice the area, along the counter-clockwise normal.
fn newell(corners: &[Point]) -> Point {
    corners[1..].windows(2).fold([0.0; 3], |sum, pair| {
        let part = cross(minus(pair[0], corners[0]), minus(pair[1], corners[0]));
        [0, 1, 2].map(|axis| sum[axis] + part[axis])
    })
}

pub(crate) fn area(corners: &[Point]) -> f64 {
    let twice = newell(corners);
    dot(twice, twice).sqrt() / 2.0
}

pub(crate) fn normal(corners: &[Point]) -> Point {
    let twice = newell(corners);
    let length = dot(twice, twice).sqrt();
    twice.map(|part| part / length)
}

/// Its edges as a point on each and the direction that leads in from there.
fn edges(corners: &[Point]) -> impl Iterator<Item = (Point, Point)> + '_ {
    let up = normal(corners);
    (0..corners.len()).filter_map(move |at| {
        let along = minus(corners[(at + 1) % corners.len()], corners[at]);
        let length = dot(along, along).sqrt();
        // An edge as short as rounding has no direction.
        (length > 1e-4).then(|| (corners[at], cross(up, along).map(|part| part / length)))
    })
}

/// Returns how far a point in the plane of a polygon is outside it, in units; 0 inside.
pub(crate) fn out_of(point: Point, corners: &[Point]) -> f64 {
    let outs = edges(corners).map(|(from, inward)| -dot(inward, minus(point, from)));
    outs.fold(0.0, f64::max)
}

/// Returns the intersection of two coplanar polygons.
pub(crate) fn common_area(a: &[Point], b: &[Point]) -> f64 {
    let mut left = a.to_vec();
    for (from, inward) in edges(b) {
        let inside = |point: Point| dot(inward, minus(point, from));
        let mut kept = Vec::new();
        for at in 0..left.len() {
            let [here, next] = [left[at], left[(at + 1) % left.len()]];
            let [in_here, in_next] = [inside(here), inside(next)];
            if in_here >= 0.0 {
                kept.push(here);
            }
            if (in_here >= 0.0) != (in_next >= 0.0) {
                let part = in_here / (in_here - in_next);
                kept.push([0, 1, 2].map(|axis| here[axis] + (next[axis] - here[axis]) * part));
            }
        }
        left = kept;
        if left.len() < 3 {
            return 0.0;
        }
    }
    area(&left)
}

/// Points all over a polygon, some way off its edges.
pub(crate) fn points(corners: &[Point]) -> Vec<Point> {
    let mut points = Vec::new();
    for at in 1..corners.len() - 1 {
        let [a, b, c] = [corners[0], corners[at], corners[at + 1]];
        for i in 0..8 {
            for j in 0..8 - i {
                let [u, v] = [(f64::from(i) + 0.33) / 8.0, (f64::from(j) + 0.33) / 8.0];
                points
                    .push([0, 1, 2].map(|axis| a[axis] + (b[axis] - a[axis]) * u + (c[axis] - a[axis]) * v));
            }
        }
    }
    points
}
