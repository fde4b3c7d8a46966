//! What the levels of tightness keep and leave out, on scenes made by hand.

use Tightness::{Boxes, Faces, Resolved};
use enfilade::laws::Reference;
use enfilade::{
    Alpha, GeometryBuilder, Material, MaterialId, Mesh, Method, SceneBuilder, Tightness, Transform, View,
    Viewer,
};

const OPAQUE: u32 = 0;
const DOUBLE_SIDED: u32 = 1;
const CUT_OUT: u32 = 2;

/// A quad by its corners, counter-clockwise from the front.
type Quad = [[f32; 3]; 4];

/// An item of one quad, in `side` × `side` parts.
struct Item {
    name: &'static str,
    corners: Quad,
    side: u32,
    /// Whether the middle third of its columns is missing.
    split: bool,
    material: u32,
    transform: Transform,
}

fn item(name: &'static str, corners: Quad, material: u32) -> Item {
    Item {
        name,
        corners,
        side: 1,
        split: false,
        material,
        transform: Transform::IDENTITY,
    }
}

impl Item {
    fn mesh(&self) -> Mesh {
        let between =
            |a: [f32; 3], b: [f32; 3], part: f32| [0, 1, 2].map(|axis| a[axis] + (b[axis] - a[axis]) * part);
        let [a, b, c, d] = self.corners;
        let side = self.side;
        let part = |step: u32| step as f32 / side as f32;
        let positions: Vec<[f32; 3]> = (0..(side + 1) * (side + 1))
            .map(|at| [part(at % (side + 1)), part(at / (side + 1))])
            .map(|[u, v]| between(between(a, b, u), between(d, c, u), v))
            .collect();
        let corners: Vec<u32> = (0..side * side)
            .map(|at| [at % side, at / side])
            .filter(|[u, _]| !self.split || !(side / 3..2 * side / 3).contains(u))
            .flat_map(|[u, v]| {
                let [low, high] = [v, v + 1].map(|v| v * (side + 1) + u);
                [low, low + 1, high + 1, low, high + 1, high]
            })
            .collect();
        Mesh::triangles(&positions, &corners, MaterialId(self.material)).expect("triangles")
    }
}

/// Returns the names that `masked` lists at a tightness, sorted. Checks that it misses nothing.
fn listed(items: &[Item], view: &View, tightness: Tightness) -> Vec<String> {
    let opaque = Material::opaque([0.5; 3]);
    let mut geometry = GeometryBuilder::new([
        opaque,
        Material {
            double_sided: true,
            ..opaque
        },
        Material {
            alpha: Alpha::Mask,
            double_sided: true,
            ..opaque
        },
    ]);
    for item in items {
        let mesh = geometry.mesh(item.mesh());
        geometry.item(item.name, mesh, item.transform);
    }
    let mut scene = SceneBuilder::new();
    scene.add("world", geometry.build().expect("sound items"), Method::Masked);
    let scene = scene.build().expect("one sector");
    let mut viewer = Viewer::new();
    viewer.options.tightness = tightness;
    let truth = Reference::new(&scene).see(&scene, view, &viewer.options.limits);
    let set = viewer.look(&scene, view);
    let verdict = truth.check(set, None);
    assert_eq!(verdict.missed, [], "{tightness:?}");
    let mut names: Vec<String> = set
        .items()
        .iter()
        .map(|seen| items[seen.item.index.0 as usize].name.to_owned())
        .collect();
    names.sort();
    names
}

/// Returns the view from the origin along −z, with a sample in the middle.
fn ahead() -> View {
    View::new([0.0; 3], [0.0, 0.0, -1.0], [129, 97]).expect("a valid view")
}

/// Returns a quad around the z axis.
fn facing([x0, x1]: [f32; 2], half: f32, z: f32) -> Quad {
    [[x0, -half, z], [x1, -half, z], [x1, half, z], [x0, half, z]]
}

/// Returns a quad in the sloped plane z = −6 − 1.5·x, moved back by `behind`, around x = `middle`.
fn sloped(middle: f32, half: f32, behind: f32) -> Quad {
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| {
        let x = middle + half * x;
        [x, half * y, -6.0 - 1.5 * x - behind]
    })
}

