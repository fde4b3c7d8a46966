//! `LargeTerrain` gives the same results as a height field in a geometry, with almost no memory.

use allocation_counter::measure;
use enfilade::laws::OwnerPicture;
use enfilade::{
    Camera, Contract, ConvexPolygon, Diagonal, GeometryBuilder, HeightBytes, HeightField, HeightFieldError,
    HeightFormat, Heights, LargeTerrain, Material, MaterialId, Mesh, Method, Opening, OpeningId, Ray, Scene,
    SceneBuilder, Sector, SectorId, Transform, View, Viewer, ViewerOptions,
};
use enfilade_scenes::Random;
use std::sync::Arc;

const COLOR: [f32; 3] = [0.3, 0.4, 0.2];
const SCREEN: [u32; 2] = [96, 64];

/// Heights generated on demand.
struct Made<F> {
    size: [u32; 2],
    height: F,
}

impl<F: Fn(u32, u32) -> f32 + Send + Sync> Heights for Made<F> {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn read(&self, column: u32, row: u32, heights: &mut [f32]) {
        for (column, height) in (column..).zip(heights) {
            *height = (self.height)(column, row);
        }
    }
}

/// Hills, spikes, cliffs, noise and plains; strips, single cells, and sizes that fill no block.
fn heights(random: &mut Random) -> ([u32; 2], Vec<f32>) {
    let size = match random.below(5) {
        0 => [2, 2 + random.below(120) as u32],
        1 => [2 + random.below(120) as u32, 2],
        2 => [33 + 32 * random.below(3) as u32, 65],
        _ => [2 + random.below(150) as u32, 2 + random.below(150) as u32],
    };
    let kind = random.below(5);
    let [long, wide] = [random.between(0.05, 0.6), random.between(0.05, 0.6)];
    let mut heights = Vec::new();
    for row in 0..size[1] {
        for column in 0..size[0] {
            let hill = 2.0 * (column as f32 * long).sin() + 2.0 * (row as f32 * wide).cos();
            heights.push(match kind {
                0 => hill,
                1 if random.below(20) == 0 => random.between(2.0, 20.0),
                2 => 6.0 * hill.round(),
                3 => random.between(-1.0, 1.0),
                _ => 0.0,
            });
        }
    }
    (size, heights)
}

fn bytes(heights: &[f32]) -> Vec<u8> {
    heights.iter().flat_map(|height| height.to_le_bytes()).collect()
}

/// Positions above, on, in and under the ground; level, straight up and down, and rolled views.
fn views(random: &mut Random, field: &HeightField) -> Vec<View> {
    let mut views = Vec::new();
    for look in 0..9 {
        let mut anywhere = |above: f32| {
            let [column, row] = [0, 1].map(|axis| random.below(field.size()[axis] as usize) as u32);
            let at = field.position(column, row);
            [at[0] + 0.13, at[1] + above, at[2] + 0.07]
        };
        let eye = anywhere([1.7, 0.4, 0.02, 40.0, 8.0, -0.3, -9.0, 20.0, -15.0][look]);
        let toward = match look {
            7 => [eye[0], eye[1] - 1.0, eye[2]],
            8 => [eye[0], eye[1] + 1.0, eye[2]],
            _ => anywhere(0.5),
        };
        let mut camera = Camera::new(eye, toward);
        if look > 3 {
            camera.up = [0, 1, 2].map(|_| f64::from(random.between(-1.0, 1.0)));
        }
        // The eye may be where it looks.
        views.extend(camera.view(SCREEN));
        views.extend(View::parallel(eye, toward, camera.up, 30.0, SCREEN));
    }
    views
}

/// The same terrain as a height field for the floating-horizon method, and as `LargeTerrain`.
fn both(random: &mut Random) -> (HeightField, LargeTerrain) {
    let (size, heights) = heights(random);
    let cell = [0, 1].map(|_| f64::from(random.between(0.3, 2.0)));
    let diagonal = [Diagonal::NorthEast, Diagonal::NorthWest][random.below(2)];
    let stored = HeightBytes::new(bytes(&heights), size, HeightFormat::F32Le, None).expect("as many");
    let large = LargeTerrain::new(stored, cell, COLOR).expect("no holes");
    let field = HeightField::new(size, cell, heights).expect("no holes");
    (field.cut_along(diagonal), large.cut_along(diagonal))
}

