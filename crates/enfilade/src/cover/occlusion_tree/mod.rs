//! Occlusion tree: a shadow volume BSP (SVBSP) tree of selected occluders, in object space.
//!
//! The eye takes the role of a point light, so there is no penumbra: each leaf is either lit (visible) or in shadow
//! (hidden). The shadow volume of an occluder is bounded by one shadow plane through the eye for each of its edges, and
//! by its own plane. An occluder is filtered down the tree and split by the planes it crosses; wherever a piece reaches
//! a lit leaf, the occluder's planes become new nodes there, with a shadow leaf behind them. Geometry that reaches only
//! shadow leaves is hidden.
//! Source: Chin, Feiner, Fast Object-Precision Shadow Generation for Area Light Sources Using BSP Trees, I3D 1992 (and
//!     Near Real-Time Shadow Generation Using BSP Trees, SIGGRAPH 1989); Bittner, Havran, Slavík, Hierarchical
//!     Visibility Culling with Occlusion Trees, CGI 1998, section 3.
//! Cost: inserting O(leaves reached · depth), a test O(leaves reached); no allocation once warm.
//! Strict: hidden geometry is hidden at every position in every pixel, whatever the resolution. Occluders that meet
//! leave no crack. See below.
//!
//! # Why hidden geometry is really hidden
//!
//! * **A shadow leaf is behind one whole occluder.** The ancestors of each shadow leaf include all planes of one
//!   occluder: its own plane, pushed away by more than rounding, and the shadow planes of all its edges. So even if
//!   pieces are split inaccurately on the way down, they only decide where shadow volumes are inserted, never how large
//!   they are. A piece that is lost only loses a shadow.
//! * **An edge gets no node only if it does not cross the leaf**: every point of it is outside an ancestor plane or
//!   within `SLIT` of it, and the piece is so thick that a point inside all other planes is outside the occluder by at
//!   most 1,000 times `SLIT`, which is 2⁻¹⁴ pixel. (`insert.rs`)
//! * **A query loses at most a slit.** A polygon goes to each side of a line on which it has a corner more than `SLIT`
//!   away; whatever is lost of it is within `SLIT` of a line of the tree. Against an occluder's plane it is hidden only
//!   if all of its corners are certainly behind: ties are visible.
//!
//! So hidden geometry could show at most in slits of 2⁻²⁴ pixel along the lines of edges, and where an occluder larger
//! or smaller by 2⁻¹⁴ pixel would show it; the samples that the conformance suite requires to agree are 2⁻¹⁰ pixel
//! apart. Without such a tolerance nothing would be hidden behind two walls if one ends in the middle of the other's
//! edge (a T-junction): in f64 that corner is never exactly on the line. Corners are rounded to f64; the answer is
//! exact for corners a few units in the last place away.

mod above;
mod by_box;
mod by_faces;
mod corners;
mod insert;
mod line;
mod pieces;
mod show;
#[cfg(test)]
mod tests;

use super::sealed::Sealed;
use super::{Cover, Hides};
use crate::contract::Contract;
use crate::geom::Aabb;
use crate::occluders::{Occluder, OccluderMeasure};
use crate::order::Unsorted;
use crate::stats::Stats;
use crate::view::aperture::Rect;
use crate::view::canvas::{Canvas, CoverShape};
use crate::view::passage::Passage;
use crate::view::region::{Region, Visibility, Volume};
use crate::view::screen_map::ScreenMap;
use above::LinesAbove;
use by_box::{PendingLink, Query, Start};
use fearless_simd::Level;
use glam::DVec3;
use line::{Back, Line};
use pieces::{Piece, Pieces};
use std::marker::PhantomData;

