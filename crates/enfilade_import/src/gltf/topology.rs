//! Triangle topologies: lists, strips and fans.
//!
//! Source: glTF 2.0 Specification, section 3.7.2.1.

/// The topology of a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Topology {
    /// Three corners per triangle.
    List,
    /// Each corner from the third on forms a triangle with the two before it.
    Strip,
    /// Each corner from the third on forms a triangle with the one before it and the first.
    Fan,
}

impl Topology {
    /// Returns the number of triangles of `corners` corners.
    pub(super) fn triangles(self, corners: u64) -> u64 {
        match self {
            Topology::List => corners / 3,
            Topology::Strip | Topology::Fan => corners.saturating_sub(2),
        }
    }

    /// Converts to a triangle list with consistent winding.
    pub(super) fn list(self, mut row: Vec<u32>) -> Vec<u32> {
        match self {
            Topology::List => {
                row.truncate(row.len() / 3 * 3);
                row
            }
            // Every second triangle of a strip has the opposite winding, so its last two corners are swapped.
            Topology::Strip => {
                let turned = |i: usize| [[0, 1, 2], [0, 2, 1]][i % 2];
                (0..row.len().saturating_sub(2))
                    .flat_map(|i| turned(i).map(|step| row[i + step]))
                    .collect()
            }
            Topology::Fan => match row.split_first() {
                Some((&first, rim)) => rim
                    .windows(2)
                    .flat_map(|pair| [pair[0], pair[1], first])
                    .collect(),
                None => row,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_make_triangles_as_the_specification_draws_them() {
        for (topology, corners, triangles) in [
            (Topology::List, 0, vec![]),
            (Topology::List, 7, vec![0, 1, 2, 3, 4, 5]),
            (Topology::Strip, 2, vec![]),
            (Topology::Strip, 5, vec![0, 1, 2, 1, 3, 2, 2, 3, 4]),
            (Topology::Fan, 0, vec![]),
            (Topology::Fan, 1, vec![]),
            (Topology::Fan, 5, vec![1, 2, 0, 2, 3, 0, 3, 4, 0]),
        ] {
            assert_eq!(
                topology.triangles(corners),
                triangles.len() as u64 / 3,
                "{topology:?} of {corners}"
            );
            assert_eq!(
                topology.list((0..corners as u32).collect()),
                triangles,
                "{topology:?} of {corners}"
            );
        }
    }
}