fn as_geometry(field: &HeightField) -> GeometryBuilder {
    let mut geometry = GeometryBuilder::new([Material {
        double_sided: true,
        ..Material::opaque(COLOR)
    }]);
    geometry
        .terrain("block", field.clone(), MaterialId(0), Transform::IDENTITY)
        .expect("few faces");
    geometry
}

fn alone(add: impl FnOnce(&mut SceneBuilder) -> SectorId) -> Scene {
    let mut scene = SceneBuilder::new();
    add(&mut scene);
    scene.build().expect("one sector")
}

#[test]
fn it_is_seen_as_the_same_heights_are_as_a_geometry() {
    let mut random = Random::new(7);
    let (mut looks, mut met) = (0, 0);
    for number in 0..60 {
        let (field, large) = both(&mut random);
        let views = views(&mut random, &field);
        let large = alone(|scene| scene.add_custom("ground", Arc::new(large)));
        let geometry = as_geometry(&field).build().expect("sound blocks");
        let geometry = alone(|scene| scene.add("ground", geometry, Method::FloatingHorizon));
        assert_eq!(large.item_count(), geometry.item_count());
        assert_eq!(large.triangle_count(), geometry.triangle_count());
        assert_eq!(large.bounds(SectorId(0)), geometry.bounds(SectorId(0)));
        let [mut viewer, mut other] = [Viewer::new(), Viewer::new()];
        for (look, view) in views.iter().enumerate() {
            let items = |viewer: &Viewer| -> Vec<_> {
                let items = viewer.visible().items().iter();
                items.map(|item| (item.item, item.size_px)).collect()
            };
            let [mut seen, mut expected] = [OwnerPicture::new(SCREEN), OwnerPicture::new(SCREEN)];
            viewer.draw(&large, view, &mut seen);
            other.draw(&geometry, view, &mut expected);
            let drawn = items(&viewer);
            assert_eq!(drawn, items(&other), "field {number}, look {look}");
            viewer.look(&large, view);
            assert_eq!(drawn, items(&viewer), "field {number}, look {look}");
            assert_eq!(
                viewer.visible().in_frustum(&large).0,
                other.visible().in_frustum(&geometry).0
            );
            for at in (0..SCREEN[1]).flat_map(|y| (0..SCREEN[0]).map(move |x| [x, y])) {
                let [seen, expected] =
                    [&seen, &expected].map(|picture| picture.owner(at).map(|owner| owner.item()));
                assert_eq!(seen, expected, "field {number}, look {look}, {at:?}");
                met += usize::from(seen.is_some());
            }
            looks += 1;
        }
    }
    assert!(looks > 400 && met > 500_000, "{looks} looks met {met}");
}

#[test]
fn rays_meet_it_where_they_meet_the_same_heights_as_a_geometry() {
    let mut random = Random::new(8);
    let mut hits = 0;
    for _ in 0..40 {
        let (field, large) = both(&mut random);
        let geometry = as_geometry(&field).build().expect("sound blocks");
        for view in views(&mut random, &field) {
            let [origin, toward] = [view.eye(), view.toward()].map(|at| at.map(|value| value as f32));
            let direction = [0, 1, 2].map(|axis| toward[axis] - origin[axis]);
            let ray = Ray { origin, direction };
            let [met, expected] = [large.cast(&ray), geometry.cast(&ray)];
            assert_eq!(met.is_some(), expected.is_some(), "{ray:?}");
            let (Some(met), Some(expected)) = (met, expected) else {
                continue;
            };
            hits += 1;
            let off = (met.distance - expected.distance).abs();
            assert!(
                off <= 1e-6 * (1.0 + expected.distance),
                "{met:?}, not {expected:?}"
            );
            assert_eq!((met.item, met.from_behind), (expected.item, expected.from_behind));
            let [surface, known] = [
                large.surface(met.item.index, met.face),
                geometry.surface(expected.item.index, expected.face),
            ];
            assert_eq!(surface.color, known.color);
            let turned: f32 = (0..3).map(|axis| surface.normal[axis] * known.normal[axis]).sum();
            assert!(turned > 0.9999, "{surface:?}, not {known:?}");
        }
    }
    assert!(hits > 100, "{hits}");
}