/// Shadow volume BSP (SVBSP) tree of selected occluders; `A` chooses how boxes are tested, [`ByFaces`] or [`ByBox`].
///
/// Independent of the resolution. Holds up to 32,768 nodes, one per occluder edge and plane in each leaf that the
/// occluder reaches; occluders that would exceed that are skipped.
#[doc(alias = "SVBSP")]
#[doc(alias = "shadow volume BSP")]
pub struct OcclusionTree<A> {
    level: Level,
    /// Starting point of the traversal for a box.
    start: Start,
    /// Starting point for boxes inside the box tested last.
    within: Start,
    tree: Tree,
    /// Pieces of the polygon that is being filtered down the tree.
    pieces: Pieces,
    /// Edges of the occluder that is being inserted.
    edges: Vec<Edge>,
    /// Stack of its pieces that still have to be filtered.
    entering: Vec<(Slot, Piece)>,
    /// Stack of pieces of the face that is being tested.
    pending: Vec<(Link, Piece)>,
    /// Stack of links that the box being tested also reaches.
    links: Vec<PendingLink>,
    box_test: PhantomData<fn() -> A>,
}

/// Tests a box by its corners; if that is inconclusive, filters its front faces down the tree and splits them by its
/// planes.
#[derive(Default)]
pub struct ByFaces;

/// Tests a box by its corners only: cheaper, but more hidden boxes are reported as partly visible.
#[derive(Default)]
pub struct ByBox;

/// Maximum number of nodes. Occluder pieces that would exceed it are not inserted: the tree then hides less, and costs
/// no more.
const MAX_NODES: usize = 1 << 15;

/// Margin in pixels by which the aperture is widened: more than rounding can move the lines of its edges.
const WIDEN: f64 = 1.0 / (1 << 14) as f64;

/// The nodes of the tree, below the planes of the aperture.
struct Tree {
    /// Planes n · p = d of the near plane and the last portal; boxes entirely at n · p < d of any of them are outside
    /// the view.
    before: Vec<(DVec3, f64)>,
    /// Lines that bound the aperture; everything outside any of them is hidden.
    aperture: Vec<Line>,
    /// Maximum |x| and |y| on the screen inside the aperture, in pixels.
    far: [f64; 2],
    root: Link,
    nodes: Vec<Node>,
    /// For each occluder, the number of nodes before it was inserted.
    firsts: Vec<u32>,
    /// Lines that bound a slot; see [`Tree::gather_bounds`].
    above: LinesAbove,
}

/// A plane and its two subtrees.
#[derive(Clone, Copy, Debug)]
struct Node {
    plane: Plane,
    /// For a line, the side inside it; for an occluder's plane, the side behind it.
    inside: Link,
    outside: Link,
    /// The slot that links to this node.
    above: Slot,
}

/// Plane of a node: a shadow plane through the eye, or the plane of an occluder.
#[derive(Clone, Copy, Debug)]
enum Plane {
    Line(Line),
    Back(Back),
}

/// A leaf or a node.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Link {
    /// Lit leaf: nothing hides this part of space.
    Lit,
    /// Shadow leaf: an occluder hides this part of space.
    Shadow,
    /// A node, by its index.
    Node(u32),
}

/// The slot that holds a link: a node and one of its sides, or the root.
type Slot = Option<(u32, Side)>;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Inside,
    Outside,
}

/// An edge of the occluder that is being inserted, and its line on the screen.
#[derive(Clone, Copy, Debug)]
struct Edge {
    from: DVec3,
    to: DVec3,
    line: Line,
}

/// Strategy by which a tree tests a box: [`ByFaces`] or [`ByBox`]. Sealed, like [`Cover`].
pub trait BoxTest: Sealed + Default + Send + Sized + 'static {
    /// Returns how much of a box is visible; `None` if it is outside the view.
    fn test(tree: &mut OcclusionTree<Self>, volume: &Volume) -> Option<Visibility>;
}

