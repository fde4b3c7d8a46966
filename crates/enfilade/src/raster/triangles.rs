//! Triangulates a batch of faces and yields the triangles in groups.
//!
//! A polygon is a triangle fan around its first corner, as everywhere in the library. The corners of a lone face are
//! stored consecutively.
//! Source: original to this library.
//! Cost: O(1) for each triangle.
//! Exact: yields every triangle once, in the order of the faces.

use crate::faces::Faces;

/// The remaining triangles, each a face number and the indices of its three corners.
pub(super) enum Triangles<'a> {
    /// A fan over a single face, whose corners are stored consecutively.
    Lone { owner: u32, last: u32, count: u32 },
    /// A triangle list: every three corners form a face.
    List {
        owner: u32,
        first_position: u32,
        corners: &'a [u32],
    },
    /// Polygons of any number of corners, as triangle fans around their first corner.
    Fans {
        owner: u32,
        first_position: u32,
        /// Start of the current face's corners, followed by the starts of the remaining faces.
        starts: &'a [u32],
        corners: &'a [u32],
        last: u32,
    },
}

impl<'a> Triangles<'a> {
    #[inline(always)]
    pub(super) fn of(faces: &Faces<'a>) -> Triangles<'a> {
        let (owner, first_position) = (faces.first_owner, faces.first_position);
        match faces.starts {
            _ if faces.is_lone() => Triangles::Lone {
                owner,
                last: 2,
                count: faces.corners.len() as u32,
            },
            None => Triangles::List {
                owner,
                first_position,
                corners: faces.corners,
            },
            Some(starts) => Triangles::Fans {
                owner,
                first_position,
                starts,
                corners: faces.corners,
                last: 2,
            },
        }
    }

    /// Writes the next triangles into `group` and returns their number; 0 at the end.
    #[inline(always)]
    pub(super) fn next_into(&mut self, group: &mut [(u32, [u32; 3])]) -> usize {
        let mut count = 0;
        match self {
            Triangles::Lone {
                owner,
                last,
                count: all,
            } => {
                while *last < *all && count < group.len() {
                    group[count] = (*owner, [0, *last - 1, *last]);
                    *last += 1;
                    count += 1;
                }
            }
            Triangles::List {
                owner,
                first_position,
                corners,
            } => {
                let first = *first_position;
                for (group, corners) in group.iter_mut().zip(corners.chunks_exact(3)) {
                    *group = (
                        *owner,
                        [corners[0] - first, corners[1] - first, corners[2] - first],
                    );
                    *owner += 1;
                    count += 1;
                }
                *corners = &corners[3 * count..];
            }
            Triangles::Fans {
                owner,
                first_position,
                starts,
                corners,
                last,
            } => {
                while let [start, end, ..] = **starts {
                    let face = &corners[..(end - start) as usize];
                    while (*last as usize) < face.len() {
                        if count == group.len() {
                            return count;
                        }
                        let used = [face[0], face[*last as usize - 1], face[*last as usize]];
                        group[count] = (*owner, used.map(|corner| corner - *first_position));
                        *last += 1;
                        count += 1;
                    }
                    *corners = &corners[face.len()..];
                    *starts = &starts[1..];
                    *owner += 1;
                    *last = 2;
                }
            }
        }
        count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Collects all triangles of a batch, taken in groups of up to `room`.
    fn all(mut triangles: Triangles, room: usize) -> Vec<(u32, [u32; 3])> {
        let mut group = vec![(0, [0; 3]); room];
        let mut all = Vec::new();
        loop {
            let count = triangles.next_into(&mut group);
            if count == 0 {
                return all;
            }
            all.extend_from_slice(&group[..count]);
        }
    }

    #[test]
    fn faces_come_as_fans_however_many_are_taken_at_a_time() {
        for room in 1..7 {
            let list = Triangles::List {
                owner: 5,
                first_position: 10,
                corners: &[10, 11, 12, 12, 11, 13],
            };
            assert_eq!(all(list, room), [(5, [0, 1, 2]), (6, [2, 1, 3])]);
            let fans = Triangles::Fans {
                owner: 5,
                first_position: 10,
                starts: &[100, 104, 107],
                corners: &[10, 11, 12, 13, 14, 10, 13],
                last: 2,
            };
            assert_eq!(all(fans, room), [(5, [0, 1, 2]), (5, [0, 2, 3]), (6, [4, 0, 3])]);
            let lone = Triangles::Lone {
                owner: 5,
                last: 2,
                count: 4,
            };
            assert_eq!(all(lone, room), [(5, [0, 1, 2]), (5, [0, 2, 3])]);
        }
    }
}
