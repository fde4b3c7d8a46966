//! A face as one passage shows it: all that is the same at each of its samples, worked out once.
//!
//! A ray through sample (x, y) meets the face's plane at eye + d·o/(n·d), with a direction d that is linear in x and y. So
//! whatever varies linearly over the face is, on the screen, a constant plus a quotient of two linear functions, whose
//! derivatives are exact.
//! Source: Heckbert, Fundamentals of texture mapping and image warping, 1989, section 2 (projective mappings).

use crate::lamps::Near;
use crate::mips::Mips;
use crate::stage::Stage;
use enfilade::{Alpha, Geometry, ItemId, Passage, Surface, Transform};
use glam::{DVec3, Vec3};
use smallvec::SmallVec;

/// Where the passage at hand sees samples: from an eye, in a direction that grows by the same from each to the next.
#[derive(Clone, Copy, Default)]
pub(crate) struct Rays {
    pub(crate) eye: DVec3,
    corner: DVec3,
    right: DVec3,
    down: DVec3,
    /// Against the line of sight, unit length.
    pub(crate) back: Vec3,
}

/// A number that grows by the same from each sample to the next.
#[derive(Clone, Copy, Default)]
pub(crate) struct Linear {
    corner: f64,
    right: f64,
    down: f64,
}

/// Such a number along one row: at column 0, for each column, and for each row.
#[derive(Clone, Copy, Default)]
pub(crate) struct Along {
    start: f32,
    pub(crate) right: f32,
    pub(crate) down: f32,
}

/// What varies linearly over a face: a constant and a numerator over the face's own denominator.
#[derive(Clone, Copy, Default)]
pub(crate) struct Varying {
    pub(crate) base: f32,
    pub(crate) over: Linear,
}

/// A face as one passage shows it. Places are seen from the passage's eye.
pub(crate) struct Face<'s> {
    /// Red, green, blue and coverage of its material, linear.
    pub(crate) color: [f32; 4],
    pub(crate) emission: Vec3,
    pub(crate) cutoff: Option<f32>,
    /// Is it seen through?
    pub(crate) glass: bool,
    pub(crate) unlit: bool,
    pub(crate) texture: Option<&'s Mips>,
    pub(crate) glow: Option<&'s Mips>,
    /// Turned to the eye.
    pub(crate) normal: Vec3,
    /// Of the plane: n · d, and n · (a point of it).
    pub(crate) facing: Linear,
    pub(crate) off: f32,
    pub(crate) place: Option<[Varying; 2]>,
    /// Normals of corners, turned to the eye's side.
    pub(crate) normals: Option<[Varying; 3]>,
    pub(crate) colors: Option<Box<[Varying; 4]>>,
    /// The lights that may shine on it, and whether each point must be asked for.
    pub(crate) lights: SmallVec<[(u16, bool); 4]>,
}

impl Rays {
    pub(crate) fn new(passage: &Passage) -> Rays {
        let direction = |at| DVec3::from(passage.ray(at)[1]);
        let corner = direction([0.5, 0.5]);
        let sector_from_eye = passage.eye_from_sector().inverse().unwrap_or(Transform::IDENTITY);
        Rays {
            eye: passage.eye().into(),
            corner,
            right: direction([1.5, 0.5]) - corner,
            down: direction([0.5, 1.5]) - corner,
            back: Vec3::from(sector_from_eye.direction([0.0, 0.0, 1.0])).normalize_or_zero(),
        }
    }

    /// The direction of each sample, along a vector.
    fn along(&self, vector: DVec3) -> Linear {
        Linear {
            corner: vector.dot(self.corner),
            right: vector.dot(self.right),
            down: vector.dot(self.down),
        }
    }

    /// The direction of the sample (x, y).
    #[inline]
    pub(crate) fn direction(&self, [x, y]: [u16; 2]) -> Vec3 {
        (self.corner + self.right * f64::from(x) + self.down * f64::from(y)).as_vec3()
    }
}

impl Linear {
    pub(crate) fn row(&self, y: u16) -> Along {
        Along {
            start: (self.corner + self.down * f64::from(y)) as f32,
            right: self.right as f32,
            down: self.down as f32,
        }
    }

    fn times(self, factor: f64) -> Linear {
        Linear {
            corner: self.corner * factor,
            right: self.right * factor,
            down: self.down * factor,
        }
    }
}

impl Along {
    #[inline]
    pub(crate) fn at(&self, column: f32) -> f32 {
        self.start + self.right * column
    }
}

