//! Merges coplanar faces of a mesh that are connected by edges into sheets.
//!
//! A sheet grows from the largest face by a flood fill over neighbours whose corners are in its plane. The plane is
//! then fitted again to all faces found, because the plane of one small face is too imprecise to reach far.
//! Single-sided and double-sided faces never mix, and faces that face the other way do not join.
//! Source: flood fill; the plane by Newell's sum (Tampieri, Graphics Gems III, 1992).
//! Cost: O(n log n) for sorting faces by area, then O(faces in the sheet) for each of a few fits.
//! A face is in at most one sheet. The corners of a sheet are off its plane by at most [`Sheet::slack`], which is at
//! most [`SPACINGS`] roundings of f32.

use super::soup::Soup;
use glam::DVec3;

/// Maximum distance of a corner from the plane of its sheet, in f32 spacings. A wall that was transformed before its
/// corners were rounded is off by one or two.
const SPACINGS: f64 = 8.0;

/// An edge shared by more faces than this connects none: the pages of a book would be merged through its spine.
const MAX_SHARERS: usize = 16;

/// Maximum number of plane fits; each lets a sheet reach up to eight times as far.
const FITTINGS: u32 = 6;

/// Connected coplanar faces.
pub(super) struct Sheet {
    /// Indices of faces in the soup.
    pub(super) faces: Vec<u32>,
    /// Unit normal; single-sided faces are visible from the side that it points to.
    pub(super) normal: DVec3,
    /// Distance of the plane from the origin, along the normal.
    pub(super) distance: f64,
    /// Maximum distance of a corner from the plane.
    pub(super) slack: f64,
    pub(super) double_sided: bool,
    pub(super) area: f64,
}

impl Soup {
    /// Calls `found` with each sheet whose area is at least `least_area`, starting with that of the largest face.
    pub(super) fn sheets(&self, least_area: f64, mut found: impl FnMut(Sheet)) {
        let mut by_area: Vec<(f64, u32)> = (0..self.face_count() as u32)
            .map(|face| (self.area(face), face))
            .collect();
        by_area.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut fill = SheetFill {
            soup: self,
            taken: vec![false; self.face_count()],
            met: vec![0; self.face_count()],
            walk: 0,
            faces: Vec::new(),
            waiting: Vec::new(),
        };
        for (area, seed) in by_area {
            if area <= 0.0 {
                break;
            }
            if fill.taken[seed as usize] {
                continue;
            }
            fill.taken[seed as usize] = true;
            if let Some(sheet) = fill.sheet(seed, least_area) {
                for &face in &sheet.faces {
                    fill.taken[face as usize] = true;
                }
                if sheet.area >= least_area {
                    found(sheet);
                }
            }
        }
    }
}

/// State of the flood fills.
struct SheetFill<'a> {
    soup: &'a Soup,
    /// Whether each face is already in a sheet or rejected.
    taken: Vec<bool>,
    /// For each face, the last fill that visited it.
    met: Vec<u32>,
    /// Number of the current fill.
    walk: u32,
    /// Faces found by the last fill, and in `waiting` the stack of faces still to expand.
    faces: Vec<u32>,
    waiting: Vec<u32>,
}

