//! Coarser meshes, to draw while the page of a mesh is absent.
//!
//! Source: Rossignac, Borrel, Multi-resolution 3D approximations for rendering complex scenes, 1993: the vertices in a cell of a
//!     grid become one of them, and faces with two corners in a cell vanish.
//! Cost: O(n log n) in the corners, for each of three or four grids.

use enfilade::{Attributes, Indices, MaterialId, Mesh, Part, Vertices};
use glam::DVec3;

/// Cells along the longest side of the grids that are tried.
const GRIDS: [u32; 8] = [2, 4, 8, 16, 32, 64, 128, 256];
/// A coarser mesh has at most one in this many triangles of a mesh,
const REDUCTION: u64 = 8;
/// or this many.
const FEW: u64 = 64;
/// If joining leaves less than one in this many of the triangles that it may, most of the mesh has vanished.
const LOST: usize = 4;

/// The material of each triangle and its vertices in a mesh, sorted, each once.
type Triangles = Vec<(MaterialId, [u32; 3])>;

/// Returns a coarser mesh within the box of a mesh, of the same materials; `None` if it has no faces.
pub(super) fn coarse(mesh: &Mesh) -> Option<Mesh> {
    if mesh.bounds().is_empty() || mesh.face_count() == 0 {
        return None;
    }
    if mesh.triangle_count() <= FEW {
        return Some(mesh.without_occluders());
    }
    let most = (mesh.triangle_count() / REDUCTION).max(FEW) as usize;
    let mut finest = Triangles::new();
    // As if the number of triangles grew with the grid, which it nearly does.
    let _ = GRIDS.partition_point(|&grid| {
        let joined = joined(mesh, grid);
        let is_coarse = joined.len() <= most;
        if is_coarse {
            finest = joined;
        }
        is_coarse
    });
    if LOST * finest.len() < most {
        finest = largest(mesh, most);
    }
    build(mesh, &finest)
}

/// Calls `visit` with the material and the corners of each triangle.
fn each_triangle(mesh: &Mesh, mut visit: impl FnMut(MaterialId, [u32; 3])) {
    for cluster in mesh.clusters() {
        for face in cluster.faces.clone() {
            let corners = mesh.face(face);
            for pair in corners[1..].windows(2) {
                visit(cluster.material, [corners[0], pair[0], pair[1]]);
            }
        }
    }
}

/// Joins the vertices in each cell of a grid.
fn joined(mesh: &Mesh, grid: u32) -> Triangles {
    let bounds = mesh.bounds();
    let cells_per_unit = f64::from(grid) / f64::from(bounds.longest_side());
    // The number of the cell; a side has at most 256.
    let cell_of = |position: &[f32; 3]| {
        (0..3).fold(0, |cell, axis| {
            let along = f64::from(position[axis]) - f64::from(bounds.min[axis]);
            cell << 8 | ((along * cells_per_unit) as u32).min(grid - 1)
        })
    };
    let kept = nearest_to_means(mesh.positions(), cell_of);
    let mut triangles = Triangles::new();
    each_triangle(mesh, |material, corners| {
        let [a, b, c] = corners.map(|corner| kept[corner as usize]);
        if a != b && b != c && c != a {
            // The same triangle from whichever corner it starts.
            let same = [[a, b, c], [b, c, a], [c, a, b]];
            triangles.push((material, same.into_iter().min().unwrap_or([a, b, c])));
        }
    });
    triangles.sort_unstable();
    triangles.dedup();
    triangles
}

/// Returns the largest triangles.
fn largest(mesh: &Mesh, count: usize) -> Triangles {
    let mut all = Vec::new();
    each_triangle(mesh, |material, corners| {
        let [a, b, c] = corners.map(|corner| DVec3::from(mesh.positions()[corner as usize].map(f64::from)));
        all.push(((b - a).cross(c - a).length_squared(), material, corners));
    });
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let largest = all.into_iter().take(count);
    let mut triangles: Triangles = largest
        .map(|(_, material, corners)| (material, corners))
        .collect();
    triangles.sort_unstable();
    triangles
}