impl BoxTest for ByFaces {
    fn test(tree: &mut OcclusionTree<ByFaces>, volume: &Volume) -> Option<Visibility> {
        let found = tree.test_box(volume, Query::Certain)?;
        let unsure = found.lit && found.shadow && !found.lit_for_certain;
        if unsure && !tree.is_any_face_visible(volume) {
            return Some(Visibility::Hidden);
        }
        Some(found.visibility())
    }
}

impl BoxTest for ByBox {
    fn test(tree: &mut OcclusionTree<ByBox>, volume: &Volume) -> Option<Visibility> {
        Some(tree.test_box(volume, Query::Visibility)?.visibility())
    }
}

impl<A: BoxTest> Cover for OcclusionTree<A> {
    type Needs = Unsorted;

    const NAME: &'static str = "OcclusionTree";

    fn test(&mut self, region: &Region) -> Visibility {
        A::test(self, &region.volume).unwrap_or(Visibility::Hidden)
    }

    fn test_local(
        &mut self,
        _passage: &Passage,
        screen_from_local: &ScreenMap,
        bounds: &Aabb,
    ) -> Option<Visibility> {
        // The tree includes the lines of the aperture, so neither the box's samples nor its reversed depth are needed.
        if bounds.is_empty() {
            return None;
        }
        A::test(self, &Volume::new(screen_from_local, bounds))
    }

    fn go_within(&mut self) {
        self.start = self.within;
    }

    fn go_back(&mut self) {
        self.start = Start::default();
    }

    fn needs_bytes(_size: [u32; 2]) -> u64 {
        // The pieces of one occluder or face may reach every leaf.
        (MAX_NODES * (size_of::<Node>() + 4 * size_of::<DVec3>())) as u64
    }

    const SHAPE: Option<CoverShape> = Some(CoverShape::Tree);

    fn show(&mut self, passage: &Passage, canvas: &mut dyn Canvas) {
        self.tree.show(passage, canvas);
    }
}

impl<A: BoxTest> Hides for OcclusionTree<A> {
    const CONTRACT: Contract = Contract::Strict;
    const MEASURE: OccluderMeasure = OccluderMeasure::AreaAngle;
    const OCCLUDERS: u32 = 128;

    fn clear(&mut self, passage: &Passage) {
        self.tree
            .open(passage.aperture.outline(), &passage.aperture.rect());
        self.tree.before.push((DVec3::Z, f64::from(passage.z_near)));
        let entry = passage.entry.map(|(normal, d)| (normal, d * (1.0 - 1e-6)));
        self.tree.before.extend(entry);
        self.go_back();
    }

    fn hides(&mut self, _passage: &Passage, screen_from_local: &ScreenMap, bounds: &Aabb) -> bool {
        // Testing the faces would cost more than most occluders save; and this way both kinds of tree insert the same
        // occluders.
        if bounds.is_empty() {
            return true;
        }
        let found = self.test_box(&Volume::new(screen_from_local, bounds), Query::Lit);
        !found.is_some_and(|found| found.lit)
    }

    fn hide(&mut self, occluder: &Occluder, passage: &Passage, _stats: &mut Stats) {
        self.insert(
            occluder,
            f64::from(passage.z_near),
            passage.entry,
            passage.corner_rounding(),
        );
    }

    fn copy(&mut self, from: &OcclusionTree<A>) {
        self.tree.copy(&from.tree);
        self.go_back();
    }
}

impl<A> Default for OcclusionTree<A> {
    fn default() -> OcclusionTree<A> {
        OcclusionTree {
            level: crate::simd::level(),
            start: Start::default(),
            within: Start::default(),
            tree: Tree::default(),
            pieces: Pieces::default(),
            edges: Vec::new(),
            entering: Vec::new(),
            pending: Vec::new(),
            links: Vec::new(),
            box_test: PhantomData,
        }
    }
}

impl Default for Tree {
    fn default() -> Tree {
        Tree {
            before: Vec::new(),
            aperture: Vec::new(),
            far: [0.0; 2],
            root: Link::Lit,
            nodes: Vec::new(),
            firsts: Vec::new(),
            above: LinesAbove::default(),
        }
    }
}