/// A house in a hillside: a doorway in the terrain leads to a room with a lamp.
fn with_a_door(field: &HeightField, large: Option<LargeTerrain>) -> Scene {
    let doorway = ConvexPolygon::rectangle([20.0, 0.0, 20.0], [3.0, 0.0, 0.0], [0.0, 4.0, 0.0]);
    let doorway = doorway.expect("a rectangle");
    let mut room = GeometryBuilder::new([Material::opaque([0.8, 0.3, 0.2])]);
    let corners = [[18.0, 0.0, 15.0], [26.0, 0.0, 15.0], [22.0, 5.0, 15.0]];
    let lamp = room.mesh(Mesh::triangles(&corners, &[0, 1, 2], MaterialId(0)).expect("a triangle"));
    room.item("lamp", lamp, Transform::IDENTITY);
    let back = room.opening("back", doorway.flipped());
    let mut scene = SceneBuilder::new();
    let ground = match large {
        Some(large) => {
            let opening = Opening {
                name: "door".to_owned(),
                outline: doorway,
            };
            let large = large.with_openings(vec![opening]).expect("a few openings");
            scene.add_custom("ground", Arc::new(large))
        }
        None => {
            let mut geometry = as_geometry(field);
            geometry.opening("door", doorway);
            let geometry = geometry.build().expect("sound blocks");
            scene.add("ground", geometry, Method::FloatingHorizon)
        }
    };
    let room = scene.add("room", room.build().expect("a lamp"), Method::ZBuffer);
    scene.door((ground, OpeningId(0)), (room, back));
    scene.build().expect("a house")
}

#[test]
fn an_opening_in_it_is_followed() {
    let size = [70, 70];
    let heights: Vec<f32> = (0..70 * 70)
        .map(|at: u32| ((at % 70) as f32 * 0.3).sin() + ((at / 70) as f32 * 0.2).cos() - 1.0)
        .collect();
    let stored = HeightBytes::new(bytes(&heights), size, HeightFormat::F32Le, None).expect("as many");
    let large = LargeTerrain::new(stored, [1.0; 2], COLOR).expect("no holes");
    let field = HeightField::new(size, [1.0; 2], heights).expect("no holes");
    let [large, geometry] = [with_a_door(&field, Some(large)), with_a_door(&field, None)];
    let [mut viewer, mut other] = [Viewer::new(), Viewer::new()];
    for eye in [[21.0, 2.0, 30.0], [24.0, 6.0, 50.0], [21.5, 2.0, 20.5]] {
        let camera = Camera {
            sector: Some(SectorId(0)),
            ..Camera::new(eye, [21.5, 2.0, 15.0])
        };
        let view = camera.view(SCREEN).expect("a valid view");
        let [mut seen, mut expected] = [OwnerPicture::new(SCREEN), OwnerPicture::new(SCREEN)];
        viewer.draw(&large, &view, &mut seen);
        other.draw(&geometry, &view, &mut expected);
        assert_eq!(
            viewer.visible().passages().len(),
            2,
            "the room is seen from {eye:?}"
        );
        let items = |viewer: &Viewer| -> Vec<_> {
            let items = viewer.visible().items().iter();
            items.map(|item| (item.passage, item.item)).collect()
        };
        assert_eq!(items(&viewer), items(&other));
        for at in (0..SCREEN[1]).flat_map(|y| (0..SCREEN[0]).map(move |x| [x, y])) {
            let item = |picture: &OwnerPicture| picture.owner(at).map(|owner| owner.item());
            assert_eq!(item(&seen), item(&expected), "{at:?} from {eye:?}");
        }
    }
    // A closed door is a face with an id after all terrain faces.
    let mut flat = OwnerPicture::new(SCREEN);
    let view = View::new([21.0, 2.0, 30.0], [21.5, 2.0, 15.0], SCREEN).expect("a valid view");
    viewer.draw(&large.without_portals(), &view, &mut flat);
    assert_eq!(viewer.visible().passages().len(), 1);
}

