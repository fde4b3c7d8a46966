//! Scenes that are sound, so that calls reach something.

use super::*;

impl Fuzz<'_> {
    /// Builds a scene that is sound: two sectors with items, a door and a mirror, or a building of two rooms.
    pub(super) fn build(&mut self) {
        let corner =
            |number: usize| [0, 1, 2].map(|axis| if number >> axis & 1 == 1 { 0.5_f32 } else { -0.5 });
        let corners: Vec<[f32; 3]> = (0..8).map(corner).collect();
        let indices: [u16; 36] = [
            0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5,
            7, 4, 7, 6,
        ];
        let part = EnfiladeMeshPart {
            positions: corners.as_ptr().cast(),
            position_count: 8,
            position_stride: 0,
            indices: indices.as_ptr().cast(),
            index_count: 36,
            index_size: 2,
            material: 0,
        };
        let (mut mesh, mut scene) = (null_mut(), null_mut());
        unsafe { enfilade_mesh_create(ENFILADE_VERSION, &part, 1, &mut mesh, null_mut()) };
        unsafe { enfilade_scene_create(ENFILADE_VERSION, &mut scene, null_mut()) };
        let materials: [EnfiladeMaterial; 3] = [0, 1, 2].map(|alpha| EnfiladeMaterial {
            color: [0.5; 4],
            alpha,
            double_sided: alpha,
            detail: 0,
        });
        let mut sectors = [0_u64; 2];
        for sector in &mut sectors {
            let method = if self.rng.bool() { 0 } else { self.rng.u32(0..14) };
            unsafe {
                enfilade_scene_add_sector(
                    scene,
                    c"room".as_ptr(),
                    method,
                    materials.as_ptr(),
                    3,
                    sector,
                    null_mut(),
                )
            };
        }
        let is_building = self.one_in(10);
        let boxes: Vec<[f32; 6]> = if is_building {
            HOUSE.to_vec()
        } else {
            let place = |_| {
                let [x, y, z] = [(); 3].map(|()| self.sound());
                let size = 0.1 + self.rng.f32();
                [x, y, z, x + size, y + 1.0, z + size]
            };
            (0..30).map(place).collect()
        };
        for (number, walls) in boxes.chunks(15).enumerate() {
            let items = walls.iter().zip(0..).map(|(&[x, y, z, to_x, to_y, to_z], key)| {
                let mut matrix = [0.0; 16];
                [matrix[0], matrix[5], matrix[10], matrix[15]] = [to_x - x, to_y - y, to_z - z, 1.0];
                [matrix[12], matrix[13], matrix[14]] = [0.5 * (x + to_x), 0.5 * (y + to_y), 0.5 * (z + to_z)];
                EnfiladeItem {
                    mesh,
                    key,
                    sector_from_item: matrix,
                    options: EnfiladeItemOptions {
                        flags: 0,
                        layers: 0,
                        max_distance: 0.0,
                        min_size_px: 0.0,
                    },
                    name: if key == 4 { c"door".as_ptr() } else { null() },
                }
            });
            let items: Vec<EnfiladeItem> = items.collect();
            let mut ids = vec![0; items.len()];
            unsafe {
                enfilade_scene_add_items(
                    scene,
                    sectors[number],
                    items.as_ptr(),
                    items.len(),
                    ids.as_mut_ptr(),
                    null_mut(),
                )
            };
            self.note_ids(&ids);
        }
        let [mut door, mut mirror] = [[0_u64; 2], [0; 2]];
        let opening = [-1.0_f32, -1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 1.0, 0.0];
        let aside = [4.0_f32, -1.0, 1.0, 4.0, -1.0, -1.0, 4.0, 1.0, -1.0, 4.0, 1.0, 1.0];
        let [a, b] = sectors;
        unsafe {
            enfilade_scene_add_door(scene, a, b, opening.as_ptr(), 0, 4, door.as_mut_ptr(), null_mut())
        };
        unsafe {
            enfilade_scene_add_portal(
                scene,
                a,
                aside.as_ptr(),
                0,
                4,
                a,
                null(),
                mirror.as_mut_ptr(),
                null_mut(),
            )
        };
        if is_building {
            let options = EnfiladeRoomOptions {
                metres_per_unit: 1.0,
                voxel: 0.1,
                max_voxels: 100_000,
                up: 2,
                ignores_sectors: 1,
            };
            let mut rooms = null_mut();
            unsafe { enfilade_rooms_find(ENFILADE_VERSION, scene, &options, &mut rooms, null_mut()) };
            self.keep(ROOMS, rooms);
        }
        self.keep(MESH, mesh);
        self.keep(SCENE, scene);
        self.note_ids(&sectors);
        self.note_ids(&door);
        self.note_ids(&mirror);
    }
}

/// The walls of two rooms of 4 by 4 units with a doorway, in which a leaf is: lower and upper corners.
const HOUSE: [[f32; 6]; 10] = [
    [0.0, 0.0, -0.2, 8.2, 3.0, 0.0],
    [0.0, 0.0, 4.0, 8.2, 3.0, 4.2],
    [-0.2, 0.0, 0.0, 0.0, 3.0, 4.0],
    [8.2, 0.0, 0.0, 8.4, 3.0, 4.0],
    [4.05, 0.0, 1.5, 4.1, 2.0, 2.5],
    [4.0, 0.0, 0.0, 4.2, 3.0, 1.5],
    [4.0, 0.0, 2.5, 4.2, 3.0, 4.0],
    [4.0, 2.0, 1.5, 4.2, 3.0, 2.5],
    [-0.2, -0.2, -0.2, 8.4, 0.0, 4.2],
    [-0.2, 3.0, -0.2, 8.4, 3.2, 4.2],
];