impl Tree {
    /// Clears the tree and sets the aperture: its outline in pixels, counter-clockwise on the screen, and the bounding
    /// rectangle of its samples.
    fn open(&mut self, mut outline: &[[f64; 2]], rect: &Rect) {
        self.nodes.clear();
        self.firsts.clear();
        self.root = Link::Lit;
        self.before.clear();
        self.aperture.clear();
        let mut min = [rect.x0, rect.y0].map(f64::from);
        let mut max = [rect.x1, rect.y1].map(f64::from);
        if outline.len() < 3 {
            // Only the samples are known: use all of their pixels.
            outline = &[];
        } else {
            for axis in 0..2 {
                min[axis] = outline.iter().map(|c| c[axis]).fold(f64::INFINITY, f64::min);
                max[axis] = outline.iter().map(|c| c[axis]).fold(f64::NEG_INFINITY, f64::max);
            }
        }
        self.far = [0, 1].map(|axis| min[axis].abs().max(max[axis].abs()) + 1.0);
        for [x, y, z] in [
            [1.0, 0.0, -min[0]],
            [-1.0, 0.0, max[0]],
            [0.0, 1.0, -min[1]],
            [0.0, -1.0, max[1]],
        ] {
            let normal = DVec3::new(x, y, z);
            self.aperture.push(Line { normal }.outward(WIDEN));
        }
        for (i, &from) in outline.iter().enumerate() {
            let to = outline[(i + 1) % outline.len()];
            // Axis-aligned edges are sides of the rectangle; rounding the ends of a short edge would rotate its line
            // too far.
            let upright = from[0] == to[0] || from[1] == to[1];
            let short = (from[0] - to[0]).abs() + (from[1] - to[1]).abs() < 1.0;
            if !upright && !short {
                let [from, to] = [from, to].map(|[x, y]| DVec3::new(x, y, 1.0));
                let line = Line::through(from, to).map(|line| line.outward(WIDEN));
                self.aperture.extend(line);
            }
        }
    }

    /// Copies the parts that queries read; nothing can be inserted afterwards.
    fn copy(&mut self, from: &Tree) {
        self.before.clone_from(&from.before);
        self.aperture.clone_from(&from.aperture);
        self.far = from.far;
        self.root = from.root;
        self.nodes.clone_from(&from.nodes);
    }

    /// Returns the link in a slot.
    fn link_at(&self, slot: Slot) -> Link {
        match slot {
            None => self.root,
            Some((node, Side::Inside)) => self.nodes[node as usize].inside,
            Some((node, Side::Outside)) => self.nodes[node as usize].outside,
        }
    }

    /// Adds a node with an empty outside to a slot, replacing the link there, and returns its index.
    fn attach(&mut self, slot: Slot, plane: Plane, inside: Link) -> u32 {
        let number = self.nodes.len() as u32;
        self.nodes.push(Node {
            plane,
            inside,
            outside: Link::Lit,
            above: slot,
        });
        let link = match slot {
            None => &mut self.root,
            Some((node, Side::Inside)) => &mut self.nodes[node as usize].inside,
            Some((node, Side::Outside)) => &mut self.nodes[node as usize].outside,
        };
        *link = Link::Node(number);
        number
    }

    /// Collects the lines that bound a slot, oriented so that the slot is inside: ancestors from the lowest up, then
    /// the aperture.
    fn gather_bounds(&mut self, slot: Slot) {
        self.above.clear();
        let mut next = slot;
        while let Some((number, side)) = next {
            let node = &self.nodes[number as usize];
            if let Plane::Line(line) = node.plane {
                self.above.push(match side {
                    Side::Inside => line,
                    Side::Outside => line.flipped(),
                });
            }
            next = node.above;
        }
        for &line in &self.aperture {
            self.above.push(line);
        }
    }
}
