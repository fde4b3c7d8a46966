//! Guesses the up axis and the unit of a building from its triangles.

use super::grid::{Grid, VoxelSet};
use super::input::{Bounds, Metric, RoomsInput, Up};
use glam::DVec3;
use std::ops::RangeInclusive;

/// Units that files are made in, in metres: metre, centimetre, millimetre, inch, foot.
const UNITS: [f64; 5] = [1.0, 0.01, 0.001, 0.0254, 0.3048];

/// Heights of rooms, in metres, for which the unit is a metre without a guess; up to the nave of a church.
const ROOMS: RangeInclusive<f64> = 1.5..=40.0;

/// Usual height of a room, in metres.
const USUAL: f64 = 2.8;

/// Returns the axis that floors face, by [`FaceAreas::up`]; [`Up::Y`] where that is not clear.
pub fn detect_up(input: &RoomsInput) -> Up {
    let as_it_is = Metric {
        up: Up::Y,
        metres_per_unit: 1.0,
    };
    let all = around(input, &as_it_is);
    let mut areas = FaceAreas::new([all.min, all.max]);
    for item in 0..input.items.len() {
        input.for_each_triangle(item, &as_it_is, |&corners, _| areas.add(corners));
    }
    areas.up().unwrap_or(Up::Y)
}

/// Areas of faces by the axis that they face and the height along it: what the up axis of a scene is found from.
///
/// ```
/// use enfilade_bake::{FaceAreas, Up};
///
/// // A box of 8 x 6 x 3, with z up.
/// let mut areas = FaceAreas::new([[0.0; 3], [8.0, 6.0, 3.0]]);
/// let mut face = |a, b, c, d| [[a, b, c], [a, c, d]].map(|corners| areas.add(corners));
/// for z in [0.0, 3.0] {
///     face([0.0, 0.0, z], [8.0, 0.0, z], [8.0, 6.0, z], [0.0, 6.0, z]);
/// }
/// for x in [0.0, 8.0] {
///     face([x, 0.0, 0.0], [x, 6.0, 0.0], [x, 6.0, 3.0], [x, 0.0, 3.0]);
/// }
/// for y in [0.0, 6.0] {
///     face([0.0, y, 0.0], [8.0, y, 0.0], [8.0, y, 3.0], [0.0, y, 3.0]);
/// }
/// assert_eq!(areas.up(), Some(Up::Z));
/// ```
#[derive(Clone, Debug)]
pub struct FaceAreas {
    min: DVec3,
    size: DVec3,
    /// By height along the longest extent: areas of the faces across each axis.
    planes: Vec<DVec3>,
    /// Areas of all faces, projected along each axis.
    projected: DVec3,
    all: f64,
    triangles: u64,
}

/// Planes that are distinguished along the longest extent.
const PLANES: usize = 256;

impl FaceAreas {
    /// Creates the areas of no faces, in a box that contains all that will be added: its minimum and its maximum corner.
    pub fn new([min, max]: [[f64; 3]; 2]) -> FaceAreas {
        FaceAreas {
            min: min.into(),
            size: DVec3::from(max) - DVec3::from(min),
            planes: vec![DVec3::ZERO; PLANES],
            projected: DVec3::ZERO,
            all: 0.0,
            triangles: 0,
        }
    }

    /// Adds a triangle; one that is not finite is ignored.
    pub fn add(&mut self, corners: [[f64; 3]; 3]) {
        self.add_sample(corners, 1);
    }

    /// Adds a triangle as a sample of this many like it; one that is not finite is ignored.
    #[inline]
    pub fn add_sample(&mut self, corners: [[f64; 3]; 3], count: u32) {
        /// Cosine of the angle to an axis.
        const ALONG: f64 = 0.99;
        let [a, b, c] = corners.map(DVec3::from);
        let normal = (b - a).cross(c - a).abs() * f64::from(count);
        let area = normal.length();
        if !area.is_finite() {
            return;
        }
        self.triangles += u64::from(count);
        self.all += area;
        self.projected += normal;
        for axis in 0..3 {
            if normal[axis] > ALONG * area {
                let height = (a[axis] - self.min[axis]) / self.size.max_element();
                let plane = (height * PLANES as f64) as usize;
                self.planes[plane.min(PLANES - 1)][axis] += area;
            }
        }
    }

    /// Adds the areas of other faces in the same box.
    pub fn merge(&mut self, others: &FaceAreas) {
        for (plane, other) in self.planes.iter_mut().zip(&others.planes) {
            *plane += *other;
        }
        self.projected += others.projected;
        self.all += others.all;
        self.triangles += others.triangles;
    }

