//! Which node owns each pixel of a villa, against another renderer: cut-outs by texel, glass seen through.

use enfilade::{
    Alpha, Canvas, Geometry, ItemIndex, Method, Owner, Passage, PassageId, Scene, SectorId, Span, Texture,
    View, Viewer, Wrap,
};
use enfilade_import::{ReadOptions, read};
use glam::{DMat3, DVec3};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

const SIZE: [u32; 2] = [640, 360];

/// The owners of pixels, holes of cut-outs left out; and clear glass before them, which the other renderer takes for the
/// owner at a pixel here and there.
struct Pixels<'a> {
    geometry: &'a Geometry,
    passage: Option<Passage>,
    owners: Vec<(Option<ItemIndex>, BTreeSet<ItemIndex>)>,
}

impl Canvas for Pixels<'_> {
    fn enter(&mut self, _id: PassageId, passage: &Passage) {
        self.passage = Some(passage.clone());
    }

    fn row(&mut self, y: u16, spans: &[Span]) {
        for span in spans {
            let Owner::Face(item, face) = span.owner else {
                continue;
            };
            for x in span.x0..span.x1 {
                let there = span.see_through.then(|| self.is_there((item, face), [x, y]));
                let at = &mut self.owners[usize::from(y) * SIZE[0] as usize + usize::from(x)];
                match there {
                    None | Some(Some(true)) => *at = (Some(item), BTreeSet::new()),
                    Some(Some(false)) => {
                        at.1.insert(item);
                    }
                    Some(None) => {}
                }
            }
        }
    }
}

impl Pixels<'_> {
    /// Whether a transparent surface also owns a pixel; `None` in a hole.
    fn is_there(&self, (item, face): (ItemIndex, u32), at: [u16; 2]) -> Option<bool> {
        let mesh = self.geometry.mesh_of(item);
        let material = self.geometry.material(&mesh.clusters()[mesh.cluster_of(face)]);
        let coverage = || match material.texture {
            None => 1.0,
            Some(texture) => {
                let texture = &self.geometry.textures()[texture.0 as usize];
                coverage(texture, self.place((item, face), at))
            }
        };
        match material.alpha {
            Alpha::Opaque => Some(true),
            Alpha::Mask => (material.base_color[3] * coverage() >= material.cutoff).then_some(true),
            Alpha::Blend => Some(material.base_color[3] >= 0.5),
        }
    }

    /// Returns the texture coordinates at the centre of a pixel.
    fn place(&self, (item, face): (ItemIndex, u32), at: [u16; 2]) -> [f64; 2] {
        let passage = self.passage.as_ref().expect("it was entered");
        let [eye, way] = passage
            .ray(at.map(|place| f64::from(place) + 0.5))
            .map(DVec3::from);
        let mesh = self.geometry.mesh_of(item);
        let columns = self.geometry.item(item).transform().columns();
        let columns = columns.map(|column| DVec3::from(column.map(f64::from)));
        let corners = mesh.face(face);
        let corner = |i: usize| {
            let [x, y, z] = mesh.positions()[corners[i] as usize].map(f64::from);
            columns[0] * x + columns[1] * y + columns[2] * z + columns[3]
        };
        let [a, b, c] = [corner(0), corner(1), corner(2)];
        // a + s (b − a) + t (c − a) = eye + d way
        let [s, t, _] = (DMat3::from_cols(b - a, c - a, -way).inverse() * (eye - a)).to_array();
        let [a, b, c] = [0, 1, 2].map(|i| mesh.texture()[corners[i] as usize].map(f64::from));
        [0, 1].map(|axis| a[axis] + s * (b[axis] - a[axis]) + t * (c[axis] - a[axis]))
    }
}

/// Between the middles of four texels.
fn coverage(texture: &Texture, place: [f64; 2]) -> f32 {
    let [width, height] = texture.size().map(i64::from);
    assert_eq!(texture.wrap, [Wrap::Repeat; 2]);
    let [x, y] = [place[0] * width as f64 - 0.5, place[1] * height as f64 - 0.5];
    let texel = |column: f64, row: f64| {
        let column = (column as i64).rem_euclid(width);
        let row = (row as i64).rem_euclid(height);
        f64::from(texture.texels()[(row * width + column) as usize][3]) / 255.0
    };
    let [part_x, part_y] = [x - x.floor(), y - y.floor()];
    let row = |row: f64| texel(x.floor(), row) * (1.0 - part_x) + texel(x.floor() + 1.0, row) * part_x;
    (row(y.floor()) * (1.0 - part_y) + row(y.floor() + 1.0) * part_y) as f32
}

