//! Numerically hard camera positions: in portals, on vertices, on edges and in planes of faces.

use super::{SurveyView, direction};
use crate::geometry::Geometry;
use crate::ids::{ItemIndex, SectorId};
use crate::random::SplitMix;
use crate::scene::Scene;
use glam::DVec3;

/// Returns up to `count` camera positions at which visibility methods are most likely to be wrong.
///
/// Uses a fixed seed. In turn, the eye is in or next to an opening, on a vertex, on an edge, and in the plane of a
/// face, often looking along a face.
///
/// Eyes may be inside solids. Returns fewer views if [`Scene::locate`] finds many of the eyes in other sectors, and
/// none if the scene has no faces.
#[doc(alias = "stress test views")]
pub fn survey_hard(scene: &Scene, count: usize) -> Vec<SurveyView> {
    let geometries: Vec<(SectorId, &Geometry)> = scene
        .sectors()
        .filter_map(|id| scene.geometry(id).map(|geometry| (id, &**geometry)))
        .filter(|(_, geometry)| geometry.face_count() > 0)
        .collect();
    let mut dice = SplitMix(0x6861_7264);
    let mut found = Vec::new();
    for number in 0..TRIES * count {
        if found.len() == count || geometries.is_empty() {
            break;
        }
        let (sector, geometry) = geometries[dice.below(geometries.len())];
        let place = match number % 4 {
            0 => in_opening(geometry, &mut dice),
            1 => at_face(geometry, &mut dice, FacePart::Corner),
            2 => at_face(geometry, &mut dice, FacePart::Edge),
            _ => at_face(geometry, &mut dice, FacePart::Plane),
        };
        let Some([eye, toward]) = place.map(|place| place.map(|point| point.as_vec3().to_array())) else {
            continue;
        };
        if eye != toward && scene.locate(eye, toward) == Some(sector) {
            found.push(SurveyView {
                sector,
                eye,
                toward,
                on_roof: false,
            });
        }
    }
    found
}

/// Candidates for each view.
const TRIES: usize = 16;

/// Distances of eyes from an opening, relative to its size.
const OFF: [f64; 7] = [0.0, 1e-6, -1e-6, 1e-3, -1e-3, 1e-2, -1e-2];

enum FacePart {
    Corner,
    Edge,
    Plane,
}

/// Returns an eye in or next to an opening, and a target through it, along its plane or in a random direction.
fn in_opening(geometry: &Geometry, dice: &mut SplitMix) -> Option<[DVec3; 2]> {
    let openings = geometry.openings();
    if openings.is_empty() {
        return None;
    }
    let outline = &openings[dice.below(openings.len())].outline;
    let corners: Vec<DVec3> = outline
        .corners()
        .iter()
        .map(|c| DVec3::from(c.map(f64::from)))
        .collect();
    let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let corner = corners[dice.below(corners.len())];
    let size = middle.distance(corner);
    let normal = outline.normal_f64();
    let eye = middle.lerp(corner, dice.fraction()) + normal * (size * OFF[dice.below(OFF.len())]);
    let along = (corner - middle).normalize_or(DVec3::X);
    let ahead = match dice.below(4) {
        0 => -normal,
        1 => normal,
        2 => along,
        _ => direction(dice),
    };
    Some([eye, eye + ahead * size])
}

/// Returns an eye on a vertex, on an edge or in the plane of a face, and a target in that plane or in a random
/// direction.
fn at_face(geometry: &Geometry, dice: &mut SplitMix, place: FacePart) -> Option<[DVec3; 2]> {
    let item = ItemIndex(dice.below(geometry.items().len()) as u32);
    let mesh = geometry.mesh_of(item);
    if mesh.face_count() == 0 {
        return None;
    }
    let transform = geometry.item(item).transform();
    let face = mesh.face(dice.below(mesh.face_count() as usize) as u32);
    let corner = |at: usize| {
        let position = mesh.positions()[face[at % face.len()] as usize];
        DVec3::from(transform.point_f64(position))
    };
    let first = dice.below(face.len());
    let [a, b, c] = [corner(first), corner(first + 1), corner(first + 2)];
    let middle = (a + b + c) / 3.0;
    let eye = match place {
        FacePart::Corner => a,
        FacePart::Edge => a.lerp(b, dice.fraction()),
        // On an edge, or outside the face by up to four times its size.
        FacePart::Plane => middle + (a.lerp(b, dice.fraction()) - middle) * (1.0 + 4.0 * dice.fraction()),
    };
    let toward = match dice.below(3) {
        0 => b,
        1 => middle,
        _ => eye + direction(dice) * a.distance(c),
    };
    Some([eye, toward])
}
