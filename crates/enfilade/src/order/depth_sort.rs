//! Depth sort (painter's algorithm): faces sorted back to front by one distance each.
//!
//! Nothing is built, so geometry may change freely; each look sorts from scratch.
//! Source: the painter's algorithm; its two keys, nearest corner and mean distance, from Painter's algorithm and binary
//!     space partitioning (a thesis in Russian, author unknown), section 1.1.
//! Cost: O(faces in view), by a radix sort of flat arrays.
//! Approximate: one distance cannot order long faces beside small ones, cycles, or intersecting faces; the scenes
//! `@overlap`, `@cycle` and `@crossing-triangles` show it. Correct for separate objects and faces of similar size.

use super::beside_sorted::{emit_non_opaque, emit_opening};
use super::sealed::Sealed;
use super::{FarToNear, Order, Visit};
use crate::faces::Faces;
use crate::geometry::{Alpha, Geometry, MovedItem};
use crate::ids::{ItemIndex, OpeningId};
use crate::traversal::may_be_visible;
use crate::unsuited::Unsuited;
use crate::view::passage::Passage;
use crate::view::screen_map::ScreenMap;
use std::marker::PhantomData;

/// Faces sorted back to front by the key `K`: [`Min`] or [`Mean`]. Needs no build; a traversal takes O(faces in view).
pub struct DepthSort<K>(PhantomData<fn() -> K>);

/// Sort key of a face, from the distances of its corners along the viewing direction. Sealed, like [`Order`].
pub trait SortKey: Sealed + Send + Sync + 'static {
    /// Returns the key of a face; a larger key is drawn earlier.
    fn key(distances: impl ExactSizeIterator<Item = f32>) -> f32;
}

/// Sorts by the distance of the nearest corner.
pub struct Min;
/// Sorts by the mean distance of all corners.
pub struct Mean;

impl SortKey for Min {
    #[inline(always)]
    fn key(distances: impl ExactSizeIterator<Item = f32>) -> f32 {
        distances.fold(f32::INFINITY, f32::min)
    }
}

impl SortKey for Mean {
    #[inline(always)]
    fn key(distances: impl ExactSizeIterator<Item = f32>) -> f32 {
        let count = distances.len() as f32;
        distances.sum::<f32>() / count
    }
}

/// Scratch memory: the faces of a traversal and the buffers that sort them.
#[derive(Default)]
pub struct SortBuffers {
    items: Vec<(ItemIndex, ScreenMap)>,
    faces: Vec<FaceKey>,
    spare: Vec<FaceKey>,
    distances: Vec<f32>,
}

/// A face and its sort key.
#[derive(Clone, Copy, Default)]
struct FaceKey {
    key: u32,
    /// Index of the item in [`SortBuffers::items`]; an index past the end marks an opening.
    item: u32,
    face: u32,
}

impl<K: SortKey> Order for DepthSort<K> {
    type Gives = FarToNear;
    type Scratch = SortBuffers;

    const NAME: &'static str = "DepthSort";
    // By one depth per face, which is wrong where faces overlap in depth.
    const KEEPS_ORDER: bool = false;

    fn build(_geometry: &Geometry, _limit_bytes: u64) -> Result<DepthSort<K>, Unsuited> {
        Ok(DepthSort(PhantomData))
    }

    fn needs_bytes(geometry: &Geometry) -> u64 {
        2 * geometry.triangle_count() * size_of::<FaceKey>() as u64
    }

    fn bytes(&self) -> u64 {
        0
    }

    fn follow(&mut self, _geometry: &Geometry, _moved: &[MovedItem], _touched: &mut Vec<u32>) -> bool {
        // Each look sorts from scratch.
        true
    }

    fn visit(
        &self,
        geometry: &Geometry,
        passage: &Passage,
        sorting: &mut SortBuffers,
        visit: &mut impl Visit,
    ) {
        sorting.items.clear();
        sorting.faces.clear();
        for item in 0..geometry.items().len() as u32 {
            emit_non_opaque(geometry, passage, ItemIndex(item), visit);
            sorting.add::<K>(geometry, passage, ItemIndex(item), visit);
        }
        let openings = if passage.flat {
            0
        } else {
            geometry.openings().len() as u16
        };
        for opening in 0..openings {
            sorting.add_opening::<K>(geometry, passage, OpeningId(opening));
        }
        sorting.sort();
        for &FaceKey { item, face, .. } in &sorting.faces {
            match sorting.items.get(item as usize) {
                Some((item, screen_from_item)) => {
                    visit.faces(&Faces::of_face(geometry, *item, face, screen_from_item, &[]));
                }
                None => emit_opening(geometry, passage, OpeningId(face as u16), visit),
            }
        }
    }
}

