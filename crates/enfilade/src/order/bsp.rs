//! BSP tree: faces in an order that is right from every place, without sorting.
//!
//! Every node's plane parts what is left of its space; whatever is on the eye's side of it can hide what is on the
//! other, never the reverse. Faces that a plane cuts are handed out in pieces: the born face, and the planes that cut
//! it, so that the pieces together own just the samples that the face does.
//! Source: Fuchs, Kedem, Naylor, On Visible Surface Generation by A Priori Tree Structures, SIGGRAPH 1980; the thesis
//!     Painter's Algorithm and Binary Space Partitioning, sections 1.2 and 2.3.
//! Cost: building O(n log n) and more where much is cut; a walk O(pieces in view).
//! Gives an exact order, far to near or near to far; geometry must not move.

use super::items::{hand_out_openings_at_eye, hand_out_see_through};
use super::{FarToNear, NearToFar, Order, Refusal, Visit};
use crate::faces::{Cut, Faces};
use crate::geom::{Aabb, BspLink, BspOptions, BspStep, BspTree, Piece, Polygons};
use crate::geometry::{Alpha, Geometry, ItemId, OpeningId, Owner, Owners};
use crate::passage::Passage;
use crate::region::{Region, Visibility};
use crate::sector::BuildStats;
use glam::{DAffine3, DMat3, DVec3};
use std::marker::PhantomData;
use std::sync::Arc;

/// A tree of planes over the opaque faces and the openings of a geometry; walked in the direction `D`, [`FarToNear`] or
/// [`NearToFar`].
pub struct Bsp<D> {
    sorted: Arc<Sorted>,
    direction: PhantomData<fn() -> D>,
}

/// What both directions share.
struct Sorted {
    tree: BspTree,
    /// The face or opening that each polygon of the tree is, by its number in the geometry.
    numbers: Vec<u32>,
    /// Items with faces that do not hide.
    see_through: Vec<ItemId>,
}

/// Which way a tree is walked.
pub trait Direction: Send + Sync + 'static {
    /// Does the nearest come first?
    const NEAR_FIRST: bool;
}

impl Direction for FarToNear {
    const NEAR_FIRST: bool = false;
}

impl Direction for NearToFar {
    const NEAR_FIRST: bool = true;
}

/// What a walk needs.
#[derive(Default)]
pub struct BspScratch {
    stack: Vec<BspLink>,
    screen_from_items: Vec<DAffine3>,
    cuts: Vec<Cut>,
}

/// Memory while building, for each face: its corners twice, and the tree.
const BYTES_PER_FACE: u64 = 400;

impl<D: Direction> Bsp<D> {
    /// Builds the tree with weights and numbers of candidates of one's own.
    pub fn with_options(geometry: &Geometry, options: &BspOptions) -> Bsp<D> {
        Bsp::over(Arc::new(Sorted::build(geometry, options)))
    }

    fn over(sorted: Arc<Sorted>) -> Bsp<D> {
        Bsp {
            sorted,
            direction: PhantomData,
        }
    }

