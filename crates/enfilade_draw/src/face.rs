//! Per-face setup for one passage: everything constant over the face's samples, computed once.
//!
//! The ray through sample (x, y) meets the face's plane at eye + d·o/(n·d), with a direction d that is linear in x and
//! y. So an attribute that varies linearly over the face is, in screen space, a constant plus a quotient of two linear
//! functions, with exact derivatives. In a parallel view the origin of the ray is linear and the direction constant, and so
//! the divisor is.
//! Source: Heckbert, Fundamentals of texture mapping and image warping, 1989, section 2 (projective mappings).

use crate::lamps::{CutBy, PassageLight};
use crate::mips::Mips;
use crate::stage::Stage;
use enfilade::{Alpha, Geometry, ItemIndex, Passage, Surface, Transform};
use glam::{DVec3, Vec3};
use smallvec::SmallVec;

/// Camera rays of the current passage: the eye, direction at sample (0, 0), and the direction's step per column and row; in
/// a parallel view, those of the origin, relative to the eye.
#[derive(Clone, Copy, Default)]
pub(crate) struct Rays {
    pub(crate) eye: DVec3,
    corner: DVec3,
    right: DVec3,
    down: DVec3,
    /// Direction of all rays, if the view is parallel.
    ahead: Option<DVec3>,
    /// Opposite to the view direction, unit length.
    pub(crate) back: Vec3,
}

/// A linear function of the sample position: value at (0, 0), and step per column and row.
#[derive(Clone, Copy, Default)]
pub(crate) struct Linear {
    corner: f64,
    right: f64,
    down: f64,
}

/// A linear function along one row: value at column 0, and step per column and row.
#[derive(Clone, Copy, Default)]
pub(crate) struct LinearRow {
    start: f32,
    pub(crate) right: f32,
    pub(crate) down: f32,
}

/// A perspective-correct attribute: `base` + `over` / `facing` of the face.
#[derive(Clone, Copy, Default)]
pub(crate) struct Varying {
    pub(crate) base: f32,
    pub(crate) over: Linear,
}

/// A face as seen through one passage. Positions are relative to the passage's eye.
pub(crate) struct Face<'s> {
    /// Linear RGB and alpha of its material.
    pub(crate) color: [f32; 4],
    pub(crate) emission: Vec3,
    pub(crate) cutoff: Option<f32>,
    /// Whether the material is alpha-blended.
    pub(crate) glass: bool,
    pub(crate) unlit: bool,
    pub(crate) texture: Option<&'s Mips>,
    pub(crate) glow: Option<&'s Mips>,
    /// Flipped towards the eye.
    pub(crate) normal: Vec3,
    /// For the plane with normal n: n · d for ray direction d, and n · (a point of the plane).
    pub(crate) facing: Linear,
    pub(crate) off: f32,
    pub(crate) uv: Option<[Varying; 2]>,
    /// Interpolated vertex normals, flipped to the eye's side.
    pub(crate) normals: Option<[Varying; 3]>,
    pub(crate) colors: Option<Box<[Varying; 4]>>,
    /// Indices of the lights that may reach it, and the planes of their beams that must be tested per sample.
    pub(crate) lights: SmallVec<[(u16, CutBy); 4]>,
    /// Whether there are any such planes.
    pub(crate) is_cut: bool,
}

impl Rays {
    pub(crate) fn new(passage: &Passage) -> Rays {
        let eye = DVec3::from(passage.eye());
        let is_parallel = passage.is_parallel();
        let varying = |at| {
            let [origin, direction] = passage.ray(at).map(DVec3::from);
            if is_parallel { origin - eye } else { direction }
        };
        let corner = varying([0.5, 0.5]);
        let sector_from_eye = passage.eye_from_sector().inverse().unwrap_or(Transform::IDENTITY);
        Rays {
            eye,
            corner,
            right: varying([1.5, 0.5]) - corner,
            down: varying([0.5, 1.5]) - corner,
            ahead: is_parallel.then(|| passage.ray([0.5, 0.5])[1].into()),
            back: Vec3::from(sector_from_eye.direction([0.0, 0.0, 1.0])).normalize_or_zero(),
        }
    }

