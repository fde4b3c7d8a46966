//! The calls, by number.

use super::*;

/// Number of branches of [`Fuzz::call`].
pub(super) const FUNCTION_COUNT: usize = 69;

impl Fuzz<'_> {
    /// Calls a function with arguments of which some are wrong.
    pub(super) fn call(&mut self, function: usize) -> EnfiladeStatus {
        let error = self.error();
        let version = self.version();
        let scene: *mut EnfiladeScene = self.handle(SCENE);
        let viewer: *mut EnfiladeViewer = self.handle(VIEWER);
        let occlusion: *mut EnfiladeOcclusion = self.handle(OCCLUSION);
        let rooms: *mut EnfiladeRooms = self.handle(ROOMS);
        unsafe {
            match function {
                0 => {
                    enfilade_version();
                    self.free_some(MESH)
                }
                1 => {
                    // Threads of its own would make the driver itself slow.
                    let count = if self.one_in(50) { self.rng.u32(1..4) } else { 1 };
                    let count = if self.one_in(4) {
                        257 + self.rng.u32(0..9)
                    } else {
                        count
                    };
                    enfilade_set_threads(count, error)
                }
                2 => {
                    let mut mesh = null_mut();
                    let part = self.part();
                    let parts = [part; 2];
                    let count = if self.one_in(20) {
                        usize::MAX / 3
                    } else {
                        self.rng.usize(0..3)
                    };
                    let to = if self.one_in(20) {
                        null_mut()
                    } else {
                        &raw mut mesh
                    };
                    let status = enfilade_mesh_create(version, self.maybe(&parts[0]), count, to, error);
                    self.keep(MESH, mesh);
                    status
                }
                3 => {
                    let mut mesh = null_mut();
                    let [low, high] = [self.floats(), self.floats()];
                    let high = if high.is_null() {
                        high
                    } else {
                        high.wrapping_byte_add(16)
                    };
                    let status = enfilade_mesh_create_box(version, low, high, &mut mesh, error);
                    self.keep(MESH, mesh);
                    status
                }
                4 => {
                    let mut scene = null_mut();
                    let to = if self.one_in(20) {
                        null_mut()
                    } else {
                        &raw mut scene
                    };
                    let status = enfilade_scene_create(version, to, error);
                    self.keep(SCENE, scene);
                    status
                }
                5 => {
                    let mut scene = null_mut();
                    let options = self.read_options();
                    let path = if self.rng.bool() {
                        self.text()
                    } else {
                        c"/".as_ptr()
                    };
                    enfilade_scene_read_file(version, path, self.maybe(&options), &mut scene, error)
                }
                6 => {
                    let mut scene = null_mut();
                    let options = self.read_options();
                    let mut bytes = GLTF.as_bytes().to_vec();
                    for _ in 0..self.rng.usize(0..3) {
                        let place = self.rng.usize(0..bytes.len());
                        bytes[place] = self.rng.u8(..);
                    }
                    let count = if self.one_in(20) {
                        self.rng.usize(0..=bytes.len())
                    } else {
                        bytes.len()
                    };
                    let options = self.maybe(&options);
                    let status = enfilade_scene_read_memory(
                        version,
                        bytes.as_ptr(),
                        count,
                        options,
                        &mut scene,
                        error,
                    );
                    self.keep(SCENE, scene);
                    status
                }
                7 => self.free_some(SCENE),
                8 => {
                    let materials: [EnfiladeMaterial; 3] = [0, 1, 2].map(|_| EnfiladeMaterial {
                        color: [0, 1, 2, 3].map(|_| if self.rng.bool() { 0.5 } else { self.float() }),
                        alpha: self.rng.u32(0..4),
                        double_sided: self.rng.u32(..),
                        detail: self.rng.u32(0..2),
                    });
                    let (name, method) = (self.text(), self.rng.u32(0..15));
                    let count = if self.one_in(20) {
                        usize::MAX
                    } else {
                        self.rng.usize(0..4)
                    };
                    let mut sector = 0;
                    let materials = self.maybe(&materials[0]);
                    let status =
                        enfilade_scene_add_sector(scene, name, method, materials, count, &mut sector, error);
                    self.note_ids(&[sector]);
                    status
                }
                9 => {
                    let sector = if self.one_in(4) {
                        self.sector(scene)
                    } else {
                        self.id()
                    };
                    enfilade_scene_remove_sector(scene, sector, error)
                }
                10 => {
                    let sector = self.sector(scene);
                    enfilade_scene_set_method(scene, sector, self.rng.u32(0..15), error)
                }
                11 => {
                    let (to, capacity, count) = self.results();
                    enfilade_scene_sectors(scene, to, capacity.min(100), count, error)
                }
                12 => {
                    let sector = self.sector(scene);
                    enfilade_scene_sector(scene, sector, self.out(), error)
                }
                13 => {
                    let (to, capacity, count) = self.results();
                    enfilade_scene_cameras(scene, to, capacity, count, error)
                }
                14 => {
                    let (to, capacity, count) = self.results();
                    enfilade_scene_warnings(scene, to, capacity, count, error)
                }
                15 | 16 => {
                    let sector = self.sector(scene);
                    let items: Vec<EnfiladeItem> = (0..self.rng.usize(1..20))
                        .map(|_| EnfiladeItem {
                            mesh: self.handle(MESH),
                            key: if self.one_in(20) {
                                self.rng.u64(..)
                            } else {
                                self.rng.u64(0..200)
                            },
                            sector_from_item: self.matrix(),
                            options: self.item_options(),
                            name: self.text(),
                        })
                        .collect();
                    let count = if self.one_in(30) {
                        usize::MAX / 2
                    } else {
                        items.len()
                    };
                    let mut ids = vec![7; items.len()];
                    let to = if self.one_in(30) {
                        null_mut()
                    } else {
                        ids.as_mut_ptr()
                    };
                    let from = self.maybe(&items[0]);
                    let from = if from.is_null() { from } else { items.as_ptr() };
                    let status = enfilade_scene_add_items(scene, sector, from, count, to, error);
                    ids.retain(|&id| id != 7);
                    self.note_ids(&ids);
                    status
                }
                17 => {
                    let ids: Vec<u64> = (0..self.rng.usize(1..4)).map(|_| self.item(scene)).collect();
                    let status = enfilade_scene_remove_items(scene, ids.as_ptr(), ids.len(), error);
                    if !self.is_shared && status == EnfiladeStatus::Ok {
                        self.removed.extend(&ids);
                    }
                    status
                }
                18 | 19 => {
                    let ids: Vec<u64> = (0..20).map(|_| self.item(scene)).collect();
                    let transforms = self.matrices(24);
                    let count = self.count(20);
                    let stride = self.stride(64);
                    let refused = if self.rng.bool() {
                        null_mut()
                    } else {
                        self.results.as_mut_ptr()
                    };
                    enfilade_scene_move_items(scene, ids.as_ptr(), count, transforms, stride, refused, error)
                }
                20 => {
                    let ids: Vec<u64> = (0..5).map(|_| self.item(scene)).collect();
                    let options: Vec<_> = (0..5).map(|_| self.item_options()).collect();
                    enfilade_scene_set_options(scene, ids.as_ptr(), self.count(5), options.as_ptr(), error)
                }
                21 => {
                    let ids: Vec<u64> = (0..5).map(|_| self.item(scene)).collect();
                    enfilade_scene_set_keys(scene, ids.as_ptr(), self.count(5), ids.as_ptr(), error)
                }
                22 => {
                    let item = self.item(scene);
                    enfilade_scene_set_mesh(scene, item, self.handle(MESH), error)
                }
                23 => {
                    let (item, sector) = (self.item(scene), self.sector(scene));
                    let transform = self.matrices(1);
                    enfilade_scene_transfer_item(scene, item, sector, transform, error)
                }
                24 => {
                    let sector = if self.rng.bool() { 0 } else { self.sector(scene) };
                    let (to, capacity, count) = self.results();
                    enfilade_scene_items(scene, sector, to, capacity, count, error)
                }
                25 => {
                    let item = if self.one_in(3) {
                        self.id()
                    } else {
                        self.item(scene)
                    };
                    let status = enfilade_scene_item(scene, item, self.out(), error);
                    let was_removed = self.removed.contains(&item);
                    assert!(
                        !was_removed || status != EnfiladeStatus::Ok,
                        "item {item} was removed"
                    );
                    status
                }
                26 => {
                    let [a, b] = [self.sector(scene), self.sector(scene)];
                    if self.portals_of(scene) > 6 {
                        return enfilade_scene_remove_portal(scene, self.portal(scene), error);
                    }
                    let (corners, count) = self.outline();
                    let stride = self.stride(12);
                    let mut portals = [0_u64; 2];
                    let to = if self.one_in(20) {
                        null_mut()
                    } else {
                        portals.as_mut_ptr()
                    };
                    let status = enfilade_scene_add_door(scene, a, b, corners, stride, count, to, error);
                    self.note_ids(&portals);
                    status
                }
                27 => {
                    let [from, to] = [self.sector(scene), self.sector(scene)];
                    if self.portals_of(scene) > 6 {
                        return enfilade_scene_remove_portal(scene, self.portal(scene), error);
                    }
                    let transform = self.matrix();
                    let transform = if self.one_in(3) {
                        null()
                    } else {
                        transform.as_ptr()
                    };
                    let (corners, count) = self.outline();
                    let stride = self.stride(12);
                    let mut portal = 0;
                    let out = if self.one_in(20) {
                        null_mut()
                    } else {
                        &raw mut portal
                    };
                    let status = enfilade_scene_add_portal(
                        scene, from, corners, stride, count, to, transform, out, error,
                    );
                    self.note_ids(&[portal]);
                    status
                }
                28 => enfilade_scene_remove_portal(scene, self.portal(scene), error),
                29 => {
                    let portal = self.portal(scene);
                    enfilade_scene_set_open(scene, portal, self.rng.u32(0..3), error)
                }
                30 => {
                    let sector = if self.rng.bool() { 0 } else { self.sector(scene) };
                    let (to, capacity, count) = self.results();
                    enfilade_scene_portals(scene, sector, to, capacity, count, error)
                }
                31 => {
                    let camera = self.camera();
                    let camera = self.maybe(&camera);
                    enfilade_view_from_camera(
                        camera,
                        self.rng.u32(0..17_000),
                        self.rng.u32(0..99),
                        self.out(),
                        error,
                    )
                }
                32 => {
                    let mut viewer = null_mut();
                    let options = self.viewer_options();
                    let to = if self.one_in(20) {
                        null_mut()
                    } else {
                        &raw mut viewer
                    };
                    let status = enfilade_viewer_create(version, &options, to, error);
                    self.keep(VIEWER, viewer);
                    status
                }
                33 => self.free_some(VIEWER),
                34 => {
                    let options = self.viewer_options();
                    enfilade_viewer_set_options(viewer, &options, error)
                }
                35..=38 => {
                    let view = self.view(scene);
                    let view = self.maybe(&view);
                    enfilade_viewer_look(viewer, scene, view, self.out(), error)
                }
                39 => {
                    let words = match self.rng.u32(0..20) {
                        0 => null_mut(),
                        1 => self.results.as_mut_ptr().cast::<u8>().wrapping_add(4).cast(),
                        _ => self.results.as_mut_ptr(),
                    };
                    enfilade_viewer_bits(viewer, words, self.count(8), error)
                }
                40 => {
                    let mut keys: EnfiladeKeys = std::mem::zeroed();
                    let status = enfilade_viewer_keys(viewer, &mut keys, error);
                    if status == EnfiladeStatus::Ok && !self.is_shared {
                        let visible = std::slice::from_raw_parts(keys.visible, keys.visible_count);
                        assert!(visible.is_sorted());
                        assert!(keys.entered_count <= keys.visible_count);
                    }
                    status
                }
                41 => {
                    let (to, capacity, count) = self.results();
                    enfilade_viewer_items(viewer, scene, to, capacity, count, error)
                }
                42 => {
                    let (to, capacity, count) = self.results();
                    enfilade_viewer_passages(viewer, scene, to, capacity, count, error)
                }
                43 => {
                    let view = self.view(scene);
                    let options = EnfiladeDrawOptions {
                        show: self.rng.u32(0..7),
                        samples: [0, 1, 4, 5][self.rng.usize(0..4)],
                        shadows: self.rng.u32(0..2),
                        ambient_rays: if self.one_in(8) { self.rng.u32(..) } else { 0 },
                        exposure: self.float(),
                    };
                    let options = EnfiladeDrawOptions {
                        ambient_rays: options.ambient_rays | u32::from(options.ambient_rays > 4) << 11,
                        ..options
                    };
                    let options = self.maybe(&options);
                    let row = if self.one_in(4) {
                        self.rng.usize(0..1000)
                    } else {
                        0
                    };
                    let bytes = self.count(8 * self.results.len());
                    enfilade_viewer_draw(
                        viewer,
                        scene,
                        &view,
                        options,
                        self.results.as_mut_ptr().cast(),
                        row,
                        bytes,
                        error,
                    )
                }
                44 => {
                    let point = self.doubles();
                    let target = if self.rng.bool() { null() } else { point };
                    enfilade_scene_locate(scene, point, target, self.out(), error)
                }
                45 => {
                    let from = self.location(scene);
                    let (from, direction) = (self.maybe(&from), self.floats());
                    enfilade_scene_cast_ray(scene, from, direction, self.out(), error)
                }
                46 => {
                    let [from, to] = [self.location(scene), self.location(scene)];
                    enfilade_scene_sees(scene, &from, self.maybe(&to), self.out(), error)
                }
                47 => {
                    let from = self.location(scene);
                    let from = self.maybe(&from);
                    let radius = self.float();
                    let (to, capacity, count) = self.results();
                    enfilade_scene_near(scene, from, radius, to, capacity, count, error)
                }
                48 => {
                    let mut location = self.location(scene);
                    let before = location;
                    let to = if self.one_in(20) {
                        null_mut()
                    } else {
                        &raw mut location
                    };
                    let status = enfilade_scene_walk(scene, to, self.floats(), self.out(), error);
                    assert!(status == EnfiladeStatus::Ok || location.sector == before.sector);
                    status
                }
                49 => {
                    let mut location = self.location(scene);
                    let mut capsule = EnfiladeCapsule {
                        radius: self.float(),
                        height: self.float(),
                        up: [0, 1, 2].map(|_| self.float()),
                        climb: if self.rng.bool() { 0.0 } else { self.float() },
                    };
                    if self.rng.bool() {
                        capsule = EnfiladeCapsule {
                            radius: 0.3,
                            height: 1.8,
                            up: [0.0, 1.0, 0.0],
                            climb: 0.2,
                        };
                    }
                    let step = self.floats();
                    let body = if self.one_in(20) {
                        null_mut()
                    } else {
                        &raw mut capsule
                    };
                    enfilade_scene_slide(scene, body, &mut location, step, self.out(), null_mut(), error)
                }
                50 => {
                    let mut occluder = null_mut();
                    let part = self.part();
                    let part = self.maybe(&part);
                    let status =
                        enfilade_occluder_create(version, part, self.rng.u32(0..2), &mut occluder, error);
                    self.keep(OCCLUDER, occluder);
                    status
                }
                51 => self.free_some(OCCLUDER),
                52 => {
                    let mut occlusion = null_mut();
                    let to = if self.one_in(20) {
                        null_mut()
                    } else {
                        &raw mut occlusion
                    };
                    let status = enfilade_occlusion_create(version, to, error);
                    self.keep(OCCLUSION, occlusion);
                    status
                }
                53 => self.free_some(OCCLUSION),
                54 => {
                    let view = self.view(null());
                    enfilade_occlusion_begin(occlusion, self.maybe(&view), error)
                }
                55 => {
                    let occluder: *mut EnfiladeOccluder = self.handle(OCCLUDER);
                    let (transforms, count) = (self.matrices(24), self.count(20));
                    enfilade_occlusion_draw(occlusion, occluder, transforms, self.stride(64), count, error)
                }
                56 => {
                    let (boxes, count) = (self.floats(), self.count(90));
                    let stride = self.stride(24);
                    let visible = match self.rng.u32(0..20) {
                        0 => null_mut(),
                        1 => self.results.as_mut_ptr().cast::<u8>().wrapping_add(4).cast(),
                        _ => self.results.as_mut_ptr(),
                    };
                    enfilade_occlusion_test_boxes(occlusion, boxes, stride, count, visible, error)
                }
                57 => {
                    let (to, capacity, count) = self.results();
                    enfilade_occlusion_depths(occlusion, to, capacity, count, error)
                }
                58 => {
                    let mut rooms = null_mut();
                    // Slow where it succeeds.
                    let scene = if self.one_in(10) { scene } else { null_mut() };
                    let options = EnfiladeRoomOptions {
                        metres_per_unit: if self.one_in(4) {
                            f64::from(self.float())
                        } else {
                            1.0
                        },
                        voxel: if self.one_in(4) {
                            f64::from(self.float())
                        } else {
                            0.5
                        },
                        max_voxels: self.rng.u64(1..3000),
                        up: self.rng.u32(0..5),
                        ignores_sectors: self.rng.u32(0..2),
                    };
                    let status = enfilade_rooms_find(version, scene, &options, &mut rooms, error);
                    self.keep(ROOMS, rooms);
                    status
                }
                59 => {
                    let mut read = null_mut();
                    let mut json = vec![0_u8; 1 << 16];
                    let mut count = 0;
                    enfilade_rooms_write(rooms, json.as_mut_ptr(), json.len(), &mut count, null_mut());
                    json.truncate(count);
                    if !json.is_empty() && self.rng.bool() {
                        let place = self.rng.usize(0..json.len());
                        json[place] = self.rng.u8(..);
                    }
                    let status = enfilade_rooms_read(version, json.as_ptr(), json.len(), &mut read, error);
                    self.keep(ROOMS, read);
                    status
                }
                60 => {
                    let (to, capacity, count) = self.results();
                    enfilade_rooms_write(rooms, to, capacity, count, error)
                }
                61 => self.free_some(ROOMS),
                62 => {
                    let (to, capacity, count) = self.results::<EnfiladeRoom>();
                    let status = enfilade_rooms_list(rooms, to, capacity, count, error);
                    if status == EnfiladeStatus::Ok && !to.is_null() && !count.is_null() {
                        let ids: Vec<u64> = (0..*count)
                            .map(|number| to.add(number).read_unaligned().room)
                            .collect();
                        self.note_ids(&ids);
                    }
                    status
                }
                63 => {
                    let room = if self.rng.bool() {
                        0
                    } else {
                        self.room_and_door(rooms)[0]
                    };
                    let (to, capacity, count) = self.results::<EnfiladeDoor>();
                    let status = enfilade_rooms_doors(rooms, room, to, capacity, count, error);
                    if status == EnfiladeStatus::Ok && !to.is_null() && !count.is_null() {
                        let ids: Vec<u64> = (0..*count)
                            .map(|number| to.add(number).read_unaligned().door)
                            .collect();
                        self.note_ids(&ids);
                    }
                    status
                }
                64 => {
                    let point = self.doubles();
                    enfilade_rooms_at(rooms, point, self.out(), error)
                }
                65 => {
                    let [_, door] = self.room_and_door(rooms);
                    enfilade_rooms_set_open(rooms, door, self.rng.u32(0..2), error)
                }
                66 => {
                    let (from, length) = (self.doubles(), self.out::<f64>());
                    // The length and the doors go to the same array.
                    let length = if length.is_null() { length } else { null_mut() };
                    let (to, capacity, count) = self.results();
                    let target = if from.is_null() {
                        from
                    } else {
                        from.wrapping_add(3)
                    };
                    enfilade_rooms_path(rooms, from, target, length, to, capacity, count, error)
                }
                67 => {
                    let from = self.doubles();
                    let source = if from.is_null() {
                        from
                    } else {
                        from.wrapping_add(3)
                    };
                    enfilade_rooms_heard(rooms, from, source, self.out(), error)
                }
                _ => {
                    let [room, _] = self.room_and_door(rooms);
                    let (to, capacity, count) = self.results();
                    enfilade_rooms_relevant(rooms, room, to, capacity, count, error)
                }
            }
        }
    }
}

/// Two triangles in a room.
const GLTF: &str = r#"{
    "asset": { "version": "2.0" },
    "scenes": [{ "nodes": [0, 2] }],
    "nodes": [{ "name": "Hall-room", "children": [1] }, { "name": "Leaf", "mesh": 0, "translation": [0, 0, -2] },
        { "name": "Eye", "camera": 0 }],
    "cameras": [{ "type": "perspective", "perspective": { "yfov": 1.0, "znear": 0.1 } }],
    "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
    "accessors": [{ "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3 }],
    "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
    "buffers": [{ "byteLength": 36, "uri":
        "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" }]
}"#;
