//! A scene of everything, baked, read, and damaged.

use super::container::{Container, Kind, Section, Source, Writer};
use super::*;
use crate::budget::Budget;
use crate::quake::MapSummary;
use crate::{
    BrokenRule, Import, NonOccluder, NonOccluders, ReadOptions, Room, SourceNodes, Warning, WarningKind,
};
use enfilade::{
    Aabb, Alpha, BakedCells, Camera, CellId, CellNode, CellSide, CellTree, ConvexPolygon, Filter, Geometry,
    GeometryBuilder, HeightField, ItemIndex, ItemOptions, Light, LightShape, Material, MaterialId, Mesh,
    Method, Minify, OpeningId, Portal, SectorId, Texture, TextureId, Transform, ViewerOptions, Wrap,
};
use std::io::Cursor;
use std::sync::Arc;
use xxhash_rust::xxh3::xxh3_64;

/// Two rooms with a mirror and a terrain between them, and everything that a file may hold.
fn everything() -> Import {
    let mut leaf =
        Texture::new("leaf", [2, 3], (0..6).map(|n| [n, 40 * n, 255, 7]).collect()).expect("texels");
    leaf.wrap = [Wrap::Clamp, Wrap::Mirror];
    leaf.magnify = Filter::Nearest;
    leaf.minify = Minify {
        texels: Filter::Linear,
        levels: None,
    };
    let leaves = Material {
        texture: Some(TextureId(0)),
        emission: [3.5, 0.0, 1e-30],
        detail: true,
        alpha: Alpha::Mask,
        ..Material::opaque([0.1, 0.2, 0.3])
    };
    let materials: Arc<[Material]> = [Material::opaque([1.0; 3]), leaves].into();
    let textures: Arc<[Arc<Texture>]> = [Arc::new(leaf)].into();
    let cuboid =
        |at: f32, material| Mesh::cuboid([at; 3], [at + 1.0; 3], MaterialId(material)).expect("a cuboid");
    let shared = Arc::new(cuboid(0.0, 1));
    let room = |name: &str, builder: GeometryBuilder, method: Option<Method>| Room {
        method,
        open_above: method.is_none(),
        ..Room::new(name, builder.build().expect("a room"))
    };
    let outline = ConvexPolygon::rectangle([0.0; 3], [2.0, 0.0, 0.0], [0.0, 1.5, 0.0]).expect("a rectangle");

    let mut hall = GeometryBuilder::new(Arc::clone(&materials));
    hall.textures(Arc::clone(&textures));
    let [first, second] = [hall.mesh(cuboid(5.0, 0)), hall.mesh(Arc::clone(&shared))];
    let statue = hall.item("statue", first, Transform::translation([1e-3, 7.25, -9.0]));
    hall.set_key(statue, u64::MAX - 3);
    let options = ItemOptions {
        is_occluder: false,
        is_drawn: true,
        never_cull: true,
        layers: 0x8000_0001,
        max_distance: 12.5,
        min_size_px: 3.0,
    };
    hall.set_options(statue, options);
    hall.item("", second, Transform::scaling([-1.0, 2.0, 1.0]));
    hall.opening("mirror", outline);
    let wall = CellNode {
        normal: [1.0, 2.0, -0.3],
        distance: 0.1,
        front: CellSide::Cell(CellId(1)),
        back: CellSide::Cell(CellId(0)),
    };
    let tree = CellTree {
        root: CellSide::Node(0),
        nodes: vec![wall],
        tolerance: 0.25,
    };
    let cells = BakedCells::new(tree, &[Some(0), None], [[CellId(0), CellId(1)]]);
    hall.cells(cells.expect("cells"));

    let mut hill = GeometryBuilder::new(materials);
    hill.textures(textures);
    let again = hill.mesh(shared);
    hill.item("a wall by a hill, für Ü", again, Transform::IDENTITY);
    let heights: Vec<f32> = (0..40 * 3).map(|n| (n * n % 17) as f32 / 3.0).collect();
    let field = HeightField::new([40, 3], [0.5, 2.0], heights).expect("heights");
    hill.terrain(
        "hill",
        field,
        MaterialId(0),
        Transform::translation([0.1, -2.0, 1e4]),
    )
    .expect("a terrain");

    let mut nodes = SourceNodes::default();
    nodes.add(ItemIndex(0), 7, Some("globalId"));
    nodes.add_movable(7);
    let of_materials = NonOccluders::of_materials([None, Some(NonOccluder::Liquid)].into());
    let mut of_hall = of_materials.clone();
    of_hall.add(ItemIndex(0), NonOccluder::Skinned);
    let hall = Room {
        nodes,
        non_occluders: of_hall,
        ..room("hall", hall, Some(Method::Masked))
    };
    let hill = Room {
        non_occluders: of_materials,
        ..room("hill", hill, None)
    };
    Import {
        rooms: vec![hall, hill],
        portals: vec![Portal {
            from: SectorId(0),
            opening: OpeningId(0),
            to: SectorId(0),
            there_from_here: Transform::reflection([0.0; 3], [0.0, 0.0, 1.0]),
            open: true,
        }],
        cameras: vec![Camera {
            name: "gate".to_owned(),
            sector: Some(SectorId(1)),
            z_near: Some(0.3),
            ..Camera::new([1.0 / 3.0, 2.0, 3.0], [0.0; 3])
        }],
        orthographic_heights: vec![Some(2.5)],
        lights: vec![
            Light::point(SectorId(0), [0.1, 0.2, 0.3], [9.0, 8.0, 7.0], f32::INFINITY),
            Light {
                shape: LightShape::Sun {
                    direction: [0.0, -1.0, 0.2],
                },
                ..Light::point(SectorId(1), [0.0; 3], [1.0; 3], 1.0)
            },
        ],
        scenes: Vec::new(),
        map: Some(MapSummary {
            format: "BSP2".to_owned(),
            leafs: 1,
            clusters: Some(2),
            faces: 3,
            models: 4,
            entities: 5,
            visibility_bytes: 6,
        }),
        warnings: vec![Warning {
            kind: WarningKind::Lines,
            count: 3,
            first: vec!["fence".to_owned()],
        }],
        files: Vec::new(),
    }
}

