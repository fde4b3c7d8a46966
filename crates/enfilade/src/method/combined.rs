//! The sector of a built-in method: one implementation of the sector trait for all ways to use an order.

use super::editable::{EditStats, EditableSector, edit_order};
use super::found::find;
use super::gathered::draw_gathered;
use super::ordered::NoCover;
use crate::contract::Contract;
use crate::faces::Faces;
use crate::geom::Aabb;
use crate::geometry::{Changes, Exchanged, Geometry, Item, Opening};
use crate::ids::ItemIndex;
use crate::order::{Order, Visit};
use crate::sector::{BuildStats, Hit, Ray, Sector, Surface};
use crate::stats::Stats;
use crate::unsuited::Unsuited;
use crate::view::canvas::{Canvas, CoverShape};
use crate::view::collector::Collector;
use crate::view::memory::{Marks, Memory};
use crate::view::options::ViewerOptions;
use crate::view::passage::Passage;
use crate::view::region::{Region, Visibility};
use std::sync::Arc;

/// A way to compute visibility from an order: with a cover that holds the picture ([`Paired`](super::Paired)), with one
/// that only culls ([`Culled`](super::Culled)), or without a cover ([`Ordered`](super::Ordered)).
///
/// The value holds what the method keeps beside its order.
pub(super) trait Combination: Send + Sync + Sized + 'static {
    type Order: Order;

    /// Name of the cover; empty if there is none.
    const COVER: &'static str;
    /// Guarantee of the visible set, if the cover has the resolution of the screen; conservative otherwise.
    const CONTRACT: Contract;
    /// Whether the cover can have another resolution than the screen.
    const TAKES_COVER_SIZE: bool = false;
    /// Default number of occluders per passage; `None` if the method selects none.
    const OCCLUDERS: Option<u32> = None;
    /// How the cover divides the screen.
    const COVER_SHAPE: Option<CoverShape>;

    /// Returns the memory of the screen buffers, in bytes, at `size` and `cover_size` [width, height].
    fn screen_bytes(size: [u32; 2], cover_size: Option<[u32; 2]>) -> u64;

    /// Returns an upper estimate of the bytes that are needed beside the order.
    fn needs_bytes(_geometry: &Geometry) -> u64 {
        0
    }

    fn new(geometry: &Geometry) -> Self;

    /// Whether [`Combination::draw`] draws what [`Combination::gather`] reported.
    fn draws_what_was_gathered(&self, _options: &ViewerOptions) -> bool {
        true
    }

    fn gather(
        &self,
        order: &Self::Order,
        geometry: &Geometry,
        passage: &Passage,
        memory: &mut Memory,
        seen: &mut Collector,
    );

    fn draw(
        &self,
        order: &Self::Order,
        geometry: &Geometry,
        passage: &Passage,
        memory: &mut Memory,
        seen: &mut Collector,
        canvas: &mut dyn Canvas,
    );

    /// Returns the memory in use beside the order, in bytes.
    fn bytes(&self) -> u64 {
        0
    }

    /// Updates what is kept beside the order after an edit; returns the number of tree nodes touched.
    fn follow(&mut self, _geometry: &Geometry, _done: &mut Exchanged) -> u64 {
        0
    }
}

/// A sector with geometry and a method.
pub(super) struct Combined<M: Combination> {
    geometry: Arc<Geometry>,
    order: M::Order,
    combination: M,
}

impl<M: Combination> Combined<M> {
    pub(super) fn build(geometry: Arc<Geometry>, limit: u64) -> Result<Arc<dyn EditableSector>, Unsuited> {
        let needs_bytes = M::Order::needs_bytes(&geometry) + M::needs_bytes(&geometry);
        if needs_bytes > limit {
            return Err(Unsuited::TooLarge { needs_bytes, limit });
        }
        Ok(Arc::new(Combined::<M> {
            order: M::Order::build(&geometry, limit)?,
            combination: M::new(&geometry),
            geometry,
        }))
    }
}

/// Whether occlusion is not wanted, or a margin is set that the method cannot keep: its occluders would hide what a renderer
/// within the margin shows.
fn culls_by_clip_region_alone<M: Combination>(options: &ViewerOptions) -> bool {
    let loses_margin = !M::TAKES_COVER_SIZE && options.margin() > 0.0;
    !M::COVER.is_empty() && (loses_margin || !options.occlusion)
}