impl<'s> Face<'s> {
    /// A face of which no more than its surface is known.
    pub(crate) fn plain(surface: &Surface, rays: &Rays) -> Face<'s> {
        let point = DVec3::from(surface.point.map(f64::from)) - rays.eye;
        let front = DVec3::from(surface.normal.map(f64::from));
        let normal = if point.dot(front) > 0.0 { -front } else { front };
        Face {
            color: surface.color,
            emission: Vec3::ZERO,
            cutoff: None,
            glass: surface.alpha == Alpha::Blend,
            unlit: false,
            texture: None,
            glow: None,
            normal: normal.as_vec3(),
            facing: rays.along(normal),
            off: normal.dot(point) as f32,
            place: None,
            normals: None,
            colors: None,
            lights: SmallVec::new(),
        }
    }

    /// A face of a geometry, with its textures and what its corners carry.
    pub(crate) fn of_geometry(
        (geometry, stage): (&Geometry, &'s Stage),
        (item, face): (ItemId, u32),
        surface: &Surface,
        rays: &Rays,
        lights: &[Near],
    ) -> Face<'s> {
        let mut made = Face::plain(surface, rays);
        let mesh = geometry.mesh_of(item);
        let material = geometry.material(&mesh.clusters()[mesh.cluster_of(face)]);
        made.emission = material.emission.into();
        made.unlit = material.unlit;
        made.glass = material.alpha == Alpha::Blend;
        made.cutoff = (material.alpha == Alpha::Mask).then_some(material.cutoff);
        made.texture = stage.mips(geometry, material.texture);
        made.glow = stage.mips(geometry, material.emission_texture);
        let corners = mesh.face(face);
        let transform = geometry.item(item).transform();
        let columns = transform
            .columns()
            .map(|column| DVec3::from(column.map(f64::from)));
        let linear = |p: DVec3| columns[0] * p.x + columns[1] * p.y + columns[2] * p.z;
        let from_eye = |&corner: &u32| {
            let place = DVec3::from(mesh.positions()[corner as usize].map(f64::from));
            linear(place) + columns[3] - rays.eye
        };
        let places: SmallVec<[DVec3; 8]> = corners.iter().map(from_eye).collect();
        let Some(slopes) = Slopes::of(&places, rays, f64::from(made.off)) else {
            return made;
        };
        let of =
            |list: &dyn Fn(u32) -> f64| slopes.varying(slopes.corners.map(|corner| list(corners[corner])));
        let textured = made.texture.is_some() || made.glow.is_some();
        if textured && !mesh.texture().is_empty() {
            let place = |axis: usize| of(&|corner| f64::from(mesh.texture()[corner as usize][axis]));
            made.place = Some([place(0), place(1)]);
        }
        if !mesh.colors().is_empty() {
            let channel = |i: usize| of(&|corner| f64::from(mesh.colors()[corner as usize][i]));
            made.colors = Some(Box::new([0, 1, 2, 3].map(channel)));
        }
        if !mesh.normals().is_empty() && !made.unlit {
            made.normals = normals(mesh.normals(), corners, &slopes, &columns, made.normal);
        }
        let eye_corners: SmallVec<[Vec3; 8]> = places.iter().map(|place| place.as_vec3()).collect();
        let flat = made.normals.is_none().then_some(made.normal);
        if !made.unlit {
            let shining = (0..).zip(lights).filter_map(|(number, light)| {
                let narrowed = light.shines_on(&eye_corners, flat)?;
                Some((number, narrowed))
            });
            made.lights = shining.collect();
        }
        made
    }

    /// Is it the same at all of its samples?
    pub(crate) fn is_plain(&self) -> bool {
        let varies = self.place.is_some() || self.normals.is_some() || self.colors.is_some();
        !varies && self.lights.is_empty()
    }
}

/// How numbers at three corners of a face vary over it.
struct Slopes<'r> {
    corners: [usize; 3],
    first: DVec3,
    /// What one more at the second and at the third corner adds along each axis.
    along: [DVec3; 2],
    rays: &'r Rays,
    off: f64,
}

impl Slopes<'_> {
    /// `None` for a face without area.
    fn of<'r>(places: &[DVec3], rays: &'r Rays, off: f64) -> Option<Slopes<'r>> {
        let first = places[0];
        // Of more than three corners, those that are least in line with the first.
        let pairs = (1..places.len() - 1).map(|second| [second, second + 1]);
        let across = |pair: &[usize; 2]| {
            let [a, b] = pair.map(|corner| places[corner] - first);
            a.cross(b)
        };
        let widest =
            pairs.max_by(|a, b| across(a).length_squared().total_cmp(&across(b).length_squared()))?;
        let normal = across(&widest);
        let square = normal.length_squared();
        let [a, b] = widest.map(|corner| places[corner] - first);
        let along = [b.cross(normal) / square, normal.cross(a) / square];
        along.iter().all(|slope| slope.is_finite()).then_some(Slopes {
            corners: [0, widest[0], widest[1]],
            first,
            along,
            rays,
            off,
        })
    }

    fn varying(&self, [first, second, third]: [f64; 3]) -> Varying {
        let slope = self.along[0] * (second - first) + self.along[1] * (third - first);
        Varying {
            base: (first - slope.dot(self.first)) as f32,
            over: self.rays.along(slope).times(self.off),
        }
    }
}

/// Normals of corners in the space of the sector, on the side of the face's own, which is turned to the eye. Corners
/// without one have the face's own; `None` where all have.
fn normals(
    list: &[[f32; 3]],
    corners: &[u32],
    slopes: &Slopes,
    [x, y, z, _]: &[DVec3; 4],
    own: Vec3,
) -> Option<[Varying; 3]> {
    let given = slopes.corners.map(|corner| list[corners[corner] as usize]);
    if given.iter().all(|normal| *normal == [0.0; 3]) {
        return None;
    }
    // As planes are moved, not as points are; the sign of a mirror has no say, for the side is known.
    let moved = |[nx, ny, nz]: [f32; 3]| {
        let sum = y.cross(*z) * f64::from(nx) + z.cross(*x) * f64::from(ny) + x.cross(*y) * f64::from(nz);
        let moved = sum.normalize_or_zero();
        if moved == DVec3::ZERO {
            own.as_dvec3()
        } else {
            moved
        }
    };
    let moved = given.map(moved);
    let side = moved.iter().sum::<DVec3>().dot(own.as_dvec3());
    let side = if side < 0.0 { -1.0 } else { 1.0 };
    Some([0, 1, 2].map(|axis| slopes.varying(moved.map(|normal| side * normal[axis]))))
}
