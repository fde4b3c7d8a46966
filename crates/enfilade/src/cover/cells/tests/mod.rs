//! Compares coarse coverage with points all over the cells.

use super::*;
use crate::chance::Dice;
use crate::cover::Cover;
use crate::geom::Transform;
use crate::geometry::{Geometry, GeometryBuilder, Material};
use crate::ids::{ItemIndex, MaterialId, SectorId};
use crate::mesh::Mesh;
use crate::view::View;
use crate::view::aperture::CellRoom;
use crate::view::region::{Region, Visibility};
use glam::{DVec2, DVec3};

/// A cover that stores one reversed depth per cell.
#[derive(Default)]
struct CellArray {
    columns: usize,
    cells: Vec<f32>,
}

impl crate::cover::sealed::Sealed for CellArray {}

impl Cover for CellArray {
    type Needs = crate::order::Unsorted;

    const NAME: &'static str = "CellArray";

    fn test(&mut self, _region: &Region) -> Visibility {
        Visibility::Partial
    }

    fn needs_bytes(_size: [u32; 2]) -> u64 {
        0
    }
}

impl Coarse for CellArray {
    fn clear_cells(&mut self, passage: &Passage) {
        let rect = passage.aperture.rect();
        self.columns = usize::from(rect.x1);
        self.cells = vec![0.0; self.columns * usize::from(rect.y1)];
    }

    fn sees_cells(&mut self, _rect: &Rect, _nearest: f32) -> bool {
        true
    }

    fn sees_plane(&mut self, _cells: &Band, _rev_depth: &Triangle) -> bool {
        true
    }

    fn cover_cells(&mut self, cells: &Band, rev_depth: &Triangle) {
        for (y, [x0, x1]) in cells.rows() {
            for x in x0..x1 {
                let known = &mut self.cells[usize::from(y) * self.columns + usize::from(x)];
                *known = known.max(rev_depth.row(y).at(x) as f32);
            }
        }
    }
}

/// Returns the coverage of all faces of a geometry in a grid of `cells`, on a screen of 320×180 that looks along −z.
fn covered(geometry: &Geometry, cells: [u32; 2]) -> (CellArray, Passage) {
    let view = View::new([0.0; 3], [0.0, 0.0, -1.0], [320, 180]).expect("a valid view");
    let passage = Passage::at_the_eye(&view, SectorId(0), false).in_cells(cells, &mut CellRoom::default());
    let (mut known, mut surface) = (CellArray::default(), CoarseCoverage::default());
    known.clear_cells(&passage);
    surface.clear(&passage);
    for item in (0..geometry.items().len() as u32).map(ItemIndex) {
        let screen_from_item = passage.screen_from(&geometry.item(item).transform());
        for cluster in 0..geometry.mesh_of(item).clusters().len() as u32 {
            let faces = Faces::of_cluster(geometry, item, cluster, &screen_from_item);
            surface.add(&faces, &passage, &mut Stats::default(), &mut known);
        }
    }
    (known, passage)
}

fn geometry(meshes: &[(Vec<[f32; 3]>, Vec<u32>)], double_sided: bool) -> Geometry {
    let mut builder = GeometryBuilder::new([Material {
        double_sided,
        ..Material::opaque([1.0; 3])
    }]);
    for (positions, corners) in meshes {
        let mesh = Mesh::triangles(positions, corners, MaterialId(0)).expect("a sound mesh");
        let mesh = builder.mesh(mesh);
        builder.item("surface", mesh, Transform::IDENTITY);
    }
    builder.build().expect("sound surfaces")
}

/// Returns a sheet of squares with corners at `place`, without the squares for which `gone` is true.
fn sheet(
    side: u32,
    place: impl Fn(f64, f64) -> [f64; 3],
    gone: impl Fn(u32, u32) -> bool,
) -> (Vec<[f32; 3]>, Vec<u32>) {
    let at = |i: u32| f64::from(i) / f64::from(side - 1) * 2.0 - 1.0;
    let positions = (0..side * side).map(|i| place(at(i % side), at(i / side)).map(|value| value as f32));
    let squares = (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| (x, y)));
    let corners = squares.filter(|&(x, y)| !gone(x, y)).flat_map(|(x, y)| {
        let i = y * side + x;
        [i, i + 1, i + side, i + side, i + 1, i + side + 1]
    });
    (positions.collect(), corners.collect())
}

#[test]
fn a_wall_of_many_clusters_and_items_has_no_crack() {
    // Larger than the screen, uneven, and in two items that share a row of vertices.
    let bumpy = |x: f64, y: f64| [9.0 * x, 6.0 * y, -4.0 - 0.3 * (7.0 * x).sin() * (5.0 * y).cos()];
    let lower = sheet(60, bumpy, |_, y| y >= 30);
    let upper = sheet(60, bumpy, |_, y| y < 30);
    let geometry = geometry(&[lower, upper], false);
    assert!(geometry.mesh_of(ItemIndex(0)).clusters().len() > 4);
    for cells in [[320, 180], [160, 90], [97, 53], [64, 36], [20, 11], [5, 3]] {
        let (known, _) = covered(&geometry, cells);
        let open = known
            .cells
            .iter()
            .filter(|&&rev_depth| rev_depth < 1.0 / 4.5)
            .count();
        assert_eq!(open, 0, "of {cells:?}");
    }
}

