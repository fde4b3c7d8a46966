//! What the rays of a bundle meet in one sector.

use super::EPSILON;
use super::tree::{Found, Meeting};
use crate::geometry::Owner;

/// What rays meet in a sector, sorted out when all is known.
pub(super) struct Hits<const N: usize> {
    active: [bool; N],
    /// Nearer than this a ray sees nothing: the near distance, or the portal; at the least, and at the most.
    from: [[f64; 2]; N],
    /// The nearest that certainly hides what is behind it.
    nearest: [f64; N],
    reach: [f64; N],
    /// As far as a face may begin that is not hidden by these, over the active rays.
    farthest: f64,
    meetings: Vec<(Meeting, Owner)>,
}

impl<const N: usize> Hits<N> {
    pub(super) fn new(active: [bool; N], from: [[f64; 2]; N]) -> Hits<N> {
        Hits {
            active,
            from,
            nearest: [f64::INFINITY; N],
            reach: [f64::INFINITY; N],
            farthest: f64::INFINITY,
            meetings: Vec::with_capacity(2 * N),
        }
    }

    /// What is this near to where seeing begins may be seen or not: it is possible, but hides nothing for certain.
    pub(super) fn certainly_beyond(&self, ray: usize, w: f64) -> bool {
        w > self.from[ray][1] * (1.0 + EPSILON)
    }

    pub(super) fn nearest(&self, ray: usize) -> f64 {
        self.nearest[ray]
    }

    /// The nearest that may hide what is behind it.
    pub(super) fn first_hiding(&self, ray: usize) -> f64 {
        let hiding = self.meetings.iter().map(|(meeting, _)| meeting);
        let hiding = hiding.filter(|meeting| meeting.ray == ray && meeting.hides);
        hiding.map(|meeting| meeting.w[0]).fold(f64::INFINITY, f64::min)
    }

    /// All that is not behind what certainly hides it; asked when all is taken.
    pub(super) fn meetings(&self) -> impl Iterator<Item = &(Meeting, Owner)> {
        self.meetings
            .iter()
            .filter(|(meeting, _)| !self.hidden(meeting.ray, meeting.w[0]))
    }

    fn hidden(&self, ray: usize, w: f64) -> bool {
        w > self.nearest[ray] * (1.0 + EPSILON)
    }

    /// Takes what is met. What is farther is hidden, if it hides and is met for certain.
    pub(super) fn take(&mut self, meeting: Meeting, owner: Owner, certain: bool) {
        let Meeting {
            ray,
            w: [least, greatest],
            hides,
            ..
        } = meeting;
        if self.hidden(ray, least) {
            return;
        }
        if hides && certain && greatest < self.nearest[ray] {
            self.nearest[ray] = greatest;
            // A face nearly in the same plane begins at most as much before where it is met.
            self.reach[ray] = greatest + (greatest - least);
            let all = (0..N).filter(|&ray| self.active[ray]);
            self.farthest = all.map(|ray| self.reach[ray]).fold(0.0, f64::max);
        }
        self.meetings.push((meeting, owner));
    }
}

impl<const N: usize> Found for Hits<N> {
    fn limit(&self) -> f64 {
        self.farthest * (1.0 + 2.0 * EPSILON)
    }

    fn add(&mut self, meeting: Meeting) {
        let [least, greatest] = meeting.w;
        if greatest >= self.from[meeting.ray][0] * (1.0 - EPSILON) {
            let certain = self.certainly_beyond(meeting.ray, least);
            self.take(meeting, Owner::Face(meeting.item, meeting.face), certain);
        }
    }
}
