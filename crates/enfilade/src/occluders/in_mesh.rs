//! Extracts the occluders of one mesh: the polygons of all its sheets that are large enough.

use super::Polygon;
use super::outline::{EXACT, Outline};
use super::pieces::{SheetPiece, pieces};
use super::sheets::Sheet;
use super::soup::Soup;
use super::stored;
use crate::geom::Aabb;
use crate::geometry::Material;
use crate::mesh::Mesh;
use glam::DVec3;

/// An occluder is small if its area is below this part of the largest face of its mesh's bounding box: the facets of a
/// column hide little that its other facets do not.
const LEAST_SHARE: f64 = 1.0 / 128.0;

/// A mesh keeps its largest small occluders, as many as it has clusters, if their area is at least this part of that
/// face: a mesh may be a whole city.
const LEAST_OF_ALL: f64 = 1.0 / 16_384.0;

/// Occluder polygons found in a mesh, largest first.
#[derive(Default)]
pub(super) struct MeshPolygons {
    /// Polygons with their corners.
    pub(super) polygons: Vec<(Polygon, Vec<DVec3>)>,
    /// Total area of the opaque faces that may occlude.
    pub(super) opaque_area: f64,
}

impl MeshPolygons {
    /// Returns the occluders of a mesh: those stored with it, or else it finds them.
    pub(super) fn of(mesh: &Mesh, materials: &[Material]) -> MeshPolygons {
        stored::read(mesh, materials).unwrap_or_else(|| MeshPolygons::find(mesh, materials))
    }

    fn find(mesh: &Mesh, materials: &[Material]) -> MeshPolygons {
        let Some(soup) = Soup::of(mesh, materials) else {
            return MeshPolygons::default();
        };
        let [x, y, z] = mesh.bounds().size().map(f64::from);
        let broadest = (x * y).max(y * z).max(z * x);
        let mut found = Vec::new();
        soup.sheets(LEAST_OF_ALL * broadest, |sheet| {
            found_in(&soup, &sheet, LEAST_OF_ALL * broadest, &mut found);
        });
        found.sort_by(|a, b| b.0.area.total_cmp(&a.0.area));
        let large = found.partition_point(|(polygon, _)| polygon.area >= LEAST_SHARE * broadest);
        found.truncate(large + mesh.clusters().len());
        MeshPolygons {
            polygons: found,
            opaque_area: (0..soup.face_count() as u32).map(|face| soup.area(face)).sum(),
        }
    }
}

/// Adds the polygons of a sheet with an area of at least `least_area`.
fn found_in(soup: &Soup, sheet: &Sheet, least_area: f64, found: &mut Vec<(Polygon, Vec<DVec3>)>) {
    let Some(outline) = Outline::of(soup, sheet) else {
        return;
    };
    let pieces = match outline.as_one() {
        None => pieces(soup, sheet, &outline, least_area),
        Some(corners) => {
            let area = area(&corners);
            vec![SheetPiece {
                corners,
                inset: 0.0,
                area,
                added: area,
                triangles: sheet.faces.iter().map(|&face| soup.triangles(face)).sum(),
            }]
        }
    };
    for mut piece in pieces.into_iter().filter(|piece| piece.area >= least_area) {
        // No zero is negative, so that equal corners have the same bits.
        piece.corners.iter_mut().for_each(|corner| *corner += DVec3::ZERO);
        let corners = &piece.corners;
        let far = corners
            .iter()
            .map(|corner| corner.abs().max_element())
            .fold(0.0, f64::max);
        let polygon = Polygon {
            first_corner: 0,
            corners: corners.len() as u32,
            normal: sheet.normal,
            distance: sheet.distance,
            // Plus the f64 rounding of computed corners and of the eye positions to come.
            slack: sheet.slack + EXACT * far,
            inset: piece.inset,
            area: piece.area,
            added: piece.added,
            triangles: piece.triangles.min(u64::from(u32::MAX)) as u32,
            centre: corners.iter().sum::<DVec3>() / corners.len() as f64,
            bounds: box_around(corners),
            double_sided: sheet.double_sided,
        };
        found.push((polygon, piece.corners));
    }
}

/// Returns the area of a planar polygon in space.
pub(super) fn area(corners: &[DVec3]) -> f64 {
    let first = corners[0];
    let sum: DVec3 = corners
        .windows(2)
        .map(|pair| (pair[0] - first).cross(pair[1] - first))
        .sum();
    0.5 * sum.length()
}

/// Returns the smallest f32 box that contains all points.
pub(super) fn box_around(points: &[DVec3]) -> Aabb {
    let below = |value: f64| {
        let rounded = value as f32;
        if f64::from(rounded) > value {
            rounded.next_down()
        } else {
            rounded
        }
    };
    points.iter().fold(Aabb::EMPTY, |held, point| {
        held.union(&Aabb {
            min: point.to_array().map(below),
            max: point.to_array().map(|value| -below(-value)),
        })
    })
}
