//! The screen that rows use: its projection, view and depth buffers.

use super::lens::Lens;
use super::shapes::{FaceOrder, RandomNumbers, Shapes};
use super::truth::Truth;
use enfilade::{OccluderMesh, OcclusionBuffer, Rect, Transform, View};

/// The screen of an eye at the origin that looks along −z.
pub(super) struct Screen {
    pub(super) lens: Lens,
    pub(super) view: View,
    /// Buffer that rows rasterize into, one after the other.
    pub(super) cover: OcclusionBuffer,
    /// Buffer that rows test boxes against: many faces in front of a backdrop. And its true depths.
    pub(super) filled: OcclusionBuffer,
    pub(super) filled_truth: Truth,
}

/// Distance of the backdrop, behind everything else.
pub(super) const BACKDROP: f64 = 2000.0;

impl Screen {
    pub(super) fn new(size: [u32; 2]) -> Screen {
        let view = View::new([0.0; 3], [0.0, 0.0, -1.0], size).expect("a valid view");
        let lens = Lens::new(&view);
        let (mut filled, mut filled_truth) = (buffer(), Truth::new(lens));
        filled.begin(&view);
        let walls = Shapes::new(&lens, 3, 1000.0, 20_000, FaceOrder::BackToFront);
        for shapes in [Shapes::backdrop(&lens, BACKDROP), walls] {
            draw(&mut filled, &shapes.meshes());
            shapes.faces().for_each(|face| filled_truth.add(face));
        }
        Screen {
            lens,
            view,
            cover: buffer(),
            filled,
            filled_truth,
        }
    }

    /// Returns `count` squares at random positions, of `side` pixels a side.
    pub(super) fn squares(&self, side: u16, count: usize) -> Vec<Rect> {
        let mut random = RandomNumbers(u64::from(side));
        let [width, height] = self.lens.size.map(|length| length - u32::from(side));
        let square = |_| {
            let [x0, y0] = [width, height].map(|room| (f64::from(room + 1) * random.uniform()) as u16);
            Rect {
                x0,
                y0,
                x1: x0 + side,
                y1: y0 + side,
            }
        };
        (0..count).map(square).collect()
    }
}

impl Shapes {
    /// Converts the faces to the engine's meshes, in the same order: small ones, because the faces of a large one are
    /// sorted.
    pub(super) fn meshes(&self) -> Vec<OccluderMesh> {
        const FACES: usize = 64;
        // The first three corners, and of a quad the first and the last two.
        let halves =
            |first: u32| (2..self.sides as u32).flat_map(move |last| [first, first + last - 1, first + last]);
        let mesh = |positions: &[[f32; 3]]| {
            let first = (0..positions.len() as u32).step_by(self.sides);
            let indices: Vec<u32> = first.flat_map(halves).collect();
            OccluderMesh::triangles(positions, &indices).expect("whole triangles")
        };
        self.positions.chunks(FACES * self.sides).map(mesh).collect()
    }
}

/// Rasterizes meshes.
pub(super) fn draw(buffer: &mut OcclusionBuffer, meshes: &[OccluderMesh]) {
    buffer.draw_all(meshes.iter().map(|mesh| (mesh, Transform::IDENTITY)));
}

/// Returns a buffer that uses one thread.
pub(super) fn buffer() -> OcclusionBuffer {
    let mut buffer = OcclusionBuffer::new();
    buffer.parallel = false;
    buffer
}

/// Returns whether each of `count` occludees is visible.
pub(super) fn are_visible(bits: &[u64], count: usize) -> impl Iterator<Item = bool> {
    (0..count).map(|place| bits[place / 64] >> (place % 64) & 1 == 1)
}
