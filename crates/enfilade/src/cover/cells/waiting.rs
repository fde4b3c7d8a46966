//! What waits in a cell for the rest of its surface.

/// Sums of what clusters left open in a cell: of the last alone, of the last two, and of all since the cell was covered
/// last. More ways to choose among them are not worth the room.
#[derive(Clone, Copy)]
pub(super) struct Waiting {
    edges: [u64; 3],
    least: [f32; 3],
    /// The last cluster that was added.
    batch: u32,
}

impl Default for Waiting {
    fn default() -> Waiting {
        Waiting {
            edges: [0; 3],
            least: [f32::INFINITY; 3],
            batch: 0,
        }
    }
}

impl Waiting {
    /// Takes what cluster `batch` leaves open. Where it closes what waited, gives the least nearness of both. What waited
    /// since before cluster `first` is of another passage.
    #[inline]
    pub(super) fn add(&mut self, edges: u64, least: f32, batch: u32, first: u32) -> Option<f32> {
        if self.batch < first {
            *self = Waiting::default();
        }
        self.batch = batch;
        let with = |place: usize| {
            (
                self.edges[place].wrapping_add(edges),
                if least < self.least[place] {
                    least
                } else {
                    self.least[place]
                },
            )
        };
        let [(two, least_of_two), (all, least_of_all)] = [with(0), with(2)];
        self.edges = [edges, two, all];
        self.least = [least, least_of_two, least_of_all];
        let closed = self.edges.iter().position(|&sum| sum == 0)?;
        let nearness = self.least[closed];
        *self = Waiting::default();
        Some(nearness)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_closes_the_last_the_last_two_or_all_covers_the_cell() {
        let mut waiting = Waiting::default();
        assert_eq!(waiting.add(7, 0.5), None);
        assert_eq!(waiting.add(3, 0.25), None);
        assert_eq!(waiting.add(3_u64.wrapping_neg(), 0.75), Some(0.25));
        assert_eq!(
            waiting.add(7_u64.wrapping_neg(), 0.5),
            None,
            "what waited is gone"
        );
        let [a, b] = [4_u64, 5];
        let rest = (a + b).wrapping_neg();
        let mut waiting = Waiting::default();
        assert_eq!(waiting.add(a, 0.5, 1, 1), None);
        assert_eq!(waiting.add(b, 0.1, 2, 1), None);
        assert_eq!(waiting.add(rest, 0.5, 3, 1), Some(0.1));
    }
    #[test]
    fn what_another_passage_left_open_stays_there() {
        let mut waiting = Waiting::default();
        assert_eq!(waiting.add(7, 0.5, 4, 1), None);
        assert_eq!(waiting.add(7_u64.wrapping_neg(), 0.5, 9, 5), None);
    }
}
