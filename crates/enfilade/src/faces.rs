//! Batches of faces: orders emit them, covers rasterize or test them.

use crate::geom::Step;
use crate::geometry::{Alpha, Geometry};
use crate::ids::{ItemIndex, OpeningId};
use crate::mesh::Cluster;
use crate::view::opening_view::OpeningView;
use crate::view::passage::Passage;
use crate::view::screen_map::ScreenMap;
use glam::DVec3;

/// A batch of faces with one mesh, one transform and one material, as plain arrays.
#[doc(alias = "triangles")]
#[doc(alias = "polygons")]
#[derive(Clone, Copy, Debug)]
pub struct Faces<'a> {
    /// The cluster or opening that the faces belong to.
    pub source: FaceSource,
    /// Number of the first face among all faces of the sector; the faces are numbered consecutively.
    pub(crate) first_owner: u32,
    /// Number of the item's first face: subtract it from a face's number to get the index in the item's mesh.
    pub(crate) item_start: u32,
    /// The positions that the faces use, in object space.
    pub(crate) positions: &'a [[f32; 3]],
    /// Subtract this from a corner to get its index in `positions`.
    pub(crate) first_position: u32,
    /// The corner indices of all faces.
    pub(crate) corners: &'a [u32],
    /// Start of each face in `corners`, relative to `starts[0]`, and the end; `None` for triangles.
    pub(crate) starts: Option<&'a [u32]>,
    /// For each corner, the face of the batch across the edge that starts there, or [`NONE`](crate::mesh::NONE); empty
    /// if unknown.
    pub(crate) neighbours: &'a [u8],
    /// Transform from the space of the positions to (X, Y, W).
    pub(crate) screen_from_local: &'a ScreenMap,
    /// Whether the item's transform is mirrored (negative determinant), which flips the winding test but not the front.
    /// A singular transform is not mirrored.
    pub(crate) mirrored: bool,
    /// Whether the faces are visible from both sides (no back-face culling).
    pub(crate) double_sided: bool,
    /// Alpha mode. Opaque faces are occluders; others are not inserted into covers.
    pub(crate) alpha: Alpha,
    /// Whether these faces may be selected as occluders.
    pub(crate) can_occlude: bool,
    /// Clip planes: only the part on the inner side of all of them counts. Faces split by a tree keep their outlines
    /// and planes.
    pub(crate) cuts: &'a [Cut],
}

/// A plane that clips faces to n · (X, Y, W) ≥ d. The other half uses −n and −d, so every sample belongs to exactly one
/// half.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut {
    pub(crate) normal: DVec3,
    pub(crate) distance: f64,
}

/// The source of a batch of faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceSource {
    /// A cluster of an item, by its index in [`Mesh::clusters`](crate::Mesh::clusters).
    Item(ItemIndex, u32),
    /// An opening: one face, not clipped at the near plane.
    Opening(OpeningId),
}

impl<'a> Faces<'a> {
    /// Returns the faces of a cluster of an item.
    pub(crate) fn of_cluster(
        geometry: &'a Geometry,
        item: ItemIndex,
        number: u32,
        screen_from_local: &'a ScreenMap,
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

    /// Returns a batch of opaque, one-sided triangles without an item.
    pub(crate) fn of_triangles(
        positions: &'a [[f32; 3]],
        corners: &'a [u32],
        screen_from_local: &'a ScreenMap,
    ) -> Faces<'a> {
        Faces {
            source: FaceSource::Item(ItemIndex(0), 0),
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

    /// Returns the sides of a box in place of a cluster without faces; `corners` as [`Aabb::corners`](crate::Aabb).
    pub(crate) fn of_sides(&self, corners: &'a [[f32; 3]; 8]) -> Faces<'a> {
        const SIDES: [u32; 36] = [
            0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5,
            7, 4, 7, 6,
        ];
        Faces {
            positions: corners,
            first_position: 0,
            corners: &SIDES,
            starts: None,
            neighbours: &[],
            ..*self
        }
    }

    /// Returns one face of an item, clipped by `cuts`.
    #[cfg(feature = "classic")]
    pub(crate) fn of_face(
        geometry: &'a Geometry,
        item: ItemIndex,
        face: u32,
        screen_from_local: &'a ScreenMap,
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

    /// Returns an opening as a face.
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

    /// Calls `each` with each opening that may be in view, as a face. Culls openings by a tree over their boxes.
    pub(crate) fn of_openings(geometry: &Geometry, passage: &Passage, mut each: impl FnMut(&Faces)) {
        if passage.flat || geometry.openings().is_empty() {
            return;
        }
        geometry
            .opening_tree()
            .walk(passage.viewpoint(), |step| match step {
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

    /// Returns the sign of the determinant of a front-facing face's first three corners as (X, Y, W); 0 for
    /// double-sided faces.
    ///
    /// Computed from the two transforms separately: the determinant of a singular product has a random sign from
    /// rounding.
    #[inline(always)]
    pub(crate) fn front(&self, passage: &Passage) -> f64 {
        let turned = self.mirrored != passage.screen_from_sector.is_mirrored();
        match (self.double_sided, turned) {
            (true, _) => 0.0,
            (false, true) => 1.0,
            (false, false) => -1.0,
        }
    }

    /// Returns the same faces clipped by `cuts`.
    #[cfg(feature = "classic")]
    pub(crate) fn cut(self, cuts: &'a [Cut]) -> Faces<'a> {
        Faces { cuts, ..self }
    }

    /// Returns the number of faces.
    pub(crate) fn count(&self) -> usize {
        self.starts
            .map_or(self.corners.len() / 3, |starts| starts.len() - 1)
    }

    /// Whether the batch has a single face. If so, only the face's own corners are worth transforming.
    #[inline(always)]
    pub(crate) fn is_lone(&self) -> bool {
        self.count() == 1
    }

    /// Calls `each` with a face's number and its corners' indices in `positions`.
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
