//! Tests a box as a whole: its corners are classified against the planes, without clipping.
//!
//! A plane that crosses the box sends it to both sides, even if other planes leave only one of them. So the box reaches
//! every leaf that its faces reach: a box hidden by this test is also hidden by its faces.
//! Source: Bittner, Havran, Slavík, Hierarchical Visibility Culling with Occlusion Trees, CGI 1998, section 3.
//! Cost: O(nodes reached), until enough is known; eight corners at a time ([`corners`](super::corners)).
//! Conservative. A corner that is certainly in a lit leaf proves that the box is visible, so its faces need no test.

use super::corners::{ALL, Bits, Corners};
use super::{Link, OcclusionTree, Plane, Tree};
use crate::simd::dispatch;
use crate::view::region::{Visibility, Volume};
use fearless_simd::prelude::*;

/// Kinds of the leaves that a box reached.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct LeafSummary {
    pub(super) lit: bool,
    pub(super) shadow: bool,
    /// Whether a corner is certainly in a lit leaf.
    pub(super) lit_for_certain: bool,
}

/// The facts that a query must decide; the traversal stops as soon as it has them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Query {
    /// Whether the box reaches a lit leaf.
    Lit,
    /// Whether it reaches a lit leaf, and whether it reaches a shadow leaf.
    Visibility,
    /// As `Visibility`; if it reaches both, also whether any corner is certainly lit.
    Certain,
}

/// Starting point of the traversal for a box.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Start {
    /// `None` starts at the current root.
    link: Option<Link>,
    /// Whether the box is certainly inside the aperture and beyond the near plane and the entry plane.
    in_view: bool,
}

/// A link that the box also reaches, with the corners that are certainly there.
pub(super) type PendingLink = (Link, Bits);

impl LeafSummary {
    /// Returns the visibility that the reached leaves imply.
    pub(super) fn visibility(&self) -> Visibility {
        match (self.lit, self.shadow) {
            (true, true) => Visibility::Partial,
            (true, false) => Visibility::Full,
            (false, _) => Visibility::Hidden,
        }
    }

    #[inline(always)]
    fn is_enough(&self, query: Query) -> bool {
        match query {
            Query::Lit => self.lit,
            Query::Visibility => self.lit && self.shadow,
            Query::Certain => self.lit_for_certain && self.shadow,
        }
    }
}

impl<A> OcclusionTree<A> {
    /// Tests a box by its corners alone; `None` if it is outside the view.
    pub(super) fn test_box(&mut self, volume: &Volume, query: Query) -> Option<LeafSummary> {
        let OcclusionTree {
            level,
            start,
            within,
            tree,
            links,
            ..
        } = self;
        *within = *start;
        dispatch!(*level, simd => match query {
            Query::Certain => tree.test_box::<_, true>(simd, links, within, volume, query),
            _ => tree.test_box::<_, false>(simd, links, within, volume, query),
        })
    }

    /// Returns the visibility of a box as far as its corners tell.
    #[cfg(test)]
    pub(super) fn box_visibility(&mut self, volume: &Volume) -> Visibility {
        self.test_box(volume, Query::Visibility)
            .map_or(Visibility::Hidden, |found| found.visibility())
    }
}

impl Tree {
    /// Traverses the tree with a box. `within` is where to start, and returns where boxes inside this one may start.
    /// `CERTAIN`: track the corners that are certainly in the current subtree.
    // No closures here: code in a closure is not compiled for the SIMD level.
    #[inline(always)]
    fn test_box<S: Simd, const CERTAIN: bool>(
        &self,
        simd: S,
        links: &mut Vec<PendingLink>,
        within: &mut Start,
        volume: &Volume,
        query: Query,
    ) -> Option<LeafSummary> {
        let corners = Corners::new(simd, volume);
        let mut found = LeafSummary::default();
        let mut certain = ALL;
        if !within.in_view {
            let mut before = 0;
            for &(normal, distance) in &self.before {
                let here = corners.before(simd, normal, distance);
                if here == ALL {
                    return None;
                }
                before |= here;
            }
            for line in &self.aperture {
                let sides = corners.against(simd, line.normal, 0.0);
                if sides.outside == ALL {
                    return None;
                }
                found.shadow |= sides.inside != ALL;
                certain &= sides.well_inside;
            }
            within.in_view = before == 0 && certain == ALL;
        }
        links.clear();
        let mut next = within.link.unwrap_or(self.root);
        // Whether all corners are well inside the current subtree, so that boxes inside this one can start there.
        let mut is_all_here = true;
        loop {
            // Both kinds of leaf were reached: only a subtree with a certain corner can add information.
            let is_known = CERTAIN && certain == 0 && found.lit && found.shadow;
            match next {
                _ if is_known => {}
                Link::Lit => {
                    found.lit = true;
                    found.lit_for_certain |= certain != 0;
                }
                Link::Shadow => found.shadow = true,
                Link::Node(node) => {
                    let node = &self.nodes[node as usize];
                    let (normal, distance) = match &node.plane {
                        Plane::Line(line) => (line.normal, 0.0),
                        Plane::Back(back) => (back.normal, back.distance),
                    };
                    let sides = corners.against(simd, normal, distance);
                    if sides.outside == ALL {
                        next = node.outside;
                        if CERTAIN {
                            certain &= sides.well_outside;
                        }
                        is_all_here = is_all_here && sides.well_outside == ALL;
                        if is_all_here {
                            within.link = Some(next);
                        }
                        continue;
                    }
                    if sides.inside == ALL {
                        next = node.inside;
                        if CERTAIN {
                            certain &= sides.well_inside;
                        }
                        is_all_here = is_all_here && sides.well_inside == ALL;
                        if is_all_here {
                            within.link = Some(next);
                        }
                        continue;
                    }
                    is_all_here = false;
                    let [inside, outside] = if CERTAIN {
                        [sides.well_inside, sides.well_outside]
                    } else {
                        [sides.inside, sides.outside]
                    };
                    let inside = (node.inside, certain & inside);
                    let outside = (node.outside, certain & outside);
                    // The side with a certain corner first: it decides the query sooner.
                    if inside.1 != 0 && outside.1 == 0 {
                        links.push(outside);
                        (next, certain) = inside;
                    } else {
                        links.push(inside);
                        (next, certain) = outside;
                    }
                    continue;
                }
            }
            if found.is_enough(query) {
                return Some(found);
            }
            match links.pop() {
                Some(pending) => (next, certain) = pending,
                None => return Some(found),
            }
        }
    }
}
