//! Edge sums that clusters left open in a cell, kept until later clusters close them.

/// Open edge sums of a cell: of the last cluster, of the last two, of the last three, and of all since the cell was
/// last covered. Three clusters meet at the corner of a cluster; more combinations are not worth the memory.
#[derive(Clone, Copy)]
pub(super) struct OpenEdges {
    edges: [u64; SUMS],
    least: [f32; SUMS],
    /// Number of the last cluster that was added.
    batch: u32,
}

const SUMS: usize = 4;

impl Default for OpenEdges {
    fn default() -> OpenEdges {
        OpenEdges {
            edges: [0; SUMS],
            least: [f32::INFINITY; SUMS],
            batch: 0,
        }
    }
}

impl OpenEdges {
    /// Adds the edge sum that cluster `batch` leaves open. If one of the sums becomes zero, resets them and returns the
    /// minimum reversed depth of its clusters. Sums from before cluster `first` belong to another passage and are
    /// dropped.
    #[inline]
    pub(super) fn add(&mut self, edges: u64, least: f32, batch: u32, first: u32) -> Option<f32> {
        if self.batch < first {
            *self = OpenEdges::default();
        }
        self.batch = batch;
        // The last cluster becomes one of the last two, and so on; the sum of all clusters stays.
        self.edges.copy_within(..SUMS - 2, 1);
        self.least.copy_within(..SUMS - 2, 1);
        (self.edges[0], self.least[0]) = (0, f32::INFINITY);
        for sum in 0..SUMS {
            self.edges[sum] = self.edges[sum].wrapping_add(edges);
            self.least[sum] = self.least[sum].min(least);
        }
        let closed = self.edges.iter().position(|&sum| sum == 0)?;
        let rev_depth = self.least[closed];
        *self = OpenEdges::default();
        Some(rev_depth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adds the sums of successive clusters of one passage and returns the depth at which the last one covers the cell.
    fn last_of(clusters: &[(u64, f32)]) -> Option<f32> {
        let mut open_edges = OpenEdges::default();
        let added = (1..).zip(clusters);
        let covered = added.map(|(batch, &(edges, least))| open_edges.add(edges, least, batch, 1));
        covered.last().flatten()
    }

    #[test]
    fn what_closes_the_last_few_or_all_covers_the_cell() {
        let minus = u64::wrapping_neg;
        assert_eq!(last_of(&[(7, 0.5), (3, 0.25)]), None);
        assert_eq!(last_of(&[(7, 0.5), (3, 0.25), (minus(3), 0.75)]), Some(0.25));
        assert_eq!(
            last_of(&[(9, 0.1), (7, 0.5), (3, 0.25), (minus(10), 0.75)]),
            Some(0.25)
        );
        assert_eq!(
            last_of(&[(9, 0.1), (7, 0.5), (3, 0.25), (minus(19), 0.75)]),
            Some(0.1)
        );
    }

    #[test]
    fn what_waited_is_gone_when_the_cell_is_covered() {
        let minus = u64::wrapping_neg;
        assert_eq!(
            last_of(&[(7, 0.5), (3, 0.25), (minus(3), 0.75), (minus(7), 0.5)]),
            None
        );
    }

    #[test]
    fn what_another_passage_left_open_stays_there() {
        let mut open_edges = OpenEdges::default();
        assert_eq!(open_edges.add(7, 0.5, 4, 1), None);
        assert_eq!(open_edges.add(7_u64.wrapping_neg(), 0.5, 9, 5), None);
    }
}
