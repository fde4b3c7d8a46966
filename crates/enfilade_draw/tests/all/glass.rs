//! Stacked glass layers: their colour equals the blend of all layers.

use crate::stage::{SIZE, drawn, view};
use enfilade::{Alpha, GeometryBuilder, Material, MaterialId, Mesh, Method, Scene, SceneBuilder, Transform};
use enfilade_draw::Settings;

const PANES: usize = 12;

/// Creates a wall with `count` panes before it, each of a different colour.
fn panes(count: usize) -> (Scene, Vec<Material>) {
    let pane = |number: usize| Material {
        base_color: [
            0.1 + 0.07 * number as f32,
            0.9 - 0.05 * number as f32,
            0.3,
            0.15 + 0.03 * number as f32,
        ],
        alpha: Alpha::Blend,
        unlit: true,
        ..Material::opaque([0.0; 3])
    };
    let wall = Material {
        unlit: true,
        ..Material::opaque([0.8, 0.5, 0.2])
    };
    let mut materials = vec![wall];
    materials.extend((0..count).map(pane));
    let mut geometry = GeometryBuilder::new(materials.clone());
    let square = [
        [-3.0, -3.0, 0.0],
        [3.0, -3.0, 0.0],
        [3.0, 3.0, 0.0],
        [-3.0, 3.0, 0.0],
    ];
    for number in 0..materials.len() {
        let mesh = Mesh::triangles(&square, &[0, 1, 2, 0, 2, 3], MaterialId(number as u32));
        let mesh = geometry.mesh(mesh.expect("a square"));
        // The nearest pane is added first.
        let depth = if number == 0 { -4.0 } else { -0.2 * number as f32 };
        geometry.item("pane", mesh, Transform::translation([0.0, 0.0, depth]));
    }
    let mut scene = SceneBuilder::new();
    scene.add("hall", geometry.build().expect("panes"), Method::ZBuffer);
    (scene.build().expect("a hall"), materials)
}

fn encode(linear: f64) -> f64 {
    255.0
        * if linear <= 0.003_130_8 {
            12.92 * linear
        } else {
            1.055 * linear.powf(1.0 / 2.4) - 0.055
        }
}

#[test]
fn a_dozen_panes_before_a_wall_lose_no_colour() {
    let (scene, materials) = panes(PANES);
    let mut expected = materials[0].base_color.map(f64::from);
    for pane in materials[1..].iter().rev() {
        let [r, g, b, a] = pane.base_color.map(f64::from);
        expected = [(r, 0), (g, 1), (b, 2), (1.0, 3)].map(|(own, i)| expected[i] * (1.0 - a) + own * a);
    }
    for method in Method::ALL
        .into_iter()
        .filter(|method| method.requires().is_none())
    {
        let scene = scene
            .with_method(method, u64::MAX)
            .expect("within the memory limit");
        let image = drawn(&scene, &view(), &Settings::default()).image;
        let shown = image.get_pixel(SIZE[0] / 2, SIZE[1] / 2).0;
        for channel in 0..3 {
            let off = (f64::from(shown[channel]) - encode(expected[channel])).abs();
            assert!(off <= 1.0, "{method}: {shown:?}, {:?}", expected.map(encode));
        }
    }
}

#[test]
fn glass_before_nothing_shows_the_sky_through_it() {
    let (scene, materials) = panes(1);
    let [mut bare, mut glazed] = [&scene, &scene].map(Clone::clone);
    let hall = enfilade::SectorId(0);
    for (scene, gone) in [(&mut glazed, &[0][..]), (&mut bare, &[0, 1])] {
        let mut edit = scene.edit();
        for &item in gone {
            edit.remove(hall, enfilade::ItemIndex(item).into())
                .expect("an existing item");
        }
        edit.finish().expect("within the memory limit");
    }
    let [through, sky] = [&glazed, &bare].map(|scene| drawn(scene, &view(), &Settings::default()).image);
    let own = materials[1].base_color;
    for at in [[60, 40], [30, 20], [90, 60]] {
        let [shown, behind] = [&through, &sky].map(|image| image.get_pixel(at[0], at[1]).0);
        for channel in 0..3 {
            let srgb = f64::from(behind[channel]) / 255.0;
            let linear = ((srgb + 0.055) / 1.055).powf(2.4);
            let [own, part] = [own[channel], own[3]].map(f64::from);
            let expected = encode(linear * (1.0 - part) + own * part);
            assert!(
                (f64::from(shown[channel]) - expected).abs() <= 1.0,
                "{at:?}: {shown:?}"
            );
        }
    }
}
