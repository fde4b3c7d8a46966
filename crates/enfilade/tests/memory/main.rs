//! A viewer's memory beyond the scene does not grow with the passages of a look.

mod mirrors;

use allocation_counter::measure;
use enfilade::{
    Alpha, Canvas, ConvexPolygon, GeometryBuilder, Material, MaterialId, Mesh, Method, Passage, PassageId,
    Scene, SceneBuilder, Span, Transform, View, Viewer,
};
use enfilade_scenes::built_in;
use mirrors::hundred_mirrors;

const SIZE: [u32; 2] = [1920, 1080];

/// Limit in bytes, at any moment.
const MOST: u64 = 64_000_000;

/// Additional memory for transparent samples, 16 bytes each: those of one passage at a time, however many follow each
/// other.
const GLASS: u64 = 16 * SIZE[0] as u64 * SIZE[1] as u64;

/// A canvas that ignores all spans.
struct Nothing;

impl Canvas for Nothing {
    fn enter(&mut self, _id: PassageId, _passage: &Passage) {}
    fn row(&mut self, _y: u16, _spans: &[Span]) {}
}

/// Checks with every method that looking and drawing through a hundred passages takes at most `most` bytes.
fn stays_small(scene: &Scene, view: &View, most: u64) {
    for method in Method::ALL
        .into_iter()
        .filter(|method| method.requires().is_none())
    {
        let scene = scene
            .with_method(method, Method::DEFAULT_LIMIT)
            .expect("it is small");
        let mut passages = 0;
        let taken = measure(|| {
            let mut viewer = Viewer::new();
            viewer.options.limits.max_crossings = 120;
            // The second look also holds what the first one remembered.
            for _ in 0..2 {
                passages = viewer.look(&scene, view).passages().len();
                viewer.draw(&scene, view, &mut Nothing);
            }
        });
        assert!(passages > 100, "{method}: only {passages} passages");
        assert!(
            taken.bytes_max < most,
            "{method}: {} bytes for {passages} passages",
            taken.bytes_max
        );
    }
}

#[test]
fn a_hundred_mirrors_side_by_side_share_their_buffers() {
    let view = View::new([0.0, 0.0, 1.0], [0.0, 0.0, -4.0], SIZE).expect("a valid view");
    stays_small(&hundred_mirrors(), &view, MOST);
}

#[test]
fn a_hundred_mirrors_within_each_other_share_their_buffers() {
    let mirrors = built_in("mirrors").expect("a built-in scene");
    stays_small(
        &mirrors.scene,
        &mirrors.cameras[0].view(SIZE).expect("a valid view"),
        MOST,
    );
}

/// Two facing mirrors, and a pane between them that fills the picture.
fn mirrors_behind_glass() -> Scene {
    let glass = Material {
        base_color: [0.6, 0.6, 0.6, 0.5],
        alpha: Alpha::Blend,
        double_sided: true,
        ..Material::opaque([0.6; 3])
    };
    let mut room = GeometryBuilder::new([glass]);
    let corners = [
        [-9.0, -9.0, -1.0],
        [9.0, -9.0, -1.0],
        [9.0, 9.0, -1.0],
        [-9.0, 9.0, -1.0],
    ];
    let pane = Mesh::triangles(&corners, &[0, 1, 2, 0, 2, 3], MaterialId(0)).expect("a square");
    let pane = room.mesh(pane);
    room.item("pane", pane, Transform::IDENTITY);
    let [across, up] = [[6.0, 0.0, 0.0], [0.0, 6.0, 0.0]];
    let mirrors = [(-2.0, [across, up]), (2.0, [up, across])].map(|(z, [a, b])| {
        let outline = ConvexPolygon::rectangle([-3.0, -3.0, z], a, b);
        room.opening("mirror", outline.expect("a square"))
    });
    let mut scene = SceneBuilder::new();
    let room = scene.add("room", room.build().expect("a room"), Method::ZBuffer);
    for mirror in mirrors {
        scene.mirror(room, mirror);
    }
    scene.build().expect("a room of two mirrors")
}

#[test]
fn nor_do_mirrors_within_each_other_keep_all_the_glass_before_them() {
    let view = View::new([0.0, 0.0, 1.0], [0.0, 0.0, -2.0], SIZE).expect("a valid view");
    stays_small(&mirrors_behind_glass(), &view, MOST + GLASS);
}
