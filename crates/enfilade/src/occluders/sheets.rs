//! Sheets: faces of a mesh that lie in one plane and hang together by their edges.
//!
//! From the largest face a sheet grows over neighbours whose corners keep to its plane, and the plane is fitted anew to
//! what was found, for that of one small face is too rough to reach far. Faces seen from one side and from both never
//! mix; faces that look the other way do not join.
//! Source: flood filling; the plane by Newell's sum (Tampieri, Graphics Gems III, 1992).
//! Cost: O(n log n) for sorting faces by area, then each fitting O(faces in the sheet), a few of them.
//! A face is in one sheet or none. A sheet's corners are off its plane by [`Sheet::slack`] at most, and that is at most
//! [`SPACINGS`] roundings of f32.

use super::soup::Soup;
use glam::DVec3;

/// How many times the spacing of f32 a corner may stand off the plane of its sheet. A wall that was turned and moved
/// before its corners were rounded is off by one or two.
const SPACINGS: f64 = 8.0;

/// An edge of more faces joins none: the leaves of a book would be turned over by each other.
const MAX_SHARERS: usize = 16;

/// How often a plane is fitted; each time a sheet may reach eight times as far.
const FITTINGS: u32 = 6;

/// Faces in one plane that hang together.
pub(super) struct Sheet {
    /// As numbers of the soup's faces.
    pub(super) faces: Vec<u32>,
    /// Unit normal; faces seen from one side are seen from where it points to.
    pub(super) normal: DVec3,
    /// Of the plane from the origin, along the normal.
    pub(super) distance: f64,
    /// How far off the plane a corner stands, at most.
    pub(super) slack: f64,
    pub(super) double_sided: bool,
    pub(super) area: f64,
}

impl Soup {
    /// All sheets of at least `least_area`, from that of the largest face on.
    pub(super) fn sheets(&self, least_area: f64, mut found: impl FnMut(Sheet)) {
        let mut by_area: Vec<(f64, u32)> = (0..self.face_count() as u32)
            .map(|face| (self.area(face), face))
            .collect();
        by_area.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut filling = Filling {
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
            if filling.taken[seed as usize] {
                continue;
            }
            filling.taken[seed as usize] = true;
            if let Some(sheet) = filling.sheet(seed, least_area) {
                for &face in &sheet.faces {
                    filling.taken[face as usize] = true;
                }
                if sheet.area >= least_area {
                    found(sheet);
                }
            }
        }
    }
}

/// Faces spoken for.
struct Filling<'a> {
    soup: &'a Soup,
    taken: Vec<bool>,
    /// The last walk that met a face.
    met: Vec<u32>,
    walk: u32,
    /// What the last walk found, and what it has still to enter.
    faces: Vec<u32>,
    waiting: Vec<u32>,
}

impl Filling<'_> {
    /// The sheet around a face; `None` where the face itself is not flat, or what is around it small.
    fn sheet(&mut self, seed: u32, least_area: f64) -> Option<Sheet> {
        let mut plane = self.fitted(&[seed], self.soup.normal(seed))?;
        self.fill(seed, plane);
        let area = self.area();
        // A better plane reaches eight times as far. Most faces of curved things end here.
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
        // Fitted once more: what was found around it may lie nearer to a plane of its own.
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

    fn area(&self) -> f64 {
        self.faces.iter().map(|&face| self.soup.area(face)).sum()
    }

    /// Finds the faces around `seed` that keep to a plane.
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

    /// Does a face lie in a plane, and look where it does?
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
        // A face no higher than the roundings of its corners looks anywhere: it belongs to what is around it.
        let corners = soup.face(face);
        let longest = (1..corners.len())
            .map(|i| soup.points[corners[i] as usize].distance(soup.points[corners[0] as usize]))
            .fold(0.0, f64::max);
        soup.normal(face).length() <= allowed * longest
    }

    /// The plane of some faces; `None` where they have no area.
    fn fitted(&self, faces: &[u32], along: DVec3) -> Option<(DVec3, f64)> {
        let soup = self.soup;
        let sum: DVec3 = faces
            .iter()
            .map(|&face| soup.normal(face))
            .map(|normal| if normal.dot(along) < 0.0 { -normal } else { normal })
            .sum();
        let axis = sum.abs().cmpgt(DVec3::ZERO);
        // Exact where it can be: dividing by the length rounds.
        let normal = if axis.bitmask().count_ones() == 1 {
            sum.signum() * DVec3::from(<[bool; 3]>::from(axis).map(|on| f64::from(u8::from(on))))
        } else {
            sum.try_normalize()?
        };
        let (least, greatest) = self.spread(faces, normal);
        Some((normal, 0.5 * (least + greatest)))
    }

    /// How far along a direction the corners of some faces reach.
    fn spread(&self, faces: &[u32], normal: DVec3) -> (f64, f64) {
        let corners = faces.iter().flat_map(|&face| self.soup.face(face));
        corners
            .map(|&corner| normal.dot(self.soup.points[corner as usize]))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, greatest), at| {
                (least.min(at), greatest.max(at))
            })
    }

    fn slack(&self, faces: &[u32], (normal, distance): (DVec3, f64)) -> f64 {
        let (least, greatest) = self.spread(faces, normal);
        (greatest - distance).max(distance - least)
    }
}
