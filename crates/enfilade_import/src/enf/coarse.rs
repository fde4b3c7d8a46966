//! Coarser meshes, to draw while the page of a mesh is absent.
//!
//! Source: Rossignac, Borrel, Multi-resolution 3D approximations for rendering complex scenes, 1993: the vertices in a cell of a
//!     grid become one of them, and faces with two corners in a cell vanish.
//! Cost: O(corners) for each grid that is tried.

use enfilade::{Aabb, Attributes, Indices, MaterialId, Mesh, Part, Vertices};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Cells along the longest side of the grids, the finest first.
const GRIDS: [u32; 3] = [8, 4, 2];
/// A mesh has so many times more triangles than a coarser one, unless that has
const REDUCTION: u64 = 8;
/// so few.
const FEW: u64 = 12;

/// Returns a coarser mesh within the box of a mesh, of the same materials; `None` if it has no faces.
pub(super) fn coarse(mesh: &Mesh) -> Option<Mesh> {
    let enough = (mesh.triangle_count() / REDUCTION).max(FEW);
    if mesh.bounds().is_empty() || mesh.face_count() == 0 {
        return None;
    }
    if mesh.triangle_count() <= FEW {
        return Some(mesh.clone());
    }
    let mut least = None;
    for grid in GRIDS {
        let Some(found) = clustered(mesh, grid) else {
            break;
        };
        let is_enough = found.triangle_count() <= enough;
        least = Some(found);
        if is_enough {
            break;
        }
    }
    least.or_else(|| {
        let Aabb { min, max } = mesh.bounds();
        let material = mesh.clusters().first()?.material;
        Mesh::cuboid(min, max, material).ok()
    })
}

/// Joins the vertices in each cell of a grid; `None` if no face is left.
fn clustered(mesh: &Mesh, grid: u32) -> Option<Mesh> {
    let bounds = mesh.bounds();
    let cells_per_unit = f64::from(grid) / f64::from(bounds.longest_side());
    let cell_of = |&position: &[f32; 3]| {
        [0, 1, 2].map(|axis| {
            let along = f64::from(position[axis]) - f64::from(bounds.min[axis]);
            ((along * cells_per_unit) as u32).min(grid - 1)
        })
    };
    let cells: Vec<[u32; 3]> = mesh.positions().iter().map(cell_of).collect();
    let (kept, new_of) = nearest_to_means(mesh.positions(), &cells);
    let mut of_materials: BTreeMap<MaterialId, BTreeSet<[u32; 3]>> = BTreeMap::new();
    for cluster in mesh.clusters() {
        let triangles = of_materials.entry(cluster.material).or_default();
        for face in cluster.faces.clone() {
            let corners = mesh.face(face);
            for pair in corners[1..].windows(2) {
                let [a, b, c] = [corners[0], pair[0], pair[1]].map(|corner| new_of[corner as usize]);
                if a != b && b != c && c != a {
                    // The same triangle from whichever corner it starts.
                    triangles.insert(
                        [[a, b, c], [b, c, a], [c, a, b]]
                            .into_iter()
                            .min()
                            .unwrap_or([a, b, c]),
                    );
                }
            }
        }
    }
    let list = Kept::new(mesh, &kept);
    let corners: Vec<(MaterialId, Vec<u32>)> = (of_materials.into_iter())
        .filter(|(_, triangles)| !triangles.is_empty())
        .map(|(material, triangles)| (material, triangles.into_iter().flatten().collect()))
        .collect();
    let parts: Vec<Part> = (corners.iter())
        .map(|(material, corners)| Part {
            positions: Vertices::Packed(&list.positions),
            corners: Indices::U32(corners),
            sides: None,
            material: *material,
            attributes: list.attributes(),
        })
        .collect();
    if parts.is_empty() {
        return None;
    }
    Mesh::new(&parts).ok()
}

/// Returns the vertices that are nearest to the mean of those in their cell, and for each vertex the place of that of its cell.
fn nearest_to_means(positions: &[[f32; 3]], cells: &[[u32; 3]]) -> (Vec<u32>, Vec<u32>) {
    let mut sums: HashMap<[u32; 3], ([f64; 3], f64)> = HashMap::new();
    for (position, &cell) in positions.iter().zip(cells) {
        let (sum, count) = sums.entry(cell).or_default();
        (0..3).for_each(|axis| sum[axis] += f64::from(position[axis]));
        *count += 1.0;
    }
    // The place of each cell, and the distance of its nearest vertex so far.
    let mut places: HashMap<[u32; 3], (u32, f64)> = HashMap::new();
    let (mut kept, mut new_of) = (Vec::new(), Vec::with_capacity(cells.len()));
    for ((position, &cell), vertex) in positions.iter().zip(cells).zip(0..) {
        let (sum, count) = sums[&cell];
        let offset = (0..3).map(|axis| f64::from(position[axis]) - sum[axis] / count);
        let distance = offset.map(|offset| offset * offset).sum::<f64>();
        let (place, best) = places.entry(cell).or_insert_with(|| {
            kept.push(vertex);
            (kept.len() as u32 - 1, distance)
        });
        if distance < *best {
            *best = distance;
            kept[*place as usize] = vertex;
        }
        new_of.push(*place);
    }
    (kept, new_of)
}

