//! Cameras as engines hand them in: matrices of every convention.

use crate::random::Random;
use enfilade::{Camera, ClipDepth, View};
use glam::{DMat4, DVec3, DVec4};

/// Returns a view from random matrices of one of the conventions that engines have, at the position and roughly in the
/// direction of a camera: left- or right-handed, any axis of eye space ahead, off-centre, jittered, with finite or infinite
/// depth in any range, in `f64` or rounded to `f32`.
///
/// # Panics
/// If the camera is invalid.
pub fn engine_view(camera: &Camera, size: [u32; 2], random: &mut Random) -> View {
    let plain = camera.view(size).expect("a valid camera");
    let near = f64::from(plain.z_near());
    let tangent = (0.5 * f64::from(plain.fov_y())).tan();
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    let mut between = |low: f32, high: f32| f64::from(random.between(low, high));
    // Up to a third of the picture away from the view direction, and half a pixel of jitter.
    let [off_x, off_y] = [between(-0.6, 0.6), between(-0.6, 0.6)];
    let [jitter_x, jitter_y] = [0, 1].map(|axis| between(-1.0, 1.0) / f64::from(size[axis]));
    let far = near * between(1e3, 1e6);
    let far = if random.once_in(2) { f64::INFINITY } else { far };
    let depth = random.pick(&[
        ClipDepth::ZeroToOne,
        ClipDepth::OneToZero,
        ClipDepth::MinusOneToOne,
    ]);
    // z / w = a + b / w, with the depth `first` at the near plane and `last` at the far one.
    let [first, last] = match depth {
        ClipDepth::ZeroToOne => [0.0, 1.0],
        ClipDepth::OneToZero => [1.0, 0.0],
        ClipDepth::MinusOneToOne => [-1.0, 1.0],
    };
    let b = (first - last) / (1.0 / near - 1.0 / far);
    let a = first - b / near;
    let clip_from_ahead = DMat4::from_cols(
        DVec4::new(1.0 / (aspect * tangent), 0.0, 0.0, 0.0),
        DVec4::new(0.0, 1.0 / tangent, 0.0, 0.0),
        DVec4::new(off_x + jitter_x, off_y + jitter_y, a, 1.0),
        DVec4::new(0.0, 0.0, b, 0.0),
    );
    // From our eye space (x right, y up, z back) to one with z ahead, then to that of the engine.
    let ahead_from_eye = DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0));
    let engine_from_ahead = random.pick(&[
        // z ahead, left-handed; z back, right-handed; x ahead, z up; y ahead, z up.
        DMat4::IDENTITY,
        ahead_from_eye,
        DMat4::from_cols(DVec4::NEG_Y, DVec4::Z, DVec4::X, DVec4::W),
        DMat4::from_cols(DVec4::X, DVec4::Z, DVec4::Y, DVec4::W),
    ]);
    let columns = plain.eye_from_sector().columns_f64();
    let eye_from_sector = DMat4::from_cols(
        DVec3::from(columns[0]).extend(0.0),
        DVec3::from(columns[1]).extend(0.0),
        DVec3::from(columns[2]).extend(0.0),
        DVec3::from(columns[3]).extend(1.0),
    );
    let engine_from_sector = engine_from_ahead * ahead_from_eye * eye_from_sector;
    let clip_from_engine = clip_from_ahead * engine_from_ahead.inverse();
    let rounds = random.once_in(2);
    let columns = |matrix: DMat4| {
        let round = |value: f64| if rounds { f64::from(value as f32) } else { value };
        matrix.to_cols_array_2d().map(|column| column.map(round))
    };
    let view = View::from_matrices(
        columns(engine_from_sector),
        columns(clip_from_engine),
        depth,
        size,
    );
    let view = view.expect("a perspective projection");
    match camera.sector {
        Some(sector) => view.in_sector(sector),
        None => view,
    }
}
