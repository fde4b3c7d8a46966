//! Walkable floors of a geometry, voxelized into vertical spans on a horizontal grid.
//!
//! Idea: each triangle is clipped to the columns of the grid and added to their solid spans. The top of a span is a
//!     floor if its slope is small and the free height above it is sufficient. Floors of neighbouring columns are
//!     connected if the step between them is small.
//! Source: Mononen, Recast Navigation, 2009 (height field of spans); Snook, Simplified 3D Movement and Pathfinding
//!     Using Navigation Meshes, Game Programming Gems, 2000.
//! Cost: O(faces + columns covered by them), at most [`MAX_COLUMNS`] columns and [`MAX_PARTS`] parts of faces.

use crate::geometry::{Alpha, Geometry};
use crate::ids::ItemIndex;
use glam::DVec3;
use smallvec::SmallVec;

/// Maximum number of columns.
const MAX_COLUMNS: f64 = (1 << 20) as f64;
/// Maximum number of clipped triangles.
const MAX_PARTS: f64 = 5e7;
/// Minimum side of a column, in metres.
const COLUMN: f64 = 0.1;
/// Minimum free height above a floor, in metres.
pub(super) const HEADROOM: f64 = 1.4;
/// Maximum step between connected floors, in metres.
const STEP: f64 = 0.45;
/// Minimum free height below a roof, in metres.
pub(super) const BELOW_ROOF: f64 = 1.8;
/// Maximum number of floors from which the border of a room is searched.
const MOST_FOR_BORDER: usize = 1 << 14;
/// Cosine of the maximum slope of a floor.
const LEVEL: f64 = 0.7;

/// A walkable floor of one column.
#[derive(Clone, Copy, Debug)]
pub(super) struct Floor {
    pub(super) height: f32,
    /// Free height above it; infinite under open sky.
    pub(super) headroom: f32,
    pub(super) kind: Kind,
    column: u32,
}

/// Kind of a floor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Floor,
    /// Under open sky and above free space.
    Roof,
    /// Not in the file: at the lowest point of the geometry, below a column's first span. Many buildings lack their
    /// ground.
    Assumed,
}

/// The floors of one geometry.
pub(super) struct Floors {
    pub(super) all: Vec<Floor>,
    /// Side of a column.
    pub(super) side: f64,
    metre: f64,
    /// The lowest point.
    bottom: f32,
    origin: [f64; 2],
    size: [usize; 2],
    /// By column: where its floors start, and the end of the last.
    starts: Vec<u32>,
}

/// A solid interval of a column.
#[derive(Clone, Copy)]
struct Span {
    low: f32,
    high: f32,
    /// Whether the slope at its top is small enough for a floor.
    is_level: bool,
}

type Spans = SmallVec<[Span; 2]>;

impl Floors {
    /// Finds all floors. `metre` is the length of a metre in scene units.
    pub(super) fn of(geometry: &Geometry, metre: f64) -> Floors {
        let bounds = geometry.bounds();
        let [min, max] = [bounds.min, bounds.max].map(|corner| corner.map(f64::from));
        let extent = [max[0] - min[0], max[2] - min[2]];
        let mut reached = 0.0;
        each_triangle(geometry, |triangle| {
            let [low, high] = around(&triangle);
            reached += (high.x - low.x) * (high.z - low.z);
        });
        let side = (COLUMN * metre)
            .max((extent[0] * extent[1] / MAX_COLUMNS).sqrt())
            .max((reached / MAX_PARTS).sqrt())
            .max(extent[0].max(extent[1]) / MAX_COLUMNS.sqrt());
        let size = extent.map(|extent| (extent / side) as usize + 1);
        let mut floors = Floors {
            all: Vec::new(),
            side,
            metre,
            bottom: bounds.min[1],
            origin: [min[0], min[2]],
            size,
            starts: Vec::with_capacity(size[0] * size[1] + 1),
        };
        let mut columns = vec![Spans::new(); size[0] * size[1]];
        each_triangle(geometry, |triangle| floors.add(&triangle, &mut columns));
        floors.starts.push(0);
        for (column, spans) in columns.iter().enumerate() {
            floors.take_column(column as u32, spans);
            floors.starts.push(floors.all.len() as u32);
        }
        floors
    }

