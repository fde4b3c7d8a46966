use super::*;
use crate::chance::Dice;

/// Returns the position in the viewport that the matrices of a view project a point to, in pixels, and its distance.
/// Perspective views only.
fn projected(view: &View, point: [f64; 3]) -> (DVec2, f64) {
    let eye_from_sector = view.eye_from_sector;
    let at = (view.viewport_from_eye * eye_from_sector).transform_point3(DVec3::from(point));
    (at.truncate() / at.z, at.z)
}

#[test]
fn what_is_looked_at_is_in_the_middle_and_up_is_up() {
    let view = View::new([1.0, 2.0, 3.0], [4.0, 2.0, -7.0], [640, 480]).expect("a valid view");
    let (middle, distance) = projected(&view, [4.0, 2.0, -7.0]);
    assert!(middle.distance(DVec2::new(320.0, 240.0)) < 1e-9);
    assert!((distance - 109.0_f64.sqrt()).abs() < 1e-9);
    assert!(projected(&view, [4.0, 3.0, -7.0]).0.y < 240.0);
    // A sample to the right and below shows what the pixel centre showed before: the picture moves left and up.
    let moved = view.at_sample([0.25, 0.5]).expect("a position in the pixel");
    let [after, before] = [moved, view].map(|view| view.screen_from_eye().transform_point3(DVec3::NEG_Z));
    let off = after - before;
    assert_eq!(off, DVec3::new(-0.25, -0.5, 0.0));
}

/// Makes a projection from left, right, bottom, top, near and far.
type Orthographic = fn(f64, f64, f64, f64, f64, f64) -> DMat4;

#[test]
fn a_parallel_view_is_the_one_of_an_orthographic_matrix() {
    let mut dice = Dice::new(6);
    for round in 0..100 {
        let [eye, toward, up] = [(); 3].map(|()| dice.point(5.0));
        let [height, aspect] = [0.1 + 9.0 * dice.roll(), 0.5 + dice.roll()];
        let size = [(600.0 * aspect) as u32, 600];
        let [half_width, half] = [0.5 * height * f64::from(size[0]) / 600.0, 0.5 * height];
        let view = View::parallel(eye.into(), toward.into(), up.into(), height, size).expect("a valid view");
        // A near plane behind the origin of eye space, as suns have it.
        let near = 10.0 * dice.roll() - 9.0;
        let origin = eye - near * (toward - eye).normalize();
        let eye_from_sector =
            glam::dcamera::rh::view::look_at_mat4(origin, toward + (origin - eye), up.normalize());
        let (orthographic, depth): (Orthographic, _) = match round % 2 {
            0 => (
                glam::dcamera::rh::proj::directx::orthographic,
                ClipDepth::ZeroToOne,
            ),
            _ => (
                glam::dcamera::rh::proj::opengl::orthographic,
                ClipDepth::MinusOneToOne,
            ),
        };
        let clip_from_eye = orthographic(-half_width, half_width, -half, half, near, near + 50.0);
        let same = View::from_matrices(
            eye_from_sector.to_cols_array_2d(),
            clip_from_eye.to_cols_array_2d(),
            depth,
            size,
        );
        let same = same.expect("an orthographic projection");
        assert!(view.is_parallel() && same.is_parallel());
        assert!(
            DVec3::from(same.eye()).distance(eye) < 1e-9,
            "{:?} is not {eye}",
            same.eye()
        );
        for _ in 0..10 {
            let place = [dice.roll() * f64::from(size[0]), dice.roll() * 600.0];
            for (ours, theirs) in view.ray(place).into_iter().zip(same.ray(place)) {
                assert!(
                    DVec3::from(ours).distance(theirs.into()) < 1e-9,
                    "{ours:?} is not {theirs:?}"
                );
            }
            // The matrix of a renderer puts every point of the ray there.
            let [origin, direction] = view.ray(place).map(DVec3::from);
            assert!((direction.length() - 1.0).abs() < 1e-9);
            for view in [view, same] {
                let clip =
                    DMat4::from_cols_array_2d(&view.clip_from_eye()) * DMat4::from(view.eye_from_sector);
                let at = clip.project_point3(origin + direction);
                let at = [
                    (0.5 + 0.5 * at.x) * f64::from(size[0]),
                    (0.5 - 0.5 * at.y) * 600.0,
                ];
                assert!(
                    (at[0] - place[0]).abs() + (at[1] - place[1]).abs() < 1e-6,
                    "{at:?} is not {place:?}"
                );
            }
        }
    }
    let refused = View::parallel([0.0; 3], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], 0.0, [8, 8]);
    assert_eq!(refused, Err(ViewError::Height(0.0)));
}