fn baked(import: &Import) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let length = bake(import, &mut file).expect("baked");
    assert_eq!(length, file.get_ref().len() as u64);
    file.into_inner()
}

fn read_again(bytes: Vec<u8>, options: &ReadOptions) -> Result<Import, BrokenRule> {
    import(bytes.into(), options, Budget::new(1 << 30))
}

fn assert_same(a: &Geometry, b: &Geometry) {
    assert_eq!(a.meshes().len(), b.meshes().len());
    for (a_mesh, b_mesh) in a.meshes().iter().zip(b.meshes()) {
        let a_mesh = a_mesh.with_occluders(a.materials());
        assert_eq!(a_mesh.to_bytes(), b_mesh.to_bytes(), "the read one has occluders");
    }
    assert_eq!((a.items(), a.openings()), (b.items(), b.openings()));
    assert_eq!((a.materials(), a.textures()), (b.materials(), b.textures()));
    assert_eq!((a.cells(), a.bounds()), (b.cells(), b.bounds()));
    for item in (0..a.items().len() as u32).map(ItemIndex) {
        assert_eq!((a.name(item), a.key(item)), (b.name(item), b.key(item)));
    }
    assert_eq!(a.terrains().len(), b.terrains().len());
    for (a, b) in a.terrains().iter().zip(b.terrains()) {
        assert_eq!((a.field(), a.first_block()), (b.field(), b.first_block()));
        assert_eq!(a.sector_from_field(), b.sector_from_field());
    }
}