impl<M: Combination> Sector for Combined<M> {
    fn bounds(&self) -> Aabb {
        self.geometry.bounds()
    }

    fn openings(&self) -> &[Opening] {
        self.geometry.openings()
    }

    fn contract(&self, options: &ViewerOptions) -> Contract {
        if !options.occlusion {
            return Contract::Strict;
        }
        let in_cells = M::TAKES_COVER_SIZE && (options.cover_size.is_some() || options.margin() > 0.0);
        if in_cells || culls_by_clip_region_alone::<M>(options) {
            Contract::Conservative
        } else {
            M::CONTRACT
        }
    }

    fn draws_what_was_gathered(&self, options: &ViewerOptions) -> bool {
        culls_by_clip_region_alone::<M>(options) || self.combination.draws_what_was_gathered(options)
    }

    fn gather(&self, passage: &Passage, memory: &mut Memory, seen: &mut Collector) {
        if culls_by_clip_region_alone::<M>(&passage.options) {
            return find(&self.order, &self.geometry, passage, &mut NoCover, memory, seen);
        }
        self.combination
            .gather(&self.order, &self.geometry, passage, memory, seen);
    }

    fn draw(&self, passage: &Passage, memory: &mut Memory, seen: &mut Collector, canvas: &mut dyn Canvas) {
        if culls_by_clip_region_alone::<M>(&passage.options) {
            return draw_gathered(&self.geometry, passage, memory, seen, canvas);
        }
        self.combination
            .draw(&self.order, &self.geometry, passage, memory, seen, canvas);
    }

    fn cast(&self, ray: &Ray) -> Option<Hit> {
        self.geometry.cast(ray)
    }

    fn surface(&self, item: ItemIndex, face: u32) -> Surface {
        self.geometry.surface(item, face)
    }

    fn walk(&self, passage: &Passage, memory: &mut Memory) -> u64 {
        let mut scratch = memory.take::<<M::Order as Order>::Scratch>();
        memory.marks.begin(self.geometry.items().len());
        let mut count = Count::new(&mut memory.marks);
        self.order
            .visit(&self.geometry, passage, &mut scratch, &mut count);
        let faces = count.faces;
        memory.put_back(scratch);
        faces
    }

    fn build_stats(&self) -> BuildStats {
        self.order.build_stats(&self.geometry)
    }

    fn bytes(&self) -> u64 {
        self.geometry.bytes() + self.order.bytes() + self.combination.bytes()
    }
}

impl<M: Combination> EditableSector for Combined<M> {
    fn geometry(&self) -> &Arc<Geometry> {
        &self.geometry
    }

    fn edit(&mut self, changes: &mut Changes, limit: u64) -> Result<EditStats, Unsuited> {
        let Self {
            geometry,
            order,
            combination,
        } = self;
        let mut edited = edit_order(order, geometry, changes, limit, M::needs_bytes)?;
        edited.nodes += combination.follow(geometry, &mut changes.exchanged);
        Ok(edited)
    }
}

/// Whether an item takes part in a look; counts it if it does not because of its own limits.
pub(super) fn takes(passage: &Passage, item: &Item, stats: &mut Stats) -> bool {
    let takes = passage.takes(item);
    stats.items_ignored += u64::from(!takes && item.options.layers & passage.options.layers != 0);
    takes
}

/// Counts the faces that an order emits; culls nothing.
pub(super) struct Count<'a> {
    pub(super) faces: u64,
    marks: &'a mut Marks,
}

impl<'a> Count<'a> {
    pub(super) fn new(marks: &'a mut Marks) -> Count<'a> {
        Count { faces: 0, marks }
    }
}

impl Visit for Count<'_> {
    fn enter(&mut self, _region: &Region) -> Visibility {
        Visibility::Partial
    }

    fn first_time(&mut self, item: ItemIndex) -> bool {
        self.marks.first_time(item)
    }

    fn faces(&mut self, faces: &Faces) {
        self.faces += faces.count() as u64;
    }
}
