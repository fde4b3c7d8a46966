//! A little map in each format: two rooms with a thick wall between them, lava in one, a door, a lamp, a start.

/// The kinds of map that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Bsp29,
    Bsp2,
    Ibsp46,
}

pub(crate) const FORMATS: [Format; 3] = [Format::Bsp29, Format::Bsp2, Format::Ibsp46];

/// A map in the making: its lumps.
pub(crate) struct Little {
    pub(crate) format: Format,
    pub(crate) lumps: Vec<Vec<u8>>,
}

pub(crate) const ENTITIES: &str = r#"{
"classname" "worldspawn"
}
{
"classname" "light"
"origin" "-32 0 16"
}
{
"classname" "info_player_start"
"origin" "-40 8 0"
"angle" "90"
}
{
"classname" "func_door"
"model" "*1"
"origin" "32 0 0"
}
{
"classname" "trigger_once"
"model" "*1"
}
"#;

/// Half of the height and of the width of a room; it is twice as long.
const HALF: f32 = 32.0;

/// Thickness of the wall between the rooms; the splitting plane is in its middle.
const WALL: f32 = 8.0;

/// A face: which texture, and four corners, clockwise seen from its front, which looks along `normal`.
struct Quad {
    texture: i32,
    normal: [f32; 3],
    corners: [[f32; 3]; 4],
}

/// A square about a place, of which each other side is `half` away.
fn quad(texture: i32, middle: [f32; 3], axis: usize, sign: f32, half: [f32; 3]) -> Quad {
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    let mut normal = [0.0; 3];
    normal[axis] = sign;
    let mut corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[a, b]: [f32; 2]| {
        let mut corner = middle;
        corner[u] += a * half[u];
        corner[v] += b * half[v];
        corner
    });
    // So far counter-clockwise seen from where the axis leads.
    if sign > 0.0 {
        corners.reverse();
    }
    Quad {
        texture,
        normal,
        corners,
    }
}

/// The inner sides of a room about a place on the first axis.
fn room(x: f32, textures: [i32; 3]) -> Vec<Quad> {
    let mut quads = Vec::new();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let mut middle = [x, 0.0, 0.0];
            middle[axis] += sign * HALF;
            let texture = match (axis, sign > 0.0) {
                (2, false) => textures[1],
                (2, true) => textures[2],
                _ => textures[0],
            };
            quads.push(quad(texture, middle, axis, -sign, [HALF; 3]));
        }
    }
    quads
}