#[test]
fn a_baked_scene_is_the_scene_bit_by_bit() {
    let before = everything();
    let after = read_again(baked(&before), &ReadOptions::default()).expect("read");
    for (a, b) in before.rooms.iter().zip(&after.rooms) {
        assert_same(&a.geometry, &b.geometry);
        assert_eq!(
            (&a.name, a.method, a.open_above),
            (&b.name, b.method, b.open_above)
        );
        assert_eq!(
            (a.nodes.node(ItemIndex(0)), a.nodes.id(ItemIndex(0))),
            (b.nodes.node(ItemIndex(0)), b.nodes.id(ItemIndex(0)))
        );
        assert_eq!(a.nodes.is_movable(ItemIndex(0)), b.nodes.is_movable(ItemIndex(0)));
        assert_eq!(a.non_occluders, b.non_occluders);
    }
    assert_eq!(before.rooms.len(), after.rooms.len());
    assert_eq!((before.portals, before.cameras), (after.portals, after.cameras));
    assert_eq!(
        (before.lights, before.orthographic_heights),
        (after.lights, after.orthographic_heights)
    );
    assert_eq!((before.map, before.warnings), (after.map, after.warnings));
    let [hall, hill] = &after.rooms[..] else {
        panic!("two rooms")
    };
    assert!(
        Arc::ptr_eq(&hall.geometry.meshes()[1], &hill.geometry.meshes()[0]),
        "a mesh is shared"
    );
}

#[test]
fn without_textures_materials_have_none() {
    let options = ReadOptions {
        textures: false,
        ..ReadOptions::default()
    };
    let plain = read_again(baked(&everything()), &options).expect("read");
    let geometry = &plain.rooms[0].geometry;
    assert!(geometry.textures().is_empty());
    assert!(
        geometry
            .materials()
            .iter()
            .all(|material| material.textures().count() == 0)
    );
}

#[test]
fn the_bytes_depend_on_the_scene_alone_and_any_change_of_them_is_a_new_version() {
    let scene = everything();
    let bytes = baked(&scene);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(7)
        .build()
        .expect("threads");
    assert!(pool.install(|| baked(&scene)) == bytes);
    assert!(baked(&read_again(bytes.clone(), &ReadOptions::default()).expect("read")) == bytes);
    assert_eq!(
        (container::VERSION, xxh3_64(&bytes)),
        (3, 0xe497_e390_6b15_4454),
        "if other bytes are right, increase the version and change this"
    );
}

/// A scene of one room, with a cuboid of each material.
fn tile(at: f32, colors: &[f32]) -> Import {
    let materials: Vec<Material> = colors.iter().map(|&color| Material::opaque([color; 3])).collect();
    let mut builder = GeometryBuilder::new(materials);
    for (number, &color) in colors.iter().enumerate() {
        let size = [1.0 + color, 2.0, 1.0];
        let mesh = Mesh::cuboid([0.0; 3], size, MaterialId(number as u32)).expect("a cuboid");
        let mesh = builder.mesh(mesh);
        builder.item(
            "house",
            mesh,
            Transform::translation([at, 0.0, 3.0 * number as f32]),
        );
    }
    let mut import = everything();
    import.portals.clear();
    import.rooms = vec![Room::new("alone", builder.build().expect("a room"))];
    for light in &mut import.lights {
        light.sector = SectorId(0);
    }
    import.cameras[0].sector = None;
    import
}

#[test]
fn tiles_that_join_keep_why_their_items_hide_nothing() {
    let glass_tile = |reason| {
        let mut import = tile(0.0, &[0.25]);
        let room = &mut import.rooms[0];
        let glass = Material {
            alpha: Alpha::Blend,
            ..Material::opaque([0.25; 3])
        };
        let mut builder = GeometryBuilder::new([glass]);
        let mesh = builder.mesh(Mesh::cuboid([0.0; 3], [1.0; 3], MaterialId(0)).expect("a cuboid"));
        builder.item("pane", mesh, Transform::IDENTITY);
        let door = builder.item("door", mesh, Transform::IDENTITY);
        let options = ItemOptions {
            is_occluder: false,
            ..ItemOptions::default()
        };
        builder.set_options(door, options);
        room.geometry = Arc::new(builder.build().expect("a room"));
        room.non_occluders = NonOccluders::of_materials([reason].into());
        room.non_occluders.add(ItemIndex(1), NonOccluder::Animated);
        import
    };
    let mut file = Cursor::new(Vec::new());
    let mut baker = Baker::new(&mut file, "town").expect("started");
    for (name, reason) in [
        ("west", None),
        ("east", Some(NonOccluder::Liquid)),
        ("north", None),
    ] {
        baker.add(&glass_tile(reason), Some(name)).expect("added");
    }
    baker.finish().expect("finished");
    let world = read_again(file.into_inner(), &ReadOptions::default()).expect("read");
    let [town] = &world.rooms[..] else {
        panic!("one room")
    };
    let why = |item| town.non_occluders.of_item(&town.geometry, ItemIndex(item));
    let why: Vec<_> = (0..6).flat_map(why).collect();
    let animated = NonOccluder::Animated;
    let [blended, liquid] = [NonOccluder::Blended, NonOccluder::Liquid];
    assert_eq!(why, [blended, animated, liquid, animated, blended, animated]);
    assert_eq!(town.geometry.materials().len(), 2);
}

