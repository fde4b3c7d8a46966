//! What a ray bundle hits in one sector.

use super::EPSILON;
use super::tree::{HitSink, Meeting};
use crate::geometry::Owner;

/// Hits of a ray bundle in a sector; the hidden ones are filtered out at the end.
pub(super) struct Hits<const N: usize> {
    active: [bool; N],
    /// Minimum and maximum parameter at which each ray starts: the near distance or the portal. Nearer hits are
    /// ignored.
    from: [[f64; 2]; N],
    /// Parameter of each ray's nearest certain occluder.
    nearest: [f64; N],
    reach: [f64; N],
    /// Largest parameter at which a face that is not hidden may start, over the active rays.
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

    /// Returns `true` if `w` is certainly past the ray's start. A nearer hit is possible, but is no certain occluder.
    pub(super) fn certainly_beyond(&self, ray: usize, w: f64) -> bool {
        w > self.from[ray][1] * (1.0 + EPSILON)
    }

    pub(super) fn nearest(&self, ray: usize) -> f64 {
        self.nearest[ray]
    }

    /// Returns the smallest parameter of anything that may be an occluder along the ray.
    pub(super) fn first_hiding(&self, ray: usize) -> f64 {
        let hiding = self.meetings.iter().map(|(meeting, _)| meeting);
        let hiding = hiding.filter(|meeting| meeting.ray == ray && meeting.hides);
        hiding.map(|meeting| meeting.w[0]).fold(f64::INFINITY, f64::min)
    }

    /// Returns all hits that are not certainly hidden. Call it after all hits are added.
    pub(super) fn meetings(&self) -> impl Iterator<Item = &(Meeting, Owner)> {
        self.meetings
            .iter()
            .filter(|(meeting, _)| !self.hidden(meeting.ray, meeting.w[0]))
    }

    fn hidden(&self, ray: usize, w: f64) -> bool {
        w > self.nearest[ray] * (1.0 + EPSILON)
    }

    /// Adds a hit. If it is a certain occluder, everything behind it is hidden.
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
            // A nearly coplanar face may start nearer than its hit by at most this hit's uncertainty.
            self.reach[ray] = greatest + (greatest - least);
            let all = (0..N).filter(|&ray| self.active[ray]);
            self.farthest = all.map(|ray| self.reach[ray]).fold(0.0, f64::max);
        }
        self.meetings.push((meeting, owner));
    }
}

impl<const N: usize> HitSink for Hits<N> {
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