#[test]
fn an_item_close_behind_a_sloped_wall_is_left_out_by_its_samples_alone() {
    let items = [
        item("wall", sloped(0.0, 3.0, 0.0), DOUBLE_SIDED),
        item("behind", sloped(0.4, 0.15, 0.02), DOUBLE_SIDED),
        item("before", sloped(-0.6, 0.1, -0.02), DOUBLE_SIDED),
    ];
    for tightness in [Boxes, Faces] {
        assert_eq!(listed(&items, &ahead(), tightness), ["before", "behind", "wall"]);
    }
    assert_eq!(listed(&items, &ahead(), Resolved), ["before", "wall"]);
}

#[test]
fn a_wall_too_fine_to_be_worth_drawing_hides_what_is_resolved_unless_it_is_cut_out() {
    let items = |material| {
        let wall = item("wall", facing([-3.4, 3.4], 2.5, -4.0), material);
        // Of eleven samples a triangle.
        let wall = Item { side: 25, ..wall };
        [wall, item("behind", facing([0.2, 0.3], 0.05, -5.0), OPAQUE)]
    };
    assert_eq!(listed(&items(OPAQUE), &ahead(), Boxes), ["behind", "wall"]);
    assert_eq!(listed(&items(OPAQUE), &ahead(), Resolved), ["wall"]);
    assert_eq!(listed(&items(CUT_OUT), &ahead(), Resolved), ["behind", "wall"]);
}

#[test]
fn a_fine_item_seen_in_the_gap_between_its_two_hidden_halves_alone_is_left_out() {
    let halves = |split| Item {
        side: 30,
        split,
        ..item("halves", facing([-2.0, 2.0], 0.4, -6.0), OPAQUE)
    };
    for tightness in [Boxes, Faces, Resolved] {
        let listed = |split| {
            let posts = [[-1.6, -0.35], [0.35, 1.6]].map(|at| item("post", facing(at, 0.6, -4.0), OPAQUE));
            let [left, right] = posts;
            listed(&[left, right, halves(split)], &ahead(), tightness)
        };
        assert_eq!(listed(true), ["post", "post"], "{tightness:?}");
        assert_eq!(listed(false), ["halves", "post", "post"], "{tightness:?}");
    }
}

#[test]
fn an_item_seen_at_a_single_sample_is_kept() {
    const EDGE: f32 = 0.01;
    let part = |[x0, x1]: [f32; 2], [y0, y1]: [f32; 2]| {
        [[x0, y0, -4.0], [x1, y0, -4.0], [x1, y1, -4.0], [x0, y1, -4.0]]
    };
    let far = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| [0.2 * x, 0.2 * y, -5.0]);
    let wall = [
        item("left", part([-9.0, -EDGE], [-9.0, 9.0]), OPAQUE),
        item("right", part([EDGE, 9.0], [-9.0, 9.0]), OPAQUE),
        item("below", part([-EDGE, EDGE], [-9.0, -EDGE]), OPAQUE),
        item("above", part([-EDGE, EDGE], [EDGE, 9.0]), OPAQUE),
    ];
    let plug = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| [0.2 * x, 0.2 * y, -3.9]);
    for tightness in [Boxes, Faces, Resolved] {
        let mut items: Vec<Item> = wall
            .iter()
            .map(|part| item(part.name, part.corners, OPAQUE))
            .collect();
        items.push(item("far", far, OPAQUE));
        let names = listed(&items, &ahead(), tightness);
        assert!(names.contains(&"far".to_owned()), "{tightness:?}: {names:?}");
    }
    let mut items: Vec<Item> = wall.into_iter().collect();
    items.extend([item("far", far, OPAQUE), item("plug", plug, OPAQUE)]);
    let names = listed(&items, &ahead(), Resolved);
    assert!(!names.contains(&"far".to_owned()), "{names:?}");
}