/// Minimum and maximum number of pixels that each node owns, by node name.
fn owned(scene: &Scene, view: &View) -> BTreeMap<String, [i64; 2]> {
    let geometry = scene.geometry(SectorId(0)).expect("one room");
    let mut pixels = Pixels {
        geometry,
        passage: None,
        owners: vec![(None, BTreeSet::new()); (SIZE[0] * SIZE[1]) as usize],
    };
    Viewer::new().draw(scene, view, &mut pixels);
    let mut counts = BTreeMap::new();
    let mut count = |item: Option<ItemIndex>, least: i64| {
        let name = item.map_or("sky", |item| geometry.name(item));
        let name = name.split('#').next().unwrap_or_default();
        // The blocks of its terrain are items.
        let name = if name.starts_with("Garden-terrain ") {
            "Garden-terrain"
        } else {
            name
        };
        let name = name.to_owned();
        let [at_least, at_most] = counts.entry(name).or_insert([0, 0]);
        (*at_least, *at_most) = (*at_least + least, *at_most + 1);
    };
    for (owner, panes) in pixels.owners {
        count(owner, i64::from(panes.is_empty()));
        panes.into_iter().for_each(|pane| count(Some(pane), 0));
    }
    counts
}

/// The scene without the two plants at the origin that its author hid: others are copies of them.
fn without_originals(mut scene: Scene) -> Scene {
    let geometry = Arc::clone(scene.geometry(SectorId(0)).expect("one room"));
    let mut edit = scene.edit();
    for name in ["Plant-leaves#284", "Plant-pot#285"] {
        let mut items = (0..geometry.items().len() as u32).map(ItemIndex);
        let original = items
            .find(|&item| geometry.name(item) == name)
            .expect("an original");
        edit.remove(SectorId(0), original.into()).expect("it is there");
    }
    edit.finish().expect("less than before");
    scene
}

#[test]
#[ignore = "needs ENFILADE_SCENES"]
fn each_node_of_a_villa_owns_the_pixels_that_another_renderer_gives_it() {
    let folder = std::env::var_os("ENFILADE_SCENES").expect("ENFILADE_SCENES names a folder");
    let folder = Path::new(&folder);
    let truth = std::fs::read(folder.join("blender_villa.truth.json")).expect("the truth");
    let truth: Value = serde_json::from_slice(&truth).expect("JSON");
    let options = ReadOptions {
        flat: true,
        ..ReadOptions::default()
    };
    let import = read(&folder.join("blender_villa.glb"), &options).unwrap_or_else(|error| panic!("{error}"));
    let scene = without_originals(import.scene(Method::SBuffer, u64::MAX).expect("it fits"));
    let mut faults = Vec::new();
    for camera in &import.cameras {
        let mut view = View::new(camera.eye, camera.toward, SIZE);
        (view.up, view.fov_y, view.near) = (camera.up, camera.fov_y, camera.near);
        let ours = owned(&scene, &view);
        let theirs = truth["cameras"].as_array().expect("a list");
        let theirs = theirs.iter().find(|other| other["name"] == camera.name.as_str());
        let theirs = theirs.expect("a camera of that name")["visible_flat"]
            .as_object()
            .expect("names");
        let names = ours
            .keys()
            .map(String::as_str)
            .chain(theirs.keys().map(String::as_str));
        let names: BTreeSet<&str> = names.collect();
        for name in names {
            let [least, most] = ours.get(name).copied().unwrap_or_default();
            let other = theirs.get(name).and_then(Value::as_i64).unwrap_or(0);
            // At edges either is right.
            let slack = 3 + other / 100;
            if least - slack > other || other > most + slack || (most == 0) != (other == 0) {
                faults.push(format!(
                    "{} {name}: {least} to {most} pixels, not {other}",
                    camera.name
                ));
            }
        }
    }
    assert_eq!(faults, Vec::<String>::new());
}
