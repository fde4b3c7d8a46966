//! Batches of faces, as orders hand them out and covers take them.

use crate::geom::Step;
use crate::geometry::{Alpha, Geometry, ItemId, OpeningId};
use crate::mesh::Cluster;
use crate::opening_view::OpeningView;
use crate::passage::Passage;
use glam::{DAffine3, DVec3};

/// Faces of one mesh, one transform and one material, as plain arrays.
#[derive(Clone, Copy, Debug)]
pub struct Faces<'a> {
    /// What they belong to.
    pub source: FaceSource,
    /// The number of the first face among all faces of the sector; the others follow.
    pub(crate) first_owner: u32,
    /// The number of the first face of the whole item: what to subtract from a number to get the item's face.
    pub(crate) item_start: u32,
    /// The positions that the faces use, in their own space.
    pub(crate) positions: &'a [[f32; 3]],
    /// What to subtract from a corner to get its place in `positions`.
    pub(crate) first_position: u32,
    /// The corners of all faces.
    pub(crate) corners: &'a [u32],
    /// Where each face's corners begin, counted from `starts[0]`, and the end; `None`: every three.
    pub(crate) starts: Option<&'a [u32]>,
    /// For each corner, the face of the batch across the edge that begins there, or [`NONE`](crate::mesh::NONE); empty
    /// where it is not known.
    pub(crate) neighbours: &'a [u8],
    /// From the space of the positions to (X, Y, W).
    pub(crate) screen_from_local: &'a DAffine3,
    /// Does the item's place turn left hands into right ones? The front stays the front. A place that flattens does
    /// not.
    pub(crate) mirrored: bool,
    /// Seen from both sides?
    pub(crate) double_sided: bool,
    /// Opaque faces hide; others are kept out of every cover.
    pub(crate) alpha: Alpha,
    /// Do they hide also where a method chooses what does?
    pub(crate) can_occlude: bool,
    /// Only what is on the inner side of all of these is meant: faces cut by a tree keep their outlines and planes.
    pub(crate) cuts: &'a [Cut],
}

/// A plane that cuts faces: what lies at n · (X, Y, W) ≥ d is left. The other half is cut by −n and −d, so that every
/// sample belongs to exactly one of the two.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut {
    pub(crate) normal: DVec3,
    pub(crate) distance: f64,
}

/// What faces belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceSource {
    /// A cluster of an item, by its place in the mesh's clusters.
    Item(ItemId, u32),
    /// An opening: one face, seen however near it is.
    Opening(OpeningId),
}