impl SortBuffers {
    /// Adds the opaque faces of an item that may be visible.
    fn add<K: SortKey>(
        &mut self,
        geometry: &Geometry,
        passage: &Passage,
        item: ItemIndex,
        visit: &mut impl Visit,
    ) {
        let screen_from_item = passage.screen_from(&geometry.item(item).transform());
        let index = self.items.len() as u32;
        let mesh = geometry.mesh_of(item);
        let mut added = false;
        for cluster in mesh.clusters() {
            let is_opaque = geometry.material_of(item, cluster).alpha == Alpha::Opaque;
            if !is_opaque || !may_be_visible(passage, &screen_from_item, &cluster.bounds, visit) {
                continue;
            }
            added = true;
            let [x, y, z, w] = view_depth_row(&screen_from_item);
            let distance = |p: &[f32; 3]| x * p[0] + y * p[1] + z * p[2] + w;
            let used = cluster.positions.start as usize..cluster.positions.end as usize;
            self.distances.clear();
            self.distances.extend(mesh.positions()[used].iter().map(distance));
            for face in cluster.faces.clone() {
                let corners = mesh.face(face).iter();
                let key = K::key(corners.map(|&at| self.distances[(at - cluster.positions.start) as usize]));
                self.faces.push(FaceKey {
                    key: far_first(key),
                    item: index,
                    face,
                });
            }
        }
        if added {
            self.items.push((item, screen_from_item));
        }
    }

    fn add_opening<K: SortKey>(&mut self, geometry: &Geometry, passage: &Passage, opening: OpeningId) {
        let Some(view) = passage.view_of(geometry, opening) else {
            return;
        };
        let [x, y, z, w] = view_depth_row(&view.screen_from_local);
        let key = K::key(view.positions.iter().map(|p| x * p[0] + y * p[1] + z * p[2] + w));
        self.faces.push(FaceKey {
            key: far_first(key),
            item: u32::MAX,
            face: u32::from(opening.0),
        });
    }

    /// Radix sort by key, from the least significant byte. Among equal keys the face with the lowest number comes last,
    /// so that it is in front.
    fn sort(&mut self) {
        self.faces.reverse();
        self.spare.resize(self.faces.len(), FaceKey::default());
        for shift in [0, 8, 16, 24] {
            let digit = |sorted: &FaceKey| (sorted.key >> shift) as usize & 0xFF;
            let mut starts = [0_u32; 256];
            for sorted in &self.faces {
                starts[digit(sorted)] += 1;
            }
            if starts.iter().any(|&count| count as usize == self.faces.len()) {
                continue;
            }
            let mut sum = 0;
            for start in &mut starts {
                sum += std::mem::replace(start, sum);
            }
            for sorted in &self.faces {
                let index = &mut starts[digit(sorted)];
                self.spare[*index as usize] = *sorted;
                *index += 1;
            }
            std::mem::swap(&mut self.faces, &mut self.spare);
        }
    }
}

/// Returns the row of the transform that gives the distance along the viewing direction.
fn view_depth_row(screen_from_local: &ScreenMap) -> [f32; 4] {
    let ScreenMap { linear, is_parallel } = screen_from_local;
    // Reversed depth falls with distance.
    let sign = if *is_parallel { -1.0 } else { 1.0 };
    let row = linear.matrix3.row(2).extend(linear.translation.z);
    (sign * row).to_array().map(|value| value as f32)
}

/// Returns an integer key that decreases with distance.
fn far_first(distance: f32) -> u32 {
    let bits = distance.to_bits();
    // Positive floats sort like their bits, negative ones in reverse.
    let ascending = if bits >> 31 == 0 { bits | 1 << 31 } else { !bits };
    !ascending
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_farthest_comes_first_and_of_equally_far_faces_the_last() {
        let distances = [3.0, 1e9, -2.0, 0.0, 3.0, 1e-9, -0.5, 1e9, 3.0];
        let mut sorting = SortBuffers::default();
        for (face, &distance) in distances.iter().enumerate() {
            sorting.faces.push(FaceKey {
                key: far_first(distance),
                item: 0,
                face: face as u32,
            });
        }
        sorting.sort();
        let order: Vec<u32> = sorting.faces.iter().map(|sorted| sorted.face).collect();
        assert_eq!(order, [7, 1, 8, 4, 0, 5, 3, 6, 2]);
    }
}
