//! BSP tree over the faces of a sector: exact front-to-back or back-to-front order for any eye position, without
//! sorting.
//!
//! Each node's splitting plane divides the remaining space. Faces on the eye's side can occlude faces on the other
//! side, never the reverse. A face that a plane cuts is emitted in pieces: the uncut face plus the planes that cut it,
//! so that the pieces together cover exactly the samples of the face.
//! Source: Fuchs, Kedem, Naylor, On Visible Surface Generation by A Priori Tree Structures, SIGGRAPH 1980;
//!     Painter's algorithm and binary space partitioning (a thesis in Russian, author unknown), sections 1.2 and 2.3.
//! Cost: building O(n log n), more if many faces are cut; a traversal O(pieces in view).
//! Guarantees an exact order, back to front or front to back; geometry must be static.

use super::beside_sorted::{emit_non_opaque, emit_openings_at_eye};
use super::sealed::Sealed;
use super::{FarToNear, NearToFar, Order, Visit};
use crate::faces::{Cut, Faces};
use crate::geom::{Aabb, BspLink, BspOptions, BspStep, BspTree, Piece, Polygons};
use crate::geometry::{Alpha, Geometry, Owner, Owners};
use crate::ids::{ItemIndex, OpeningId};
use crate::sector::BuildStats;
use crate::unsuited::Unsuited;
use crate::view::passage::Passage;
use crate::view::region::{Region, Visibility};
use crate::view::screen_map::ScreenMap;
use glam::DVec3;
use std::marker::PhantomData;
use std::sync::Arc;

/// BSP tree over the opaque faces and the openings of a geometry, traversed in the direction `D`: [`FarToNear`] (back
/// to front) or [`NearToFar`] (front to back).
pub struct Bsp<D> {
    shared: Arc<SharedTree>,
    direction: PhantomData<fn() -> D>,
}

/// The tree, shared by both directions.
struct SharedTree {
    tree: BspTree,
    /// For each polygon of the tree, the number of its face or opening in the geometry.
    numbers: Vec<u32>,
    /// Items with faces that are not opaque.
    non_opaque: Vec<ItemIndex>,
}

/// Direction in which a BSP tree is traversed. Sealed, like [`Order`].
pub trait Direction: Sealed + Send + Sync + 'static {
    /// `true` for front to back, `false` for back to front.
    const NEAR_FIRST: bool;
}

impl Direction for FarToNear {
    const NEAR_FIRST: bool = false;
}

impl Direction for NearToFar {
    const NEAR_FIRST: bool = true;
}

/// Scratch memory of a traversal.
#[derive(Default)]
pub struct BspScratch {
    stack: Vec<BspLink>,
    screen_from_items: Vec<ScreenMap>,
    cuts: Vec<Cut>,
}

/// Estimated bytes per face while building: its corners twice, and the tree.
const BYTES_PER_FACE: u64 = 400;

impl<D: Direction> Bsp<D> {
    /// Builds the tree with custom weights, candidate count and memory limit. Takes O(n log n) for typical input.
    ///
    /// If [`BspOptions::limit_bytes`] is reached the tree stays incomplete ([`BspTree::is_complete`]) and the order is
    /// not exact; [`Order::build`] returns an error instead.
    pub fn with_options(geometry: &Geometry, options: &BspOptions) -> Bsp<D> {
        Bsp::over(Arc::new(SharedTree::build(geometry, options)))
    }

    fn over(shared: Arc<SharedTree>) -> Bsp<D> {
        Bsp {
            shared,
            direction: PhantomData,
        }
    }

    /// Emits the piece of a face or an opening that its cuts leave.
    fn emit(
        &self,
        piece: &Piece,
        walk: &Walk,
        cuts: &mut Vec<Cut>,
        last: &mut Option<Owner>,
        visit: &mut impl Visit,
    ) {
        let Walk {
            geometry, passage, ..
        } = *walk;
        cuts.clear();
        cuts.extend(self.shared.tree.cuts(piece).map(|plane| walk.on_screen(plane)));
        let owner = geometry.owner(self.shared.numbers[piece.polygon as usize], *last);
        *last = Some(owner);
        match owner {
            Owner::Face(item, face) => {
                let screen_from_item = &walk.screen_from_items[item.0 as usize];
                visit.faces(&Faces::of_face(geometry, item, face, screen_from_item, cuts));
            }
            Owner::Opening(_) if passage.flat => {}
            Owner::Opening(opening) => {
                // An opening that touches the eye is emitted separately, first or last: the tree may have the eye on
                // its back side.
                if let Some(view) = passage
                    .view_of(geometry, opening)
                    .filter(|view| !view.touches_eye)
                {
                    visit.faces(&Faces::of_opening(geometry, opening, &view).cut(cuts));
                }
            }
        }
    }
}