#[test]
fn a_needle_hole_in_a_wall_stays_open() {
    let flat = |x: f64, y: f64| [9.0 * x, 6.0 * y, -4.0];
    let whole = covered(&geometry(&[sheet(40, flat, |_, _| false)], false), [40, 22]).0;
    assert!(whole.cells.iter().all(|&rev_depth| rev_depth > 0.24));
    let holed = covered(
        &geometry(&[sheet(40, flat, |x, y| (x, y) == (19, 20))], false),
        [40, 22],
    )
    .0;
    let open = holed.cells.iter().filter(|&&rev_depth| rev_depth == 0.0).count();
    assert!((1..=16).contains(&open), "{open} cells");
}

#[test]
fn a_surface_that_turns_over_is_open_where_it_does() {
    // A sheet folded along x = 0 and double-sided: the fold is a silhouette, with the sheet in front and behind on one
    // side of it.
    let folded = |x: f64, y: f64| [4.0 * x.abs() - 2.0, 6.0 * y, -4.0 - x];
    let (known, _) = covered(&geometry(&[sheet(21, folded, |_, _| false)], true), [64, 36]);
    let fold = 32.0 - 2.0 / 4.0 * 64.0 * 0.5 * 0.974;
    for y in 2..34 {
        let row = &known.cells[y * 64..][..64];
        assert!(
            row[..(fold as usize) - 2]
                .iter()
                .all(|&rev_depth| rev_depth == 0.0)
        );
        assert!(
            row.iter().filter(|&&rev_depth| rev_depth > 0.0).count() > 10,
            "row {y}"
        );
    }
}

#[test]
fn what_covers_a_cell_is_at_every_place_in_it_and_no_farther() {
    let (mut held, mut faces) = (0, 0);
    for seed in 0..48 {
        let mut dice = Dice::new(seed);
        let parts: Vec<_> = (0..1 + seed % 3)
            .map(|_| {
                let [a, b, c, d] = [(); 4].map(|()| 4.0 * dice.roll() - 2.0);
                let [right, up, deep] = [(); 3].map(|()| 3.0 * dice.roll() - 1.5);
                let hole = (9.0 * dice.roll()) as u32;
                let wavy = move |x: f64, y: f64| {
                    [
                        right + a * x + 0.3 * b * y,
                        up + c * y + 0.3 * d * x,
                        -2.0 + deep + 0.4 * (a * x * 3.0).sin() + 0.8 * b * y,
                    ]
                };
                sheet(10, wavy, move |x, y| x == hole && y > 4)
            })
            .collect();
        let geometry = geometry(&parts, seed % 2 == 0);
        let cells = [[64, 36], [23, 17], [160, 90]][seed as usize % 3];
        let (known, passage) = covered(&geometry, cells);
        let triangles = on_screen(&geometry, &passage, seed % 2 == 0);
        faces += triangles.len();
        for (place, &rev_depth) in known
            .cells
            .iter()
            .enumerate()
            .filter(|(_, rev_depth)| **rev_depth > 0.0)
        {
            let [x, y] = [(place % known.columns) as f64, (place / known.columns) as f64];
            for (i, j) in (0..4).flat_map(|j| (0..4).map(move |i| (i, j))) {
                let at = DVec2::new(x + (f64::from(i) + 0.5) / 4.0, y + (f64::from(j) + 0.5) / 4.0);
                let truth = triangles
                    .iter()
                    .map(|triangle| rev_depth_at(triangle, at))
                    .fold(0.0, f64::max);
                assert!(
                    truth >= f64::from(rev_depth) * (1.0 - 1e-6),
                    "seed {seed}, {at}: {truth} is farther than {rev_depth}"
                );
                held += 1;
            }
        }
    }
    assert!(held > 50_000 && faces > 5_000, "{held} places, {faces} faces");
}

/// Returns the visible triangles as (X, Y, W).
fn on_screen(geometry: &Geometry, passage: &Passage, double_sided: bool) -> Vec<[DVec3; 3]> {
    let mut all = Vec::new();
    for item in (0..geometry.items().len() as u32).map(ItemIndex) {
        let mesh = geometry.mesh_of(item);
        let at = |corner: u32| {
            let position = mesh.positions()[corner as usize].map(f64::from);
            passage.screen_from_sector.point(DVec3::from(position))
        };
        for face in 0..mesh.face_count() {
            let (corners, _) = mesh.runs(face..face + 1);
            let [a, b, c] = [0, 1, 2].map(|corner| at(corners[corner]));
            if double_sided || (b - a).cross(c - a).dot(a) < 0.0 {
                all.push([a, b, c]);
            }
        }
    }
    all
}

/// Returns the reversed depth of a triangle at a point; 0 outside it or in front of the near plane.
fn rev_depth_at(&[a, b, c]: &[DVec3; 3], at: DVec2) -> f64 {
    let ray = at.extend(1.0);
    let sides = [a.cross(b), b.cross(c), c.cross(a)].map(|plane| plane.dot(ray));
    let inside = sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0);
    let normal = (b - a).cross(c - a);
    let rev_depth = normal.dot(ray) / normal.dot(a);
    if inside && rev_depth > 0.0 && rev_depth < 1.0 / 0.001 {
        rev_depth
    } else {
        0.0
    }
}
