//! Large convex pieces of a sheet that is not convex, such as a wall with windows or an L-shaped floor.
//!
//! A piece grows around a point. It begins as the bounding rectangle of the outline; as long as an edge of the outline
//! reaches into it, it is clipped at the nearest such edge, along that edge's line if possible. A finished piece is
//! grown again around its own centroid, with a metric stretched to its shape, for as long as it gains area. Pieces may
//! overlap: they are occluders, not a partition; each must add enough area to those before it.
//! No edge of the outline reaches into a piece, and its centre is in a face: so the whole piece is, by the argument in
//! the header of [`super::outline`]. If corners are off the plane by rounding, an eye at a grazing angle sees them
//! displaced, so pieces keep an [`inset`] from the outline and hide only for eyes at a steep enough angle.
//! Source: Deits, Tedrake, Computing Large Convex Regions of Obstacle-Free Space through Semidefinite Programming, WAFR
//!     2014: cuts at the nearest obstacle and a growing ellipse, here with a metric from second moments instead of a
//!     semidefinite program.
//! Cost: O(edges) for each cut, [`MAX_CUTS`] at most; O(edges + faces) for each piece; [`WORK`] bounds both for all
//!     pieces.

use super::flat::{Side, added_by, area_of, clipped, doubled, holds, inside, shape, sides};
use super::outline::{EXACT, MAX_CORNERS, Outline, fewer_corners};
use super::sheets::Sheet;
use super::soup::Soup;
use glam::{DMat2, DVec2, DVec3};

/// Maximum number of cuts of one piece: more leave a piece of many corners and little area.
const MAX_CUTS: usize = 64;

/// Maximum number of times that a piece is grown again.
const GROWTHS: usize = 3;

/// Maximum number of edges and faces examined for one sheet: about a hundredth of a second.
const WORK: usize = 1 << 21;

/// Maximum number of pieces of one sheet, and of consecutive failures to find one.
const MAX_PIECES: usize = 64;
const MAX_FAILURES: usize = 8;

/// Minimum part of a sheet's area that a piece must add.
const LEAST_ADDED: f64 = 0.01;

/// Returns the distance that a piece keeps from an outline whose corners are off their plane by `slack`. It serves eyes
/// whose height over the plane is at least 1/128 of the distance along it.
pub(super) fn inset(slack: f64) -> f64 {
    128.0 * slack
}

/// A convex piece of a sheet.
pub(super) struct SheetPiece {
    pub(super) corners: Vec<DVec3>,
    /// Distance that it keeps from the outline; 0 if none is needed.
    pub(super) inset: f64,
    pub(super) area: f64,
    /// Part of the area that no earlier piece of the sheet covers.
    pub(super) added: f64,
    /// Number of triangles of the sheet whose centres it covers and no earlier piece does.
    pub(super) triangles: u64,
}

