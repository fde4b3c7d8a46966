//! Camera positions around an object.

use super::{SurveyView, Surveyor, TRIES};
use glam::DVec3;

/// Range of distances from the centre, relative to the radius of the bounding sphere. From the minimum the sphere fills
/// the picture.
const DISTANCE: [f64; 2] = [1.2, 2.5];
/// Range of the sine of the elevation.
const ELEVATION: [f64; 2] = [-0.3, 0.9];

pub(super) fn places(surveyor: &mut Surveyor, count: usize) -> Vec<SurveyView> {
    let mut found = Vec::new();
    for number in 0..TRIES * count {
        if found.len() == count {
            break;
        }
        let (sector, geometry) = surveyor.geometries[number % surveyor.geometries.len()];
        let bounds = geometry.bounds();
        let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
        let dice = &mut surveyor.dice;
        let mut between = |[low, high]: [f64; 2]| low + (high - low) * dice.fraction();
        let height = between(ELEVATION);
        let around = between([0.0, std::f64::consts::TAU]);
        let level = (1.0 - height * height).sqrt();
        let away = DVec3::new(level * around.cos(), height, level * around.sin());
        let [center, radius] = [0.5 * (min + max), 0.5 * (max - min)];
        let eye = center + away * (radius.length() * between(DISTANCE));
        let [eye, toward] = [eye, center].map(|point| point.as_vec3().to_array());
        if surveyor.scene.locate(eye, toward) == Some(sector) {
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