impl SharedTree {
    fn build(geometry: &Geometry, options: &BspOptions) -> SharedTree {
        let mut polygons = Polygons::default();
        let (mut numbers, mut non_opaque) = (Vec::new(), Vec::new());
        for item in (0..geometry.items().len() as u32).map(ItemIndex) {
            let mesh = geometry.mesh_of(item);
            let sector_from_item = geometry.item(item).transform();
            for cluster in mesh.clusters() {
                if geometry.material_of(item, cluster).alpha != Alpha::Opaque {
                    if non_opaque.last() != Some(&item) {
                        non_opaque.push(item);
                    }
                    continue;
                }
                for face in cluster.faces.clone() {
                    let corners = mesh
                        .face(face)
                        .iter()
                        .map(|&index| mesh.positions()[index as usize]);
                    add(
                        &mut polygons,
                        corners.map(|corner| sector_from_item.point_f64(corner)),
                    );
                    numbers.push(geometry.first_face(item) + face);
                }
            }
        }
        for (opening, hole) in geometry.openings().iter().enumerate() {
            add(
                &mut polygons,
                hole.outline.corners().iter().map(|corner| corner.map(f64::from)),
            );
            numbers.push(geometry.opening_number(OpeningId(opening as u16)));
        }
        polygons.starts.push(polygons.corners.len() as u32);
        SharedTree {
            tree: BspTree::build(&polygons, options),
            numbers,
            non_opaque,
        }
    }
}

fn add(polygons: &mut Polygons, corners: impl Iterator<Item = [f64; 3]>) {
    polygons.starts.push(polygons.corners.len() as u32);
    polygons.corners.extend(corners);
}

/// State of one traversal.
#[derive(Clone, Copy)]
struct Walk<'a> {
    geometry: &'a Geometry,
    passage: &'a Passage,
    screen_from_items: &'a [ScreenMap],
}

impl Walk<'_> {
    /// Transforms a plane n · p ≥ d from sector space to (X, Y, W) space.
    fn on_screen(&self, [x, y, z, distance]: [f64; 4]) -> Cut {
        let half_space = self
            .passage
            .screen_from_sector
            .half_space(DVec3::new(x, y, z), distance);
        let (normal, distance) = half_space;
        Cut { normal, distance }
    }
}

impl<D: Direction> Order for Bsp<D> {
    type Gives = D;
    type Scratch = BspScratch;

    const NAME: &'static str = "Bsp";
    const SPLITS_FACES: bool = true;
    const INCLUDES_OPENINGS: bool = true;

    fn build(geometry: &Geometry, limit_bytes: u64) -> Result<Bsp<D>, Unsuited> {
        let options = BspOptions {
            limit_bytes,
            ..BspOptions::default()
        };
        let shared = geometry.share(|| SharedTree::build(geometry, &options));
        let complete = shared.tree.is_complete();
        complete
            .then(|| Bsp::over(shared))
            .ok_or_else(|| Unsuited::exceeds(limit_bytes))
    }

    fn needs_bytes(geometry: &Geometry) -> u64 {
        geometry.face_count() * BYTES_PER_FACE
    }

    fn bytes(&self) -> u64 {
        self.shared.tree.bytes()
            + (size_of_val(&*self.shared.numbers) + size_of_val(&*self.shared.non_opaque)) as u64
    }

    fn build_stats(&self, geometry: &Geometry) -> BuildStats {
        let whole =
            geometry.face_count() + geometry.openings().len() as u64 - self.shared.numbers.len() as u64;
        BuildStats {
            faces: self.shared.tree.pieces() + whole,
            splits: self.shared.tree.splits(),
            depth: self.shared.tree.depth(),
        }
    }

    fn visit(
        &self,
        geometry: &Geometry,
        passage: &Passage,
        scratch: &mut BspScratch,
        visit: &mut impl Visit,
    ) {
        let BspScratch {
            stack,
            screen_from_items,
            cuts,
        } = scratch;
        screen_from_items.clear();
        screen_from_items.extend(
            geometry
                .items()
                .iter()
                .map(|item| passage.screen_from(&item.transform())),
        );
        for &item in &self.shared.non_opaque {
            emit_non_opaque(geometry, passage, item, visit);
        }
        let walk = Walk {
            geometry,
            passage,
            screen_from_items,
        };
        if D::NEAR_FIRST {
            emit_openings_at_eye(geometry, passage, visit);
        }
        // The near plane does not clip openings, and any node may contain one.
        let has_openings = !passage.flat && !geometry.openings().is_empty();
        let region = |bounds: &Aabb| {
            if has_openings {
                passage.region_around_openings(bounds)
            } else {
                Region::of(passage, &passage.screen_from_sector, bounds)
            }
        };
        let mut last = None;
        self.shared.tree.walk(
            passage.viewpoint(),
            D::NEAR_FIRST,
            stack,
            &mut |step| match step {
                BspStep::Node(bounds) => {
                    region(bounds).is_some_and(|region| visit.enter(&region) != Visibility::Hidden)
                }
                BspStep::Coplanar(pieces) => {
                    // Among coplanar faces the one with the lowest number is visible: it comes first front to back, and
                    // last back to front.
                    if D::NEAR_FIRST {
                        pieces
                            .iter()
                            .for_each(|piece| self.emit(piece, &walk, cuts, &mut last, visit));
                    } else {
                        pieces
                            .iter()
                            .rev()
                            .for_each(|piece| self.emit(piece, &walk, cuts, &mut last, visit));
                    }
                    true
                }
            },
        );
        if !D::NEAR_FIRST {
            emit_openings_at_eye(geometry, passage, visit);
        }
    }
}
