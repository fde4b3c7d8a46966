//! Finds contested samples at edges: those that a neighbouring item may own as well.
//!
//! The owners are drawn four more times, shifted by one sample left, right, up and down. If the truth allows the
//! shifted owner and that is another item, the sample is contested. This finds edges, but not coplanar items.

use enfilade::laws::{OwnerPicture, Truth};
use enfilade::{Canvas, Owner, Passage, PassageId, Span};

/// A canvas that stores the owners, unshifted and shifted by one sample in four directions.
pub(super) struct Neighbours {
    size: [u32; 2],
    pictures: [OwnerPicture; 5],
}

const SHIFTS: [[i32; 2]; 5] = [[0, 0], [-1, 0], [1, 0], [0, -1], [0, 1]];

impl Neighbours {
    pub(super) fn new(size: [u32; 2]) -> Neighbours {
        Neighbours {
            size,
            pictures: SHIFTS.map(|_| OwnerPicture::new(size)),
        }
    }

    /// Returns the unshifted owners.
    pub(super) fn owners(&self) -> &OwnerPicture {
        &self.pictures[0]
    }

    /// Returns the samples (x, y) at which the truth also allows the item of a neighbour, each once.
    pub(super) fn contested(&self, truth: &Truth) -> Vec<[u32; 2]> {
        let [width, height] = self.size;
        let item = |picture: &OwnerPicture, sample| picture.owner(sample).and_then(Owner::item);
        let mut contested = Vec::new();
        for moved in &self.pictures[1..] {
            let mut wrong = truth.different(moved).peekable();
            for sample in (0..height).flat_map(|y| (0..width).map(move |x| [x, y])) {
                // Both run row by row.
                let allowed = wrong.next_if_eq(&sample).is_none();
                if allowed && item(moved, sample) != item(self.owners(), sample) {
                    contested.push(sample);
                }
            }
        }
        contested.sort_unstable();
        contested.dedup();
        contested
    }
}

impl Canvas for Neighbours {
    fn enter(&mut self, id: PassageId, passage: &Passage) {
        self.pictures
            .iter_mut()
            .for_each(|picture| picture.enter(id, passage));
    }

    fn row(&mut self, y: u16, spans: &[Span]) {
        let [width, height] = self.size.map(|side| side as i32);
        for (picture, [right, down]) in self.pictures.iter_mut().zip(SHIFTS) {
            let y = i32::from(y) + down;
            if !(0..height).contains(&y) {
                continue;
            }
            let column = |x: u16| (i32::from(x) + right).clamp(0, width) as u16;
            let moved: Vec<Span> = spans
                .iter()
                .map(|span| Span {
                    x0: column(span.x0),
                    x1: column(span.x1),
                    ..*span
                })
                .collect();
            picture.row(y as u16, &moved);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use enfilade::laws::Reference;
    use enfilade::{
        GeometryBuilder, Limits, Material, MaterialId, Mesh, Method, SceneBuilder, Transform, View, Viewer,
    };

    #[test]
    fn an_edge_through_the_middle_of_samples_is_contested() {
        let mut geometry = GeometryBuilder::new([Material::opaque([1.0; 3])]);
        let corners = [
            [0.0, -9.0, 0.0],
            [9.0, -9.0, 0.0],
            [9.0, 9.0, 0.0],
            [0.0, 9.0, 0.0],
        ];
        let mesh = Mesh::triangles(&corners, &[0, 1, 2, 0, 2, 3], MaterialId(0)).expect("a square");
        let mesh = geometry.mesh(mesh);
        geometry.item("right half", mesh, Transform::IDENTITY);
        let mut scene = SceneBuilder::new();
        scene.add("plane", geometry.build().expect("sound"), Method::ZBuffer);
        let scene = scene.build().expect("sound");
        // With an odd width, the middle of the middle column is on the square's left edge.
        let view = View::new([0.0, 0.0, 3.0], [0.0; 3], [15, 9]).expect("a valid view");
        let view = view.at_sample(View::GENERIC_OFFSET.map(|offset| -offset as f32));
        let view = view.expect("a position in the pixel");
        let mut canvas = Neighbours::new(view.size());
        let mut viewer = Viewer::new();
        viewer.draw(&scene, &view, &mut canvas);
        let limits: Limits = viewer.options.limits;
        let truth = Reference::new(&scene).see(&scene, &view, &limits);
        let verdict = truth.check(viewer.visible(), Some(canvas.owners()));
        assert_eq!((verdict.pixels_contested, verdict.pixels_different), (9, 0));
        assert_eq!(
            canvas.contested(&truth),
            (0..9).map(|y| [7, y]).collect::<Vec<_>>()
        );
    }
}