#[test]
fn what_makes_no_ground_is_refused_by_its_place() {
    let made = |size, height: fn(u32, u32) -> f32| {
        let made = Made { size, height };
        LargeTerrain::new(made, [1.0; 2], COLOR).map(|_| ())
    };
    let hole = made([100, 90], |column, row| {
        if (column, row) == (77, 65) || row > 70 {
            f32::NAN
        } else {
            1.0
        }
    });
    let said = hole.expect_err("a hole").to_string();
    assert!(
        said.starts_with("the height at column 77, row 65 is NaN"),
        "{said}"
    );
    let flat = |_, _| 0.0;
    assert_eq!(made([1, 9], flat), Err(HeightFieldError::Size([1, 9])));
    assert_eq!(made([9, 65538], flat), Err(HeightFieldError::Size([9, 65538])));
    let faces = 2048_u64.pow(3);
    assert_eq!(made([65537, 65537], flat), Err(HeightFieldError::Faces(faces)));
    let cell = LargeTerrain::new(
        Made {
            size: [9, 9],
            height: flat,
        },
        [1.0, 0.0],
        COLOR,
    );
    assert_eq!(
        cell.map(|_| ()).expect_err("no length"),
        HeightFieldError::Cell([1.0, 0.0])
    );
    let few = HeightBytes::new(vec![0; 17], [3, 3], HeightFormat::U16Le, None).map(|_| ());
    assert_eq!(few, Err(HeightFieldError::Bytes { needs: 18, has: 17 }));
}

#[test]
fn bytes_are_read_in_either_order_and_one_of_their_heights_may_be_a_hole() {
    let read = |bytes: Vec<u8>, format, hole| {
        let mut heights = [0.0; 2];
        let stored = HeightBytes::new(bytes, [3, 2], format, hole).expect("as many");
        stored.read(1, 1, &mut heights);
        heights
    };
    let shorts: [u16; 6] = [9, 9, 9, 9, 300, 65535];
    let floats: [f32; 6] = [9.0, 9.0, 9.0, 9.0, -0.5, 1e9];
    let le = shorts
        .iter()
        .flat_map(|height| height.to_le_bytes())
        .collect::<Vec<u8>>();
    let be = shorts.iter().flat_map(|height| height.to_be_bytes()).collect();
    assert_eq!(read(le.clone(), HeightFormat::U16Le, None), [300.0, 65535.0]);
    assert_eq!(read(be, HeightFormat::U16Be, None), [300.0, 65535.0]);
    let [seen, hole] = read(le, HeightFormat::U16Le, Some(65535.0));
    assert!(seen == 300.0 && hole.is_nan());
    let be = floats.iter().flat_map(|height| height.to_be_bytes()).collect();
    assert_eq!(read(be, HeightFormat::F32Be, None), [-0.5, 1e9]);
    assert_eq!(read(bytes(&floats), HeightFormat::F32Le, None), [-0.5, 1e9]);
}

#[test]
fn a_look_allocates_nothing_and_the_tree_takes_eleven_bytes_a_block() {
    let made = Made {
        size: [2049, 1025],
        height: |column, row| 30.0 * ((column as f32 * 0.01).sin() + (row as f32 * 0.013).cos()),
    };
    let large = LargeTerrain::new(made, [1.0; 2], COLOR).expect("no holes");
    assert!(large.bytes() < 64 * 32 * 11 + 8192, "{}", large.bytes());
    assert_eq!(
        (
            large.contract(&ViewerOptions::default()),
            large.build_stats().faces
        ),
        (Contract::Exact, 2 * 2048 * 1024)
    );
    let scene = alone(|scene| scene.add_custom("ground", Arc::new(large)));
    let views = [[900.0, 40.0, 500.0], [20.0, 70.0, 20.0]]
        .map(|eye| View::new(eye, [1024.0, 0.0, 512.0], SCREEN).expect("a valid view"));
    let mut viewer = Viewer::new();
    let mut seen = 0;
    let mut round = || {
        for view in &views {
            seen += viewer.look(&scene, view).items().len();
        }
    };
    (0..4).for_each(|_| round());
    assert_eq!(measure(&mut round).count_total, 0);
    assert!(seen > 0);
}
