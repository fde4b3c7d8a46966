//! Camera paths through portals, frame by frame: in front of the plane, in it and behind it.

use crate::ids::PortalId;
use crate::query::Location;
use crate::scene::Scene;
use crate::view::{Camera, View};
use glam::DVec3;

/// Distances of the frames in front of the opening's plane (negative: behind it), in fifths of the near distance.
const FRAMES: [i32; 12] = [12, 8, 5, 4, 3, 2, 1, 0, -1, -2, -4, -8];

/// Returns the views of a camera that moves through the middle of a portal, looking ahead, obliquely, along the plane
/// and back.
///
/// The near distance is 0.01, or less for a small opening, so the frames are 2 mm apart near the plane of a door. The
/// camera changes sectors as [`Scene::walk`] defines.
pub fn views_through(scene: &Scene, portal: PortalId, size: [u32; 2]) -> Vec<View> {
    let here = &scene.portals()[portal.0 as usize];
    let outline = &scene.sector(here.from).openings()[usize::from(here.opening.0)].outline;
    let corners: Vec<DVec3> = outline
        .corners()
        .iter()
        .map(|c| DVec3::from(c.map(f64::from)))
        .collect();
    let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let normal = DVec3::from(outline.normal().map(f64::from));
    let along = (corners[1] - corners[0]).normalize();
    let longest = f64::from(outline.bounds().longest_side());
    let near = 0.01 * (0.5 * longest).min(1.0);
    let directions = [
        -normal,
        -normal + 2.0 * along + 0.3 * normal.cross(along),
        along + 0.2 * normal.cross(along),
        normal,
    ];
    let at = |frame: i32| (middle + normal * (f64::from(frame) * 0.2 * near)).as_vec3();
    let start = at(FRAMES[0]);
    let mut views = Vec::new();
    for frame in FRAMES {
        let place = Location {
            sector: here.from,
            position: start.into(),
        };
        let mut walked = scene.walk(place, (at(frame) - start).into());
        if frame >= 0 && walked.crossed.is_empty() {
            // Exactly in the plane, not where rounding ends the step.
            walked.location.position = at(frame).into();
        }
        let eye = DVec3::from(walked.location.position.map(f64::from));
        for direction in directions {
            let direction = walked
                .there_from_here
                .0
                .transform_vector3(direction.normalize() * longest);
            let toward = (eye + direction).as_vec3();
            let camera = Camera {
                sector: Some(walked.location.sector),
                z_near: Some(near as f32),
                ..Camera::new(walked.location.position, toward.into())
            };
            views.push(camera.view(size).expect("a view of a valid camera"));
        }
    }
    views
}
