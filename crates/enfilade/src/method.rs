//! Methods: an order times a cover. Only this file knows both.

use crate::canvas::Canvas;
use crate::content::{Alpha, Content, ItemId, Opening};
use crate::cover::{Cover, DepthBuffer, DepthPyramid, Mask, Nothing, Sight, SpanBuffer};
use crate::faces::{Faces, Of};
use crate::fragment::{Built, Fragment, Hit, Ray, Surface};
use crate::geom::Aabb;
use crate::memory::{Marks, Memory};
use crate::order::{
    Bsp, DepthSort, FarToNear, Gives, Mean, Min, NearToFar, OctreeOrder, Order, Unordered, Visit,
};
use crate::passage::Passage;
use crate::region::Region;
use crate::seen::Seen;
use crate::stats::Stats;
use crate::view::View;
use std::fmt;
use std::marker::PhantomData;
use std::sync::Arc;
use thiserror::Error;

/// Painter's algorithm, sorted by each face's nearest corner. Thesis Painter's Algorithm and Binary Space Partitioning,
/// 1.1.
///
/// Wrong where a face reaches nearer than another that hides it (`@tetrahedron`, `@overlap`), in cycles (`@cycle`) and
/// where faces cross (`@crossing-triangles`).
pub type PainterMin = Paired<DepthSort<Min>, Nothing>;

/// Painter's algorithm, sorted by each face's mean distance. As [`PainterMin`].
///
/// Right more often than by the nearest corner, but not on long faces beside small ones (`@overlap` from its second
/// camera), in cycles (`@cycle`) and where faces cross (`@crossing-triangles`).
pub type PainterMean = Paired<DepthSort<Mean>, Nothing>;

/// BSP tree, far to near: every face is painted. Fuchs, Kedem, Naylor, SIGGRAPH 1980; thesis Painter's Algorithm and
/// Binary Space Partitioning, 1.2.
pub type BspPainter = Paired<Bsp<FarToNear>, Nothing>;

/// BSP tree, near to far: every sample is painted once. Boreskov, Using portals.
pub type BspFront = Paired<Bsp<NearToFar>, Mask>;

/// z-buffer: any order, and at each sample the nearest face. Catmull 1974; Boreskov, Using portals.
pub type ZBuffer = Paired<Unordered, DepthBuffer>;

/// s-buffer: any order, and for each row the spans that are seen. Boreskov, Hierarchical s-buffer for scenes of high
/// complexity, section 2.
pub type SBuffer = Paired<Unordered, SpanBuffer>;

/// Hierarchical z-buffer: an octree near to far, and a pyramid of farthest depths that hides whole nodes. Greene, Kass,
/// Miller, SIGGRAPH 1993.
pub type HierarchicalZ = Paired<OctreeOrder, DepthPyramid>;

/// How a fragment is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Method {
    /// See [`PainterMin`](crate::PainterMin).
    PainterMin,
    /// See [`PainterMean`](crate::PainterMean).
    PainterMean,
    /// See [`BspPainter`](crate::BspPainter).
    Bsp,
    /// See [`BspFront`](crate::BspFront).
    BspFront,
    /// See [`ZBuffer`](crate::ZBuffer).
    ZBuffer,
    /// See [`SBuffer`](crate::SBuffer).
    SBuffer,
    /// See [`HierarchicalZ`](crate::HierarchicalZ).
    HierarchicalZ,
}

/// What a method promises of its visible set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
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

/// A method would need too much memory; told by an estimate, before anything is built.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{method} needs about {needs_bytes} bytes, but {limit} are allowed{}", self.advice())]
#[non_exhaustive]
pub struct TooLarge {
    /// The method that was asked for.
    pub method: Method,
    /// What it would need.
    pub needs_bytes: u64,
    /// What is allowed.
    pub limit: u64,
    /// A method that needs less, if there is one.
    pub instead: Option<Method>,
}

