//! How a box is asked after as it is: its corners held against the planes, never cut.
//!
//! Where a plane goes through it, it is on both sides, even if other planes say that only one of them is left. So what
//! its faces come to, it comes to as well: what is hidden by box is hidden by faces.
//! Source: Bittner, Havran, Slavík, Hierarchical Visibility Culling with Occlusion Trees, CGI 1998, section 3.
//! Cost: O(nodes reached), until enough is known; eight corners at once ([`corners`](super::corners)).
//! Conservative. A corner that is certainly in a lit leaf shows that the box is seen: its faces need not be asked.

use super::corners::{ALL, Bits, Corners};
use super::{Link, OcclusionTree, Plane, Tree};
use crate::region::{Visibility, Volume};
use fearless_simd::dispatch;
use fearless_simd::prelude::*;

/// What the leaves that a box came to say of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Found {
    pub(super) lit: bool,
    pub(super) shadow: bool,
    /// Is a corner certainly in a lit leaf?
    pub(super) lit_for_certain: bool,
}

/// What an answer must say; more need not be found out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wanted {
    /// Is anything lit?
    Lit,
    /// Is anything lit, and anything in shadow?
    Visibility,
    /// As `Visibility`, and where some of both, is any corner lit for certain?
    Certain,
}

/// Where a box is asked after from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Start {
    /// `None`: the root, whatever that is by now.
    link: Option<Link>,
    /// Is it certainly within the aperture, and beyond all that is before it?
    in_view: bool,
}

/// A link that a box also comes to, with the corners that are certainly there.
pub(super) type Waiting = (Link, Bits);

impl Found {
    pub(super) fn sight(&self) -> Visibility {
        match (self.lit, self.shadow) {
            (true, true) => Visibility::Partial,
            (true, false) => Visibility::Full,
            (false, _) => Visibility::Hidden,
        }
    }

    #[inline(always)]
    fn is_enough(&self, wanted: Wanted) -> bool {
        match wanted {
            Wanted::Lit => self.lit,
            Wanted::Visibility => self.lit && self.shadow,
            Wanted::Certain => self.lit_for_certain && self.shadow,
        }
    }
}

impl<A> OcclusionTree<A> {
    /// What the box alone tells; `None` where it is out of view.
    pub(super) fn ask(&mut self, volume: &Volume, wanted: Wanted) -> Option<Found> {
        let OcclusionTree {
            level,
            start,
            within,
            tree,
            links,
            ..
        } = self;
        *within = *start;
        dispatch!(*level, simd => match wanted {
            Wanted::Certain => tree.ask::<_, true>(simd, links, within, volume, wanted),
            _ => tree.ask::<_, false>(simd, links, within, volume, wanted),
        })
    }

    /// How much of the box can be seen, as far as the box alone tells.
    #[cfg(test)]
    pub(super) fn sees_box(&mut self, volume: &Volume) -> Visibility {
        self.ask(volume, Wanted::Visibility)
            .map_or(Visibility::Hidden, |found| found.sight())
    }
}

impl Tree {
    /// `within` says where to begin, and then where what lies in the box may begin. `CERTAIN`: know corners for certain?
    // No closures here: what runs in one does not run at the SIMD level.
    #[inline(always)]
    fn ask<S: Simd, const CERTAIN: bool>(
        &self,
        simd: S,
        links: &mut Vec<Waiting>,
        within: &mut Start,
        volume: &Volume,
        wanted: Wanted,
    ) -> Option<Found> {
        let corners = Corners::new(simd, volume);
        let mut found = Found::default();
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
        // What lies in the box is where all its corners well are, so far.
        let mut is_all_here = true;
        loop {
            // Some of both is known: only a corner that is here for certain can tell more.
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
                    // Where a corner certainly is, most is known soonest.
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
            if found.is_enough(wanted) {
                return Some(found);
            }
            match links.pop() {
                Some(waiting) => (next, certain) = waiting,
                None => return Some(found),
            }
        }
    }
}
