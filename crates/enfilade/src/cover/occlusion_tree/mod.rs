//! Occlusion tree: what chosen occluders hide, merged into one tree of planes.
//!
//! What an occluder hides is bounded by a plane through the eye for each of its edges, and by its own plane. It is
//! filtered down the tree, cut by the planes it meets; where it comes to a place that nothing hides yet (a lit leaf),
//! its planes stand from then on, with a shadow behind them. What lies in shadow leaves only is hidden.
//! Source: Chin, Feiner, Fast Object-Precision Shadow Generation for Area Light Sources Using BSP Trees, I3D 1992 (and
//!     Near Real-Time Shadow Generation Using BSP Trees, SIGGRAPH 1989); Bittner, Havran, Slavík, Hierarchical
//!     Visibility Culling with Occlusion Trees, CGI 1998, section 3.
//! Cost: inserting O(leaves reached · depth), a test O(leaves reached); nothing is allocated once warm.
//! Strict: what is hidden is hidden at any place in any pixel. Occluders that meet leave no crack. See below.
//!
//! # Why what is called hidden is hidden
//!
//! * **A shadow is behind one whole occluder.** Above each shadow leaf stand the planes of one occluder: its own, pushed
//!   away by more than rounding, and those of all its edges. So however wrongly pieces were cut on the way there, they
//!   only decide where shadows are made, never how large they are. A piece that is lost loses a shadow.
//! * **An edge is left out only if it is nowhere in the leaf**: every place of it is outside of, or within `SLIT` of,
//!   a plane above; and the piece is thick enough that what lies inside all other planes cannot leave the occluder by
//!   more than 1,000 times that, which is 2⁻¹⁴ pixel. (`insert.rs`)
//! * **A question is never cut short.** A polygon goes to each side of a line on which it has a corner more than `SLIT`
//!   off; what is lost of it lies within `SLIT` of a line of the tree. Against planes of occluders it is only hidden
//!   where all corners are certainly beyond: ties are visible.
//!
//! So what is called hidden shows at most in slits of 2⁻²⁴ pixel along the lines of edges, and by what 2⁻¹⁴ pixel more
//! or less of an occluder would show; two samples of the laws that must agree are 2⁻¹⁰ pixel apart. Without any such
//! measure nothing would be hidden behind two walls of which one ends in the middle of the other's edge: in f64 that
//! corner never lies on the line. Corners come rounded to f64; the answer is true of corners some units in the last
//! place away.

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

use super::{Cover, Hides};
use crate::aperture::Rect;
use crate::canvas::{Canvas, CoverShape};
use crate::geom::Aabb;
use crate::occluders::{Occluder, OccluderMeasure};
use crate::order::Unsorted;
use crate::passage::Passage;
use crate::region::{Region, Visibility, Volume};
use crate::stats::Stats;
use above::Above;
use by_box::{Start, Waiting, Wanted};
use fearless_simd::Level;
use glam::{DAffine3, DVec3};
use line::{Back, Line};
use pieces::{Piece, Pieces};
use std::marker::PhantomData;

/// What chosen occluders hide, as one tree of planes; asked by `A`, [`ByFaces`] or [`ByBox`].
pub struct OcclusionTree<A> {
    level: Level,
    /// Where boxes are asked after from.
    start: Start,
    /// Where those may be that lie in the box asked after last.
    within: Start,
    tree: Tree,
    /// Polygons at work.
    pieces: Pieces,
    edges: Vec<Edge>,
    entering: Vec<(Location, Piece)>,
    waiting: Vec<(Link, Piece)>,
    links: Vec<Waiting>,
    asks: PhantomData<fn() -> A>,
}

/// Where the box itself does not tell, filters its faces down the tree, cut by its planes.
#[derive(Default)]
pub struct ByFaces;

/// Only holds a box against the planes: cheaper, and more is called partly visible.
#[derive(Default)]
pub struct ByBox;

/// Nodes, at most. What would need more is not inserted: it hides less, and costs no more.
const MAX_NODES: usize = 1 << 15;

/// By how many pixels the aperture is widened: more than rounding can move the lines of its edges.
const WIDEN: f64 = 1.0 / (1 << 14) as f64;

/// The planes, and the aperture above them all.
struct Tree {
    /// What is before all of these, n · p < d, is not asked after: the near distance and the last portal.
    before: Vec<(DVec3, f64)>,
    /// What is outside of any of these is hidden.
    aperture: Vec<Line>,
    /// The greatest |x| and |y| on the screen inside the aperture.
    far: [f64; 2],
    root: Link,
    nodes: Vec<Node>,
    /// For each occluder, how many nodes there were before it came.
    firsts: Vec<u32>,
    /// Lines that bound a place; see [`Tree::gather_above`].
    above: Above,
}

/// A plane, and what hangs on either side of it.
#[derive(Clone, Copy, Debug)]
struct Node {
    plane: Plane,
    /// Of a line inside, of an occluder's plane beyond.
    inside: Link,
    outside: Link,
    above: Location,
}

#[derive(Clone, Copy, Debug)]
enum Plane {
    Line(Line),
    Back(Back),
}

/// What hangs below.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Link {
    /// Nothing hides what is here.
    Lit,
    /// An occluder hides all that is here.
    Shadow,
    Node(u32),
}

/// Where something hangs: on which node, and on which side; or at the top.
type Location = Option<(u32, Side)>;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Inside,
    Outside,
}

/// An edge of the occluder that is being inserted.
#[derive(Clone, Copy, Debug)]
struct Edge {
    from: DVec3,
    to: DVec3,
    line: Line,
}