#[test]
fn an_oblique_near_plane_is_found_wherever_it_is() {
    let mut dice = Dice::new(7);
    for _ in 0..100 {
        let normal = (dice.point(1.0) + DVec3::NEG_Z * 1.5).normalize();
        let distance = 0.1 + dice.roll();
        let mut rows = DMat4::from_cols_array_2d(&PERSPECTIVE).transpose();
        rows.z_axis = normal.extend(-distance) * (0.1 + dice.roll());
        let view = View::from_matrices(
            IDENTITY,
            rows.transpose().to_cols_array_2d(),
            ClipDepth::ZeroToOne,
            [64, 64],
        );
        let view = view.expect("an oblique near plane");
        let [x, y, z, d] = view.near_plane().expect("it is oblique");
        assert!(DVec3::new(x, y, z).distance(normal) < 1e-9 && (d + distance).abs() < 1e-9);
        // Nowhere in the frustum is the plane nearer.
        for place in [[0.0, 0.0], [64.0, 0.0], [0.0, 64.0], [64.0, 64.0], [10.0, 50.0]] {
            let way = DVec3::from(view.ray(place)[1]).dot(normal);
            assert!(way <= 0.0 || distance / way >= f64::from(view.z_near()));
        }
    }
}

#[test]
fn a_view_straight_down_is_sound() {
    let view = View::new([0.0, 5.0, 0.0], [0.0, 0.0, 0.0], [8, 8]).expect("a valid view");
    assert!(view.eye_from_sector.is_finite());
}

#[test]
fn a_camera_draws_what_look_at_and_perspective_matrices_draw() {
    let mut dice = Dice::new(5);
    for _ in 0..100 {
        let mut point = || dice.point(5.0);
        let [eye, toward, up] = [point(), point(), point()];
        let camera = Camera {
            up: up.into(),
            fov_y: 0.2 + dice.roll() as f32 * 2.5,
            z_near: Some(0.01),
            ..Camera::new(eye.into(), toward.into())
        };
        let size = [1 + dice.below(2000) as u32, 1 + dice.below(2000) as u32];
        let view = camera.view(size).expect("a valid camera");
        let clip_from_eye = glam::dcamera::rh::proj::directx::perspective_infinite_reverse(
            f64::from(camera.fov_y),
            f64::from(size[0]) / f64::from(size[1]),
            0.01,
        );
        let eye_from_sector = glam::dcamera::rh::view::look_at_mat4(eye, toward, up.normalize());
        let same = View::from_matrices(
            eye_from_sector.to_cols_array_2d(),
            clip_from_eye.to_cols_array_2d(),
            ClipDepth::OneToZero,
            size,
        );
        let same = same.expect("matrices in perspective");
        assert_eq!(same.z_near, view.z_near);
        assert!((same.fov_y - view.fov_y).abs() < 1e-6);
        assert!(DVec3::from(same.eye()).distance(eye) < 1e-12);
        let point = (eye + 3.0 * (toward - eye) + 0.1 * up).into();
        let [(a, near), (b, far)] = [projected(&view, point), projected(&same, point)];
        assert!(a.distance(b) < 1e-3 && (near - far).abs() < 1e-9, "{a} {b}");
    }
}

#[test]
fn the_tangents_of_a_pose_are_the_edges_of_its_picture() {
    // A quarter turn to the left: −z ahead in eye space is −x in the sector.
    let half = 0.5_f64.sqrt();
    let tangents = [-0.5, 1.5, -1.0, 0.25];
    let view = View::from_pose([1e7, 2.0, 3.0], [0.0, half, 0.0, half], tangents, 0.1, [400, 250]);
    let view = view.expect("a valid pose");
    assert_eq!(view.eye(), [1e7, 2.0, 3.0]);
    let [left, right, bottom, top] = tangents;
    for (x, y, pixel) in [
        (left, top, [0.0, 0.0]),
        (right, bottom, [400.0, 250.0]),
        (0.0, 0.0, [100.0, 50.0]),
    ] {
        // x of eye space is −z of the sector.
        let (at, distance) = projected(&view, [1e7 - 8.0, 2.0 + 8.0 * y, 3.0 - 8.0 * x]);
        assert!(at.distance(DVec2::from(pixel)) < 1e-4, "{at}");
        assert!((distance - 8.0).abs() < 1e-6);
    }
    // One pixel in a picture of 8000 columns, 10,000 km from the origin, is not lost to rounding.
    let sharp = [-4.0, 4.0, -4.0, 4.0];
    let view = View::from_pose([1e7, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0], sharp, 0.1, [8000, 8000]);
    let view = view.expect("a valid pose");
    let step = projected(&view, [1e7 + 0.001, 0.0, -1.0]).0.x - projected(&view, [1e7, 0.0, -1.0]).0.x;
    assert!((step - 1.0).abs() < 1e-4, "{step}");
}

