//! What every piece of the world can do.

use crate::canvas::Canvas;
use crate::collector::Collector;
use crate::geom::Aabb;
use crate::geometry::{Alpha, ItemId, Opening};
use crate::memory::Memory;
use crate::passage::Passage;
use std::fmt;

/// A piece of the world with its own way of being seen.
///
/// It knows its openings, not where they lead: it never follows one. Source: Boreskov, Using portals to create
/// aggregate scenes ("a sector draws itself inside a given polygon of the picture plane").
pub trait Sector: Send + Sync {
    /// The smallest box around everything in it, in its own space.
    fn bounds(&self) -> Aabb;

    /// The holes one can look through.
    fn openings(&self) -> &[Opening];

    /// What it promises of what it reports.
    fn contract(&self) -> Contract;

    /// Does [`Sector::draw`] paint what [`Sector::gather`] reported just before through the same passage, and
    /// nothing else? So does a method that knows what may be seen but not where.
    fn draws_what_was_gathered(&self, _memory: &Memory) -> bool {
        false
    }

    /// Reports every item and opening that may be seen through `passage`.
    fn gather(&self, passage: &Passage, memory: &mut Memory, seen: &mut Collector);

    /// Paints what is seen through `passage`: opaque faces at once, samples of glass into `seen`, to be painted
    /// after what is behind the openings. Reports as [`Sector::gather`] does; what that reported is in `seen` if it is
    /// to be painted ([`Sector::draws_what_was_gathered`]).
    fn draw(&self, passage: &Passage, memory: &mut Memory, seen: &mut Collector, canvas: &mut dyn Canvas);

    /// The first face along a ray, seen from whichever side.
    fn cast(&self, ray: &Ray) -> Option<Hit>;

    /// How a face looks.
    fn surface(&self, item: ItemId, face: u32) -> Surface;

    /// Goes through its order alone, holding nothing against a cover: what the order costs. Gives the number of faces
    /// handed out; 0 where it has no order.
    fn walk(&self, _passage: &Passage, _memory: &mut Memory) -> u64 {
        0
    }

    /// What was built to see it.
    fn build_stats(&self) -> BuildStats {
        BuildStats::default()
    }

    /// Memory in bytes.
    fn bytes(&self) -> u64 {
        0
    }

    /// How many items it has, for who counts them: those below this number. 0 where it does not say; nor need it where it is a
    /// geometry that a method sees, as of which [`Scene::geometry`](crate::Scene::geometry) tells.
    fn item_count(&self) -> u32 {
        0
    }

    /// How people call an item; empty where it has no name.
    fn item_name(&self, _item: ItemId) -> String {
        String::new()
    }

    /// The box around an item, in the space of the sector; empty where it does not say.
    fn item_bounds(&self, _item: ItemId) -> Aabb {
        Aabb::EMPTY
    }

    /// The triangles of some of an item's clusters, or with none of all; 0 where it does not say.
    fn item_triangles(&self, _item: ItemId, _clusters: &[u32]) -> u64 {
        0
    }
}

/// What a method built over the faces of a sector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct BuildStats {
    /// Faces after splitting; those of the sector where nothing is split.
    pub faces: u64,
    /// How often a face was split.
    pub splits: u64,
    /// Levels of the deepest tree; 0 where there is none.
    pub depth: u32,
}

/// A half-line in the space of a sector.
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
    /// Unit normal in the space of the sector; it points to the front. Zero for a face without area.
    pub normal: [f32; 3],
    /// A point of the face, in the space of the sector.
    pub point: [f32; 3],
    /// Red, green, blue and coverage, linear, 0 to 1.
    pub color: [f32; 4],
    /// What light does with it.
    pub alpha: Alpha,
}

/// What a method promises of its visible set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Contract {
    /// It may be wrong; the method's docs say on which scenes.
    Approximate,
    /// Everything that owns a sample, or is glass in front of one, is in it; it may hold more.
    Conservative,
    /// As conservative, for samples at any place in the pixels.
    Strict,
    /// Everything that owns a sample, or is glass in front of one, and nothing that cannot be seen at any.
    Exact,
}

impl Contract {
    /// Returns `true` if no visible item is ever missing from the set: for all contracts but [`Contract::Approximate`].
    pub fn never_misses(self) -> bool {
        self != Contract::Approximate
    }

    /// What is promised of what two sectors report together, one seen through an opening of the other: the weaker, and
    /// of exact and strict neither. A strict parent opens more than is seen, an exact one only what the middles of pixels
    /// show.
    #[must_use]
    pub fn combined_with(self, other: Contract) -> Contract {
        match (self, other) {
            (Contract::Approximate, _) | (_, Contract::Approximate) => Contract::Approximate,
            (a, b) if a == b => a,
            _ => Contract::Conservative,
        }
    }
}

impl fmt::Display for Contract {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Contract::Approximate => "approximate",
            Contract::Conservative => "conservative",
            Contract::Strict => "strict",
            Contract::Exact => "exact",
        })
    }
}
