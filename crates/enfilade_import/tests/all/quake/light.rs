//! Lightmaps: what compilers have computed is what is drawn.

use super::little::{Format, Little};
use enfilade::{Geometry, ItemIndex, Material};
use enfilade_import::{Import, ReadOptions, WarningKind, read_bytes};

fn read(map: &Little) -> Import {
    read_bytes(&map.bytes(), None, &ReadOptions::default()).expect("a map")
}

/// A corner's position, and the texel of light there.
type Corner = ([f32; 3], [u8; 4]);

/// The corners of each triangle with a lightmap.
fn lit_triangles(geometry: &Geometry) -> Vec<Vec<Corner>> {
    let mut triangles = Vec::new();
    for item in (0..geometry.items().len() as u32).map(ItemIndex) {
        let mesh = geometry.mesh_of(item);
        for cluster in mesh.clusters() {
            let Material { texture, unlit, .. } = geometry.materials()[cluster.material.0 as usize];
            let texture = texture.map(|texture| &geometry.textures()[texture.0 as usize]);
            let Some(light) = texture.filter(|texture| texture.name == "light") else {
                continue;
            };
            assert!(unlit, "no lamp lights it again");
            let corner = |&corner: &u32| {
                let place = mesh.texture()[corner as usize];
                let [column, row] = [0, 1].map(|axis| (place[axis] * light.size()[axis] as f32) as usize);
                let texel = light.texels()[row * light.size()[0] as usize + column];
                (mesh.positions()[corner as usize], texel)
            };
            triangles.extend(
                (cluster.faces.clone()).map(|face| mesh.face(face).iter().map(corner).collect::<Vec<_>>()),
            );
        }
    }
    triangles
}

fn is_first_floor(triangle: &[Corner]) -> bool {
    triangle
        .iter()
        .all(|(place, _)| place[1] == -32.0 && place[0] <= 0.0)
}

/// The floor of the first room is its face 4. It has two styles of light, each 5 by 5 samples, after three bytes of others.
fn with_light(format: Format, offset: i32) -> Little {
    let mut map = Little::new(format);
    let (face_bytes, styles) = if format == Format::Bsp29 {
        (20, 12)
    } else {
        (28, 20)
    };
    let face = &mut map.lumps[7][4 * face_bytes + styles..];
    face[..4].copy_from_slice(&[0, 3, 255, 255]);
    face[4..8].copy_from_slice(&offset.to_le_bytes());
    let samples = (0..25).map(|at| 10 * at);
    let dimmer = (0..25).map(|at| at + 1);
    map.lumps[8] = [7, 7, 7].into_iter().chain(samples).chain(dimmer).collect();
    map
}

#[test]
fn the_samples_of_a_face_of_quake_are_where_its_texture_says() {
    for format in [Format::Bsp29, Format::Bsp2] {
        let map = read(&with_light(format, 3));
        assert_eq!(map.warnings, []);
        let (floor, others): (Vec<_>, Vec<_>) = (lit_triangles(&map.rooms[0].geometry).into_iter())
            .partition(|triangle| is_first_floor(triangle));
        assert_eq!(floor.len(), 2);
        for &([x, _, z], texel) in floor.iter().flatten() {
            // Samples are 16 units apart, from the least corner on; z in the scene is -y in the map.
            let [column, row] = [(x + 64.0) / 16.0, (32.0 - z) / 16.0];
            let at = 5.0 * row + column;
            let light = (11.0 * at + 1.0).min(255.0) as u8;
            assert_eq!(texel, [light, light, light, 255], "{format:?} at {x} {z}");
        }
        let is_black = |&(_, texel): &Corner| texel == [0, 0, 0, 255];
        assert!(
            others.len() > 10 && others.iter().flatten().all(is_black),
            "the others have no light"
        );
    }
}

#[test]
fn light_beyond_the_end_of_its_lump_is_said_and_left_out() {
    for offset in [4, i32::MAX] {
        let map = read(&with_light(Format::Bsp2, offset));
        let warnings: Vec<_> = map.warnings.iter().map(|warning| warning.kind).collect();
        assert_eq!(warnings, [WarningKind::Lightmaps]);
        let triangles = lit_triangles(&map.rooms[0].geometry);
        assert!(!triangles.is_empty() && !triangles.iter().any(|triangle| is_first_floor(triangle)));
    }
}

#[test]
fn a_page_of_quake_3_lights_the_faces_that_name_it() {
    let mut map = Little::new(Format::Ibsp46);
    map.lumps[14] = vec![10; 3 * 128 * 128];
    // At the middle of column 64, row 32: twice as bright as its greatest part allows.
    map.lumps[14][3 * (32 * 128 + 64)..][..3].copy_from_slice(&[200, 100, 50]);
    map.lumps[13][4 * 104 + 28..][..4].copy_from_slice(&0_i32.to_le_bytes());
    for face in [0, 1, 2, 3, 5] {
        map.lumps[13][face * 104 + 28..][..4].copy_from_slice(&(-1_i32).to_le_bytes());
    }
    for corner in 16..20 {
        let place = [64.5_f32 / 128.0, 32.5 / 128.0].map(f32::to_le_bytes).concat();
        map.lumps[10][corner * 44 + 20..][..8].copy_from_slice(&place);
    }
    let map = read(&map);
    let (floor, others): (Vec<_>, Vec<_>) =
        (lit_triangles(&map.rooms[0].geometry).into_iter()).partition(|triangle| is_first_floor(triangle));
    assert_eq!(floor.len(), 2);
    assert!(
        floor
            .iter()
            .flatten()
            .all(|(_, texel)| *texel == [255, 127, 63, 255]),
        "{floor:?}"
    );
    assert!(!others.is_empty());
    assert!(
        others
            .iter()
            .flatten()
            .all(|(_, texel)| *texel == [20, 20, 20, 255]),
        "{others:?}"
    );
}

#[test]
fn who_wants_no_images_gets_no_light() {
    let options = ReadOptions {
        textures: false,
        ..ReadOptions::default()
    };
    let map = read_bytes(&with_light(Format::Bsp29, 3).bytes(), None, &options).expect("a map");
    assert!(map.rooms[0].geometry.textures().is_empty());
}