impl<'a> Faces<'a> {
    /// A cluster of an item.
    pub(crate) fn of_cluster(
        geometry: &'a Geometry,
        item: ItemId,
        number: u32,
        screen_from_local: &'a DAffine3,
    ) -> Faces<'a> {
        let mesh = geometry.mesh_of(item);
        let Cluster { faces, positions, .. } = &mesh.clusters()[number as usize];
        let material = geometry.material_of(item, &mesh.clusters()[number as usize]);
        let (corners, starts) = mesh.runs(faces.clone());
        Faces {
            source: FaceSource::Item(item, number),
            first_owner: geometry.first_face(item) + faces.start,
            item_start: geometry.first_face(item),
            positions: &mesh.positions()[positions.start as usize..positions.end as usize],
            first_position: positions.start,
            corners,
            starts,
            neighbours: mesh.neighbours(faces.clone()),
            screen_from_local,
            mirrored: geometry.item(item).transform().mirrors(),
            double_sided: material.double_sided,
            alpha: material.alpha,
            can_occlude: material.can_occlude(),
            cuts: &[],
        }
    }

    /// Opaque triangles seen from their front, of no item.
    pub(crate) fn of_triangles(
        positions: &'a [[f32; 3]],
        corners: &'a [u32],
        screen_from_local: &'a DAffine3,
    ) -> Faces<'a> {
        Faces {
            source: FaceSource::Item(ItemId(0), 0),
            first_owner: 0,
            item_start: 0,
            positions,
            first_position: 0,
            corners,
            starts: None,
            neighbours: &[],
            screen_from_local,
            mirrored: false,
            double_sided: false,
            alpha: Alpha::Opaque,
            can_occlude: true,
            cuts: &[],
        }
    }

    /// One face of an item, or what `cuts` leave of it.
    pub(crate) fn of_face(
        geometry: &'a Geometry,
        item: ItemId,
        face: u32,
        screen_from_local: &'a DAffine3,
        cuts: &'a [Cut],
    ) -> Faces<'a> {
        let mesh = geometry.mesh_of(item);
        let number = mesh.cluster_of(face) as u32;
        let (corners, starts) = mesh.runs(face..face + 1);
        Faces {
            first_owner: geometry.first_face(item) + face,
            corners,
            starts,
            neighbours: &[],
            cuts,
            ..Faces::of_cluster(geometry, item, number, screen_from_local)
        }
    }

    /// An opening, as a face.
    pub(crate) fn of_opening(
        geometry: &'a Geometry,
        opening: OpeningId,
        view: &'a OpeningView<'a>,
    ) -> Faces<'a> {
        let (corners, ends) = if view.holds_eye {
            OpeningView::SQUARE_FACE
        } else {
            geometry.outline_face(opening)
        };
        Faces {
            source: FaceSource::Opening(opening),
            first_owner: geometry.opening_number(opening),
            item_start: geometry.opening_number(opening),
            positions: view.positions,
            first_position: 0,
            corners,
            starts: Some(ends),
            neighbours: &[],
            screen_from_local: &view.screen_from_local,
            mirrored: false,
            double_sided: false,
            alpha: Alpha::Opaque,
            can_occlude: false,
            cuts: &[],
        }
    }

    /// Hands out the openings that may be in view, each as a face: of many, those of the parts of the sector that are.
    pub(crate) fn of_openings(geometry: &Geometry, passage: &Passage, mut each: impl FnMut(&Faces)) {
        if passage.flat || geometry.openings().is_empty() {
            return;
        }
        geometry.opening_tree().walk(passage.eye(), |step| match step {
            Step::Node(bounds) => passage.region_around_openings(bounds).is_some(),
            Step::Thing(opening) => {
                let opening = OpeningId(opening as u16);
                if let Some(view) = passage.view_of(geometry, opening) {
                    each(&Faces::of_opening(geometry, opening, &view));
                }
                true
            }
        });
    }

    /// The sign that the determinant of three corners as (X, Y, W) has where a face is seen from its front; 0 where faces
    /// are seen from both sides.
    ///
    /// Told from the two maps apart, for the product of a flattening one has none but by rounding.
    #[inline(always)]
    pub(crate) fn front(&self, passage: &Passage) -> f64 {
        let turned = self.mirrored != (passage.screen_from_sector.matrix3.determinant() < 0.0);
        match (self.double_sided, turned) {
            (true, _) => 0.0,
            (false, true) => 1.0,
            (false, false) => -1.0,
        }
    }

    /// The same faces, but only what `cuts` leave of them.
    pub(crate) fn cut(self, cuts: &'a [Cut]) -> Faces<'a> {
        Faces { cuts, ..self }
    }

    /// How many faces there are.
    pub(crate) fn count(&self) -> usize {
        self.starts
            .map_or(self.corners.len() / 3, |starts| starts.len() - 1)
    }

    /// Is it one face alone? Then only its own corners are worth a look.
    #[inline(always)]
    pub(crate) fn is_lone(&self) -> bool {
        self.count() == 1
    }

    /// Calls `each` with a face's number and its corners' places in `positions`.
    #[inline(always)]
    pub(crate) fn for_each(&self, mut each: impl FnMut(u32, &[u32])) {
        match self.starts {
            None => {
                for (face, corners) in self.corners.chunks_exact(3).enumerate() {
                    each(self.first_owner + face as u32, corners);
                }
            }
            Some(starts) => {
                for (face, ends) in starts.windows(2).enumerate() {
                    let run = (ends[0] - starts[0]) as usize..(ends[1] - starts[0]) as usize;
                    each(self.first_owner + face as u32, &self.corners[run]);
                }
            }
        }
    }
}
