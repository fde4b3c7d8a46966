//! A triangle in cell coordinates: the cells that it and its edges touch, and bounds of its depth there.

use crate::raster::{Triangle, greater, smaller};
use crate::view::aperture::Rect;
use crate::view::passage::{BEYOND, Passage};
use crate::view::screen_map::ScreenMap;
use glam::DVec3;
use smallvec::SmallVec;

/// A vertex, as shared by faces.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    /// (X, Y, W), in cells.
    at: DVec3,
    /// Hash of the position and its space.
    name: u64,
}

/// Line through two vertices, and the signed hash of the edge between them.
type Line = (DVec3, u64);

/// An edge of a face, after clipping.
#[derive(Clone, Copy)]
pub(super) struct Edge {
    /// Summand of the cells that it touches; the face on its other side adds the negative.
    pub(super) name: u64,
    /// The points (x, y) with line · (x, y, 1) = 0. Has the same bits for both faces.
    line: DVec3,
    /// Bounds of the clipped edge.
    min: [f64; 2],
    max: [f64; 2],
}

/// Coverage of one row of cells; each pair is a first column and an end column (exclusive).
pub(super) struct Row {
    /// Columns that the face touches.
    pub(super) columns: [u16; 2],
    /// Columns inside the face, which it covers alone.
    pub(super) within: [u16; 2],
    /// Columns that each edge touches.
    pub(super) edges: SmallVec<[[u16; 2]; MAX_EDGES]>,
}

/// Maximum number of edges of a triangle clipped by two planes.
const MAX_EDGES: usize = 5;

/// A triangle, clipped at the near plane and the entry plane.
pub(super) struct Face {
    edges: SmallVec<[Edge; MAX_EDGES]>,
    /// Bounding rectangle in cells.
    pub(super) rect: Rect,
    min: [f64; 2],
    max: [f64; 2],
    /// Distance from the sides of a cell's square to the sides of the cell: ½ minus half the side of the square.
    inset: f64,
    /// Plane of reversed depth slope · (x, y, 1), and the minimum at the corners.
    slope: DVec3,
    least: f64,
    nearest: f64,
}

/// Distance, in cells, within which something counts as touching a cell. Positions are accurate to 10⁻⁹.
const SLACK: f64 = 1e-6;

/// Slope below which a line counts as horizontal: its crossings with a row would be less accurate than [`SLACK`].
const LEVEL: f64 = 1.0 / (1_u64 << 20) as f64;

/// Generous bound on the rounding error of sums of three products, relative to the largest.
const ROUNDING: f64 = 1.0 / (1_u64 << 48) as f64;

/// Factor that lowers reversed depth before it is stored: covers rounding to f32 and the multiplication.
const ROUND_DOWN: f64 = 1.0 - 1.0 / (1_u64 << 22) as f64;

/// Same as `ROUND_UP` in `region`.
const ROUND_UP: f64 = 1.0 + 1.0 / (1_u64 << 20) as f64;

/// Returns a hash of a space, from its transform to the screen.
pub(super) fn name_of_space(screen_from_local: &ScreenMap) -> u64 {
    let numbers = screen_from_local.linear.to_cols_array();
    numbers
        .iter()
        .fold(0, |name, number| mix(name ^ number.to_bits()))
}