    /// Returns the up axis: the one that floors face. `None` where that is not clear.
    ///
    /// A building is wider than high, and its floors are at few heights: across the up axis there is the most area, and the
    /// most of it in few planes. Another axis than y must have clearly more of both, and walls around it, because many objects
    /// with y up, such as shelves and facades, have a large back.
    pub fn up(&self) -> Option<Up> {
        /// Ratio of scores from which on one axis is clearly the up axis, and from which on x is, which few programs use.
        const CLEARLY: f64 = 1.5;
        const CLEARLY_X: f64 = 2.0;
        let scores = self.scores();
        let [x, y, z] = scores.to_array();
        if z > CLEARLY * y && z * CLEARLY_X > x {
            return self.is_place(2).then_some(Up::Z);
        }
        if x > CLEARLY_X * y.max(z) {
            return self.is_place(0).then_some(Up::X);
        }
        (y > CLEARLY * z).then_some(Up::Y)
    }

    /// Returns for each axis the product of three areas across it: that of all planes, that of the largest plane, and the root
    /// mean square, which is large if few planes have most of the area.
    fn scores(&self) -> DVec3 {
        let sum = |part: fn(DVec3) -> DVec3| self.planes.iter().map(|&areas| part(areas)).sum::<DVec3>();
        let of_all = sum(|areas| areas);
        let largest = self.largest();
        let squares = sum(|areas| areas * areas);
        of_all * largest * squares.map(f64::sqrt)
    }

    fn largest(&self) -> DVec3 {
        self.planes.iter().copied().fold(DVec3::ZERO, DVec3::max)
    }

    /// Returns `true` if a scene with this up axis is a place to be in: the faces outside its largest floor also face the other
    /// two axes, and what is as flat as a shelf that lies on its back has many faces, as a town has.
    fn is_place(&self, up: usize) -> bool {
        /// Minimum share of the area that faces each other axis.
        const WALLS: f64 = 0.1;
        /// Ratio of height to width below which a scene is flat.
        const FLAT: f64 = 0.35;
        const MANY_TRIANGLES: u64 = 500;
        let others = [(up + 1) % 3, (up + 2) % 3];
        let rest = self.all - self.largest()[up];
        let has_walls = others.iter().all(|&axis| self.projected[axis] > WALLS * rest);
        let width = self.size[others[0]].min(self.size[others[1]]);
        has_walls && (self.size[up] > FLAT * width || self.triangles >= MANY_TRIANGLES)
    }
}

/// Returns the box of all items.
fn around(input: &RoomsInput, metric: &Metric) -> Bounds {
    let mut all = Bounds::EMPTY;
    for bounds in input.bounds(metric).iter().filter(|bounds| !bounds.is_empty()) {
        all.add(bounds.min);
        all.add(bounds.max);
    }
    all
}

/// Returns the metres per scene unit: 1 if rooms are as high as rooms are, else that of the usual unit for which they
/// are. `None` if there are no rooms with a floor and a ceiling.
pub fn detect_metres_per_unit(input: &RoomsInput, up: Up) -> Option<f64> {
    room_height(input, up).map(metres_per_unit_of)
}

/// Returns the metres per scene unit if rooms have this median height in scene units: 1 if that is the height of a room in
/// metres, else the usual unit in which it is.
pub fn metres_per_unit_of(room_height: f64) -> f64 {
    if ROOMS.contains(&room_height) {
        return 1.0;
    }
    let off = |unit: &f64| (room_height * unit / USUAL).ln().abs();
    let nearest = UNITS.into_iter().min_by(|a, b| off(a).total_cmp(&off(b)));
    nearest.unwrap_or(1.0)
}

