//! A minimal Quake map with something visible in it.

/// One leaf with one wall, the square from −8 to 8 at x = 16, seen from a start at the origin; with
/// PVS rows or without. As BSP2.
pub(crate) fn map(with_rows: bool) -> Vec<u8> {
    let words = |numbers: &[i32]| -> Vec<u8> { numbers.iter().flat_map(|n| n.to_le_bytes()).collect() };
    let floats = |numbers: &[f32]| -> Vec<u8> { numbers.iter().flat_map(|n| n.to_le_bytes()).collect() };
    let mut lumps = vec![Vec::new(); 15];
    lumps[0] =
        b"{\"classname\" \"worldspawn\"}\n{\"classname\" \"info_player_start\" \"origin\" \"0 0 -22\"}\0"
            .to_vec();
    lumps[1] = [floats(&[-1.0, 0.0, 0.0, -16.0]), words(&[0])].concat();
    // Clockwise seen from the origin.
    for [y, z] in [[8.0, -8.0], [8.0, 8.0], [-8.0, 8.0], [-8.0, -8.0]] {
        lumps[3].extend(floats(&[16.0, y, z]));
    }
    lumps[4] = if with_rows { vec![1] } else { Vec::new() };
    let around = floats(&[-16.0, -16.0, -16.0, 16.0, 16.0, 16.0]);
    // Leaf 1 is in front of the plane, solid space behind it.
    lumps[5] = [words(&[0, -2, -1]), around.clone(), words(&[0, 1])].concat();
    lumps[6] = [floats(&[0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]), words(&[0, 0])].concat();
    lumps[7] = words(&[0, 0, 0, 4, 0, 0, -1]);
    for (kind, row, marks) in [(-2, -1, 0), (-1, 0, 1)] {
        lumps[10].extend([words(&[kind, row]), around.clone(), words(&[0, marks, 0])].concat());
    }
    lumps[11] = words(&[0]);
    lumps[12] = words(&[0, 0, 0, 1, 1, 2, 2, 3, 3, 0]);
    lumps[13] = words(&[1, 2, 3, 4]);
    lumps[14] = [around, floats(&[0.0; 3]), words(&[0, 0, 0, 0, 1, 0, 1])].concat();
    let mut map = b"BSP2".to_vec();
    map.resize(4 + 15 * 8, 0);
    for (number, lump) in lumps.iter().enumerate() {
        let entry = words(&[map.len() as i32, lump.len() as i32]);
        map[4 + 8 * number..][..8].copy_from_slice(&entry);
        map.extend_from_slice(lump);
        map.resize(map.len().next_multiple_of(4), 0);
    }
    map
}
