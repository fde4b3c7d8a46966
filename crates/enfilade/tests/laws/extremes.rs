//! The contracts hold at every scale and throughout the coordinate range.

use crate::subject::{LIMIT, limits, subject};
use crate::the_laws_hold;
use enfilade::laws::Contestants;
use enfilade::{
    Aabb, Attributes, ConvexPolygon, GeometryBuilder, ItemIndex, MAX_COORDINATE, Mesh, Part, SceneBuilder,
    SectorId, Transform, View,
};
use enfilade_scenes::{BuiltIn, Camera};

/// Doors, mirrors, scaling portals, intersecting and coplanar faces, slivers, glass, openings in openings.
const SCENES: [&str; 9] = [
    "two-rooms",
    "mirror",
    "teleport",
    "crossing",
    "coplanar",
    "degenerate",
    "glass",
    "slits",
    "eye-in-things",
];

const SIZE: [u32; 2] = [64, 36];

/// Returns the mesh, scaled.
fn scaled(mesh: &Mesh, scale: f32) -> Mesh {
    let positions: Vec<[f32; 3]> = (mesh.positions().iter())
        .map(|position| position.map(|value| value * scale))
        .collect();
    let mut corners = Vec::new();
    let mut sides = Vec::new();
    for cluster in mesh.clusters() {
        let faces = cluster.faces.clone().map(|face| mesh.face(face));
        corners.push(faces.clone().flatten().copied().collect::<Vec<u32>>());
        sides.push(faces.map(|face| face.len() as u32).collect::<Vec<u32>>());
    }
    let parts: Vec<Part> = (mesh.clusters().iter().zip(corners.iter().zip(&sides)))
        .map(|(cluster, (corners, sides))| Part {
            positions: &positions,
            corners,
            sides: Some(sides),
            material: cluster.material,
            attributes: Attributes::default(),
        })
        .collect();
    Mesh::new(&parts).expect("the faces stay flat and convex")
}

/// Returns the scene scaled, then translated: its meshes, items, openings, portals and cameras.
fn moved(built: &BuiltIn, scale: f32, shift: [f32; 3]) -> BuiltIn {
    let scene = &built.scene;
    let there_from_here = Transform::translation(shift) * Transform::scaling([scale; 3]);
    let back_to_size = Transform::scaling([1.0 / scale; 3]);
    let here_from_there = there_from_here.inverse().expect("it scales and shifts");
    let conjugate = |map: Transform| there_from_here * map * here_from_there;
    let mut moved = SceneBuilder::new();
    for id in scene.sectors() {
        let geometry = scene.geometry(id).expect("no custom sectors");
        let mut builder = GeometryBuilder::new(geometry.materials());
        builder.textures(geometry.textures());
        for (number, item) in (0..).zip(geometry.items()) {
            let mesh = builder.mesh(scaled(geometry.mesh_of(ItemIndex(number)), scale));
            let there_from_item = there_from_here * item.transform() * back_to_size;
            builder.item(geometry.name(ItemIndex(number)), mesh, there_from_item);
        }
        for opening in geometry.openings() {
            let corners = opening.outline.corners().iter();
            let corners: Vec<[f32; 3]> = corners.map(|&corner| there_from_here.point(corner)).collect();
            builder.opening(&opening.name, ConvexPolygon::new(&corners).expect("still flat"));
        }
        let method = scene.method(id).expect("no custom sectors");
        moved.add(scene.sector_name(id), builder.build().expect("in range"), method);
    }
    for portal in scene.portals() {
        moved.portal(
            (portal.from, portal.opening),
            portal.to,
            conjugate(portal.there_from_here),
        );
    }
    let cameras = built.cameras.iter().take(2).map(|camera| Camera {
        eye: there_from_here.point(camera.eye),
        toward: there_from_here.point(camera.toward),
        ..camera.clone()
    });
    BuiltIn {
        scene: moved.build().expect("in range"),
        cameras: cameras.collect(),
    }
}

/// Returns the largest absolute coordinate of a scene.
fn reach(built: &BuiltIn) -> f32 {
    let whole = built.scene.sectors().fold(Aabb::EMPTY, |sum, id: SectorId| {
        sum.union(&built.scene.bounds(id))
    });
    (whole.min.into_iter().chain(whole.max)).fold(0.0, |most, side| most.max(side.abs()))
}

fn holds_on(name: &'static str, scale: f32, shift: [f32; 3]) {
    let built = moved(&subject(name).built, scale, shift);
    the_laws_hold(name, &built, SIZE);
}

/// The near distance, a centimetre, is most of a room there: the doorway is nearer, and the geometry behind it is not.
#[test]
fn doorways_nearer_than_the_near_plane_of_a_tiny_scene_are_looked_through() {
    let mut visible = 0;
    for scale in [1e-3, 2e-3, 3e-3] {
        let built = moved(&subject("two-rooms").built, scale, [0.0; 3]);
        let mut contestants = Contestants::new(&built.scene, limits(), LIMIT);
        for (eye, toward) in [
            ([-2.0, 1.0, 0.3], [5.0, 1.0, 0.0]),
            ([-0.5, 1.2, 0.0], [5.0, 0.8, 1.0]),
            ([-0.002, 1.05, 0.02], [5.0, 1.05, 0.02]),
            ([2.5, 1.0, 0.4], [-5.0, 1.0, 0.0]),
        ] {
            let [eye, toward] = [eye, toward].map(|point: [f32; 3]| point.map(|value| value * scale));
            let view = View::new(eye, toward, SIZE);
            let (certain, broken) = contestants.check(&view);
            assert!(broken.is_empty(), "{scale}, {view:?}: {}", broken[0]);
            visible += certain;
        }
    }
    assert!(visible > 8, "{visible} items are visible");
}

#[test]
fn scenes_of_all_sizes_are_seen_as_they_are() {
    for name in SCENES {
        let largest = 0.99 * MAX_COORDINATE / reach(&subject(name).built);
        for scale in [1e-5, 1e-2, 1e3, 1e6, 1e8, largest] {
            holds_on(name, scale, [0.0; 3]);
        }
    }
}

#[test]
fn scenes_far_from_the_origin_are_seen_as_they_are() {
    for name in SCENES {
        for (scale, far) in [(1.0, 1e3), (606.0, 1e7), (1e5, 1e8), (1e9, 0.8 * MAX_COORDINATE)] {
            holds_on(name, scale, [far, -0.9 * far, 0.8 * far]);
        }
    }
}
