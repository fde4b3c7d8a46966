//! Scene errors: each one once, with its whole message.
//!
//! A scene cannot contain itself: [`SceneBuilder::nest`] takes a scene that is already built.

use enfilade::{
    Aabb, Canvas, Collector, Contract, ConvexPolygon, Geometry, GeometryBuilder, Hit, ItemIndex, Light,
    Material, MaterialId, Memory, Mesh, Method, Opening, OpeningId, Passage, PortalEnd, PortalId, Ray, Scene,
    SceneBuilder, SceneError, Sector, SectorId, Surface, Transform, Unsuited, ViewerOptions,
};
use std::sync::Arc;

const DOOR: OpeningId = OpeningId(0);
const WINDOW: OpeningId = OpeningId(1);

/// A room with a wall, a door and a window.
fn room() -> Geometry {
    let mut room = GeometryBuilder::new([Material::opaque([1.0; 3])]);
    let wall = Mesh::triangles(
        &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        &[0, 1, 2],
        MaterialId(0),
    );
    let wall = room.mesh(wall.expect("a triangle"));
    room.item("wall", wall, Transform::IDENTITY);
    for (name, x) in [("door", 0.0), ("window", 2.0)] {
        let outline = ConvexPolygon::rectangle([x, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        room.opening(name, outline.expect("a square"));
    }
    room.build().expect("a room")
}

/// Builds a hall and whatever `add` puts into the scene. Returns the error.
fn refused(add: impl FnOnce(&mut SceneBuilder, SectorId)) -> SceneError {
    let mut builder = SceneBuilder::new();
    let hall = builder.add("hall", room(), Method::ZBuffer);
    add(&mut builder, hall);
    builder.build().err().expect("it makes no scene")
}

fn says(error: &SceneError, message: &str) {
    assert_eq!(error.to_string(), message);
}

/// A scene of one room, with its door and its window as exits.
fn cabinet() -> Scene {
    let mut builder = SceneBuilder::new();
    let cabinet = builder.add("cabinet", room(), Method::ZBuffer);
    builder
        .exit("front", (cabinet, DOOR))
        .exit("hatch", (cabinet, WINDOW));
    builder.build().expect("a cabinet")
}

#[test]
fn a_sector_that_is_not_there() {
    let nowhere = SectorId(12);
    let error = refused(|scene, hall| {
        scene
            .mirror(hall, WINDOW)
            .portal((hall, DOOR), nowhere, Transform::IDENTITY);
    });
    says(&error, "portal 1 names sector 12, but there are only 1");
    let error = refused(|scene, _| {
        scene.exit("gate", (nowhere, DOOR));
    });
    says(&error, "exit `gate` names sector 12, but there are only 1");
    // Sectors of a nested scene cannot be accessed; they are reached through its exits.
    let error = refused(|scene, hall| {
        scene.nest(&cabinet());
        scene.portal((hall, DOOR), SectorId(1), Transform::IDENTITY);
    });
    says(&error, "portal 0 names sector 1, but there are only 1");
}

#[test]
fn an_opening_that_is_not_there() {
    let error = refused(|scene, hall| {
        scene.mirror(hall, OpeningId(7));
    });
    says(
        &error,
        "portal 0 uses opening 7 of sector `hall`, which has only 2",
    );
    let error = refused(|scene, hall| {
        scene.exit("gate", (hall, OpeningId(2)));
    });
    says(
        &error,
        "exit `gate` uses opening 2 of sector `hall`, which has only 2",
    );
}

#[test]
fn an_exit_that_is_not_there() {
    let error = refused(|scene, hall| {
        let inner = scene.nest(&cabinet());
        scene.door((hall, DOOR), (inner, "back"));
    });
    says(
        &error,
        "portal 0 uses exit `back` of a nested scene, which has only `front`, `hatch`",
    );
    let error = refused(|scene, hall| {
        let closed = scene.nest(&SceneBuilder::new().build().expect("nothing"));
        scene.door((hall, DOOR), (closed, "front"));
    });
    says(
        &error,
        "portal 0 uses exit `front` of a nested scene, which has none",
    );
    let error = refused(|scene, _| {
        let inner = scene.nest(&cabinet());
        scene.exit("gate", (inner, "back"));
    });
    says(
        &error,
        "exit `gate` uses exit `back` of a nested scene, which has only `front`, `hatch`",
    );
}

#[test]
fn a_way_out_of_anywhere() {
    let rule =
        "starts at a sector, not at an opening; start it at an opening or at an exit of a nested scene";
    let error = refused(|scene, hall| {
        scene.portal(hall, (hall, DOOR), Transform::IDENTITY);
    });
    says(&error, &format!("portal 0 {rule}"));
    let error = refused(|scene, hall| {
        scene.exit("gate", PortalEnd::Anywhere(hall));
    });
    says(&error, &format!("exit `gate` {rule}"));
}

#[test]
fn two_portals_out_of_one_opening() {
    let error = refused(|scene, hall| {
        scene.mirror(hall, WINDOW).mirror(hall, DOOR).mirror(hall, WINDOW);
    });
    says(
        &error,
        "portal 0 and portal 2 both lead out of opening `window` of sector `hall`",
    );
    // Portals of nested scenes have no id in the outer scene.
    let mut inner = SceneBuilder::new();
    let cabinet = inner.add("cabinet", room(), Method::ZBuffer);
    inner.mirror(cabinet, DOOR).exit("front", (cabinet, DOOR));
    let inner = inner.build().expect("a cabinet");
    let error = refused(|scene, hall| {
        let inner = scene.nest(&inner);
        scene.portal((inner, "front"), hall, Transform::IDENTITY);
    });
    says(
        &error,
        "a portal of a nested scene and portal 0 both lead out of opening `door` of sector `cabinet`",
    );
}

#[test]
fn two_exits_of_one_name() {
    let error = refused(|scene, hall| {
        scene.exit("gate", (hall, DOOR)).exit("gate", (hall, WINDOW));
    });
    says(&error, "duplicate exit name `gate`");
}

#[test]
fn a_transform_that_shears() {
    let sheared = Transform::from_columns([[1.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]]);
    let error = refused(|scene, hall| {
        scene.portal((hall, DOOR), hall, sheared);
    });
    says(
        &error,
        "the transform of portal 0 must be rigid, uniformly scaling or reflecting",
    );
    let mut builder = SceneBuilder::new();
    let hall = builder.add("hall", room(), Method::ZBuffer);
    builder.mirror(hall, DOOR);
    let mut scene = builder.build().expect("a hall");
    assert_eq!(scene.set_portal(PortalId(0), sheared), Err(error));
}

#[test]
fn a_lamp_that_cannot_shine() {
    let lamp = |sector, range| Light::point(sector, [0.0; 3], [1.0; 3], range);
    let error = refused(|scene, hall| {
        scene.light(lamp(hall, 1.0));
        scene.light(lamp(hall, 0.0));
    });
    let rule = "is invalid: it needs finite numbers, a position within 1e12 units, a range above 0, a nonzero direction, angles with 0 <= inner < outer <= pi/2, and a sector of this scene";
    says(&error, &format!("light 1 {rule}"));
    let error = refused(|scene, _| {
        scene.light(lamp(SectorId(1), 1.0));
    });
    says(&error, &format!("light 0 {rule}"));
    // The same rules apply to a nested scene that is added later.
    let mut scene = cabinet();
    let later = scene.add_light(lamp(SectorId(0), -1.0)).expect_err("no range");
    says(&later, &format!("light 0 {rule}"));
    assert!(scene.lights().is_empty());
}

#[test]
fn a_sector_that_needs_too_much_memory() {
    let error = refused(|scene, _| {
        scene.limit_bytes(100);
        scene.add("tower", room(), Method::Bsp);
    });
    let SceneError::Unsuited { sector, why } = &error else {
        panic!("{error}");
    };
    let limit = match why.reason {
        Unsuited::TooLarge { limit, .. } => limit,
        _ => panic!("{error}"),
    };
    assert_eq!((&**sector, limit), ("tower", 100));
    let said = error.to_string();
    assert!(
        said.starts_with("sector `tower`: method bsp needs about ")
            && said.ends_with(", above the limit of 100 bytes; z-buffer needs less"),
        "{said}"
    );
}

/// A sector without visible geometry.
struct Void(Aabb);

impl Sector for Void {
    fn bounds(&self) -> Aabb {
        self.0
    }
    fn openings(&self) -> &[Opening] {
        &[]
    }
    fn contract(&self, _options: &ViewerOptions) -> Contract {
        Contract::Exact
    }
    fn gather(&self, _passage: &Passage, _memory: &mut Memory, _seen: &mut Collector) {}
    fn draw(
        &self,
        _passage: &Passage,
        _memory: &mut Memory,
        _seen: &mut Collector,
        _canvas: &mut dyn Canvas,
    ) {
    }
    fn cast(&self, _ray: &Ray) -> Option<Hit> {
        None
    }
    fn surface(&self, _item: ItemIndex, _face: u32) -> Surface {
        unreachable!("it has no faces")
    }
}

#[test]
fn what_is_not_ours_is_not_exchanged() {
    let mut builder = SceneBuilder::new();
    let void = builder.add_custom("void", Arc::new(Void(Aabb::EMPTY)));
    let mut scene = builder.build().expect("a scene of a custom sector");
    let message = "sector `void` is custom; its geometry and method cannot be replaced";
    says(&scene.set_geometry(void, room()).expect_err("not ours"), message);
    says(
        &scene.set_method(void, Method::Bsp).expect_err("not ours"),
        message,
    );
}

#[test]
fn a_custom_sector_with_a_box_of_no_numbers() {
    for (side, is_sound) in [
        (f32::INFINITY, true),
        (1e12, true),
        (2e12, false),
        (f32::NAN, false),
    ] {
        let bounds = Aabb {
            min: [-1.0; 3],
            max: [1.0, side, 1.0],
        };
        let mut builder = SceneBuilder::new();
        builder.add_custom("sky", Arc::new(Void(bounds)));
        match builder.build() {
            Ok(_) => assert!(is_sound, "{side}"),
            Err(error) => {
                assert!(!is_sound, "{side}");
                says(
                    &error,
                    "the bounds of custom sector `sky` have a coordinate that is NaN, or finite and beyond 1e12 units",
                );
            }
        }
    }
}

#[test]
fn a_geometry_with_fewer_openings() {
    let mut builder = SceneBuilder::new();
    let hall = builder.add("hall", room(), Method::ZBuffer);
    let mut scene = builder.build().expect("a hall");
    let closed = GeometryBuilder::new([]).build().expect("nothing");
    says(
        &scene
            .set_geometry(hall, closed)
            .expect_err("openings are missing"),
        "sector `hall` has 2 openings, but its new geometry has 0; keep their number",
    );
}

#[test]
fn a_method_is_exchanged_in_one_sector_or_not_at_all() {
    let mut builder = SceneBuilder::new();
    builder.limit_bytes(100);
    let [hall, tower] = ["hall", "tower"].map(|name| builder.add(name, room(), Method::ZBuffer));
    let mut scene = builder.build().expect("two rooms");
    scene
        .set_method(tower, Method::SBuffer)
        .expect("it needs nothing");
    assert!(matches!(
        scene.set_method(tower, Method::Bsp),
        Err(SceneError::Unsuited { .. })
    ));
    assert_eq!([hall, tower].map(|id| scene.builds(id)), [1, 2]);
    let methods = [hall, tower].map(|id| scene.method(id));
    assert_eq!(methods, [Some(Method::ZBuffer), Some(Method::SBuffer)]);
}

#[test]
fn a_sector_that_is_open_above_and_not_there() {
    let error = refused(|builder, _| {
        builder.open_above(SectorId(7));
    });
    says(&error, "open_above names sector 7, but there are only 1");
}