/// Finds pieces of a sheet that each add at least `least_area`, starting around the largest faces.
pub(super) fn pieces(soup: &Soup, sheet: &Sheet, outline: &Outline, least_area: f64) -> Vec<SheetPiece> {
    let mut cutter = Cutter::of(outline, sheet.slack);
    let mut seeds: Vec<(f64, u32)> = sheet.faces.iter().map(|&face| (soup.area(face), face)).collect();
    seeds.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let middle_of = |face: u32| {
        let corners = soup.face(face);
        corners.iter().map(|&corner| outline.flat(corner)).sum::<DVec2>() / corners.len() as f64
    };
    let mut found: Vec<SheetPiece> = Vec::new();
    // Pieces in the plane. Rejected ones are kept so that they are not tried again from every face that they cover.
    let (mut taken, mut rejected): (Vec<Vec<DVec2>>, Vec<Vec<DVec2>>) = (Vec::new(), Vec::new());
    let (mut left, mut failures, mut work) = (sheet.area, 0, 0);
    let enough = least_area.max(LEAST_ADDED * sheet.area);
    for &(area, face) in &seeds {
        if area <= 0.0
            || left < enough
            || taken.len() == MAX_PIECES
            || failures == MAX_FAILURES
            || work > WORK
        {
            break;
        }
        work += 1 + taken.len() + rejected.len();
        let middle = middle_of(face);
        if taken.iter().chain(&rejected).any(|piece| holds(piece, middle)) {
            continue;
        }
        let grown = cutter.grow(middle, &mut work);
        // Use the face itself if growing gains no area.
        let is_face =
            soup.face(face).len() <= MAX_CORNERS && grown.as_ref().is_none_or(|piece| area_of(piece) <= area);
        let (flat, corners) = if is_face {
            let mut own = soup.face(face).to_vec();
            if soup.normal(face).dot(sheet.normal) < 0.0 {
                own.reverse();
            }
            let flat: Vec<DVec2> = own.iter().map(|&corner| outline.flat(corner)).collect();
            (flat, own.iter().map(|&corner| outline.corner(corner)).collect())
        } else if let Some(grown) = grown {
            let corners = grown.iter().map(|&corner| cutter.raised(corner)).collect();
            (grown, corners)
        } else {
            failures += 1;
            continue;
        };
        let added = added_by(&flat, &taken);
        if added < enough {
            failures += 1;
            rejected.push(flat);
            continue;
        }
        left -= added;
        failures = 0;
        found.push(SheetPiece {
            corners,
            inset: if is_face { 0.0 } else { cutter.inset },
            area: area_of(&flat),
            added,
            triangles: 0,
        });
        taken.push(flat);
    }
    for &(_, face) in &seeds {
        let middle = middle_of(face);
        if let Some(by) = taken.iter().position(|piece| holds(piece, middle)) {
            found[by].triangles += soup.triangles(face);
        }
    }
    found
}

/// A cutting line, the remaining polygon, and twice its area.
struct Cut {
    line: Side,
    left: Vec<DVec2>,
    area: f64,
}

/// Clips convex polygons until no edge of an outline reaches into them.
struct Cutter<'a> {
    outline: &'a Outline<'a>,
    /// Edges of the outline in the plane, from and to.
    edges: Vec<[DVec2; 2]>,
    /// Distance to keep from the outline.
    inset: f64,
    /// Rounding error of f64 in plane coordinates.
    rounding: f64,
    /// Edges that may still reach into the current piece.
    active: Vec<u32>,
}