    /// Adds a triangle to the columns that it covers.
    fn add(&self, triangle: &[DVec3; 3], columns: &mut [Spans]) {
        let [a, b, c] = *triangle;
        let normal = (b - a).cross(c - a);
        let is_level = normal.y.abs() >= LEVEL * normal.length();
        let [low, high] = around(triangle);
        let place = |value: f64, axis: usize| {
            (((value - self.origin[axis]) / self.side) as usize).min(self.size[axis] - 1)
        };
        let rows = [place(low.z, 1), place(high.z, 1)];
        let all: Polygon = triangle.iter().copied().collect();
        for z in rows[0]..=rows[1] {
            let row = if rows[0] == rows[1] {
                all.clone()
            } else {
                between(&all, 2, self.limits(z, 1))
            };
            let Some([low, high]) = extent_along(&row, |p| p.x) else {
                continue;
            };
            let cells = [place(low, 0), place(high, 0)];
            for x in cells[0]..=cells[1] {
                let part = if cells[0] == cells[1] {
                    extent_along(&row, |p| p.y)
                } else {
                    extent_along(&between(&row, 0, self.limits(x, 0)), |p| p.y)
                };
                if let Some([low, high]) = part {
                    let span = Span {
                        low: low as f32,
                        high: high as f32,
                        is_level,
                    };
                    put(
                        &mut columns[z * self.size[0] + x],
                        span,
                        (0.05 * self.metre) as f32,
                    );
                }
            }
        }
    }

    /// Returns the coordinates at which a row of columns starts and ends.
    fn limits(&self, place: usize, axis: usize) -> [f64; 2] {
        [place, place + 1].map(|place| self.origin[axis] + place as f64 * self.side)
    }

    fn take_column(&mut self, column: u32, spans: &[Span]) {
        let [headroom, below_roof] = [HEADROOM, BELOW_ROOF].map(|metres| (metres * self.metre) as f32);
        if let Some(first) = spans.first().filter(|span| span.low - self.bottom >= headroom) {
            self.all.push(Floor {
                height: self.bottom,
                headroom: first.low - self.bottom,
                kind: Kind::Assumed,
                column,
            });
        }
        // Whether there is free space anywhere below. The top and the underside of a slab may be separate spans.
        let mut is_hollow = false;
        for (at, span) in spans.iter().enumerate() {
            is_hollow |= at > 0 && span.low - spans[at - 1].high >= below_roof;
            let free = spans
                .get(at + 1)
                .map_or(f32::INFINITY, |above| above.low - span.high);
            if !span.is_level || free < headroom {
                continue;
            }
            let is_roof = is_hollow && free == f32::INFINITY;
            self.all.push(Floor {
                height: span.high,
                headroom: free,
                kind: if is_roof { Kind::Roof } else { Kind::Floor },
                column,
            });
        }
    }

    /// Returns the centre of a floor.
    pub(super) fn place(&self, floor: u32) -> DVec3 {
        let Floor { height, column, .. } = self.all[floor as usize];
        let [x, z] = [column as usize % self.size[0], column as usize / self.size[0]];
        DVec3::new(
            self.origin[0] + (x as f64 + 0.5) * self.side,
            f64::from(height),
            self.origin[1] + (z as f64 + 0.5) * self.side,
        )
    }

    /// Returns `true` if most of the border of connected floors, within the grid, is above much lower floors. The
    /// outermost `margin` floors may be missing.
    pub(super) fn ends_at_drops(&self, floors: &[u32], margin: usize) -> bool {
        let [mut border, mut drops] = [0, 0];
        let sampled = floors
            .iter()
            .step_by(floors.len().div_ceil(MOST_FOR_BORDER).max(1));
        for (&floor, side) in sampled.flat_map(|floor| (0..4).map(move |side| (floor, side))) {
            if let Some(drop) = self.drop_beyond(floor, side, margin) {
                border += 1;
                drops += usize::from(drop >= BELOW_ROOF * self.metre);
            }
        }
        2 * drops > border
    }

    /// Returns the height of the border of connected floors, in one direction, above the highest floor beyond it; `None`
    /// if the border is more than `margin` floors away, or no floor is beyond it.
    fn drop_beyond(&self, mut floor: u32, side: usize, margin: usize) -> Option<f64> {
        for _ in 0..=margin {
            let Floor { height, column, .. } = self.all[floor as usize];
            match self.neighbours(floor)[side] {
                Some(next) => floor = next,
                None => {
                    let top = self.top(self.columns_around(column)[side]?)?;
                    return Some(f64::from(height - top));
                }
            }
        }
        None
    }