impl TooLarge {
    fn new(method: Method, needs_bytes: u64, limit: u64) -> TooLarge {
        let instead = (method != Method::ZBuffer).then_some(Method::ZBuffer);
        TooLarge {
            method,
            needs_bytes,
            limit,
            instead,
        }
    }

    fn advice(&self) -> String {
        self.instead
            .map_or_else(String::new, |method| format!("; {method} needs fewer"))
    }
}

impl Method {
    /// Every method there is.
    pub const ALL: [Method; 7] = [
        Method::PainterMin,
        Method::PainterMean,
        Method::Bsp,
        Method::BspFront,
        Method::ZBuffer,
        Method::SBuffer,
        Method::HierarchicalZ,
    ];

    /// What one fragment's method may build unless told otherwise, in bytes: 1 GB.
    pub const DEFAULT_LIMIT: u64 = 1_000_000_000;

    /// Its name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Method::PainterMin => "painter-min",
            Method::PainterMean => "painter-mean",
            Method::Bsp => "bsp",
            Method::BspFront => "bsp-front",
            Method::ZBuffer => "z-buffer",
            Method::SBuffer => "s-buffer",
            Method::HierarchicalZ => "hierarchical-z",
        }
    }

    /// The method of a name; `None` where there is none.
    pub fn by_name(name: &str) -> Option<Method> {
        Method::ALL.into_iter().find(|method| method.name() == name)
    }

    /// What it promises of its visible set.
    pub fn contract(self) -> Contract {
        match self {
            Method::PainterMin | Method::PainterMean => Contract::Approximate,
            Method::Bsp | Method::BspFront | Method::ZBuffer | Method::SBuffer | Method::HierarchicalZ => {
                Contract::Exact
            }
        }
    }

    /// Prepares a content to be seen.
    ///
    /// # Errors
    /// [`TooLarge`] where more than `limit_bytes` would be needed.
    pub fn build(self, content: Arc<Content>, limit_bytes: u64) -> Result<Arc<dyn Fragment>, TooLarge> {
        Ok(match self {
            Method::PainterMin => Arc::new(PainterMin::build(self, content, limit_bytes)?),
            Method::PainterMean => Arc::new(PainterMean::build(self, content, limit_bytes)?),
            Method::Bsp => Arc::new(BspPainter::build(self, content, limit_bytes)?),
            Method::BspFront => Arc::new(BspFront::build(self, content, limit_bytes)?),
            Method::ZBuffer => Arc::new(ZBuffer::build(self, content, limit_bytes)?),
            Method::SBuffer => Arc::new(SBuffer::build(self, content, limit_bytes)?),
            Method::HierarchicalZ => Arc::new(HierarchicalZ::build(self, content, limit_bytes)?),
        })
    }

    /// Memory of its buffers for a screen of this size, in bytes.
    pub fn screen_bytes(self, size: [u32; 2]) -> u64 {
        match self {
            Method::BspFront => Mask::needs_bytes(size),
            Method::PainterMin | Method::PainterMean | Method::Bsp => Nothing::needs_bytes(size),
            Method::ZBuffer => DepthBuffer::needs_bytes(size),
            Method::SBuffer => SpanBuffer::needs_bytes(size),
            Method::HierarchicalZ => DepthPyramid::needs_bytes(size),
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
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

/// Content seen by an order and a cover that go together. A pair that does not, does not compile:
///
/// ```compile_fail,E0277
/// use enfilade::order::{Gives, NearToFar, Order, Unordered};
/// fn needs_near_to_far<O: Order>() where O::Gives: Gives<NearToFar> {}
/// needs_near_to_far::<Unordered>();
/// ```
pub struct Paired<O, C> {
    content: Arc<Content>,
    order: O,
    cover: PhantomData<fn() -> C>,
}

impl<O, C> Paired<O, C>
where
    O: Order,
    C: Cover,
    O::Gives: Gives<C::CullNeeds> + Gives<C::DrawNeeds>,
{
    fn build(method: Method, content: Arc<Content>, limit: u64) -> Result<Self, TooLarge> {
        let needs_bytes = O::needs_bytes(&content);
        if needs_bytes > limit {
            return Err(TooLarge::new(method, needs_bytes, limit));
        }
        // What turns out to be more than estimated is twice the limit, as far as is known.
        let order =
            O::build(&content, limit).ok_or_else(|| TooLarge::new(method, limit.saturating_mul(2), limit))?;
        Ok(Paired {
            order,
            content,
            cover: PhantomData,
        })
    }

    fn see(
        &self,
        passage: &Passage,
        memory: &mut Memory,
        seen: &mut Seen,
        mut canvas: Option<&mut dyn Canvas>,
    ) {
        let mut cover = memory.take::<C>();
        let mut waiting = memory.take::<Waiting>();
        let mut scratch = memory.take::<O::Scratch>();
        let size = self.content.bounds().longest_side();
        let primes = C::PRIMES && memory.coherence;
        let last = if primes {
            memory.recall.seen_last(passage, size)
        } else {
            Vec::new()
        };
        cover.clear(passage, memory.trace);
        memory.marks.begin(self.content.items().len());
        let mut walk = Walk {
            passage,
            cover: &mut *cover,
            marks: &mut memory.marks,
            stats: &mut memory.stats,
            waiting: &mut waiting.0,
            primed: &last,
            canvas: reborrow(&mut canvas),
        };
        walk.prime(&self.content);
        self.order.visit(&self.content, passage, &mut scratch, &mut walk);
        for (item, cluster) in waiting.0.drain(..) {
            let screen_from_item = passage.screen_from(&self.content.item(item).transform());
            let bounds = self.content.mesh_of(item).clusters()[cluster as usize].bounds;
            let region = Region::of(passage, &screen_from_item, &bounds);
            if region.is_some_and(|region| !C::KEEPS_DEPTHS || cover.sees(&region) != Sight::Hidden) {
                let faces = Faces::of_cluster(&self.content, item, cluster, &screen_from_item);
                cover.look_through(&faces, passage, &mut memory.stats, seen);
            }
        }
        cover.finish(&self.content, passage, seen, canvas);
        memory.stats.samples_owned += seen.samples_owned;
        if primes {
            memory.recall.remember(passage, seen.clusters_of_items());
        }
        memory.put_back(cover);
        memory.put_back(waiting);
        memory.put_back(scratch);
    }
}

/// Counts what an order hands out, and hides nothing.
struct Count<'a> {
    faces: u64,
    marks: &'a mut Marks,
}

impl Visit for Count<'_> {
    fn enter(&mut self, _region: &Region) -> bool {
        true
    }

    fn first_time(&mut self, item: ItemId) -> bool {
        self.marks.first_time(item)
    }

    fn faces(&mut self, faces: &Faces) {
        self.faces += faces.count() as u64;
    }
}

