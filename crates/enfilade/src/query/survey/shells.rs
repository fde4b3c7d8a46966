//! Connected parts of a mesh that enclose a volume.
//!
//! Idea: faces that share a vertex position belong to one part. Its volume by the divergence theorem is positive if the
//!     fronts of its faces are outside. A part with a few missing faces, such as a house without an underside, has that
//!     sign too, if no way of closing the hole could change it: the missing vector area is at most half the diagonal of
//!     the bounds from the centre. Only if it is positive, because vaults and niches have their fronts inside. Terrain,
//!     single walls and open rooms are no shells.
//! Source: Zhang, Chen, Efficient Feature Extraction for 2D/3D Objects in Mesh Representation, ICIP 2001, for the
//!     volume; Van Oosterom, Strackee, The Solid Angle of a Plane Triangle, 1983, for winding numbers.
//! Cost: O(corners), with one hash table of the positions.

use crate::geom::Aabb;
use crate::mesh::{Mesh, PositionTable, VACANT};
use glam::DVec3;
use std::ops::Range;

/// Volume below which a part is flat, relative to its area times its size: what rounding leaves of zero.
const FLAT: f64 = 1e-9;
/// Missing vector area below which a part is closed, and above which it is open, relative to its area.
const CLOSED: f64 = 1e-6;
const OPEN: f64 = 0.35;

/// A connected part of a mesh that encloses a volume, in the space of the mesh.
pub(super) struct Shell {
    pub(super) bounds: Aabb,
    pub(super) area: f64,
    /// Positive if the fronts of the faces are outside.
    pub(super) volume: f64,
    /// Whether a ray that enters it also leaves it.
    pub(super) is_closed: bool,
    /// Of [`Shells::faces`].
    faces: Range<usize>,
}

/// The shells of one mesh.
#[derive(Default)]
pub(super) struct Shells {
    pub(super) all: Vec<Shell>,
    /// By face; [`NONE`] for faces of other parts.
    shell_of: Vec<u32>,
    /// The faces of each shell.
    faces: Vec<u32>,
    /// Area of all faces.
    pub(super) area: f64,
}

const NONE: u32 = u32::MAX;

impl Shells {
    pub(super) fn of(mesh: &Mesh) -> Shells {
        let parts = Parts::of(mesh);
        let mut sums = vec![Sums::default(); parts.count];
        let origin = DVec3::from(mesh.bounds().center().map(f64::from));
        for (face, &part) in parts.of_face.iter().enumerate() {
            sums[part as usize].add(mesh, face as u32, origin);
        }
        let mut shells = Shells {
            area: sums.iter().map(|sums| sums.area).sum(),
            ..Shells::default()
        };
        let mut shell_of_part = vec![NONE; parts.count];
        for (sums, shell) in sums.iter().zip(&mut shell_of_part) {
            if let Some(found) = sums.shell(origin, shells.faces.len()) {
                *shell = shells.all.len() as u32;
                shells.faces.resize(found.faces.end, 0);
                shells.all.push(found);
            }
        }
        if shells.all.is_empty() {
            return shells;
        }
        let mut next: Vec<usize> = shells.all.iter().map(|shell| shell.faces.start).collect();
        for (face, &part) in parts.of_face.iter().enumerate() {
            let shell = shell_of_part[part as usize];
            shells.shell_of.push(shell);
            if shell != NONE {
                shells.faces[next[shell as usize]] = face as u32;
                next[shell as usize] += 1;
            }
        }
        shells
    }

    /// Returns the shell of a face.
    pub(super) fn of_face(&self, face: u32) -> Option<u32> {
        let shell = self.shell_of.get(face as usize).copied();
        shell.filter(|&shell| shell != NONE)
    }

    pub(super) fn face_count(&self, shell: u32) -> usize {
        self.all[shell as usize].faces.len()
    }

    /// Returns `true` if a shell winds around a point, in either sense.
    pub(super) fn encloses(&self, mesh: &Mesh, shell: u32, point: DVec3) -> bool {
        let faces = &self.faces[self.all[shell as usize].faces.clone()];
        let mut angle = 0.0;
        for &face in faces {
            each_triangle(mesh, face, point, |[a, b, c]| {
                let [long_a, long_b, long_c] = [a, b, c].map(DVec3::length);
                let below =
                    long_a * long_b * long_c + a.dot(b) * long_c + b.dot(c) * long_a + c.dot(a) * long_b;
                angle += 2.0 * a.dot(b.cross(c)).atan2(below);
            });
        }
        angle.abs() > std::f64::consts::TAU
    }
}

