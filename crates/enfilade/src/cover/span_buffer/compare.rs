//! Depth order of two faces, computed once per pair where possible, not once per row.
//!
//! Two convex faces that do not intersect have the same order wherever they overlap on the screen, so a result holds
//! for all rows. A face is inserted as a whole, so results need not be kept any longer. The result for an adjacent face
//! is reused if it must be the same: the AABBs of the two faces are disjoint, so they do not intersect, and the order
//! is known at a point that both pairs share. Faces that may intersect are compared anew in each row.
//! Source: Boreskov, Hierarchical s-buffer for scenes of high complexity, section 2, statements 1 to 3. Statement 3 is
//!     false without a condition: the third face must cross the shared edge on the screen, and not touch it.

use super::face::{Face, PlaneSide};
use super::rows::{COVERED, Span};
use crate::raster::Row;
use crate::stats::SpanStats;

/// Order of a kept face and the last face that was compared with it.
#[derive(Clone, Copy, Default)]
pub(super) struct CachedOrder {
    /// Serial number of that face, from 1.
    by: u32,
    order: Order,
}

/// Position of the newer face relative to the older one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Order {
    Before {
        /// Whether the faces do not touch.
        apart: bool,
    },
    Behind {
        apart: bool,
    },
    /// The faces may intersect.
    #[default]
    Unsure,
}

/// Position of a new face relative to part of a span.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Relation {
    Before,
    Behind,
    /// The order swaps at column `at`.
    Crosses {
        at: u16,
        before_first: bool,
    },
}

/// The face that is being inserted.
pub(super) struct NewFace<'a> {
    pub(super) face: &'a Face,
    /// Its serial number, from 1.
    turn: u32,
    /// Serial numbers of its neighbours across its edges; 0 for one not inserted yet.
    neighbours: [u32; 3],
    kept: &'a mut Vec<Face>,
    cached_orders: &'a mut Vec<CachedOrder>,
    /// Its index among the kept faces, once it owns a sample.
    index: Option<u32>,
    y: u16,
    row: Row,
    /// The span to the left, and the position of the new face relative to it.
    left: Option<(Span, Order)>,
}

