//! Tests LODs of generated meshes and of real scenes.

use super::*;
use enfilade::{
    Attributes, GeometryBuilder, Material, Method, SceneBuilder, SectorId, Transform, View, Viewer,
};
use std::path::Path;

/// Hills of n × n squares: the left half with material 0 (grass), the right half with material 1 (stone).
fn hills(n: u32) -> Arc<Mesh> {
    let at = |i: u32| i as f32 / n as f32;
    let height =
        |x: f32, z: f32| 0.1 * (7.0 * x).sin() * (5.0 * z).cos() + 0.01 * (40.0 * x + 30.0 * z).sin();
    let positions: Vec<[f32; 3]> = (0..(n + 1) * (n + 1))
        .map(|i| [at(i % (n + 1)), at(i / (n + 1))])
        .map(|[x, z]| [x, height(x, z), z])
        .collect();
    let mut halves = [Vec::new(), Vec::new()];
    for z in 0..n {
        for x in 0..n {
            let [a, b] = [z * (n + 1) + x, (z + 1) * (n + 1) + x];
            halves[usize::from(2 * x >= n)].extend([a, b, b + 1, a, b + 1, a + 1]);
        }
    }
    let part = |material: u32| Part {
        positions: Vertices::Packed(&positions),
        corners: Indices::U32(&halves[material as usize]),
        sides: None,
        material: MaterialId(material),
        attributes: Attributes::default(),
    };
    Arc::new(Mesh::new(&[part(0), part(1)]).expect("hills"))
}

fn corners_on(mesh: &Mesh, keep: impl Fn([f32; 3]) -> bool, material: u32) -> Vec<[u32; 3]> {
    let mut found: Vec<[u32; 3]> = mesh
        .clusters()
        .iter()
        .filter(|cluster| cluster.material == MaterialId(material))
        .flat_map(|cluster| {
            mesh.positions()[cluster.positions.start as usize..cluster.positions.end as usize].iter()
        })
        .filter(|&&position| keep(position))
        .map(|position| position.map(f32::to_bits))
        .collect();
    found.sort_unstable();
    found.dedup();
    found
}

#[test]
fn each_level_has_fewer_faces_and_is_no_farther_off_than_it_says() {
    let mesh = hills(64);
    let levels = Levels::of(Arc::clone(&mesh));
    assert!(levels.levels() >= 4);
    let mut faces = Vec::new();
    for level in 0..levels.levels() {
        let made = levels.build(level).expect("it can be made");
        faces.push(made.face_count());
        // Tolerance for rounding the level's error to f32.
        let error = f64::from(levels.error(level)) * (1.0 + 1e-6) + 1e-7;
        assert!(
            within(&mesh, &made, error) && within(&made, &mesh, error),
            "level {level}"
        );
        // No vertex on the border between grass and stone is removed, so no crack opens.
        let seam = |position: [f32; 3]| position[0] == 0.5;
        let [grass, stone] = [0, 1].map(|material| corners_on(&made, seam, material));
        assert_eq!((grass.len(), &grass), (65, &stone), "level {level}");
    }
    assert!(
        faces.is_sorted() && faces[0] < 700 && faces[faces.len() - 1] == 2 * 64 * 64,
        "{faces:?}"
    );
    assert_eq!(levels.error(levels.levels() - 1), 0.0);
}

#[test]
fn levels_keep_what_corners_carry_and_the_seams_of_textures() {
    let mesh = hills(64);
    // The texture is unrolled twice: left of the middle its coordinates end at 1, right of it they begin at 0.
    let is_right = |&&corner: &&u32| mesh.positions()[corner as usize][0] > 0.5;
    let half = |right: bool| -> Vec<u32> {
        let faces = (0..mesh.face_count()).map(|face| mesh.face(face));
        faces
            .filter(|corners| corners.iter().any(|corner| is_right(&corner)) == right)
            .flatten()
            .copied()
            .collect()
    };
    let halves = [false, true].map(half);
    let places = [0.0, 1.0].map(|shift| {
        let place = |&[x, _, z]: &[f32; 3]| [2.0 * x - shift, z];
        mesh.positions().iter().map(place).collect::<Vec<[f32; 2]>>()
    });
    let part = |number: usize| Part {
        positions: Vertices::Packed(mesh.positions()),
        corners: Indices::U32(&halves[number]),
        sides: None,
        material: MaterialId(0),
        attributes: Attributes {
            texture: Vertices::Packed(&places[number]),
            ..Attributes::default()
        },
    };
    let textured = Arc::new(Mesh::new(&[part(0), part(1)]).expect("textured hills"));
    let levels = Levels::of(Arc::clone(&textured));
    for level in 0..levels.levels() {
        let made = levels.build(level).expect("it can be made");
        assert_eq!(made.texture().len(), made.positions().len());
        let right = |(position, place): (&[f32; 3], &[f32; 2])| {
            let [u, v] = [2.0 * position[0], position[2]];
            *place == [u, v] || *place == [u - 1.0, v]
        };
        assert!(
            made.positions().iter().zip(made.texture()).all(right),
            "level {level}"
        );
        let error = f64::from(levels.error(level)) * (1.0 + 1e-6) + 1e-7;
        assert!(
            within(&textured, &made, error),
            "a crack at the seam, level {level}"
        );
    }
    let coarse = levels.build(0).expect("it can be made").face_count();
    assert!(coarse < 1000, "{coarse} faces");
}