/// Calls `take` with the triangles of a face, relative to `origin`.
fn each_triangle(mesh: &Mesh, face: u32, origin: DVec3, mut take: impl FnMut([DVec3; 3])) {
    let corner = |&at: &u32| DVec3::from(mesh.positions()[at as usize].map(f64::from)) - origin;
    let corners = mesh.face(face);
    let first = corner(&corners[0]);
    for pair in corners[1..].windows(2) {
        take([first, corner(&pair[0]), corner(&pair[1])]);
    }
}

/// Integrals over a part.
#[derive(Clone, Default)]
struct Sums {
    faces: usize,
    bounds: Option<Aabb>,
    area: f64,
    /// Sum of the faces' normals times their areas: zero if the part is closed.
    vector_area: DVec3,
    /// With respect to the origin.
    volume: f64,
}

impl Sums {
    fn add(&mut self, mesh: &Mesh, face: u32, origin: DVec3) {
        self.faces += 1;
        let bounds = self.bounds.get_or_insert(Aabb::EMPTY);
        for &corner in mesh.face(face) {
            bounds.add(mesh.positions()[corner as usize]);
        }
        each_triangle(mesh, face, origin, |[a, b, c]| {
            let normal = 0.5 * (b - a).cross(c - a);
            self.area += normal.length();
            self.vector_area += normal;
            self.volume += a.dot(normal) / 3.0;
        });
    }

    /// Returns the shell, with its faces from `first` on; `None` if the part is flat or too open.
    fn shell(&self, origin: DVec3, first: usize) -> Option<Shell> {
        let bounds = self.bounds?;
        let centre = DVec3::from(bounds.center().map(f64::from)) - origin;
        let volume = self.volume - centre.dot(self.vector_area) / 3.0;
        let diagonal = DVec3::from(bounds.size().map(f64::from)).length();
        let missing = self.vector_area.length();
        let uncertain = missing * diagonal / 6.0 + FLAT * self.area * diagonal.max(centre.length());
        let is_closed = missing <= CLOSED * self.area;
        let is_shell = is_closed || (missing <= OPEN * self.area && volume > 0.0);
        (is_shell && volume.abs() > uncertain).then(|| Shell {
            bounds,
            area: self.area,
            volume,
            is_closed,
            faces: first..first + self.faces,
        })
    }
}

/// The parts of a mesh that are connected by common vertex positions.
struct Parts {
    of_face: Vec<u32>,
    count: usize,
}

impl Parts {
    fn of(mesh: &Mesh) -> Parts {
        let number_of = welded(mesh.positions());
        let mut parents: Vec<u32> = (0..number_of.len() as u32).collect();
        for face in 0..mesh.face_count() {
            let corners = mesh.face(face);
            let first = root(&mut parents, number_of[corners[0] as usize]);
            for &corner in &corners[1..] {
                let other = root(&mut parents, number_of[corner as usize]);
                parents[other as usize] = first;
            }
        }
        let mut part_of = vec![NONE; parents.len()];
        let mut count = 0;
        let of_face = (0..mesh.face_count())
            .map(|face| {
                let root = root(&mut parents, number_of[mesh.face(face)[0] as usize]) as usize;
                if part_of[root] == NONE {
                    part_of[root] = count as u32;
                    count += 1;
                }
                part_of[root]
            })
            .collect();
        Parts { of_face, count }
    }
}

/// Returns for each vertex one at its position.
fn welded(positions: &[[f32; 3]]) -> Vec<u32> {
    // -0 is equal to 0.
    let bits = |vertex: u32| positions[vertex as usize].map(|value| (value + 0.0).to_bits());
    let mut first = PositionTable::default();
    first.clear(positions.len());
    let number = |vertex: u32| {
        let key = bits(vertex);
        let known = first.slot(key, |other| bits(other) == key);
        if *known == VACANT {
            *known = vertex;
        }
        *known
    };
    (0..positions.len() as u32).map(number).collect()
}

fn root(parents: &mut [u32], mut vertex: u32) -> u32 {
    while parents[vertex as usize] != vertex {
        let parent = parents[vertex as usize];
        parents[vertex as usize] = parents[parent as usize];
        vertex = parent;
    }
    vertex
}
