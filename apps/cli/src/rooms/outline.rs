//! Outlines of labelled cells: traces the border of each label, and straightens the steps.

/// A closed outline: corners in cells.
pub(super) type Outline = Vec<[f64; 2]>;

/// Maximum distance by which an outline is moved to be straight, in cells: steps of a slanted wall disappear.
const STRAIGHT: f64 = 0.8;

/// Returns the outlines of the cells with a label, outer ones and holes, for the even-odd rule. `label` is `None` outside.
pub(super) fn outlines(size: [usize; 2], has_label: impl Fn(usize, usize) -> bool) -> Vec<Outline> {
    let [columns, rows] = size;
    let is_in = |x: isize, y: isize| {
        x >= 0 && y >= 0 && (x as usize) < columns && (y as usize) < rows && has_label(x as usize, y as usize)
    };
    // Edges run with the label on their left: right along the top of a cell without it, and so on.
    const STEPS: [[isize; 2]; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];
    let corner_count = (columns + 1) * (rows + 1);
    // For each corner and direction: whether an edge begins there.
    let mut edges = vec![[false; 4]; corner_count];
    let corner = |x: isize, y: isize| y as usize * (columns + 1) + x as usize;
    for y in 0..rows as isize {
        for x in 0..columns as isize {
            if !is_in(x, y) {
                continue;
            }
            if !is_in(x, y - 1) {
                edges[corner(x, y)][0] = true;
            }
            if !is_in(x + 1, y) {
                edges[corner(x + 1, y)][1] = true;
            }
            if !is_in(x, y + 1) {
                edges[corner(x + 1, y + 1)][2] = true;
            }
            if !is_in(x - 1, y) {
                edges[corner(x, y + 1)][3] = true;
            }
        }
    }
    let mut found = Vec::new();
    for start in 0..corner_count {
        for first in 0..4 {
            if !edges[start][first] {
                continue;
            }
            let mut outline = Vec::new();
            let [mut x, mut y] = [(start % (columns + 1)) as isize, (start / (columns + 1)) as isize];
            let mut way = first;
            while std::mem::replace(&mut edges[corner(x, y)][way], false) {
                outline.push([x as f64, y as f64]);
                x += STEPS[way][0];
                y += STEPS[way][1];
                // At a corner that two outlines share, turn right: they stay apart.
                let here = edges[corner(x, y)];
                let turns = [(way + 1) % 4, way, (way + 3) % 4];
                match turns.into_iter().find(|&turn| here[turn]) {
                    Some(next) => way = next,
                    None => break,
                }
            }
            found.push(straight(&outline));
        }
    }
    found
}

/// Leaves out corners as long as the outline moves by at most [`STRAIGHT`].
fn straight(outline: &[[f64; 2]]) -> Outline {
    if outline.len() < 4 {
        return outline.to_vec();
    }
    // Split at two corners that certainly stay: the first, and the one farthest from it.
    let away = |&[x, y]: &[f64; 2]| (x - outline[0][0]).powi(2) + (y - outline[0][1]).powi(2);
    let middle = (0..outline.len())
        .max_by(|&a, &b| away(&outline[a]).total_cmp(&away(&outline[b])))
        .unwrap_or(0);
    let mut closed = outline.to_vec();
    closed.push(outline[0]);
    let mut kept = Vec::new();
    simplify(&closed[..=middle], &mut kept);
    simplify(&closed[middle..], &mut kept);
    kept
}

/// Appends the corners that stay, without the last.
/// Source: Douglas, Peucker, Algorithms for the Reduction of the Number of Points Required to Represent a Digitized Line
/// or its Caricature, Cartographica 1973.
fn simplify(line: &[[f64; 2]], kept: &mut Outline) {
    let mut pending = vec![line];
    while let Some(line) = pending.pop() {
        let [Some(&first), Some(&last)] = [line.first(), line.last()] else {
            continue;
        };
        let [dx, dy] = [last[0] - first[0], last[1] - first[1]];
        let length = dx.hypot(dy);
        let off = |&[x, y]: &[f64; 2]| {
            let [x, y] = [x - first[0], y - first[1]];
            if length == 0.0 {
                x.hypot(y)
            } else {
                (x * dy - y * dx).abs() / length
            }
        };
        let farthest =
            (1..line.len().saturating_sub(1)).max_by(|&a, &b| off(&line[a]).total_cmp(&off(&line[b])));
        match farthest.filter(|&place| off(&line[place]) > STRAIGHT) {
            Some(place) => {
                pending.push(&line[place..]);
                pending.push(&line[..=place]);
            }
            None => kept.push(first),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(plan: &str) -> Vec<Outline> {
        let rows: Vec<Vec<char>> = plan.split_whitespace().map(|row| row.chars().collect()).collect();
        outlines([rows[0].len(), rows.len()], |x, y| rows[y][x] == '#')
    }

    /// Returns twice the area by the shoelace formula.
    fn area(outline: &Outline) -> f64 {
        let next = outline.iter().cycle().skip(1);
        outline
            .iter()
            .zip(next)
            .map(|(a, b)| a[0] * b[1] - b[0] * a[1])
            .sum()
    }

    #[test]
    fn a_room_around_a_court_has_two_outlines() {
        let found = of("########
                        #......#
                        #......#
                        #......#
                        ########");
        let areas: Vec<f64> = found.iter().map(area).collect();
        assert_eq!(areas, [80.0, -36.0]);
        assert!(found.iter().all(|outline| outline.len() == 4));
    }

    #[test]
    fn a_slanted_wall_is_straight() {
        let found = of("#.......
                        ##......
                        ###.....
                        ####....
                        #####...
                        ######..
                        #######.
                        ########");
        assert_eq!(found.len(), 1);
        assert!(found[0].len() <= 5, "{found:?}");
    }

    #[test]
    fn rooms_that_meet_at_a_corner_stay_apart() {
        let found = of("###...
                        ###...
                        ...###
                        ...###");
        assert_eq!(found.len(), 2);
        assert!(found.iter().all(|outline| area(outline) == 12.0));
    }
}