    /// Returns the height of the highest floor of a column.
    fn top(&self, column: usize) -> Option<f32> {
        let all = self.starts[column] as usize..self.starts[column + 1] as usize;
        self.all[all].last().map(|floor| floor.height)
    }

    /// Returns the four neighbouring columns.
    fn columns_around(&self, column: u32) -> [Option<usize>; 4] {
        let [width, depth] = self.size;
        let column = column as usize;
        let [x, z] = [column % width, column / width];
        [
            (x > 0).then(|| column - 1),
            (x + 1 < width).then_some(column + 1),
            (z > 0).then(|| column - width),
            (z + 1 < depth).then_some(column + width),
        ]
    }

    /// Returns the connected floors in the four neighbouring columns.
    pub(super) fn neighbours(&self, floor: u32) -> [Option<u32>; 4] {
        let from = self.all[floor as usize];
        // On a coarse grid slopes are steps.
        let step = (STEP * self.metre).max(self.side) as f32;
        let headroom = (HEADROOM * self.metre) as f32;
        let in_column = |column: usize| {
            let all = self.starts[column]..self.starts[column + 1];
            all.min_by(|&a, &b| {
                let off = |floor: u32| (self.all[floor as usize].height - from.height).abs();
                off(a).total_cmp(&off(b))
            })
            .filter(|&to| {
                let to = &self.all[to as usize];
                let ceiling = (from.height + from.headroom).min(to.height + to.headroom);
                (to.height - from.height).abs() <= step && ceiling - from.height.max(to.height) >= headroom
            })
        };
        self.columns_around(from.column)
            .map(|column| column.and_then(in_column))
    }
}

/// Corners of a clipped triangle.
type Polygon = SmallVec<[DVec3; 8]>;

/// Calls `take` with every triangle that is not alpha-blended, in the geometry's space.
fn each_triangle(geometry: &Geometry, mut take: impl FnMut([DVec3; 3])) {
    for item in (0..geometry.items().len() as u32).map(ItemIndex) {
        let mesh = geometry.mesh_of(item);
        let transform = geometry.item(item).transform();
        for cluster in mesh.clusters() {
            if geometry.material_of(item, cluster).alpha == Alpha::Blend {
                continue;
            }
            for face in cluster.faces.clone() {
                let corner = |&at: &u32| DVec3::from(transform.point_f64(mesh.positions()[at as usize]));
                let corners = mesh.face(face);
                let first = corner(&corners[0]);
                for pair in corners[1..].windows(2) {
                    take([first, corner(&pair[0]), corner(&pair[1])]);
                }
            }
        }
    }
}

fn around([a, b, c]: &[DVec3; 3]) -> [DVec3; 2] {
    [a.min(*b).min(*c), a.max(*b).max(*c)]
}

/// Returns the minimum and maximum of a coordinate; `None` for an empty polygon.
fn extent_along(polygon: &Polygon, of: impl Fn(&DVec3) -> f64) -> Option<[f64; 2]> {
    let first = of(polygon.first()?);
    Some(
        polygon
            .iter()
            .map(of)
            .fold([first; 2], |[low, high], value| [low.min(value), high.max(value)]),
    )
}

/// Clips a polygon to the interval `limits` of an axis.
fn between(polygon: &Polygon, axis: usize, limits: [f64; 2]) -> Polygon {
    let mut left = polygon.clone();
    for (limit, sign) in limits.into_iter().zip([1.0, -1.0]) {
        let mut kept = Polygon::new();
        for (at, &from) in left.iter().enumerate() {
            let to = left[(at + 1) % left.len()];
            let [here, there] = [from, to].map(|corner| sign * (corner[axis] - limit));
            if here >= 0.0 {
                kept.push(from);
            }
            if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
                kept.push(from + (to - from) * (here / (here - there)));
            }
        }
        left = kept;
    }
    left
}

/// Adds a span to those of a column, which are sorted; merges spans not farther apart than `gap`.
fn put(spans: &mut Spans, mut span: Span, gap: f32) {
    let first = spans.partition_point(|other| other.high + gap < span.low);
    let mut end = first;
    while let Some(other) = spans.get(end).filter(|other| other.low <= span.high + gap) {
        let is_level = if (other.high - span.high).abs() <= gap {
            other.is_level || span.is_level
        } else if other.high > span.high {
            other.is_level
        } else {
            span.is_level
        };
        span = Span {
            low: span.low.min(other.low),
            high: span.high.max(other.high),
            is_level,
        };
        end += 1;
    }
    spans.drain(first..end);
    spans.insert(first, span);
}
