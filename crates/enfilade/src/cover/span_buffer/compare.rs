//! Which of two faces is before the other: asked once a pair where that can be, not once a row.
//!
//! Two convex faces that do not cross have one order wherever they overlap on the screen. So an answer holds for all
//! rows; each face goes in whole, so it need not be kept longer than that. An answer about a neighbour is taken over
//! where it must be the same: the boxes around both faces are apart, so that they do not cross, and at a point that
//! both of the other pair reach, the order is known. Faces that may cross are compared anew in each row.
//! Source: Boreskov, Hierarchical s-buffer for scenes of high complexity, section 2, statements 1 to 3. Statement 3 is
//!     false without a condition: the third face must meet the shared edge, and not touch it.

use super::face::{Face, PlaneSide};
use super::rows::{COVERED, Span};
use crate::cover::triangle::Row;
use crate::stats::SpanStats;

/// What is known of a kept face and the last face that was held against it.
#[derive(Clone, Copy, Default)]
pub(super) struct CachedOrder {
    /// That face's turn, from 1.
    by: u32,
    order: Order,
}

/// Where the newer face lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Order {
    Before {
        /// Do both not touch?
        apart: bool,
    },
    Behind {
        apart: bool,
    },
    /// They may cross.
    #[default]
    Unsure,
}

/// How a newcomer lies to part of a span.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Relation {
    Before,
    Behind,
    /// From column `at` on the other way round.
    Crosses {
        at: u16,
        before_first: bool,
    },
}

/// The face that is going in.
pub(super) struct NewFace<'a> {
    pub(super) face: &'a Face,
    /// Its turn, from 1.
    turn: u32,
    /// The turns of its neighbours across its edges; 0: not met.
    neighbours: [u32; 3],
    kept: &'a mut Vec<Face>,
    cached_orders: &'a mut Vec<CachedOrder>,
    /// Its place among the kept, once it owns a sample.
    index: Option<u32>,
    y: u16,
    row: Row,
    /// The span to the left, and how the newcomer lies to it.
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

    /// Its place among the kept, if it owns a sample.
    pub(super) fn index(&self) -> Option<u32> {
        self.index
    }

    #[inline(always)]
    pub(super) fn begin_run(&mut self, y: u16) {
        self.y = y;
        self.row = self.face.triangle.row(y);
        self.left = None;
    }

    /// A span of its own in the row at hand.
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

    /// How it lies to columns `x0..x1` of a span.
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

    /// The span to the left ends where this one begins, also in space, and the newcomer lies across both: it passes
    /// their common end on the same side.
    ///
    /// That they share an edge is not enough: of a fold, one hides part of the other, and ends before it.
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

    /// Do the planes of two faces meet in the row at hand between the sample before column `x` and the one there?
    #[inline]
    fn meet(&self, left: &Face, right: &Face, x: u16) -> bool {
        if left.triangle.owner == right.triangle.owner {
            return true;
        }
        let [left, right] = [left, right].map(|face| face.triangle.row(self.y));
        let [here, there] = [x - 1, x].map(|x| left.beyond(x) - right.beyond(x));
        (here >= 0.0 && there <= 0.0) || (here <= 0.0 && there >= 0.0)
    }

    /// A neighbour of the newcomer was the last to be held against the old face, and the edge between both passes it:
    /// the newcomer passes it on the same side.
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

    /// Compares reversed depth at both ends; where they disagree, finds the column at which it turns.
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