impl<'a> NewFace<'a> {
    #[inline(always)]
    pub(super) fn new(
        face: &'a Face,
        turn: u32,
        neighbours: [u32; 3],
        kept: &'a mut Vec<Face>,
        cached_orders: &'a mut Vec<CachedOrder>,
        index: Option<u32>,
    ) -> NewFace<'a> {
        NewFace {
            y: 0,
            row: face.triangle.row(0),
            face,
            turn,
            neighbours,
            kept,
            cached_orders,
            index,
            left: None,
        }
    }

    /// Returns its index among the kept faces; `None` if it owns no sample.
    pub(super) fn index(&self) -> Option<u32> {
        self.index
    }

    #[inline(always)]
    pub(super) fn begin_run(&mut self, y: u16) {
        self.y = y;
        self.row = self.face.triangle.row(y);
        self.left = None;
    }

    /// Returns a span of this face in the current row. Adds the face to the kept ones if it is not there yet.
    #[inline(always)]
    pub(super) fn span(&mut self, x0: u16, x1: u16) -> Span {
        let index = match self.index {
            Some(index) => index,
            None => self.keep(),
        };
        let [a, b] = [self.row.at(x0) as f32, self.row.at(x1 - 1) as f32];
        let [farthest, nearest] = if a < b { [a, b] } else { [b, a] };
        Span {
            x0,
            x1,
            face: index,
            farthest: farthest.next_down(),
            nearest: nearest.next_up(),
        }
    }

    #[inline(never)]
    fn keep(&mut self) -> u32 {
        let index = self.kept.len() as u32;
        self.kept.push(*self.face);
        self.cached_orders.push(CachedOrder::default());
        self.index = Some(index);
        index
    }

    /// Compares the face with columns `x0..x1` of a span.
    #[inline(always)]
    pub(super) fn compare(&mut self, span: &Span, x0: u16, x1: u16, stats: &mut SpanStats) -> Relation {
        if span.face == COVERED {
            self.left = None;
            return Relation::Behind;
        }
        stats.compared += 1;
        let known = self.cached_orders[span.face as usize];
        let order = if known.by == self.turn {
            stats.by_cache += u64::from(known.order != Order::Unsure);
            known.order
        } else {
            let order = self.compute_order(span, known, stats);
            self.cached_orders[span.face as usize] = CachedOrder { by: self.turn, order };
            order
        };
        self.left = Some((*span, order));
        match order {
            Order::Before { .. } => Relation::Before,
            Order::Behind { .. } => Relation::Behind,
            Order::Unsure => {
                stats.by_depth += 1;
                self.by_depth(span, x0, x1)
            }
        }
    }

    #[inline(never)]
    fn compute_order(&self, span: &Span, known: CachedOrder, stats: &mut SpanStats) -> Order {
        let new = self.face;
        let old = &self.kept[span.face as usize];
        let apart = new.is_apart_from(old);
        if apart {
            if let Some(order) = self.order_from_left_span(span, old) {
                stats.by_neighbour += 1;
                return order;
            }
            if let Some(order) = self.order_from_neighbour(old, known) {
                stats.by_adjacency += 1;
                return order;
            }
        }
        if new.triangle.greatest < old.triangle.least {
            stats.by_range += 1;
            return Order::Behind { apart: true };
        }
        if new.triangle.least > old.triangle.greatest {
            stats.by_range += 1;
            return Order::Before { apart: true };
        }
        let order = match new.side_of(old) {
            PlaneSide::Before { apart: clear } => Order::Before { apart: apart | clear },
            PlaneSide::Behind { apart: clear } => Order::Behind { apart: apart | clear },
            PlaneSide::Level if new.triangle.owner < old.triangle.owner => Order::Before { apart: false },
            PlaneSide::Level => Order::Behind { apart: false },
            PlaneSide::Unsure => Order::Unsure,
        };
        stats.by_plane += u64::from(order != Order::Unsure);
        order
    }

    /// Returns the order relative to the span on the left, if it must be the same: the two spans' faces are adjacent
    /// and meet in space at this column, and the new face overlaps both, so it passes their common end on the same
    /// side.
    ///
    /// A shared edge alone is not enough: at a fold one face hides part of the other, and its span ends in front of it.
    #[inline]
    fn order_from_left_span(&self, span: &Span, old: &Face) -> Option<Order> {
        let (left, order) = self.left?;
        let clear = matches!(
            order,
            Order::Before { apart: true } | Order::Behind { apart: true }
        );
        let before = &self.kept[left.face as usize];
        (clear && left.x1 == span.x0 && before.adjoins(old) && self.meet(before, old, span.x0))
            .then_some(order)
    }

    /// Returns `true` if the planes of two faces intersect, in the current row, between the samples at columns `x - 1`
    /// and `x`.
    #[inline]
    fn meet(&self, left: &Face, right: &Face, x: u16) -> bool {
        if left.triangle.owner == right.triangle.owner {
            return true;
        }
        let [left, right] = [left, right].map(|face| face.triangle.row(self.y));
        let [here, there] = [x - 1, x].map(|x| left.beyond(x) - right.beyond(x));
        (here >= 0.0 && there <= 0.0) || (here <= 0.0 && there >= 0.0)
    }

    /// Returns the cached order of the old face, if it must be the same: it was computed for a neighbour of the new
    /// face, and the midpoint of their common edge is, on the screen, inside the old face. So both pass it on the same
    /// side.
    #[inline]
    fn order_from_neighbour(&self, old: &Face, known: CachedOrder) -> Option<Order> {
        let clear = matches!(
            known.order,
            Order::Before { apart: true } | Order::Behind { apart: true }
        );
        if !clear || known.by == 0 {
            return None;
        }
        let edge = self.neighbours.iter().position(|&turn| turn == known.by)?;
        old.contains_edge_midpoint(self.face, edge).then_some(known.order)
    }

    /// Compares reversed depths at both ends; if they disagree, finds the column at which the order swaps.
    #[inline]
    fn by_depth(&self, span: &Span, x0: u16, x1: u16) -> Relation {
        let old = &self.kept[span.face as usize].triangle;
        let theirs = old.row(self.y);
        let before = |x: u16| {
            let [mine, theirs] = [self.row.at(x), theirs.at(x)];
            mine > theirs || (mine == theirs && self.face.triangle.owner < old.owner)
        };
        let [mut same, mut other] = [x0, x1 - 1];
        let before_first = before(same);
        if before(other) == before_first {
            return if before_first {
                Relation::Before
            } else {
                Relation::Behind
            };
        }
        while other - same > 1 {
            let middle = same + (other - same) / 2;
            if before(middle) == before_first {
                same = middle;
            } else {
                other = middle;
            }
        }
        Relation::Crosses {
            at: other,
            before_first,
        }
    }
}