/// The vertices that are kept, with what they have.
struct Kept {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    texture: Vec<[f32; 2]>,
    colors: Vec<[f32; 4]>,
}

impl Kept {
    fn new(mesh: &Mesh, vertices: &[u32]) -> Kept {
        /// An empty list stays empty.
        fn of<T: Copy>(list: &[T], vertices: &[u32]) -> Vec<T> {
            let of_vertex = |&vertex: &u32| list.get(vertex as usize).copied();
            vertices.iter().filter_map(of_vertex).collect()
        }
        Kept {
            positions: of(mesh.positions(), vertices),
            normals: of(mesh.normals(), vertices),
            texture: of(mesh.texture(), vertices),
            colors: of(mesh.colors(), vertices),
        }
    }

    fn attributes(&self) -> Attributes<'_> {
        Attributes {
            normals: Vertices::Packed(&self.normals),
            texture: Vertices::Packed(&self.texture),
            colors: Vertices::Packed(&self.colors),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball of many triangles, in two materials.
    fn ball(rows: u32) -> Mesh {
        let columns = 2 * rows;
        let mut positions = Vec::new();
        for row in 0..=rows {
            for column in 0..=columns {
                let [up, around] = [
                    std::f32::consts::PI * row as f32 / rows as f32,
                    std::f32::consts::TAU * column as f32 / columns as f32,
                ];
                positions.push([
                    3.0 * up.sin() * around.cos(),
                    3.0 * up.cos(),
                    3.0 * up.sin() * around.sin(),
                ]);
            }
        }
        let square = |row: u32, column: u32| {
            let [a, b] = [row, row + 1].map(|row| row * (columns + 1) + column);
            [a, a + 1, b + 1, a, b + 1, b]
        };
        let half = |rows: std::ops::Range<u32>| -> Vec<u32> {
            rows.flat_map(|row| (0..columns).flat_map(move |column| square(row, column)))
                .collect()
        };
        let halves = [half(0..rows / 2), half(rows / 2..rows)];
        let parts: Vec<Part> = (halves.iter().zip(0..))
            .map(|(corners, material)| Part {
                positions: Vertices::Packed(&positions),
                corners: Indices::U32(corners),
                sides: None,
                material: MaterialId(material),
                attributes: Attributes {
                    normals: Vertices::Packed(&positions),
                    ..Attributes::default()
                },
            })
            .collect();
        Mesh::new(&parts).expect("a ball")
    }

    #[test]
    fn a_ball_becomes_a_rough_ball_of_its_own_vertices_and_materials() {
        let ball = ball(40);
        let rough = coarse(&ball).expect("faces");
        assert!(
            rough.triangle_count() * 8 <= ball.triangle_count() && rough.triangle_count() > 100,
            "{} of {} triangles",
            rough.triangle_count(),
            ball.triangle_count()
        );
        let cell = ball.bounds().longest_side() / 8.0 * 3.0_f32.sqrt();
        let distance =
            |a: &[f32; 3], b: &[f32; 3]| (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f32>().sqrt();
        for position in ball.positions() {
            let near = rough
                .positions()
                .iter()
                .any(|kept| distance(kept, position) <= cell);
            assert!(near, "{position:?}");
        }
        for (position, normal) in rough.positions().iter().zip(rough.normals()) {
            assert!(ball.positions().contains(position) && position == normal);
        }
        let materials: BTreeSet<MaterialId> =
            rough.clusters().iter().map(|cluster| cluster.material).collect();
        assert_eq!(materials.len(), 2);
        let again = coarse(&ball).expect("faces");
        assert!(again.to_bytes() == rough.to_bytes());
    }

    #[test]
    fn what_vanishes_in_every_grid_becomes_a_box_and_small_meshes_stay() {
        // A cloud of specks, each within a cell.
        let mut positions = Vec::new();
        for speck in 0..40_u8 {
            let at = f32::from(speck % 2) * 9.0;
            positions.extend([[at, at, at], [at + 0.1, at, at], [at, at + 0.1, at + 0.1]]);
        }
        let corners: Vec<u32> = (0..120).collect();
        let specks = Mesh::triangles(&positions, &corners, MaterialId(3)).expect("specks");
        let rough = coarse(&specks).expect("a box");
        assert_eq!((rough.bounds(), rough.face_count()), (specks.bounds(), 6));
        let cuboid = Mesh::cuboid([0.0; 3], [1.0; 3], MaterialId(0)).expect("a cuboid");
        assert!(coarse(&cuboid).expect("a cuboid").to_bytes() == cuboid.to_bytes());
        assert!(coarse(&Mesh::new(&[]).expect("nothing")).is_none());
        assert!(coarse(&Mesh::bounds_only([0.0; 3], [1.0; 3]).expect("a box")).is_none());
    }
}
