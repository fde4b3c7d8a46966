//! Ambient occlusion: the part of the directions over a surface in which nothing is near.
//!
//! Source: Landis, Production-Ready Global Illumination, SIGGRAPH 2002 course 16, for occlusion by rays.
//! Cost: one ray cast per direction and sample.

use enfilade::{Ray, Scene, SectorId};
use glam::{DVec3, Vec3};

/// How far rays go, relative to the distance of the surface from the eye: what is far away needs no fine contact shadows.
const REACH: f32 = 0.25;
/// How far before the surface rays start, relative to the same distance.
const OFF: f32 = 1e-4;

/// Casts the rays of one passage.
pub(crate) struct Ambient<'a> {
    scene: &'a Scene,
    sector: SectorId,
    eye: DVec3,
    /// Unit vectors over a surface whose normal is +z, denser towards the normal, as ambient light counts.
    directions: &'a [Vec3],
}

/// Returns `count` directions over a surface with the normal +z, distributed by the cosine.
pub(crate) fn directions(count: u32) -> Vec<Vec3> {
    const GOLDEN: f32 = 2.399_963_2;
    let direction = |number: u32| {
        let square = (number as f32 + 0.5) / count as f32;
        let (sin, cos) = (GOLDEN * number as f32).sin_cos();
        let across = square.sqrt();
        Vec3::new(across * cos, across * sin, (1.0 - square).sqrt())
    };
    (0..count).map(direction).collect()
}

impl<'a> Ambient<'a> {
    pub(crate) fn new(scene: &'a Scene, sector: SectorId, eye: DVec3, directions: &'a [Vec3]) -> Ambient<'a> {
        Ambient {
            scene,
            sector,
            eye,
            directions,
        }
    }

    /// Returns how open a point is, 0 to 1; positions are relative to the eye.
    pub(crate) fn at(&self, point: Vec3, normal: Vec3) -> f32 {
        let away = point.length();
        let origin = (self.eye + (point + normal * (OFF * away)).as_dvec3()).as_vec3();
        let (side, up) = normal.any_orthonormal_pair();
        let sector = self.scene.sector(self.sector);
        let open = |direction: &Vec3| {
            let direction = side * direction.x + up * direction.y + normal * direction.z;
            let ray = Ray {
                origin: origin.into(),
                direction: (direction * (REACH * away)).into(),
            };
            sector.cast(&ray).map_or(1.0, |hit| hit.distance.min(1.0) as f32)
        };
        self.directions.iter().map(open).sum::<f32>() / self.directions.len() as f32
    }
}
