//! Generates small Quake maps: square rooms on a grid, with a door between each two neighbours.

#[path = "../../../../../crates/enfilade_import/tests/all/quake/rows.rs"]
pub(crate) mod rows;

/// A grid of rooms, 100 units wide each; doors are 20 wide, at an offset per wall.
pub(crate) struct Grid {
    pub(crate) rooms: usize,
    /// Offset of the door along the wall between two rooms, 0 to 80.
    pub(crate) door: fn(usize, usize) -> usize,
    /// Minimum x of the map.
    pub(crate) at: usize,
}

/// Offsets of doors that shift from wall to wall.
pub(crate) fn aside(from: usize, to: usize) -> usize {
    (from * 37 + to * 23) % 81
}

impl Grid {
    pub(crate) fn row(rooms: usize) -> Grid {
        Grid {
            rooms,
            door: aside,
            at: 0,
        }
    }

    /// `PRT2`, each room a leaf and a cluster.
    pub(crate) fn prt(&self) -> String {
        let n = self.rooms;
        let mut portals = Vec::new();
        for room in 0..n * n {
            let (x, y) = (room % n, room / n);
            if x + 1 < n {
                let (x, y) = (self.at + (x + 1) * 100, y * 100 + (self.door)(room, room + 1));
                portals.push(format!(
                    "4 {room} {} ({x} {y} 0) ({x} {} 0) ({x} {} 80) ({x} {y} 80)",
                    room + 1,
                    y + 20,
                    y + 20
                ));
            }
            if y + 1 < n {
                let (x, y) = (self.at + x * 100 + (self.door)(room, room + n), (y + 1) * 100);
                portals.push(format!(
                    "4 {room} {} ({x} {y} 0) ({x} {y} 80) ({} {y} 80) ({} {y} 0)",
                    room + n,
                    x + 20,
                    x + 20
                ));
            }
        }
        let clusters: String = (0..n * n).map(|room| format!("{room} -1\n")).collect();
        let (leafs, portals) = (n * n, (portals.len(), portals.join("\n")));
        format!("PRT2\n{leafs}\n{leafs}\n{}\n{}\n{clusters}", portals.0, portals.1)
    }

    /// `BSP2`: planes, nodes, leafs and the world model; no faces.
    pub(crate) fn bsp(&self) -> Vec<u8> {
        let n = self.rooms as i32;
        let mut planes = Vec::new();
        for (axis, wall) in (0..2usize).flat_map(|axis| (1..n).map(move |wall| (axis, wall))) {
            let mut normal = [0f32; 3];
            normal[axis] = 1.0;
            let at = wall as f32 * 100.0 + if axis == 0 { self.at as f32 } else { 0.0 };
            planes.extend(normal.into_iter().chain([at]).flat_map(f32::to_le_bytes));
            planes.extend((axis as i32).to_le_bytes());
        }
        // Columns one after another, then the rooms of each. Leaf 0 is solid.
        let mut nodes = Vec::new();
        let mut node = |plane: i32, front: i32, back: i32| {
            nodes.extend([plane, front, back].into_iter().flat_map(i32::to_le_bytes));
            nodes.extend([0; 44 - 12]);
        };
        let column = |x: i32| (n - 1) + x * (n - 1);
        for x in 0..n - 1 {
            let rest = if x + 2 < n { x + 1 } else { column(n - 1) };
            node(x, rest, column(x));
        }
        for x in 0..n {
            let leaf = |y: i32| -1 - (1 + y * n + x);
            for y in 0..n - 1 {
                let rest = if y + 2 < n { column(x) + y + 1 } else { leaf(n - 1) };
                node(n - 1 + y, rest, leaf(y));
            }
        }
        let mut leafs = Vec::new();
        for leaf in 0..=n * n {
            let contents = if leaf == 0 { -2 } else { -1 };
            leafs.extend([contents, -1].into_iter().flat_map(i32::to_le_bytes));
            leafs.extend([0; 44 - 8]);
        }
        let mut model = vec![0; 64];
        model[52..56].copy_from_slice(&(n * n).to_le_bytes());
        let mut lumps = vec![Vec::new(); 15];
        lumps[0] = b"{\n\"classname\" \"worldspawn\"\n}\n\0".to_vec();
        (lumps[1], lumps[5], lumps[10], lumps[14]) = (planes, nodes, leafs, model);
        let mut map = b"BSP2".to_vec();
        map.resize(4 + 15 * 8, 0);
        for (number, lump) in lumps.iter().enumerate() {
            map.resize(map.len().next_multiple_of(4), 0);
            let entry = [map.len() as u32, lump.len() as u32]
                .map(u32::to_le_bytes)
                .concat();
            map[4 + number * 8..][..8].copy_from_slice(&entry);
            map.extend_from_slice(lump);
        }
        map
    }
}
