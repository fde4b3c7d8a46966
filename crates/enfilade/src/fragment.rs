//! What every piece of the world can do.

use crate::canvas::Canvas;
use crate::content::{Alpha, ItemId, Opening};
use crate::geom::Aabb;
use crate::memory::Memory;
use crate::passage::Passage;
use crate::seen::Seen;

/// A piece of the world with its own way of being seen.
///
/// It knows its openings, not where they lead: it never follows one. Source: Boreskov, Using portals to create
/// aggregate scenes ("a fragment draws itself inside a given polygon of the picture plane").
pub trait Fragment: Send + Sync {
    /// The smallest box around everything in it, in its own space.
    fn bounds(&self) -> Aabb;

    /// The holes one can look through.
    fn openings(&self) -> &[Opening];

    /// Reports every item and opening that may be seen through `passage`.
    fn gather(&self, passage: &Passage, memory: &mut Memory, seen: &mut Seen);

    /// Paints what is seen through `passage`: opaque faces at once, samples of glass into `seen`, to be painted
    /// after what is behind the openings. Reports as [`Fragment::gather`] does.
    fn draw(&self, passage: &Passage, memory: &mut Memory, seen: &mut Seen, canvas: &mut dyn Canvas);

    /// The first face along a ray, seen from whichever side.
    fn cast(&self, ray: &Ray) -> Option<Hit>;

    /// How a face looks.
    fn surface(&self, item: ItemId, face: u32) -> Surface;

    /// Memory in bytes.
    fn bytes(&self) -> u64 {
        0
    }
}

/// A half-line in the space of a fragment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it begins.
    pub origin: [f32; 3],
    /// Where it goes; need not have unit length.
    pub direction: [f32; 3],
}

/// Where a ray meets a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The item met.
    pub item: ItemId,
    /// The face of the item's mesh.
    pub face: u32,
    /// The distance, in lengths of the ray's direction; above zero.
    pub distance: f64,
    /// Did the ray come from behind the face?
    pub from_behind: bool,
}

/// How a face looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Unit normal in the space of the fragment; it points to the front. Zero for a face without area.
    pub normal: [f32; 3],
    /// A point of the face, in the space of the fragment.
    pub point: [f32; 3],
    /// Red, green, blue and coverage, linear, 0 to 1.
    pub color: [f32; 4],
    /// What light does with it.
    pub alpha: Alpha,
}
