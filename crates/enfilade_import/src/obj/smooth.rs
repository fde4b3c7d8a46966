//! Computes smooth normals: the mean normal of adjacent faces of the same smoothing group.

use super::groups::Group;
use super::parse::{Faces, Tables};
use glam::DVec3;

/// Normals by position and smoothing group.
pub(super) struct SmoothNormals(Vec<((u32, u32), [f32; 3])>);

impl SmoothNormals {
    /// Computes the normals for faces of a group with corners that lack one. Weighted by face area.
    pub(super) fn of(group: &Group, pieces: &[Faces], tables: &Tables) -> SmoothNormals {
        let mut shares: Vec<((u32, u32), DVec3)> = Vec::new();
        for run in &group.runs {
            let Some(number) = run.smooth else { continue };
            let faces = &pieces[run.piece];
            for corners in run.faces.clone().map(|face| faces.face(face)) {
                if corners.iter().all(|corner| corner.normal.is_some()) {
                    continue;
                }
                let place = |position: u32| DVec3::from(tables.positions[position as usize].map(f64::from));
                let origin = place(corners[0].position);
                let normal: DVec3 = corners[1..]
                    .windows(2)
                    .map(|pair| (place(pair[0].position) - origin).cross(place(pair[1].position) - origin))
                    .sum();
                shares.extend(
                    corners
                        .iter()
                        .map(|corner| ((corner.position, number.get()), normal)),
                );
            }
        }
        // A stable sort, so that sums are always computed in file order.
        shares.sort_by_key(|(key, _)| *key);
        let mean = |shares: &[((u32, u32), DVec3)]| {
            let sum: DVec3 = shares.iter().map(|(_, normal)| normal).sum();
            let scale = sum.abs().max_element();
            let normal = if scale > 0.0 && scale.is_finite() {
                (sum / scale).normalize().as_vec3().to_array()
            } else {
                [0.0; 3]
            };
            (shares[0].0, normal)
        };
        SmoothNormals(shares.chunk_by(|a, b| a.0 == b.0).map(mean).collect())
    }

    /// Returns the normal at a position in a smoothing group; zero if there is none.
    pub(super) fn at(&self, position: u32, number: u32) -> [f32; 3] {
        let found = self.0.binary_search_by_key(&(position, number), |(key, _)| *key);
        found.map_or([0.0; 3], |place| self.0[place].1)
    }
}