/// Lends a canvas for a while.
fn reborrow<'a>(canvas: &'a mut Option<&mut dyn Canvas>) -> Option<&'a mut dyn Canvas> {
    match canvas {
        Some(canvas) => Some(&mut **canvas),
        None => None,
    }
}

/// Clusters of faces that do not hide: they are held against the cover when all that hides is in it.
#[derive(Default)]
struct Waiting(Vec<(ItemId, u32)>);

/// Joins an order's walk to a cover.
struct Walk<'a, C> {
    passage: &'a Passage,
    cover: &'a mut C,
    marks: &'a mut Marks,
    stats: &'a mut Stats,
    waiting: &'a mut Vec<(ItemId, u32)>,
    /// What goes in before the walk, in order.
    primed: &'a [(ItemId, u32)],
    canvas: Option<&'a mut dyn Canvas>,
}

impl<C: Cover> Walk<'_, C> {
    /// Lets the cover see first what the last look saw; what has left the picture since is left out.
    fn prime(&mut self, content: &Content) {
        let mut in_view: Vec<_> = self
            .primed
            .iter()
            .filter_map(|&(item, cluster)| {
                let screen_from_item = self.passage.screen_from(&content.item(item).transform());
                let bounds = &content.mesh_of(item).clusters()[cluster as usize].bounds;
                let region = Region::of(self.passage, &screen_from_item, bounds)?;
                Some((region.nearest, item, cluster))
            })
            .collect();
        in_view.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (_, item, cluster) in in_view {
            let screen_from_item = self.passage.screen_from(&content.item(item).transform());
            self.take(&Faces::of_cluster(content, item, cluster, &screen_from_item));
        }
        self.stats.clusters_primed += self.primed.len() as u64;
    }

    fn take(&mut self, faces: &Faces) {
        match (faces.alpha, faces.of) {
            (Alpha::Mask | Alpha::Blend, Of::Item(item, cluster)) => self.waiting.push((item, cluster)),
            _ => {
                self.cover
                    .add(faces, self.passage, self.stats, reborrow(&mut self.canvas));
            }
        }
    }
}

