//! The screen that rows use: its projection, passage and depth buffers.

use super::lens::Lens;
use super::shapes::{FaceOrder, RandomNumbers, Shapes};
use super::truth::Truth;
use anyhow::{Context, Result};
use enfilade::cover::{Hides, MaskedDepth};
use enfilade::{
    GeometryBuilder, Material, Method, OccluderMesh, Passage, Rect, SceneBuilder, SectorId, Stats, View,
    Viewer,
};

/// The screen of an eye at the origin that looks along −z.
pub(super) struct Screen {
    pub(super) lens: Lens,
    pub(super) passage: Passage,
    /// Buffer that rows rasterize into, one after the other.
    pub(super) cover: MaskedDepth,
    /// Buffer that rows test boxes against: many faces in front of a backdrop. And its true depths.
    pub(super) filled: MaskedDepth,
    pub(super) filled_truth: Truth,
}

/// Distance of the backdrop, behind everything else.
pub(super) const BACKDROP: f64 = 2000.0;

impl Screen {
    pub(super) fn new(size: [u32; 2]) -> Result<Screen> {
        let view = View::new([0.0; 3], [0.0, 0.0, -1.0], size).expect("a valid view");
        let lens = Lens::new(&view);
        let passage = passage(&view)?;
        let (mut filled, mut filled_truth) = (MaskedDepth::default(), Truth::new(lens));
        filled.clear(&passage);
        let walls = Shapes::new(&lens, 3, 1000.0, 20_000, FaceOrder::BackToFront);
        for shapes in [Shapes::backdrop(&lens, BACKDROP), walls] {
            filled.hide_mesh(&shapes.mesh(), &passage, &mut Stats::default());
            shapes.faces().for_each(|face| {
                filled_truth.add(face);
            });
        }
        Ok(Screen {
            lens,
            passage,
            cover: MaskedDepth::default(),
            filled,
            filled_truth,
        })
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
    /// Converts the faces to the engine's mesh.
    pub(super) fn mesh(&self) -> OccluderMesh {
        let corners: Vec<u32> = (0..self.positions.len() as u32).collect();
        if self.sides == 4 {
            OccluderMesh::quads(&self.positions, &corners)
        } else {
            OccluderMesh::triangles(&self.positions, &corners)
        }
    }
}

/// Returns the passage of a view into the sector of the eye, which does not depend on its geometry.
pub(super) fn passage(view: &View) -> Result<Passage> {
    let mut scene = SceneBuilder::new();
    let geometry = GeometryBuilder::new([Material::opaque([1.0; 3])]).build()?;
    scene.add("empty", geometry, Method::ZBuffer);
    let scene = scene.build()?;
    let mut view = *view;
    view.sector = Some(SectorId(0));
    let mut viewer = Viewer::new();
    let passages = viewer.look(&scene, &view).passages();
    passages.first().cloned().context("the view has no passage")
}