/// Returns the median height of the free space between a floor and a ceiling, in scene units.
fn room_height(input: &RoomsInput, up: Up) -> Option<f64> {
    const MAX_VOXELS: usize = 4_000_000;
    /// Voxels across the longest extent.
    const ACROSS: f64 = 384.0;
    /// Minimum height in voxels.
    const MIN_HEIGHT: usize = 3;
    let metric = Metric {
        up,
        metres_per_unit: 1.0,
    };
    let all = around(input, &metric);
    let longest = all.size().into_iter().fold(0.0, f64::max);
    if all.is_empty() || longest.is_infinite() || longest <= 0.0 {
        return None;
    }
    let step = longest / ACROSS;
    let grid = Grid::around(&all, step, step, MAX_VOXELS);
    let solid = VoxelSet::new(&grid);
    for item in 0..input.items.len() {
        input.for_each_triangle(item, &metric, |corners, _| {
            grid.for_each_voxel_of(corners, |voxel| solid.insert(voxel));
        });
    }
    // Number of free voxels by the height of their free space: by volume, because hollow slabs have as much area as rooms.
    let [columns, slices, rows] = grid.size;
    let mut heights = vec![0_u64; slices + 1];
    for z in 0..rows {
        for x in 0..columns {
            let mut last_solid: Option<usize> = None;
            for y in 0..slices {
                if solid.has(grid.index([x, y, z])) {
                    if let Some(last) = last_solid
                        && y - last > MIN_HEIGHT
                    {
                        heights[y - last - 1] += (y - last - 1) as u64;
                    }
                    last_solid = Some(y);
                }
            }
        }
    }
    let total: u64 = heights.iter().sum();
    let mut below = 0;
    let median = heights.iter().position(|&count| {
        below += count;
        total > 0 && 2 * below >= total
    })?;
    Some(median as f64 * grid.step)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes, from their least to their greatest corner.
    type Boxes = Vec<[[f64; 3]; 2]>;

    /// Returns the up axis of boxes whose axes are exchanged: with 1, what was y becomes z.
    fn up_of(boxes: &Boxes, turns: usize) -> Option<Up> {
        let turned = |mut point: [f64; 3]| {
            point.rotate_right(turns);
            point
        };
        let boxes: Boxes = boxes.iter().map(|ends| ends.map(turned)).collect();
        let mut around = Bounds::EMPTY;
        boxes.iter().flatten().for_each(|&corner| around.add(corner));
        let mut areas = FaceAreas::new([around.min, around.max]);
        for ends in &boxes {
            for axis in 0..3 {
                let [a, b] = [(axis + 1) % 3, (axis + 2) % 3];
                for end in 0..2 {
                    let corner = |at_a: usize, at_b: usize| {
                        let mut corner = ends[end];
                        (corner[a], corner[b]) = (ends[at_a][a], ends[at_b][b]);
                        corner
                    };
                    let quad = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                    areas.add([quad[0], quad[1], quad[2]]);
                    areas.add([quad[0], quad[2], quad[3]]);
                }
            }
        }
        areas.up()
    }

    /// Two storeys with y up: slabs, and walls around and between.
    fn house() -> Boxes {
        let mut boxes = Vec::new();
        for storey in 0..3 {
            let y = 3.0 * f64::from(storey);
            boxes.push([[0.0, y - 0.3, 0.0], [12.0, y, 9.0]]);
        }
        for storey in 0..2 {
            let [low, high] = [3.0 * f64::from(storey), 3.0 * f64::from(storey) + 2.7];
            for x in [0.0, 6.0, 11.8] {
                boxes.push([[x, low, 0.0], [x + 0.2, high, 9.0]]);
            }
            for z in [0.0, 8.8] {
                boxes.push([[0.0, low, z], [12.0, high, z + 0.2]]);
            }
        }
        boxes
    }

    #[test]
    fn a_house_stands_whichever_axis_is_up() {
        for (turns, up) in [(0, Up::Y), (1, Up::Z), (2, Up::X)] {
            assert_eq!(up_of(&house(), turns), Some(up));
        }
    }

    #[test]
    fn what_has_a_large_back_is_not_laid_on_it() {
        let mut shelf = vec![[[0.0, 0.0, 0.0], [1.0, 2.0, 0.02]]];
        shelf.extend((0..6).map(|board| {
            let y = 0.39 * f64::from(board);
            [[0.0, y, 0.0], [1.0, y + 0.02, 0.3]]
        }));
        shelf.extend([0.0, 0.98].map(|x| [[x, 0.0, 0.0], [x + 0.02, 2.0, 0.3]]));
        let picture = vec![[[0.0, 0.0, 0.0], [2.0, 1.5, 0.05]]];
        let facade_with_steps = vec![
            [[0.0, 0.0, 0.0], [12.0, 9.0, 0.5]],
            [[5.0, 0.0, 0.5], [7.0, 0.3, 1.5]],
        ];
        for object in [shelf, picture, facade_with_steps] {
            let up = up_of(&object, 0);
            assert!(up.is_none_or(|up| up == Up::Y), "{up:?}: {object:?}");
        }
    }

    #[test]
    fn a_cube_and_nothing_tell_no_axis() {
        assert_eq!(up_of(&vec![[[0.0; 3], [1.0; 3]]], 0), None);
        assert_eq!(FaceAreas::new([[0.0; 3], [1.0; 3]]).up(), None);
        let mut areas = FaceAreas::new([[0.0; 3]; 2]);
        areas.add([[0.0; 3], [f64::NAN; 3], [1e300; 3]]);
        areas.add([[0.0; 3]; 3]);
        assert_eq!(areas.up(), None);
    }
}