#[test]
fn what_is_measured_is_what_is_there() {
    let mesh = hills(8);
    let shifted: Vec<[f32; 3]> = mesh
        .positions()
        .iter()
        .map(|&[x, y, z]| [x, y + 0.5, z])
        .collect();
    let corners: Vec<u32> = (0..mesh.face_count())
        .flat_map(|face| mesh.face(face).to_vec())
        .collect();
    let shifted = Mesh::triangles(&shifted, &corners, MaterialId(0)).expect("hills");
    // Steep slopes are nearer than that; the rim is not.
    assert!(within(&mesh, &shifted, 0.51) && !within(&mesh, &shifted, 0.3));
    // A subset of the mesh is within 1e-9 of the whole, but not the other way round.
    let part = Mesh::triangles(mesh.positions(), &corners[..90], MaterialId(0)).expect("a part");
    assert!(within(&part, &mesh, 1e-9) && !within(&mesh, &part, 0.1));
}

#[test]
fn large_items_of_a_scene_get_levels_and_copies_share_them() {
    let mut geometry = GeometryBuilder::new([Material::opaque([0.3; 3]), Material::opaque([0.6; 3])]);
    let (large, small) = (geometry.mesh(hills(64)), geometry.mesh(hills(4)));
    for (name, mesh, x) in [("near", large, 0.0), ("far", large, 1.5), ("small", small, -1.5)] {
        geometry.item(name, mesh, Transform::translation([x, 0.0, 0.0]));
    }
    let mut scene = SceneBuilder::new();
    let sector = scene.add("hills", geometry.build().expect("sound"), Method::HierarchicalZ);
    let mut scene = scene.build().expect("one sector");
    let full = scene.triangle_count();
    let mut details = details_of(&mut scene, 1000, DetailOptions::default()).expect("they fit");
    assert!(scene.triangle_count() < 200);
    let mut viewer = Viewer::new();
    let view = View::new([0.5, 3.0, 4.0], [0.5, 0.0, 0.5], [320, 240]).expect("a valid view");
    for _ in 0..4 {
        let set = viewer.look(&scene, &view);
        details.refine(&mut scene, &[set]).expect("they fit");
    }
    let levels = [0, 1, 2].map(|item| details.level(sector, enfilade::ItemIndex(item).into()));
    assert!(
        levels[0].flatten().is_some() && levels[0] == levels[1] && levels[2].is_none(),
        "{levels:?}"
    );
    let now = scene.triangle_count();
    assert!(200 < now && now < full / 2, "{now} of {full}");
}

#[test]
#[ignore = "needs ENFILADE_SCENES"]
fn what_real_scenes_hold_keeps_its_errors() {
    let folder = std::env::var_os("ENFILADE_SCENES").expect("ENFILADE_SCENES names a folder");
    let mut saved = 0;
    for file in ["sponza_crytek.glb", "blender_villa.glb"] {
        let import =
            crate::read(&Path::new(&folder).join(file), &crate::ReadOptions::default()).expect("sound");
        let scene = import.scene(Method::ZBuffer, u64::MAX).expect("it fits");
        let mut meshes: Vec<Arc<Mesh>> = scene
            .sectors()
            .filter_map(|sector: SectorId| scene.geometry(sector))
            .flat_map(|geometry| geometry.meshes().iter().cloned())
            .filter(|mesh| mesh.face_count() < 20_000)
            .collect();
        meshes.sort_by_key(|mesh| std::cmp::Reverse(mesh.face_count()));
        for mesh in &meshes[..4] {
            let levels = Levels::of(Arc::clone(mesh));
            for level in [0, levels.levels() / 2] {
                let made = levels.build(level).expect("it can be made");
                let error = f64::from(levels.error(level)) * (1.0 + 1e-6);
                assert!(within(mesh, &made, error) && within(&made, mesh, error), "{file}");
                saved += u64::from(mesh.face_count() - made.face_count());
            }
        }
    }
    assert!(saved > 10_000, "only {saved} faces fewer");
}
