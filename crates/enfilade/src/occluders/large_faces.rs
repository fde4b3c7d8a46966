//! The largest convex polygons inside the surface of a mesh, for an occluder that hides only what the mesh hides.
//!
//! Connected faces of one plane become one polygon or a few ([`Outline`], [`pieces`]). Only where that is exact: all
//! corners in the plane and on representable positions, so that every ray through the polygon goes through a face of
//! the mesh, at the same point and from the same side. All other faces stay as they are.
//! Source: that of [`sheets`](super::sheets) and [`pieces`](super::pieces).
//! Cost: O(n log n) for n triangles.
//! Exact, from every eye position, inside the mesh too: each polygon is a part of its surface.

use super::outline::Outline;
use super::pieces::pieces;
use super::sheets::Sheet;
use super::soup::Soup;
use glam::DVec3;

/// A convex polygon inside the surface of a mesh; counter-clockwise seen from the front.
pub(crate) struct LargeFace {
    pub(crate) corners: Vec<[f32; 3]>,
    area: f64,
}

/// Returns polygons that together cover about the surface of a mesh, the largest first.
pub(crate) fn large_faces(
    positions: &[[f32; 3]],
    triangles: &[[u32; 3]],
    double_sided: bool,
) -> Vec<LargeFace> {
    let starts = (0..=triangles.len() as u32).map(|face| 3 * face).collect();
    let sides = vec![double_sided; triangles.len()];
    let Some(soup) = Soup::new(positions, starts, triangles.as_flattened().to_vec(), sides) else {
        return Vec::new();
    };
    let mut found = Vec::new();
    soup.sheets(0.0, |sheet| match merged(&soup, &sheet) {
        merged if !merged.is_empty() => found.extend(merged),
        _ => found.extend(sheet.faces.iter().map(|&face| {
            LargeFace {
                corners: soup
                    .face(face)
                    .iter()
                    .map(|&corner| soup.points[corner as usize].as_vec3().into())
                    .collect(),
                area: soup.area(face),
            }
        })),
    });
    found.sort_by(|a, b| b.area.total_cmp(&a.area));
    found
}

/// Merges the faces of a sheet. Returns nothing if there is nothing to merge or that would not be exact.
fn merged(soup: &Soup, sheet: &Sheet) -> Vec<LargeFace> {
    let outline = Outline::of(soup, sheet).filter(|outline| outline.exact && sheet.faces.len() > 1);
    let Some(outline) = outline else {
        return Vec::new();
    };
    let polygons = match outline.as_one() {
        Some(corners) => vec![(corners, sheet.area)],
        None => {
            let pieces = pieces(soup, sheet, &outline, 0.0);
            pieces
                .into_iter()
                .map(|piece| (piece.corners, piece.added))
                .collect()
        }
    };
    let exact = polygons
        .into_iter()
        .filter(|(corners, _)| is_exact(corners) && is_convex(corners, sheet.normal));
    exact
        .map(|(corners, area)| LargeFace {
            corners: corners.iter().map(|corner| corner.as_vec3().into()).collect(),
            area,
        })
        .collect()
}

/// Whether all corners are numbers of f32.
fn is_exact(corners: &[DVec3]) -> bool {
    corners
        .iter()
        .all(|corner| corner.as_vec3().as_dvec3() == *corner)
}

/// Whether a polygon turns left at every corner: then the triangles from its first corner are inside it.
fn is_convex(corners: &[DVec3], normal: DVec3) -> bool {
    (0..corners.len()).all(|place| {
        let [a, b, c] = [0, 1, 2].map(|next| corners[(place + next) % corners.len()]);
        (b - a).cross(c - b).dot(normal) > 0.0
    })
}