/// Mixes all bits. Constants of the finalizer of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014).
#[inline(always)]
fn mix(name: u64) -> u64 {
    let name = (name ^ (name >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let name = (name ^ (name >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    (name ^ (name >> 31)).wrapping_add(0x9E37_79B9_7F4A_7C15)
}

impl Corner {
    #[inline(always)]
    pub(super) fn new(position: [f32; 3], screen_from_local: &ScreenMap, space: u64) -> Corner {
        // Adding zero turns −0 into +0, which would hash differently.
        let [x, y, z] = position.map(|value| u64::from((value + 0.0).to_bits()));
        let position = DVec3::from(position.map(f64::from));
        Corner {
            at: screen_from_local.point(position),
            name: mix(mix(space ^ (x << 32 | y)) ^ z),
        }
    }
}

impl Edge {
    /// Creates an edge that was clipped to `from`..`to`; `name` is its signed hash.
    #[inline(always)]
    fn new(line: DVec3, name: u64, [from, to]: [[f64; 2]; 2]) -> Edge {
        Edge {
            name,
            line,
            min: [smaller(from[0], to[0]), smaller(from[1], to[1])],
            max: [greater(from[0], to[0]), greater(from[1], to[1])],
        }
    }

    /// Returns the line through two vertices and the edge's hash. The opposite direction gives the same line and the
    /// negative hash. `None` if both vertices are the same.
    #[inline(always)]
    fn between(from: &Corner, to: &Corner) -> Option<Line> {
        let forward = from.name < to.name;
        let [first, second] = if forward { [from, to] } else { [to, from] };
        let name = mix(first.name ^ second.name.rotate_left(32));
        let signed = if forward { name } else { name.wrapping_neg() };
        (first.name != second.name).then(|| (first.at.cross(second.at - first.at), signed))
    }

    /// Returns the minimum and maximum x of the edge in row `y` of cells; `None` if it does not reach the row.
    #[inline(always)]
    fn reach(&self, y: u16, inset: f64) -> Option<[f64; 2]> {
        let y0 = greater(self.min[1], f64::from(y) + (inset - SLACK));
        let y1 = smaller(self.max[1], f64::from(y) + (1.0 - inset + SLACK));
        if y0 > y1 {
            return None;
        }
        let DVec3 { x: a, y: b, z: c } = self.line;
        if a.abs() <= b.abs() * LEVEL {
            return Some([self.min[0], self.max[0]]);
        }
        let [x0, x1] = [-(b * y0 + c) / a, -(b * y1 + c) / a];
        let within = |x: f64| smaller(greater(x, self.min[0]), self.max[0]);
        Some([within(smaller(x0, x1)), within(greater(x0, x1))])
    }
}

impl Face {
    /// Clips a triangle. Returns `None` if it is edge-on, back-facing, outside `limits` or clipped away.
    ///
    /// `front` is the sign of the determinant of front-facing corners, or 0 for double-sided faces; `half` is half the side
    /// of the square of a cell.
    #[inline(always)]
    pub(super) fn of(
        corners: [&Corner; 3],
        front: f64,
        passage: &Passage,
        half: f64,
        limits: &Rect,
    ) -> Option<Face> {
        let [a, b, c] = corners.map(|corner| corner.at);
        let normal = (b - a).cross(c - a);
        let determinant = normal.dot(a);
        if determinant == 0.0 || front * determinant < 0.0 || !determinant.is_finite() {
            return None;
        }
        // Same winding on the screen, whichever side is visible. So the two faces at a silhouette edge, where the
        // surface folds over, do not cancel there.
        let [a, b, c] = if determinant < 0.0 {
            corners
        } else {
            [corners[0], corners[2], corners[1]]
        };
        let near = f64::from(passage.z_near);
        let inside = |at: DVec3| {
            let beyond_entry = passage
                .entry
                .is_none_or(|(normal, distance)| normal.dot(at) > distance * BEYOND);
            at.z > near && beyond_entry
        };
        let slope = normal / determinant;
        let mut face = Face {
            edges: SmallVec::new(),
            rect: Rect::default(),
            min: [f64::INFINITY; 2],
            max: [f64::NEG_INFINITY; 2],
            inset: 0.5 - half,
            slope,
            least: f64::INFINITY,
            nearest: 0.0,
        };
        if inside(a.at) && inside(b.at) && inside(c.at) {
            let pixels = [a, b, c].map(|corner| face.add_corner(corner.at));
            face.rect = face.within(limits)?;
            for (place, [from, to]) in [[a, b], [b, c], [c, a]].into_iter().enumerate() {
                if let Some((line, name)) = Edge::between(from, to) {
                    face.edges
                        .push(Edge::new(line, name, [pixels[place], pixels[(place + 1) % 3]]));
                }
            }
        } else {
            face.clip([a, b, c], near, passage);
            face.rect = face.within(limits)?;
        }
        (face.edges.len() >= 3).then_some(face)
    }

    /// Extends the bounds by a corner and returns its position on the screen.
    #[inline(always)]
    fn add_corner(&mut self, at: DVec3) -> [f64; 2] {
        let rev_depth = 1.0 / at.z;
        let pixel = [at.x * rev_depth, at.y * rev_depth];
        for (axis, value) in pixel.into_iter().enumerate() {
            self.min[axis] = smaller(value, self.min[axis]);
            self.max[axis] = greater(value, self.max[axis]);
        }
        self.least = smaller(rev_depth, self.least);
        self.nearest = greater(rev_depth, self.nearest);
        pixel
    }

    /// Clips a triangle at the near plane and the entry plane. A face that ends at one of them is not drawn, so it must not
    /// occlude either: nothing is left of it.
    #[cold]
    fn clip(&mut self, corners: [&Corner; 3], near: f64, passage: &Passage) {
        let mut kept: SmallVec<[(DVec3, Option<Line>); MAX_EDGES]> = [[0, 1], [1, 2], [2, 0]]
            .into_iter()
            .map(|[from, to]| (corners[from].at, Edge::between(corners[from], corners[to])))
            .collect();
        let entry = passage
            .entry
            .map(|(normal, distance)| (normal, distance * BEYOND));
        for (normal, distance) in [Some((DVec3::Z, near)), entry].into_iter().flatten() {
            let whole = std::mem::take(&mut kept);
            if whole.iter().all(|(at, _)| normal.dot(*at) <= distance) {
                return;
            }
            for (i, &(here, edge)) in whole.iter().enumerate() {
                let (there, _) = whole[(i + 1) % whole.len()];
                let [at_here, at_there] = [here, there].map(|at| normal.dot(at) - distance);
                if at_here >= 0.0 {
                    kept.push((here, edge));
                }
                if (at_here < 0.0) != (at_there < 0.0) {
                    let cut = here + (there - here) * (at_here / (at_here - at_there));
                    // The cut is a new edge, which no face has on its other side.
                    kept.push((cut, if at_here < 0.0 { edge } else { None }));
                }
            }
        }
        for (i, &(from, edge)) in kept.iter().enumerate() {
            let (to, _) = kept[(i + 1) % kept.len()];
            let ends = [self.add_corner(from), self.add_corner(to)];
            // The cut has no line, so it counts as its whole extent in each row that it reaches.
            let (line, name) = edge.unwrap_or((DVec3::ZERO, mix(from.x.to_bits() ^ mix(to.y.to_bits())) | 1));
            self.edges.push(Edge::new(line, name, ends));
        }
    }

    pub(super) fn edges(&self) -> &[Edge] {
        &self.edges
    }

    #[inline(always)]
    fn within(&self, limits: &Rect) -> Option<Rect> {
        let [x0, x1] = touched(self.min[0], self.max[0], self.inset, [limits.x0, limits.x1])?;
        let [y0, y1] = touched(self.min[1], self.max[1], self.inset, [limits.y0, limits.y1])?;
        Some(Rect { x0, y0, x1, y1 })
    }

    /// Returns `true` if the face is entirely inside the squares of these cells.
    #[inline(always)]
    pub(super) fn is_within(&self, rect: &Rect) -> bool {
        let [low, high] = [[rect.x0, rect.y0], [rect.x1, rect.y1]].map(|corner| corner.map(f64::from));
        (0..2)
            .all(|axis| self.min[axis] >= low[axis] + self.inset && self.max[axis] <= high[axis] - self.inset)
    }

    /// Returns the maximum reversed depth, rounded up.
    pub(super) fn nearest(&self) -> f32 {
        (self.nearest * ROUND_UP) as f32
    }

    /// Returns the columns that the face and its edges touch in a row of cells; `None` if there are none.
    #[inline(always)]
    pub(super) fn row(&self, y: u16, limits: &Rect) -> Option<Row> {
        let limits = [limits.x0, limits.x1];
        let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY];
        let mut edges = SmallVec::new();
        for edge in &self.edges {
            let reach = edge.reach(y, self.inset);
            edges.push(
                reach
                    .and_then(|[x0, x1]| touched(x0, x1, self.inset, limits))
                    .unwrap_or([0; 2]),
            );
            if let Some([x0, x1]) = reach {
                low = smaller(x0, low);
                high = greater(x1, high);
            }
        }
        let columns = touched(low, high, self.inset, limits)?;
        let within = within(columns, &edges);
        Some(Row {
            columns,
            within,
            edges,
        })
    }

    /// Returns an upper bound of the reversed depth in the cells that the face touches, as a plane evaluated at cell
    /// centres. Not clamped to the corners, so that it is linear.
    pub(super) fn upper_plane(&self, limits: &Rect) -> Triangle {
        let DVec3 { x: a, y: b, z: c } = self.slope;
        let most = a.abs() * f64::from(limits.x1) + b.abs() * f64::from(limits.y1) + c.abs();
        let lifted = c + (a.abs() + b.abs()) * (0.5 - self.inset + SLACK) + most * ROUNDING;
        Triangle {
            owner: 0,
            rev_depth: DVec3::new(a, b, lifted) * ROUND_UP,
            least: 0.0,
            greatest: self.nearest * ROUND_UP,
        }
    }

    /// Returns a lower bound of the reversed depth in the cells inside the face, as a plane evaluated at cell centres.
    #[inline(always)]
    pub(super) fn lower_plane(&self, limits: &Rect) -> Triangle {
        let DVec3 { x: a, y: b, z: c } = self.slope;
        let most = a.abs() * f64::from(limits.x1) + b.abs() * f64::from(limits.y1) + c.abs();
        let lowered = c - (a.abs() + b.abs()) * (0.5 - self.inset + SLACK) - most * ROUNDING;
        Triangle {
            owner: 0,
            rev_depth: DVec3::new(a, b, lowered) * ROUND_DOWN,
            least: self.least * ROUND_DOWN,
            greatest: f64::from(f32::MAX),
        }
    }

    /// Returns a lower bound of the reversed depth in a cell that the face touches.
    #[inline(always)]
    pub(super) fn least_in(&self, x: u16, y: u16) -> f32 {
        let DVec3 { x: a, y: b, z: c } = self.slope;
        // Linear, so the minimum is at a corner.
        let [low, high] = [self.inset - SLACK, 1.0 - self.inset + SLACK];
        let x = f64::from(x) + if a < 0.0 { high } else { low };
        let y = f64::from(y) + if b < 0.0 { high } else { low };
        let rounding = (a.abs() * x.abs() + b.abs() * y.abs() + c.abs()) * ROUNDING;
        let rev_depth = greater(a * x + (b * y + c) - rounding, self.least) * ROUND_DOWN;
        let rev_depth = smaller(rev_depth, f64::from(f32::MAX)) as f32;
        // Subnormal numbers round more coarsely, so store them as infinitely far.
        if rev_depth < f32::MIN_POSITIVE {
            0.0
        } else {
            rev_depth
        }
    }
}

/// Returns the columns that no edge touches. They are contiguous, because a face is convex.
#[inline(always)]
fn within(columns: [u16; 2], edges: &[[u16; 2]]) -> [u16; 2] {
    let [mut first, mut end] = columns;
    // The inside is entirely on one side of each edge. So each edge removes its smaller side: the larger one contains
    // the inside, or another edge removes it.
    for &[x0, x1] in edges {
        if x0 >= x1 || x1 <= first || x0 >= end {
            continue;
        }
        if x0.saturating_sub(first) > end.saturating_sub(x1) {
            end = x0;
        } else {
            first = x1.min(end);
        }
    }
    [first, end.max(first)]
}

/// Returns the first cell of a row or column inside `limits` whose square `low..high` touches, and the end (exclusive);
/// `None` if there is none.
#[inline(always)]
fn touched(low: f64, high: f64, inset: f64, limits: [u16; 2]) -> Option<[u16; 2]> {
    let [first, end] = limits.map(f64::from);
    // Cell x is touched if `low` is at most x + 1, and `high` at least x, after the squares are blown up to whole cells.
    let [low, high] = [low - SLACK + inset, high + SLACK - inset];
    // Written so that NaN fails too.
    if !(low < end && high >= first) {
        return None;
    }
    let last = smaller(high, end - 1.0) as u16;
    let touched = [greater(low, first) as u16, last + 1];
    (touched[0] < touched[1]).then_some(touched)
}
