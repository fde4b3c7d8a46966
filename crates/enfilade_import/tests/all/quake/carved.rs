//! Maps of rooms that are boxes, carved out of what is solid, and compiled as simply as can be.

/// Output of the little map compiler.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Bsp29,
    Bsp2,
    Ibsp46,
}

/// A box, from its least to its greatest corner, and what it is filled with: −1 air, −3 water, −6 sky.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Room(pub(crate) [i32; 3], pub(crate) [i32; 3], pub(crate) i32);

/// A tree as in a file: planes; nodes as a plane and two children; leafs as contents and PVS row.
#[derive(Clone, Debug, Default)]
pub(crate) struct Raw {
    pub(crate) planes: Vec<[f32; 4]>,
    pub(crate) nodes: Vec<(i32, [i32; 2])>,
    pub(crate) leafs: Vec<[i32; 2]>,
    pub(crate) world_leafs: i32,
}

/// A leaf that is solid: the first in maps of Quake.
pub(crate) const SOLID: i32 = -1;

/// Rooms that do not overlap. Where no plane parts them that cuts none, rooms are cut into several leafs.
pub(crate) fn carved(rooms: &[Room]) -> Raw {
    let mut raw = Raw {
        leafs: vec![[-2, -1]],
        ..Raw::default()
    };
    let root = carve(&mut raw, rooms, [[i32::MIN; 3], [i32::MAX; 3]]);
    assert_eq!(root, 0, "at least one room");
    raw.world_leafs = raw.leafs.len() as i32 - 1;
    raw
}

fn carve(raw: &mut Raw, rooms: &[Room], part: [[i32; 3]; 2]) -> i32 {
    if rooms.is_empty() {
        return SOLID;
    }
    let faces = rooms
        .iter()
        .flat_map(|room| (0..3).flat_map(move |axis| [(axis, room.0[axis]), (axis, room.1[axis])]));
    let mut cuts: Vec<(usize, i32)> = faces
        .filter(|&(axis, at)| part[0][axis] < at && at < part[1][axis])
        .collect();
    // Best cuts no room, and has as many before it as behind it.
    let badness = |&(axis, at): &(usize, i32)| {
        let before = rooms.iter().filter(|room| room.1[axis] > at).count();
        let behind = rooms.iter().filter(|room| room.0[axis] < at).count();
        (before + behind - rooms.len(), before.abs_diff(behind))
    };
    cuts.sort_by_key(badness);
    let Some(&(axis, at)) = cuts.first() else {
        raw.leafs.push([rooms[0].2, -1]);
        return -(raw.leafs.len() as i32);
    };
    let mut plane = [0.0; 4];
    plane[axis] = 1.0;
    plane[3] = at as f32;
    let node = raw.nodes.len();
    raw.nodes.push((raw.planes.len() as i32, [0; 2]));
    raw.planes.push(plane);
    let [mut least, mut most] = part;
    least[axis] = at;
    most[axis] = at;
    let before: Vec<Room> = rooms.iter().filter(|room| room.1[axis] > at).copied().collect();
    let behind: Vec<Room> = rooms.iter().filter(|room| room.0[axis] < at).copied().collect();
    raw.nodes[node].1[0] = carve(raw, &before, [least, part[1]]);
    raw.nodes[node].1[1] = carve(raw, &behind, [part[0], most]);
    node as i32
}

impl Raw {
    /// The bytes of a file. In Quake 3 each leaf but the first is a cluster.
    pub(crate) fn bytes(&self, format: Format) -> Vec<u8> {
        let is_quake3 = format == Format::Ibsp46;
        let (magic, table, count) = match format {
            Format::Bsp29 => (29u32.to_le_bytes().to_vec(), 4, 15),
            Format::Bsp2 => (b"BSP2".to_vec(), 4, 15),
            Format::Ibsp46 => (b"IBSP\x2e\0\0\0".to_vec(), 8, 17),
        };
        let mut lumps = vec![Vec::new(); count];
        let [planes, nodes, leafs, models] = if is_quake3 { [2, 3, 4, 7] } else { [1, 5, 10, 14] };
        let plane_bytes = if is_quake3 { 16 } else { 20 };
        for (at, plane) in self.planes.iter().enumerate() {
            lumps[planes].extend(plane.iter().flat_map(|number| number.to_le_bytes()));
            lumps[planes].resize((at + 1) * plane_bytes, 0);
        }
        let node_bytes = [24, 44, 36][format as usize];
        for (at, (plane, children)) in self.nodes.iter().enumerate() {
            lumps[nodes].extend(plane.to_le_bytes());
            for child in children {
                let bytes = child.to_le_bytes();
                lumps[nodes].extend(&bytes[..if format == Format::Bsp29 { 2 } else { 4 }]);
            }
            lumps[nodes].resize((at + 1) * node_bytes, 0);
        }
        let leaf_bytes = [28, 44, 48][format as usize];
        for (at, [kind, row]) in self.leafs.iter().enumerate() {
            let kind = if is_quake3 { at as i32 - 1 } else { *kind };
            lumps[leafs].extend([kind, *row].iter().flat_map(|number| number.to_le_bytes()));
            lumps[leafs].resize((at + 1) * leaf_bytes, 0);
        }
        lumps[models] = vec![0; if is_quake3 { 40 } else { 64 }];
        if !is_quake3 {
            lumps[models][52..56].copy_from_slice(&self.world_leafs.to_le_bytes());
        }
        let mut map = magic;
        map.resize(table + count * 8, 0);
        for (number, lump) in lumps.iter().enumerate() {
            let entry = [map.len() as u32, lump.len() as u32]
                .map(u32::to_le_bytes)
                .concat();
            map[table + number * 8..][..8].copy_from_slice(&entry);
            map.extend_from_slice(lump);
        }
        map
    }
}

/// Two rooms and a door of 32 × 48 in the wall between them, which is 16 thick.
pub(crate) const TWO_ROOMS: [Room; 3] = [
    Room([-136, -64, 0], [-8, 64, 128], -1),
    Room([-8, -16, 0], [8, 16, 48], -1),
    Room([8, -64, 0], [136, 64, 128], -1),
];