#[test]
fn a_stereo_offset_in_the_projection_moves_the_eye() {
    let mut clip = PERSPECTIVE;
    // The eye sees from half a unit to the right: x of clip space is x − 0.5.
    clip[3][0] = -0.5;
    let view = View::from_matrices(IDENTITY, clip, ClipDepth::ZeroToOne, [100, 100]).expect("an offset");
    assert_eq!(view.eye(), [0.5, 0.0, 0.0]);
    assert_eq!(projected(&view, [0.5, 0.0, -2.0]).0, DVec2::splat(50.0));
    assert!((view.z_near - 0.1).abs() < 1e-6);
}

#[test]
fn a_view_says_whether_it_turns_counter_clockwise_faces_clockwise() {
    let orthographic = glam::dcamera::rh::proj::directx::orthographic(-1.0, 1.0, -1.0, 1.0, 0.5, 9.0);
    for clip in [PERSPECTIVE, orthographic.to_cols_array_2d()] {
        let mut flipped = clip;
        for column in &mut flipped {
            column[0] = -column[0];
        }
        let mut mirror = IDENTITY;
        mirror[1][1] = -1.0;
        let mirrored = |view, clip| {
            let view = View::from_matrices(view, clip, ClipDepth::ZeroToOne, [64, 64]);
            view.expect("a valid view").mirrored()
        };
        assert!(!mirrored(IDENTITY, clip) && !mirrored(mirror, flipped));
        assert!(mirrored(IDENTITY, flipped) && mirrored(mirror, clip));
    }
}

#[test]
fn a_ray_goes_to_what_its_pixel_shows() {
    let view = View::new([1.0, 2.0, 3.0], [4.0, 1.0, -7.0], [640, 480]).expect("a valid view");
    let [origin, direction] = view.ray([123.0, 45.0]).map(DVec3::from);
    let (at, distance) = projected(&view, (origin + 7.0 * direction).into());
    assert!(at.distance(DVec2::new(123.0, 45.0)) < 1e-9 && (distance - 7.0).abs() < 1e-9);
}

const IDENTITY: [[f64; 4]; 4] = [
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
    [0.0, 0.0, 0.0, 1.0],
];

/// Right-handed, 90 degrees, near plane at 0.1, far plane at 100, depth 0 to 1.
const PERSPECTIVE: [[f64; 4]; 4] = [
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, -100.0 / 99.9, -1.0],
    [0.0, 0.0, -10.0 / 99.9, 0.0],
];

#[test]
fn each_broken_rule_has_its_own_error() {
    let sound = Camera::new([0.0; 3], [0.0, 0.0, -1.0]);
    let error = |change: fn(&mut Camera)| {
        let mut camera = sound.clone();
        change(&mut camera);
        camera.view([8, 8]).expect_err("the rule is broken")
    };
    assert_eq!(error(|c| c.toward = c.eye), ViewError::NoDirection);
    assert_eq!(error(|c| c.eye[2] = -1.1e12), ViewError::TooFar("the eye"));
    assert_eq!(error(|c| c.eye[1] = f64::NAN), ViewError::NotFinite("the eye"));
    assert!(matches!(error(|c| c.fov_y = 4.0), ViewError::FieldOfView(_)));
    assert_eq!(error(|c| c.z_near = Some(0.0)), ViewError::Near(0.0));
    assert_eq!(sound.view([0, 0]), Err(ViewError::Size(0, 0)));
    assert_eq!(sound.view([100_000, 1]), Err(ViewError::Size(100_000, 1)));
    let viewport = Viewport {
        origin: [u32::MAX, 0],
        size: [8, 8],
    };
    assert_eq!(sound.view(viewport), Err(ViewError::Origin(u32::MAX, 0)));
    let view = sound.view([8, 8]).expect("a valid view");
    assert_eq!(view.at_sample([0.0, 0.6]), Err(ViewError::Sample(0.0, 0.6)));
    assert!(matches!(
        view.at_sample([f32::NAN, 0.0]),
        Err(ViewError::Sample(..))
    ));

    let pose = |orientation, tangents| View::from_pose([0.0; 3], orientation, tangents, 0.1, [8, 8]);
    assert_eq!(
        pose([0.0; 4], [-1.0, 1.0, -1.0, 1.0]),
        Err(ViewError::Orientation)
    );
    assert_eq!(
        pose([0.0, 0.0, 0.0, 1.0], [1.0, -1.0, -1.0, 1.0]),
        Err(ViewError::Tangents)
    );
}

