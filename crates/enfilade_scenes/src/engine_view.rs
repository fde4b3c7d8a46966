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
    let eye_from_sector = matrix_of(&plain);
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

/// Returns a parallel view from random matrices, roughly in the direction of a camera and with the camera's eye in its near
/// plane: of any height, off-centre, some sheared, with the origin of eye space before or behind the near plane.
///
/// # Panics
/// If the camera is invalid.
pub fn parallel_view(camera: &Camera, size: [u32; 2], random: &mut Random) -> View {
    let plain = camera.view(size).expect("a valid camera");
    let [eye, toward] = [plain.eye(), plain.toward()].map(DVec3::from);
    let distance = eye.distance(toward);
    let mut between = |low: f32, high: f32| f64::from(random.between(low, high));
    let height = distance * between(0.05, 3.0);
    let [width, depth] = [
        height * f64::from(size[0]) / f64::from(size[1]),
        distance * between(1.0, 8.0),
    ];
    let offset = [between(-0.5, 0.5), between(-0.5, 0.5)];
    let near = distance * between(-5.0, 5.0);
    let shear = [between(-0.3, 0.3), between(-0.3, 0.3)];
    let tilt = [between(-0.4, 0.4), between(-0.4, 0.4)];
    let shear = if random.once_in(3) { shear } else { [0.0; 2] };
    let tilt = if random.once_in(3) { tilt } else { [0.0; 2] };
    let convention = random.pick(&[
        ClipDepth::ZeroToOne,
        ClipDepth::OneToZero,
        ClipDepth::MinusOneToOne,
    ]);
    let [first, last] = match convention {
        ClipDepth::ZeroToOne => [0.0, 1.0],
        ClipDepth::OneToZero => [1.0, 0.0],
        ClipDepth::MinusOneToOne => [-1.0, 1.0],
    };
    let z = |value: f64| value * (last - first) / depth;
    // From a space with its origin in the eye, z ahead.
    let clip_from_ahead = DMat4::from_cols(
        DVec4::new(2.0 / width, 0.0, z(tilt[0]), 0.0),
        DVec4::new(0.0, 2.0 / height, z(tilt[1]), 0.0),
        DVec4::new(2.0 * shear[0] / width, 2.0 * shear[1] / height, z(1.0), 0.0),
        DVec4::new(offset[0], offset[1], first, 1.0),
    );
    let back =
        DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0)) * DMat4::from_translation(DVec3::new(0.0, 0.0, near));
    let eye_from_sector = back.inverse() * DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0)) * matrix_of(&plain);
    let clip_from_eye = clip_from_ahead * back;
    let view = View::from_matrices(
        eye_from_sector.to_cols_array_2d(),
        clip_from_eye.to_cols_array_2d(),
        convention,
        size,
    );
    let view = view.expect("a parallel projection");
    match camera.sector {
        Some(sector) => view.in_sector(sector),
        None => view,
    }
}

/// Returns a perspective view from random matrices, with an oblique near plane through a random point ahead of the camera.
///
/// # Panics
/// If the camera is invalid.
pub fn oblique_view(camera: &Camera, size: [u32; 2], random: &mut Random) -> View {
    let plain = camera.view(size).expect("a valid camera");
    let distance = DVec3::from(plain.eye()).distance(DVec3::from(plain.toward()));
    let mut between = |low: f32, high: f32| f64::from(random.between(low, high));
    // In eye space, with the far side at a positive distance.
    let normal = DVec3::new(between(-1.0, 1.0), between(-1.0, 1.0), -1.0).normalize();
    let plane = normal.extend(-distance * between(0.02, 0.9));
    let mut rows = DMat4::from_cols_array_2d(&plain.clip_from_eye()).transpose();
    // Depth 0 in the plane, and 1 at some distance behind it: z = s * plane.
    rows.z_axis = plane * between(0.01, 1.0);
    let view = View::from_matrices(
        matrix_of(&plain).to_cols_array_2d(),
        rows.transpose().to_cols_array_2d(),
        ClipDepth::ZeroToOne,
        size,
    );
    let view = view.expect("an oblique near plane");
    match camera.sector {
        Some(sector) => view.in_sector(sector),
        None => view,
    }
}

fn matrix_of(view: &View) -> DMat4 {
    let [x, y, z, w] = view.eye_from_sector().columns_f64().map(DVec3::from);
    DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), w.extend(1.0))
}
