//! In which leaf of a map a point is, by code that knows nothing of the reader's.

use super::rows::{lump, word};

/// BSP2 or IBSP46.
pub(crate) struct Located<'a> {
    map: &'a [u8],
    /// Lump offsets, and record sizes in bytes.
    planes: [usize; 2],
    nodes: [usize; 2],
    root: usize,
}

impl Located<'_> {
    pub(crate) fn new(map: &[u8]) -> Located<'_> {
        let (planes, nodes, root) = if map.starts_with(b"IBSP") {
            ([lump(map, 2).start, 16], [lump(map, 3).start, 36], 0)
        } else {
            let root = word(map, lump(map, 14).start + 36);
            ([lump(map, 1).start, 20], [lump(map, 5).start, 44], root)
        };
        Located {
            map,
            planes,
            nodes,
            root,
        }
    }

    pub(crate) fn leaf(&self, point: [f64; 3]) -> usize {
        let mut node = self.root as i32;
        while node >= 0 {
            let at = self.nodes[0] + node as usize * self.nodes[1];
            let plane = self.planes[0] + word(self.map, at) * self.planes[1];
            let number = |nth: usize| f64::from(f32::from_bits(word(self.map, plane + nth * 4) as u32));
            let above: f64 = (0..3).map(|axis| number(axis) * point[axis]).sum();
            let side = usize::from(above < number(3));
            node = word(self.map, at + 4 + side * 4) as i32;
        }
        (-1 - node) as usize
    }
}