#[test]
fn no_item_hides_itself_or_another_at_the_same_depth() {
    for turn in 0..60 {
        let angle = turn as f32 * 0.37;
        let [x, y] = [0.3 * angle.cos(), 0.2 * angle.sin()];
        // Nearly edge-on: depths within a sub-tile differ by more than the item is large.
        let lean = 4.0 * (angle * 1.7).sin();
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .map(|[u, v]: [f32; 2]| [x + 0.1 * u, y + 0.1 * v, -3.0 - 0.1 * lean * (u + 0.5 * v)]);
        let items = [
            item("one", corners, DOUBLE_SIDED),
            item("other", corners, DOUBLE_SIDED),
        ];
        assert_eq!(listed(&items, &ahead(), Resolved), ["one", "other"], "{turn}");
    }
}

#[test]
fn a_mirrored_item_shows_its_front_and_is_hidden_alike() {
    // Where the item was, seen from the front: its corners are counter-clockwise in its own space.
    let flipped = |item: Item| {
        let [a, b, c, d] = item.corners.map(|[x, y, z]| [-x, y, z]);
        Item {
            corners: [d, c, b, a],
            transform: Transform::scaling([-1.0, 1.0, 1.0]),
            ..item
        }
    };
    let items = [
        flipped(item("wall", sloped(0.0, 3.0, 0.0), OPAQUE)),
        flipped(item("behind", sloped(0.4, 0.15, 0.02), OPAQUE)),
        flipped(item("before", sloped(-0.6, 0.1, -0.02), OPAQUE)),
    ];
    assert_eq!(listed(&items, &ahead(), Resolved), ["before", "wall"]);
}

#[test]
fn cut_out_faces_are_tested_but_hide_nothing() {
    let items = |wall, small| {
        [
            item("wall", sloped(0.0, 3.0, 0.0), wall),
            item("behind", sloped(0.4, 0.15, 0.02), small),
        ]
    };
    let names = listed(&items(CUT_OUT, DOUBLE_SIDED), &ahead(), Resolved);
    assert_eq!(names, ["behind", "wall"]);
    assert_eq!(
        listed(&items(DOUBLE_SIDED, CUT_OUT), &ahead(), Resolved),
        ["wall"]
    );
}

#[test]
fn an_eye_in_a_doorway_misses_nothing_on_either_side() {
    let wall = |x: [f32; 2], y: [f32; 2]| {
        [
            [x[0], y[0], 0.0],
            [x[1], y[0], 0.0],
            [x[1], y[1], 0.0],
            [x[0], y[1], 0.0],
        ]
    };
    let thing = |x: f32, z: f32| {
        [
            [x - 0.1, -0.1, z],
            [x + 0.1, -0.1, z + 0.3],
            [x + 0.1, 0.1, z + 0.3],
            [x - 0.1, 0.1, z],
        ]
    };
    let floor = [
        [-5.0, -1.0, 5.0],
        [5.0, -1.0, 5.0],
        [5.0, -1.0, -5.0],
        [-5.0, -1.0, -5.0],
    ];
    let items = [
        item("left", wall([-5.0, -0.5], [-1.0, 2.0]), DOUBLE_SIDED),
        item("right", wall([0.5, 5.0], [-1.0, 2.0]), DOUBLE_SIDED),
        item("lintel", wall([-0.5, 0.5], [1.0, 2.0]), DOUBLE_SIDED),
        item("floor", floor, DOUBLE_SIDED),
        item("here", thing(0.7, 0.5), DOUBLE_SIDED),
        item("there", thing(0.8, -0.9), DOUBLE_SIDED),
        item("farther", thing(-1.0, -3.0), DOUBLE_SIDED),
    ];
    let mut seen = 0;
    for turn in 0..32 {
        let angle = turn as f32 * std::f32::consts::TAU / 32.0;
        for eye in [[0.0, 0.0, 0.0], [0.49, 0.2, 0.0], [0.5, -0.99, 0.001]] {
            let toward = [eye[0] + angle.cos(), eye[1] - 0.05, eye[2] + angle.sin()];
            let view = View::new(eye, toward, [128, 96]).expect("a valid view");
            for tightness in [Boxes, Faces, Resolved] {
                seen += listed(&items, &view, tightness).len();
            }
        }
    }
    assert!(seen > 500, "{seen}");
}