impl<C: Cover> Visit for Walk<'_, C> {
    fn enter(&mut self, region: &Region) -> bool {
        self.stats.boxes_tested += 1;
        let hidden = self.cover.sees(region) == Sight::Hidden;
        self.stats.boxes_hidden += u64::from(hidden);
        !hidden
    }

    fn first_time(&mut self, item: ItemId) -> bool {
        self.marks.first_time(item)
    }

    fn faces(&mut self, faces: &Faces) {
        let primed = matches!(faces.of, Of::Item(item, cluster) if self.primed.binary_search(&(item, cluster)).is_ok());
        if !primed {
            self.take(faces);
        }
    }
}

impl<O, C> Fragment for Paired<O, C>
where
    O: Order,
    C: Cover,
    O::Gives: Gives<C::CullNeeds> + Gives<C::DrawNeeds>,
{
    fn bounds(&self) -> Aabb {
        self.content.bounds()
    }

    fn openings(&self) -> &[Opening] {
        self.content.openings()
    }

    fn gather(&self, passage: &Passage, memory: &mut Memory, seen: &mut Seen) {
        self.see(passage, memory, seen, None);
    }

    fn draw(&self, passage: &Passage, memory: &mut Memory, seen: &mut Seen, canvas: &mut dyn Canvas) {
        self.see(passage, memory, seen, Some(canvas));
    }

    fn cast(&self, ray: &Ray) -> Option<Hit> {
        self.content.cast(ray)
    }

    fn surface(&self, item: ItemId, face: u32) -> Surface {
        self.content.surface(item, face)
    }

    fn walk(&self, passage: &Passage, memory: &mut Memory) -> u64 {
        let mut scratch = memory.take::<O::Scratch>();
        memory.marks.begin(self.content.items().len());
        let mut count = Count {
            faces: 0,
            marks: &mut memory.marks,
        };
        self.order.visit(&self.content, passage, &mut scratch, &mut count);
        let faces = count.faces;
        memory.put_back(scratch);
        faces
    }

    fn built(&self) -> Built {
        self.order.built(&self.content)
    }

    fn bytes(&self) -> u64 {
        self.content.bytes() + self.order.bytes()
    }
}

impl Method {
    /// Why a screen of this size cannot be looked at within `limit_bytes`, if so.
    ///
    /// # Errors
    /// [`TooLarge`].
    pub fn check_screen(self, view: &View, limit_bytes: u64) -> Result<(), TooLarge> {
        let needs_bytes = self.screen_bytes(view.size);
        if needs_bytes > limit_bytes {
            return Err(TooLarge::new(self, needs_bytes, limit_bytes));
        }
        Ok(())
    }
}