impl SheetFill<'_> {
    /// Finds the sheet around a face; `None` if the face itself is not flat or the area around it is small.
    fn sheet(&mut self, seed: u32, least_area: f64) -> Option<Sheet> {
        let mut plane = self.fitted(&[seed], self.soup.normal(seed))?;
        self.fill(seed, plane);
        let area = self.area();
        // A better plane reaches eight times as far in each direction. Most faces of curved surfaces stop here.
        if area < least_area / 64.0 || (self.faces.len() == 1 && area < least_area) {
            self.faces
                .iter()
                .for_each(|&face| self.taken[face as usize] = true);
            return None;
        }
        let mut best: Option<(Vec<u32>, (DVec3, f64))> = None;
        for _ in 0..FITTINGS {
            if self.faces.len() <= best.as_ref().map_or(0, |(before, _)| before.len()) {
                break;
            }
            let next = self.fitted(&self.faces, plane.0);
            best = Some((self.faces.clone(), plane));
            plane = next?;
            if self.faces.len() > 1 {
                self.fill(seed, plane);
            }
        }
        let (faces, plane) = best?;
        // Fit once more: the faces found may be nearer to a plane fitted to all of them.
        let fitted = self.fitted(&faces, plane.0).unwrap_or(plane);
        let [old, new] = [plane, fitted].map(|plane| self.slack(&faces, plane));
        let ((normal, distance), slack) = if new <= old { (fitted, new) } else { (plane, old) };
        Some(Sheet {
            area: faces.iter().map(|&face| self.soup.area(face)).sum(),
            double_sided: self.soup.double_sided[seed as usize],
            faces,
            normal,
            distance,
            slack,
        })
    }

    /// Returns the area of the faces found.
    fn area(&self) -> f64 {
        self.faces.iter().map(|&face| self.soup.area(face)).sum()
    }

    /// Finds the connected faces around `seed` that are in a plane.
    fn fill(&mut self, seed: u32, plane: (DVec3, f64)) {
        let soup = self.soup;
        self.walk += 1;
        self.met[seed as usize] = self.walk;
        self.faces.clear();
        let far = soup
            .face(seed)
            .iter()
            .map(|&corner| soup.points[corner as usize].abs().max_element())
            .fold(0.0, f64::max);
        if self.keeps_to(seed, plane, far) {
            self.waiting.push(seed);
        }
        while let Some(face) = self.waiting.pop() {
            self.faces.push(face);
            for corner in soup.range(face) {
                let edge = soup.edges[corner] as usize;
                let run = soup.runs[edge] as usize..soup.runs[edge + 1] as usize;
                if run.len() > MAX_SHARERS {
                    continue;
                }
                for &other in &soup.sharers[run] {
                    let met = &mut self.met[other as usize];
                    if *met == self.walk || self.taken[other as usize] {
                        continue;
                    }
                    *met = self.walk;
                    if soup.double_sided[other as usize] == soup.double_sided[seed as usize]
                        && self.keeps_to(other, plane, far)
                    {
                        self.waiting.push(other);
                    }
                }
            }
        }
    }

    /// Returns `true` if a face is in a plane and faces the same way.
    fn keeps_to(&self, face: u32, (normal, distance): (DVec3, f64), far: f64) -> bool {
        let soup = self.soup;
        let mut allowed = 0.0;
        for &corner in soup.face(face) {
            let point = soup.points[corner as usize];
            allowed = SPACINGS * f64::from(f32::EPSILON) * point.abs().max_element().max(far);
            if (normal.dot(point) - distance).abs() > allowed {
                return false;
            }
        }
        if soup.double_sided[face as usize] || soup.normal(face).dot(normal) >= 0.0 {
            return true;
        }
        // A sliver no wider than the rounding of its corners has no reliable normal: it joins its neighbours.
        let corners = soup.face(face);
        let longest = (1..corners.len())
            .map(|i| soup.points[corners[i] as usize].distance(soup.points[corners[0] as usize]))
            .fold(0.0, f64::max);
        soup.normal(face).length() <= allowed * longest
    }

    /// Fits a plane to some faces; `None` if they have no area.
    fn fitted(&self, faces: &[u32], along: DVec3) -> Option<(DVec3, f64)> {
        let soup = self.soup;
        let sum: DVec3 = faces
            .iter()
            .map(|&face| soup.normal(face))
            .map(|normal| if normal.dot(along) < 0.0 { -normal } else { normal })
            .sum();
        let normal = unit_normal(sum)?;
        let (least, greatest) = self.spread(faces, normal);
        Some((normal, 0.5 * (least + greatest)))
    }

    /// Returns the extent of the corners of some faces along a direction: minimum, maximum.
    fn spread(&self, faces: &[u32], normal: DVec3) -> (f64, f64) {
        let corners = faces.iter().flat_map(|&face| self.soup.face(face));
        corners
            .map(|&corner| normal.dot(self.soup.points[corner as usize]))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, greatest), at| {
                (least.min(at), greatest.max(at))
            })
    }

    /// Returns the maximum distance of the corners of some faces from a plane.
    fn slack(&self, faces: &[u32], (normal, distance): (DVec3, f64)) -> f64 {
        let (least, greatest) = self.spread(faces, normal);
        (greatest - distance).max(distance - least)
    }
}

/// Returns the unit vector of an area vector; `None` if it is zero.
pub(super) fn unit_normal(area: DVec3) -> Option<DVec3> {
    let axis = area.abs().cmpgt(DVec3::ZERO);
    // Exact for an axis-aligned plane: dividing by the length would round.
    if axis.bitmask().count_ones() == 1 {
        Some(DVec3::select(axis, area.signum(), DVec3::ZERO))
    } else {
        area.try_normalize()
    }
}