    /// Hands out what its cuts leave of a face or an opening.
    fn hand_out(
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
        cuts.extend(self.sorted.tree.cuts(piece).map(|plane| walk.on_screen(plane)));
        let owner = geometry.owner(self.sorted.numbers[piece.polygon as usize], *last);
        *last = Some(owner);
        match owner {
            Owner::Face(item, face) => {
                let screen_from_item = &walk.screen_from_items[item.0 as usize];
                visit.faces(&Faces::of_face(geometry, item, face, screen_from_item, cuts));
            }
            Owner::Opening(_) if passage.flat => {}
            Owner::Opening(opening) => {
                // One that touches the eye comes before, or over, everything: the tree may have the eye on its back.
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

impl Sorted {
    fn build(geometry: &Geometry, options: &BspOptions) -> Sorted {
        let mut polygons = Polygons::default();
        let (mut numbers, mut see_through) = (Vec::new(), Vec::new());
        for item in (0..geometry.items().len() as u32).map(ItemId) {
            let mesh = geometry.mesh_of(item);
            let sector_from_item = geometry.item(item).transform();
            for cluster in mesh.clusters() {
                if geometry.material_of(item, cluster).alpha != Alpha::Opaque {
                    if see_through.last() != Some(&item) {
                        see_through.push(item);
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
        Sorted {
            tree: BspTree::build(&polygons, options),
            numbers,
            see_through,
        }
    }
}

fn add(polygons: &mut Polygons, corners: impl Iterator<Item = [f64; 3]>) {
    polygons.starts.push(polygons.corners.len() as u32);
    polygons.corners.extend(corners);
}

/// What holds for all of a walk.
#[derive(Clone, Copy)]
struct Walk<'a> {
    geometry: &'a Geometry,
    passage: &'a Passage,
    screen_from_items: &'a [DAffine3],
    /// Takes the normals of planes from the space of the sector to that of (X, Y, W).
    normals: DMat3,
}

impl Walk<'_> {
    /// A plane n · p ≥ d of the sector as one of (X, Y, W).
    fn on_screen(&self, [x, y, z, distance]: [f64; 4]) -> Cut {
        let normal = self.normals * DVec3::new(x, y, z);
        Cut {
            normal,
            distance: distance + normal.dot(self.passage.screen_from_sector.translation),
        }
    }
}

impl<D: Direction> Order for Bsp<D> {
    type Gives = D;
    type Scratch = BspScratch;

    fn build(geometry: &Geometry, limit_bytes: u64) -> Result<Bsp<D>, Refusal> {
        let options = BspOptions {
            limit_bytes,
            ..BspOptions::default()
        };
        let sorted = geometry.share(|| Sorted::build(geometry, &options));
        let complete = sorted.tree.is_complete();
        complete.then(|| Bsp::over(sorted)).ok_or(Refusal::TooLarge)
    }

    fn needs_bytes(geometry: &Geometry) -> u64 {
        geometry.face_count() * BYTES_PER_FACE
    }

    fn bytes(&self) -> u64 {
        self.sorted.tree.bytes()
            + (size_of_val(&*self.sorted.numbers) + size_of_val(&*self.sorted.see_through)) as u64
    }

    fn build_stats(&self, geometry: &Geometry) -> BuildStats {
        let whole =
            geometry.face_count() + geometry.openings().len() as u64 - self.sorted.numbers.len() as u64;
        BuildStats {
            faces: self.sorted.tree.pieces() + whole,
            splits: self.sorted.tree.splits(),
            depth: self.sorted.tree.depth(),
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
        for &item in &self.sorted.see_through {
            hand_out_see_through(geometry, passage, item, visit);
        }
        let walk = Walk {
            geometry,
            passage,
            screen_from_items,
            normals: passage.screen_from_sector.matrix3.inverse().transpose(),
        };
        if D::NEAR_FIRST {
            hand_out_openings_at_eye(geometry, passage, visit);
        }
        // Openings have no near limit, and any node may hold one.
        let has_openings = !passage.flat && !geometry.openings().is_empty();
        let region = |bounds: &Aabb| {
            if has_openings {
                passage.region_around_openings(bounds)
            } else {
                Region::of(passage, &passage.screen_from_sector, bounds)
            }
        };
        let mut last = None;
        self.sorted
            .tree
            .walk(passage.eye(), D::NEAR_FIRST, stack, &mut |step| match step {
                BspStep::Node(bounds) => {
                    region(bounds).is_some_and(|region| visit.enter(&region) != Visibility::Hidden)
                }
                BspStep::Coplanar(pieces) => {
                    // Of faces in one plane the lowest is seen: it comes first near to far, and last far to near.
                    if D::NEAR_FIRST {
                        pieces
                            .iter()
                            .for_each(|piece| self.hand_out(piece, &walk, cuts, &mut last, visit));
                    } else {
                        pieces
                            .iter()
                            .rev()
                            .for_each(|piece| self.hand_out(piece, &walk, cuts, &mut last, visit));
                    }
                    true
                }
            });
        if !D::NEAR_FIRST {
            hand_out_openings_at_eye(geometry, passage, visit);
        }
    }
}