impl<'a> Cutter<'a> {
    fn of(outline: &'a Outline<'a>, slack: f64) -> Cutter<'a> {
        Cutter {
            edges: outline
                .edges
                .iter()
                .map(|edge| edge.map(|end| outline.flat(end)))
                .collect(),
            inset: if outline.exact { 0.0 } else { inset(slack) },
            rounding: EXACT * outline.min.abs().max(outline.max.abs()).max_element(),
            active: Vec::new(),
            outline,
        }
    }

    /// Grows a large convex polygon around a point, counter-clockwise; `None` if there is none.
    fn grow(&mut self, around: DVec2, work: &mut usize) -> Option<Vec<DVec2>> {
        let mut best = self.cut(around, DMat2::IDENTITY, work)?;
        for _ in 0..GROWTHS {
            let (middle, measure) = shape(&best)?;
            let Some(next) = self.cut(middle, measure, work) else {
                break;
            };
            let gain = area_of(&next) / area_of(&best);
            if gain > 1.0 {
                best = next;
            }
            if gain < 1.01 {
                break;
            }
        }
        self.tidy(&mut best);
        if best.len() < 3 {
            return None;
        }
        let kept = fewer_corners(best.clone());
        Some(kept.into_iter().map(|place| best[place]).collect())
    }

    /// Removes corners that coincide with the next one or are collinear with both neighbours: cuts through one corner
    /// leave such. The remainder of a convex polygon is inside it.
    fn tidy(&self, piece: &mut Vec<DVec2>) {
        let mut place = 0;
        while place < piece.len() && piece.len() >= 3 {
            let count = piece.len();
            let [a, b, c] = [place + count - 1, place, place + 1].map(|place| piece[place % count]);
            let near = 4.0 * self.rounding;
            if b.distance(c) <= near || (b - a).perp_dot(c - b) <= near * a.distance(c) {
                piece.remove(place);
            } else {
                place += 1;
            }
        }
    }

    /// Clips the bounding rectangle around `middle` at the nearest edge that reaches into it, repeatedly; d·M·d is the
    /// squared distance.
    fn cut(&mut self, middle: DVec2, measure: DMat2, work: &mut usize) -> Option<Vec<DVec2>> {
        let (min, max) = (self.outline.min, self.outline.max);
        let mut piece = vec![min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)];
        // Stored as created: a half-plane recomputed from the corners of an almost degenerate edge would have an
        // arbitrary direction.
        let mut lines: Vec<Side> = sides(&piece).collect();
        self.active.clear();
        self.active.extend(0..self.edges.len() as u32);
        let mut near: Vec<(f64, DVec2, u32)> = Vec::new();
        for _ in 0..MAX_CUTS {
            *work += self.active.len();
            near.clear();
            let reach = self.rounding - self.inset;
            self.active.retain(|&edge| {
                let [from, to] = self.edges[edge as usize];
                let Some([start, end]) = inside(&lines, reach, from, to) else {
                    return false;
                };
                let (start, way) = (from + (to - from) * start, (to - from) * (end - start));
                let along = measure * way;
                let t = (along.dot(middle - start) / along.dot(way)).clamp(0.0, 1.0);
                let nearest = start + way * if t.is_finite() { t } else { 0.0 };
                let off = nearest - middle;
                near.push((off.dot(measure * off), nearest, edge));
                true
            });
            let Some(&(least, point, _)) = near.iter().min_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)))
            else {
                return Some(piece);
            };
            // Along one of the nearest edges, or perpendicular to the direction to the point.
            let mut best: Option<Cut> = None;
            for &(distance, _, edge) in &near {
                if distance <= least * (1.0 + 1e-9) {
                    let [from, to] = self.edges[edge as usize];
                    let line = Side::left_of(from, to);
                    self.try_cut(&piece, middle, line, &mut best);
                }
            }
            if best.is_none() {
                let inward = measure * (middle - point);
                self.try_cut(&piece, middle, Side::through(point, inward), &mut best);
            }
            let cut = best?;
            piece = cut.left;
            lines.push(cut.line);
        }
        None
    }

    /// Clips by a line, and replaces `best` if the remainder contains the middle and is the largest so far.
    fn try_cut(&self, piece: &[DVec2], middle: DVec2, line: Side, best: &mut Option<Cut>) {
        if !line.inward.is_finite() {
            return;
        }
        // Corners that deviate across the line shift it, so that they need no cuts of their own.
        let band = self.outline.wavering;
        let mut shift = 0.0_f64;
        for &edge in &self.active {
            for end in self.edges[edge as usize] {
                let height = line.height(end);
                if height > shift && height <= band {
                    shift = height;
                }
            }
        }
        let line = line.moved(shift + self.inset);
        if line.height(middle) <= 0.0 {
            return;
        }
        let left = clipped(piece, &line);
        let area = doubled(&left);
        if area > 0.0 && best.as_ref().is_none_or(|most| area > most.area) {
            *best = Some(Cut { line, left, area });
        }
    }

    /// Returns a corner in space: the exact corner of the outline if it coincides with one.
    fn raised(&self, corner: DVec2) -> DVec3 {
        let own = (self.inset == 0.0)
            .then(|| {
                let mut ends = self.edges.iter().zip(&self.outline.edges);
                ends.find(|(flat, _)| flat[0].distance(corner) <= self.rounding)
            })
            .flatten();
        match own {
            Some((_, ends)) => self.outline.corner(ends[0]),
            None => self.outline.raised(corner),
        }
    }
}