    /// Returns the dot product of a normal with each sample's ray direction.
    fn facing(&self, normal: DVec3) -> Linear {
        match self.ahead {
            Some(ahead) => Linear {
                corner: normal.dot(ahead),
                ..Linear::default()
            },
            None => self.along(normal),
        }
    }

    /// Returns the position where each sample's ray meets a face, times the face's `facing`: the dot product of a vector
    /// with that. The face's plane is `normal` · p = `off`.
    fn over(&self, vector: DVec3, normal: DVec3, off: f64) -> Linear {
        let Some(ahead) = self.ahead else {
            return self.along(vector).times(off);
        };
        // s + d (off − n · s) / (n · d), with the origin s and the direction d.
        let [steepness, facing] = [vector.dot(ahead), normal.dot(ahead)];
        let sum = self.along(vector * facing - normal * steepness);
        Linear {
            corner: sum.corner + steepness * off,
            ..sum
        }
    }

    /// Returns the dot product of a vector with what varies.
    fn along(&self, vector: DVec3) -> Linear {
        Linear {
            corner: vector.dot(self.corner),
            right: vector.dot(self.right),
            down: vector.dot(self.down),
        }
    }

    /// Returns the position where the ray of sample (x, y) meets a face, relative to the eye, and the steps on the face from
    /// there to the next sample right and down. `facing` is the value of the face's [`Face::facing`] at the sample, `slopes`
    /// its steps.
    #[inline]
    pub(crate) fn point(
        &self,
        face: &Face,
        [x, y]: [u16; 2],
        per_facing: f32,
        slopes: [f32; 2],
    ) -> (Vec3, [Vec3; 2]) {
        let varying = (self.corner + self.right * f64::from(x) + self.down * f64::from(y)).as_vec3();
        let [right, down] = [self.right, self.down].map(|step| step.as_vec3());
        match self.ahead {
            None => {
                let along = face.off * per_facing;
                let step = |step: Vec3, slope: f32| (step - varying * (slope * per_facing)) * along;
                (varying * along, [step(right, slopes[0]), step(down, slopes[1])])
            }
            Some(ahead) => {
                let ahead = ahead.as_vec3() * per_facing;
                let onto = |at: Vec3, off: f32| at + ahead * (off - face.normal.dot(at));
                (onto(varying, face.off), [onto(right, 0.0), onto(down, 0.0)])
            }
        }
    }
}