/// How a tree is asked after a box.
pub trait Asks: Default + Send + Sized + 'static {
    /// How much of a box can be seen; `None` where it is out of view.
    fn sight(tree: &mut OcclusionTree<Self>, volume: &Volume) -> Option<Visibility>;
}

impl Asks for ByFaces {
    fn sight(tree: &mut OcclusionTree<ByFaces>, volume: &Volume) -> Option<Visibility> {
        let found = tree.ask(volume, Wanted::Certain)?;
        let unsure = found.lit && found.shadow && !found.lit_for_certain;
        if unsure && !tree.sees_faces(volume) {
            return Some(Visibility::Hidden);
        }
        Some(found.sight())
    }
}

impl Asks for ByBox {
    fn sight(tree: &mut OcclusionTree<ByBox>, volume: &Volume) -> Option<Visibility> {
        Some(tree.ask(volume, Wanted::Visibility)?.sight())
    }
}

impl<A: Asks> Cover for OcclusionTree<A> {
    type CullNeeds = Unsorted;

    fn sees(&mut self, region: &Region) -> Visibility {
        A::sight(self, &region.volume).unwrap_or(Visibility::Hidden)
    }

    fn sight_of(
        &mut self,
        _passage: &Passage,
        screen_from_local: &DAffine3,
        bounds: &Aabb,
    ) -> Option<Visibility> {
        // Its lines are the aperture's too: neither the box's samples nor its reversed depth are needed.
        if bounds.is_empty() {
            return None;
        }
        A::sight(self, &Volume::new(screen_from_local, bounds))
    }

    fn go_within(&mut self) {
        self.start = self.within;
    }

    fn go_back(&mut self) {
        self.start = Start::default();
    }

    fn needs_bytes(_size: [u32; 2]) -> u64 {
        // The pieces of one occluder or face may come to every leaf.
        (MAX_NODES * (size_of::<Node>() + 4 * size_of::<DVec3>())) as u64
    }

    const SHAPE: Option<CoverShape> = Some(CoverShape::Tree);

    fn show(&mut self, passage: &Passage, canvas: &mut dyn Canvas) {
        self.tree.show(passage, canvas);
    }
}

impl<A: Asks> Hides for OcclusionTree<A> {
    const MEASURE: OccluderMeasure = OccluderMeasure::AreaAngle;
    const OCCLUDERS: u32 = 128;

    fn clear(&mut self, passage: &Passage) {
        self.tree
            .open(passage.aperture.outline(), &passage.aperture.rect());
        self.tree.before.push((DVec3::Z, f64::from(passage.near)));
        let entry = passage.entry.map(|(normal, d)| (normal, d * (1.0 - 1e-6)));
        self.tree.before.extend(entry);
        self.go_back();
    }

    fn hides(&mut self, _passage: &Passage, screen_from_local: &DAffine3, bounds: &Aabb) -> bool {
        // By its faces it would cost more than most occluders save; and so both kinds of tree take the same ones.
        if bounds.is_empty() {
            return true;
        }
        let found = self.ask(&Volume::new(screen_from_local, bounds), Wanted::Lit);
        !found.is_some_and(|found| found.lit)
    }

    fn hide(&mut self, occluder: &Occluder, passage: &Passage, _stats: &mut Stats) {
        self.insert(
            occluder,
            f64::from(passage.near),
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
            waiting: Vec::new(),
            links: Vec::new(),
            asks: PhantomData,
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
            above: Above::default(),
        }
    }
}

impl Tree {
    /// Starts over with an aperture: its outline, counter-clockwise on the screen, and the rectangle of its samples.
    fn open(&mut self, mut outline: &[[f64; 2]], rect: &Rect) {
        self.nodes.clear();
        self.firsts.clear();
        self.root = Link::Lit;
        self.before.clear();
        self.aperture.clear();
        let mut min = [rect.x0, rect.y0].map(f64::from);
        let mut max = [rect.x1, rect.y1].map(f64::from);
        if outline.len() < 3 {
            // Only its samples are known: all of their pixels.
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
            // Upright edges are sides of the rectangle; short ones turn too far when their ends are rounded.
            let upright = from[0] == to[0] || from[1] == to[1];
            let short = (from[0] - to[0]).abs() + (from[1] - to[1]).abs() < 1.0;
            if !upright && !short {
                let [from, to] = [from, to].map(|[x, y]| DVec3::new(x, y, 1.0));
                let line = Line::through(from, to).map(|line| line.outward(WIDEN));
                self.aperture.extend(line);
            }
        }
    }

    /// What is asked after; nothing can be let in afterwards.
    fn copy(&mut self, from: &Tree) {
        self.before.clone_from(&from.before);
        self.aperture.clone_from(&from.aperture);
        self.far = from.far;
        self.root = from.root;
        self.nodes.clone_from(&from.nodes);
    }

    fn at(&self, place: Location) -> Link {
        match place {
            None => self.root,
            Some((node, Side::Inside)) => self.nodes[node as usize].inside,
            Some((node, Side::Outside)) => self.nodes[node as usize].outside,
        }
    }

    /// Hangs a new node at a place; what hung there is forgotten.
    fn hang(&mut self, place: Location, plane: Plane, inside: Link) -> u32 {
        let number = self.nodes.len() as u32;
        self.nodes.push(Node {
            plane,
            inside,
            outside: Link::Lit,
            above: place,
        });
        let link = match place {
            None => &mut self.root,
            Some((node, Side::Inside)) => &mut self.nodes[node as usize].inside,
            Some((node, Side::Outside)) => &mut self.nodes[node as usize].outside,
        };
        *link = Link::Node(number);
        number
    }

    /// Gathers the lines that bound a place, turned so that the place is inside: the lowest first, the aperture's last.
    fn gather_above(&mut self, place: Location) {
        self.above.clear();
        let mut next = place;
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