fn words(numbers: &[i32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

fn shorts(numbers: &[i32]) -> Vec<u8> {
    numbers
        .iter()
        .flat_map(|&number| (number as u16).to_le_bytes())
        .collect()
}

const NAMES: [&str; 4] = ["wall", "*lava1", "sky1", "clip"];

impl Little {
    pub(crate) fn new(format: Format) -> Little {
        let mut quads = room(-HALF, [0, 0, 2]);
        quads.extend(room(HALF + WALL, [0, 1, 0]));
        // Undrawn faces in the second room; then the door.
        quads.push(quad(3, [HALF, 0.0, 0.0], 0, 1.0, [16.0; 3]));
        quads.push(quad(0, [0.0; 3], 0, -1.0, [8.0; 3]));
        let mut little = Little {
            format,
            lumps: vec![Vec::new(); if format == Format::Ibsp46 { 17 } else { 15 }],
        };
        little.lumps[0] = format!("{ENTITIES}\0").into_bytes();
        match format {
            Format::Ibsp46 => little.fill_ibsp46(&quads),
            _ => little.fill_quake(&quads),
        }
        little
    }

    fn fill_quake(&mut self, quads: &[Quad]) {
        let is_short = self.format == Format::Bsp29;
        let lumps = &mut self.lumps;
        let both = |numbers: &[i32]| if is_short { shorts(numbers) } else { words(numbers) };
        // The first plane separates the rooms; each face has a separate plane.
        let plane =
            |normal: [f32; 3], offset: f32| [floats(&normal), floats(&[offset]), words(&[0])].concat();
        lumps[1] = plane([1.0, 0.0, 0.0], WALL / 2.0);
        lumps[2] = words(&[4, 20, 60, 100, 140]);
        for name in NAMES {
            let mut image = name.as_bytes().to_vec();
            image.resize(16, 0);
            lumps[2].extend([image, words(&[64, 32, 0, 0, 0, 0])].concat());
        }
        lumps[6] = (0..4)
            .flat_map(|texture| {
                let axes = floats(&[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
                [axes, words(&[texture, 0])].concat()
            })
            .collect();
        lumps[12] = both(&[0, 0]);
        for (at, quad) in quads.iter().enumerate() {
            let offset = (0..3).map(|axis| quad.normal[axis] * quad.corners[0][axis]).sum();
            lumps[1].extend(plane(quad.normal, offset));
            let vertex = 4 * at as i32;
            for (side, corner) in (0..).zip(&quad.corners) {
                lumps[3].extend(floats(corner));
                lumps[12].extend(both(&[vertex + side, vertex + (side + 1) % 4]));
                lumps[13].extend(words(&[vertex + side + 1]));
            }
            let face = [at as i32 + 1, 0, vertex, 4, quad.texture];
            lumps[7].extend(if is_short {
                [shorts(&face[..2]), words(&face[2..3]), shorts(&face[3..])].concat()
            } else {
                words(&face)
            });
            lumps[7].extend(words(&[0, -1]));
        }
        // In front of the plane is leaf 2, behind it leaf 1.
        let around = [-64, -32, -32, 64, 32, 32];
        lumps[5] = [
            words(&[0]),
            both(&[-3, -2]),
            self::around(is_short, around),
            both(&[0, 13]),
        ]
        .concat();
        let marks = [[0, 0], [0, 6], [6, 7]];
        for (leaf, [first, count]) in marks.into_iter().enumerate() {
            let kind = if leaf == 0 { -2 } else { -1 };
            let row = if leaf == 0 { -1 } else { leaf as i32 - 1 };
            lumps[10].extend(words(&[kind, row]));
            lumps[10].extend([self::around(is_short, around), both(&[first, count]), words(&[0])].concat());
        }
        lumps[11] = both(&(0..13).collect::<Vec<_>>());
        // Each is visible from itself.
        lumps[4] = vec![0b01, 0b10];
        for [leafs, first, count] in [[2, 0, 13], [0, 13, 1]] {
            lumps[14].extend(floats(&[-64.0, -32.0, -32.0, 64.0, 32.0, 32.0, 0.0, 0.0, 0.0]));
            lumps[14].extend(words(&[0, 0, 0, 0, leafs, first, count]));
        }
    }

    fn fill_ibsp46(&mut self, quads: &[Quad]) {
        let lumps = &mut self.lumps;
        for (name, [surface, geometry]) in NAMES.into_iter().zip([[0, 1], [0x10, 8], [0x4, 1], [0x80, 1]]) {
            let mut path = format!("textures/little/{name}").into_bytes();
            path.resize(64, 0);
            lumps[1].extend([path, words(&[surface, geometry])].concat());
        }
        lumps[2] = floats(&[1.0, 0.0, 0.0, WALL / 2.0, -1.0, 0.0, 0.0, -WALL / 2.0]);
        let around = words(&[-64, -32, -32, 64, 32, 32]);
        lumps[3] = [words(&[0, -3, -2]), around.clone()].concat();
        for (cluster, first, count) in [(-1, 0, 0), (0, 0, 6), (1, 6, 7)] {
            lumps[4].extend([words(&[cluster, 0]), around.clone(), words(&[first, count, 0, 0])].concat());
        }
        lumps[5] = words(&(0..13).collect::<Vec<_>>());
        for [first, count] in [[0, 13], [13, 1]] {
            lumps[7].extend(floats(&[-64.0, -32.0, -32.0, 64.0, 32.0, 32.0]));
            lumps[7].extend(words(&[first, count, 0, 0]));
        }
        for (at, quad) in quads.iter().enumerate() {
            let vertex = 4 * at as i32;
            for (side, corner) in quad.corners.iter().enumerate() {
                let place = [(side / 2) as f32, (side % 2) as f32];
                lumps[10].extend([floats(corner), floats(&place), floats(&[0.0; 2])].concat());
                lumps[10].extend(floats(&quad.normal));
                lumps[10].extend([200, 100, 40 * side as u8, 255]);
            }
            // The first is a patch of three corners a side.
            let head = [quad.texture, -1, 1, vertex, 4, 6 * at as i32, 6];
            lumps[11].extend(words(&[0, 1, 2, 0, 2, 3]));
            lumps[13].extend(words(&head));
            lumps[13].extend([0; 68]);
            lumps[13].extend(words(&[0, 0]));
        }
        lumps[16] = words(&[2, 8]);
        lumps[16].extend([0b01, 0, 0, 0, 0, 0, 0, 0, 0b10, 0, 0, 0, 0, 0, 0, 0]);
    }

    /// The file.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let mut map = match self.format {
            Format::Bsp29 => 29u32.to_le_bytes().to_vec(),
            Format::Bsp2 => b"BSP2".to_vec(),
            Format::Ibsp46 => b"IBSP\x2e\0\0\0".to_vec(),
        };
        let table = map.len();
        map.resize(table + 8 * self.lumps.len(), 0);
        for (number, lump) in self.lumps.iter().enumerate() {
            map.resize(map.len().next_multiple_of(4), 0);
            let entry = words(&[map.len() as i32, lump.len() as i32]);
            map[table + 8 * number..][..8].copy_from_slice(&entry);
            map.extend_from_slice(lump);
        }
        map
    }
}

/// A box around something, as each format of Quake has it.
fn around(is_short: bool, numbers: [i32; 6]) -> Vec<u8> {
    match is_short {
        true => shorts(&numbers),
        false => floats(&numbers.map(|number| number as f32)),
    }
}