impl Linear {
    pub(crate) fn row(&self, y: u16) -> LinearRow {
        LinearRow {
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

impl LinearRow {
    #[inline]
    pub(crate) fn at(&self, column: f32) -> f32 {
        self.start + self.right * column
    }
}

impl<'s> Face<'s> {
    /// Creates a face without textures and vertex attributes, from its surface alone.
    pub(crate) fn plain(surface: &Surface, rays: &Rays) -> Face<'s> {
        let point = DVec3::from(surface.point.map(f64::from)) - rays.eye;
        let front = DVec3::from(surface.normal.map(f64::from));
        let away = rays.ahead.unwrap_or(point);
        let normal = if away.dot(front) > 0.0 { -front } else { front };
        Face {
            color: surface.color,
            emission: Vec3::ZERO,
            cutoff: None,
            glass: surface.alpha == Alpha::Blend,
            unlit: false,
            texture: None,
            glow: None,
            normal: normal.as_vec3(),
            facing: rays.facing(normal),
            off: normal.dot(point) as f32,
            uv: None,
            normals: None,
            colors: None,
            lights: SmallVec::new(),
            is_cut: false,
        }
    }

    /// Creates a face of a geometry, with its textures and vertex attributes.
    pub(crate) fn of_geometry(
        (geometry, stage): (&Geometry, &'s Stage),
        (item, face): (ItemIndex, u32),
        surface: &Surface,
        rays: &Rays,
        lights: &[PassageLight],
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
            let position = DVec3::from(mesh.positions()[corner as usize].map(f64::from));
            linear(position) + columns[3] - rays.eye
        };
        let positions: SmallVec<[DVec3; 8]> = corners.iter().map(from_eye).collect();
        let plane = (made.normal.as_dvec3(), f64::from(made.off));
        let Some(slopes) = Slopes::of(&positions, rays, plane) else {
            return made;
        };
        let of =
            |list: &dyn Fn(u32) -> f64| slopes.varying(slopes.corners.map(|corner| list(corners[corner])));
        let textured = made.texture.is_some() || made.glow.is_some();
        if textured && !mesh.texture().is_empty() {
            let uv = |axis: usize| of(&|corner| f64::from(mesh.texture()[corner as usize][axis]));
            made.uv = Some([uv(0), uv(1)]);
        }
        if !mesh.colors().is_empty() {
            let channel = |i: usize| of(&|corner| f64::from(mesh.colors()[corner as usize][i]));
            made.colors = Some(Box::new([0, 1, 2, 3].map(channel)));
        }
        if !mesh.normals().is_empty() && !made.unlit {
            made.normals = normals(mesh.normals(), corners, &slopes, &columns, made.normal);
        }
        let eye_corners: SmallVec<[Vec3; 8]> = positions.iter().map(|position| position.as_vec3()).collect();
        let flat = made.normals.is_none().then_some(made.normal);
        if !made.unlit {
            let shining = (0..).zip(lights).filter_map(|(number, light)| {
                let cut = light.shines_on(&eye_corners, flat)?;
                Some((number, cut))
            });
            made.lights = shining.collect();
            made.is_cut = made.lights.iter().any(|&(_, cut)| cut != 0);
        }
        made
    }

    /// Returns `true` if all samples of the face have the same shade.
    pub(crate) fn is_plain(&self) -> bool {
        let varies = self.uv.is_some() || self.normals.is_some() || self.colors.is_some();
        !varies && self.lights.is_empty()
    }
}

/// Gradients of vertex attributes over a face.
struct Slopes<'r> {
    corners: [usize; 3],
    first: DVec3,
    /// Gradients of the barycentric coordinates of the second and the third corner.
    along: [DVec3; 2],
    rays: &'r Rays,
    /// The face's plane n · p = d.
    plane: (DVec3, f64),
}

impl Slopes<'_> {
    /// Returns `None` for a face without area.
    fn of<'r>(positions: &[DVec3], rays: &'r Rays, plane: (DVec3, f64)) -> Option<Slopes<'r>> {
        let first = positions[0];
        // The largest triangle of the fan about the first corner.
        let pairs = (1..positions.len() - 1).map(|second| [second, second + 1]);
        let across = |pair: &[usize; 2]| {
            let [a, b] = pair.map(|corner| positions[corner] - first);
            a.cross(b)
        };
        let widest =
            pairs.max_by(|a, b| across(a).length_squared().total_cmp(&across(b).length_squared()))?;
        let normal = across(&widest);
        let square = normal.length_squared();
        let [a, b] = widest.map(|corner| positions[corner] - first);
        let along = [b.cross(normal) / square, normal.cross(a) / square];
        along.iter().all(|slope| slope.is_finite()).then_some(Slopes {
            corners: [0, widest[0], widest[1]],
            first,
            along,
            rays,
            plane,
        })
    }

    fn varying(&self, [first, second, third]: [f64; 3]) -> Varying {
        let slope = self.along[0] * (second - first) + self.along[1] * (third - first);
        Varying {
            base: (first - slope.dot(self.first)) as f32,
            over: self.rays.over(slope, self.plane.0, self.plane.1),
        }
    }
}

/// Returns interpolated vertex normals in sector space, on the side of the face normal `own`, which points towards the
/// eye. Corners without a normal use `own`. Returns `None` if all corners lack one.
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
    // Normals transform by the cofactor matrix. The sign of its determinant does not matter, because the side is fixed
    // below.
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