#[test]
fn matrices_that_are_no_perspective_view_are_refused_by_name() {
    let refused = |eye: [[f64; 4]; 4], clip: [[f64; 4]; 4], depth| {
        View::from_matrices(eye, clip, depth, [64, 64]).expect_err("the rule is broken")
    };
    let changed = |matrix: [[f64; 4]; 4], [column, row]: [usize; 2], value: f64| {
        let mut changed = matrix;
        changed[column][row] = value;
        changed
    };
    let zero_to_one = ClipDepth::ZeroToOne;
    assert!(View::from_matrices(IDENTITY, PERSPECTIVE, zero_to_one, [64, 64]).is_ok());
    let parallel = changed(changed(PERSPECTIVE, [2, 3], 0.0), [3, 3], 1.0);
    let upright = changed(changed(parallel, [2, 2], 0.0), [0, 2], 1.0);
    assert_eq!(refused(IDENTITY, upright, zero_to_one), ViewError::Parallel);
    let squeezed = changed(parallel, [0, 0], 0.0);
    assert_eq!(refused(IDENTITY, squeezed, zero_to_one), ViewError::Singular);
    let oblique = changed(changed(PERSPECTIVE, [0, 2], 0.3), [3, 2], 0.1);
    assert_eq!(refused(IDENTITY, oblique, zero_to_one), ViewError::Oblique);
    // Depth is not reversed, but said to be: the far plane would be taken for the near one.
    let not_reversed = ViewError::ClipDepth {
        depth: ClipDepth::OneToZero,
        is_reversed: false,
    };
    assert_eq!(refused(IDENTITY, PERSPECTIVE, ClipDepth::OneToZero), not_reversed);
    let reversed = changed(changed(PERSPECTIVE, [2, 2], 0.1 / 99.9), [3, 2], 10.0 / 99.9);
    let as_reversed = ViewError::ClipDepth {
        depth: zero_to_one,
        is_reversed: true,
    };
    assert_eq!(refused(IDENTITY, reversed, zero_to_one), as_reversed);
    let no_depth = changed(PERSPECTIVE, [3, 2], 0.0);
    assert!(matches!(
        refused(IDENTITY, no_depth, zero_to_one),
        ViewError::ClipDepth { .. }
    ));
    let flat = changed(PERSPECTIVE, [1, 1], 0.0);
    assert_eq!(refused(IDENTITY, flat, zero_to_one), ViewError::Singular);
    assert_eq!(
        refused(changed(IDENTITY, [2, 2], 0.0), PERSPECTIVE, zero_to_one),
        ViewError::Singular
    );
    assert_eq!(refused(IDENTITY, [[0.0; 4]; 4], zero_to_one), ViewError::Singular);
    let transposed = changed(IDENTITY, [0, 3], 7.0);
    assert_eq!(
        refused(transposed, PERSPECTIVE, zero_to_one),
        ViewError::NotAffine
    );
    // Standard, reversed without a far plane, OpenGL; the last off-centre.
    for [x, z, b] in [[0.0, -1.001, -0.1001], [0.0, 0.0, 0.1], [0.3, -1.002, -0.2002]] {
        let rows = [
            [1.3, 0.0, x, 0.0],
            [0.0, 1.7, 0.0, 0.0],
            [0.0, 0.0, z, b],
            [0.0, 0.0, -1.0, 0.0],
        ];
        for depth in [zero_to_one, ClipDepth::OneToZero, ClipDepth::MinusOneToOne] {
            assert_eq!(refused(IDENTITY, rows, depth), ViewError::Transposed);
        }
    }
    let nan = changed(PERSPECTIVE, [0, 0], f64::NAN);
    assert_eq!(
        refused(IDENTITY, nan, zero_to_one),
        ViewError::NotFinite("the projection matrix")
    );
    let infinite = changed(IDENTITY, [3, 0], f64::INFINITY);
    assert_eq!(
        refused(infinite, PERSPECTIVE, zero_to_one),
        ViewError::NotFinite("the view matrix")
    );
    let far = changed(IDENTITY, [3, 0], 1e13);
    assert_eq!(
        refused(far, PERSPECTIVE, zero_to_one),
        ViewError::TooFar("the eye")
    );
}