/// Builds a mesh of some triangles of the vertices of another.
fn build(mesh: &Mesh, triangles: &Triangles) -> Option<Mesh> {
    let mut used: Vec<u32> = triangles.iter().flat_map(|(_, corners)| *corners).collect();
    used.sort_unstable();
    used.dedup();
    let list = VertexData::new(mesh, &used);
    let new_of = |old: u32| used.partition_point(|&vertex| vertex < old) as u32;
    let corners: Vec<(MaterialId, Vec<u32>)> = triangles
        .chunk_by(|a, b| a.0 == b.0)
        .map(|triangles| {
            let corners = triangles.iter().flat_map(|(_, corners)| *corners);
            (triangles[0].0, corners.map(new_of).collect())
        })
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
    Mesh::new(&parts).ok().filter(|mesh| mesh.face_count() > 0)
}

/// Returns for each vertex the one that is nearest to the mean of all in its cell.
fn nearest_to_means(positions: &[[f32; 3]], cell_of: impl Fn(&[f32; 3]) -> u32) -> Vec<u32> {
    let mut by_cell: Vec<(u32, u32)> = positions.iter().map(cell_of).zip(0..).collect();
    by_cell.sort_unstable();
    let mut nearest = vec![0; positions.len()];
    for cell in by_cell.chunk_by(|a, b| a.0 == b.0) {
        let position = |&(_, vertex): &(u32, u32)| DVec3::from(positions[vertex as usize].map(f64::from));
        let mean = cell.iter().map(position).sum::<DVec3>() / cell.len() as f64;
        let distance = |vertex| position(vertex).distance_squared(mean);
        let of_cell = (cell.iter()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        for &(_, vertex) in cell {
            nearest[vertex as usize] = of_cell.map_or(vertex, |&(_, nearest)| nearest);
        }
    }
    nearest
}

/// The vertices that are kept, with what they have.
struct VertexData {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    texture: Vec<[f32; 2]>,
    colors: Vec<[f32; 4]>,
}

impl VertexData {
    fn new(mesh: &Mesh, vertices: &[u32]) -> VertexData {
        /// An empty list stays empty.
        fn of<T: Copy>(list: &[T], vertices: &[u32]) -> Vec<T> {
            let of_vertex = |&vertex: &u32| list.get(vertex as usize).copied();
            vertices.iter().filter_map(of_vertex).collect()
        }
        VertexData {
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
    use std::collections::BTreeSet;

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
        let cell = ball.bounds().longest_side() / 16.0 * 3.0_f32.sqrt();
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
    fn of_what_vanishes_in_grids_the_largest_faces_stay_and_small_meshes_stay_as_they_are() {
        // A cloud of specks, each within a cell of the finest grid, and some panes among them.
        let mut positions = Vec::new();
        for speck in 0..800_u16 {
            let at = f32::from(speck) * 9.0;
            let size = if speck % 80 == 7 { 2.0 } else { 0.01 };
            positions.extend([[at, at, at], [at + size, at, at], [at, at + size, at + size]]);
        }
        let corners: Vec<u32> = (0..2400).collect();
        let specks = Mesh::triangles(&positions, &corners, MaterialId(3)).expect("specks");
        let rough = coarse(&specks).expect("faces");
        assert_eq!(rough.face_count(), 100);
        let pane = |pane: u16| [9.0 * f32::from(80 * pane + 7); 3];
        assert!((0..10).all(|number| rough.positions().contains(&pane(number))));
        let cuboid = Mesh::cuboid([0.0; 3], [1.0; 3], MaterialId(0)).expect("a cuboid");
        assert!(coarse(&cuboid).expect("a cuboid").to_bytes() == cuboid.to_bytes());
        assert!(coarse(&Mesh::new(&[]).expect("nothing")).is_none());
        assert!(coarse(&Mesh::bounds_only([0.0; 3], [1.0; 3]).expect("a box")).is_none());
    }
}