#[test]
fn tiles_join_in_one_room_with_the_materials_of_all_and_scenes_with_portals_keep_theirs() {
    let mut file = Cursor::new(Vec::new());
    let mut baker = Baker::new(&mut file, "town").expect("started");
    baker.add(&tile(0.0, &[0.25, 0.5]), Some("west")).expect("added");
    baker.add(&everything(), Some("castle")).expect("added");
    baker
        .add(&tile(9.0, &[0.5, 0.75, 0.25]), Some("east"))
        .expect("added");
    baker.finish().expect("finished");
    let world = read_again(file.into_inner(), &ReadOptions::default()).expect("read");
    let names: Vec<&str> = world.rooms.iter().map(|room| &*room.name).collect();
    assert_eq!(names, ["town", "castle/hall", "castle/hill"]);
    let town = &world.rooms[0].geometry;
    let colors: Vec<f32> = town
        .materials()
        .iter()
        .map(|material| material.base_color[0])
        .collect();
    assert_eq!(colors, [0.25, 0.5, 0.75]);
    for (index, color) in [0.25, 0.5, 0.5, 0.75, 0.25].into_iter().enumerate() {
        let item = ItemIndex(index as u32);
        let mesh = town.mesh_of(item);
        assert_eq!(town.material(&mesh.clusters()[0]).base_color[0], color);
        assert_eq!(mesh.bounds().max[0], 1.0 + color);
        assert_eq!(town.key(item), index as u64);
    }
    assert_eq!(
        (town.name(ItemIndex(0)), town.name(ItemIndex(2))),
        ("west/house", "east/house")
    );
    let [portal] = &world.portals[..] else {
        panic!("one mirror")
    };
    assert_eq!((portal.from, portal.to), (SectorId(1), SectorId(1)));
    let sectors: Vec<u32> = world.lights.iter().map(|light| light.sector.0).collect();
    assert_eq!(sectors, [0, 0, 1, 2, 0, 0]);
    assert_eq!(world.cameras[1].sector, Some(SectorId(2)));
    assert_eq!(world.cameras[2].name, "east/gate");
    world.scene(Method::Masked, 1 << 30).expect("a scene");
}

/// Returns the file with one section changed, and all checksums correct.
fn with_section(bytes: &[u8], of: Section, change: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let container = Container::open(Source::Memory(bytes.to_vec().into())).expect("a container");
    let mut change = Some(change);
    let mut file = Cursor::new(Vec::new());
    let mut writer = Writer::new(&mut file).expect("started");
    for section in container.sections() {
        let mut bytes = container.section(section).expect("whole").to_vec();
        if section == of
            && let Some(change) = change.take()
        {
            change(&mut bytes);
        }
        writer.section(section, &bytes).expect("written");
    }
    writer.finish().expect("finished");
    file.into_inner()
}

const ALL: [(Kind, &str); 8] = [
    (Kind::Page, "page 0"),
    (Kind::Image, "image 0"),
    (Kind::Meshes, "meshes"),
    (Kind::Items, "items"),
    (Kind::Names, "names"),
    (Kind::Scene, "scene"),
    (Kind::Hint, "hint 0"),
    (Kind::Level, "level 0"),
];

/// The baked scene of everything with two hints.
fn hinted() -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("everything.enf");
    std::fs::write(&file, baked(&everything())).expect("written");
    let mut hinted = Cursor::new(Vec::new());
    bake_hints(&file, &hints(), &mut hinted).expect("baked");
    hinted.into_inner()
}

fn hints() -> [Hint; 2] {
    let hint = |room: u32, items: &[(u32, u32)]| Hint {
        sector: SectorId(room),
        bounds: Aabb {
            min: [-1.0, 0.5, f32::NEG_INFINITY],
            max: [1e30, 2.0, 3.0],
        },
        items: items
            .iter()
            .map(|&(room, item)| (SectorId(room), ItemIndex(item)))
            .collect(),
    };
    [hint(1, &[(1, 1), (0, 1), (1, 0)]), hint(0, &[])]
}

#[test]
fn hints_are_kept_and_replaced_and_those_of_what_is_not_there_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("everything.enf");
    std::fs::write(&file, hinted()).expect("written");
    let (_, pages) = Pages::open(&file, &ReadOptions::default()).expect("pages");
    assert_eq!(pages.hints(), hints());
    let bake = |hints: &[Hint]| {
        let mut baked = Cursor::new(Vec::new());
        bake_hints(&file, hints, &mut baked).map(|_| baked.into_inner())
    };
    assert!(bake(&hints()).expect("baked") == hinted());
    assert!(bake(&[]).expect("baked") == baked(&everything()));
    let [mut no_room, mut no_item, mut no_place] = [(); 3].map(|()| hints()[0].clone());
    no_room.sector = SectorId(2);
    no_item.items[1].1 = ItemIndex(99);
    no_place.bounds.max[1] = f32::NAN;
    for wrong in [no_room, no_item, no_place] {
        let why = bake(&[wrong]).expect_err("wrong").to_string();
        assert!(
            why.contains("everything.enf") && why.contains("`hint 0` is invalid"),
            "{why}"
        );
    }
}

#[test]
fn a_damaged_byte_in_any_section_is_an_error_that_names_it() {
    let bytes = hinted();
    for (kind, name) in ALL {
        let section = Container::open(Source::Memory(bytes.clone().into()))
            .expect("open")
            .section(Section(kind, 0))
            .expect("whole");
        let mut places = bytes.windows(section.len());
        let is_it = |window: &[u8]| window == &section[..];
        // A coarser mesh of a cuboid is the cuboid, and comes after it.
        let at = if kind == Kind::Level {
            places.rposition(is_it)
        } else {
            places.position(is_it)
        };
        let at = at.expect("it is there");
        for offset in [0, section.len() / 2, section.len() - 1] {
            let mut damaged = bytes.clone();
            damaged[at + offset] ^= 1;
            let why = read_again(damaged, &ReadOptions::default()).expect_err(name);
            let BrokenRule::Enf(EnfError::Damaged(section)) = why else {
                panic!("{name}: {why}")
            };
            assert_eq!(section, name);
        }
    }
}

#[test]
fn a_section_that_lies_with_a_correct_checksum_is_an_error_or_another_scene() {
    let bytes = hinted();
    let mut random = fastrand::Rng::with_seed(11);
    let (mut refused, mut read) = (0, 0);
    for round in 0..6000 {
        let (kind, _) = ALL[round % ALL.len()];
        let lied = with_section(&bytes, Section(kind, 0), |section| match random.u32(..8) {
            0 => section.truncate(random.usize(..section.len())),
            1 => section.extend([random.u8(..); 80]),
            _ => {
                for _ in 0..random.u32(1..4) {
                    let at = random.usize(..section.len());
                    let any = random.u8(..);
                    section[at] = random
                        .choice([0, 1, 0x7F, 0x80, 0xFF, 0xDD, any])
                        .expect("a byte");
                }
            }
        });
        match read_again(lied, &ReadOptions::default()) {
            Err(_) => refused += 1,
            Ok(import) => {
                read += 1;
                let Ok(scene) = import.scene(Method::Masked, 1 << 30) else {
                    continue;
                };
                let view = Camera::new([0.3, 2.0, 9.0], [0.0; 3])
                    .view([32, 18])
                    .expect("a view");
                enfilade::Viewer::with_options(ViewerOptions::default()).look(&scene, &view);
            }
        }
    }
    assert!(refused > 1000 && read > 100, "{refused} refused, {read} read");
}

#[test]
fn a_baked_scene_is_not_flattened_in_silence() {
    let options = ReadOptions {
        flat: true,
        ..ReadOptions::default()
    };
    let why = read_again(baked(&everything()), &options).expect_err("it has rooms");
    assert!(matches!(why, BrokenRule::Enf(EnfError::Flat)), "{why}");
}
