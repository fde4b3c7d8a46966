//! Camera positions in the open space of geometries without floors.
//!
//! Idea: choose a random point on the free segment between a point on a surface and the next surface, and look level. A
//!     position is rejected as inside a solid if most rays from it hit solid sides.
//! Source: after the random walks of visibility sampling.

use super::{CLEARANCE, Site, SurveyView, Surveyor, TRIES};
use crate::ids::ItemIndex;
use glam::DVec3;

/// Minimum distance of an eye from all faces, relative to the geometry's size.
const CLEAR_OF_SIZE: f64 = 1e-3;

pub(super) fn places(surveyor: &mut Surveyor, sites: &[Site], count: usize) -> Vec<SurveyView> {
    let mut found = Vec::new();
    let items: usize = sites.iter().map(|site| site.geometry.items().len()).sum();
    if items == 0 {
        return found;
    }
    for _ in 0..TRIES * count {
        if found.len() == count || surveyor.budget.is_spent() {
            break;
        }
        let mut item = surveyor.dice.below(items);
        let home = sites.iter().find(|site| {
            let items = site.geometry.items().len();
            let here = item < items;
            item -= if here { 0 } else { items };
            here
        });
        let Some(site) = home else {
            continue;
        };
        let &Site { sector, geometry, .. } = site;
        let Some(place) = place_in_the_open(surveyor, site, ItemIndex(item as u32)) else {
            continue;
        };
        let eye = place.as_vec3().to_array();
        // Where sectors overlap the eye belongs to the smallest: it must be open there too.
        if let Some(toward) = surveyor
            .target(sector, geometry, place)
            .map(|toward| toward.as_vec3())
            && !surveyor.budget.is_spent()
            && surveyor.scene.locate(eye, toward.to_array()) == Some(sector)
        {
            found.push(SurveyView {
                sector,
                eye,
                toward: toward.to_array(),
                on_roof: false,
            });
        }
    }
    found
}

/// Returns a random point on the free segment from a face of an item to the next surface.
fn place_in_the_open(surveyor: &mut Surveyor, site: &Site, item: ItemIndex) -> Option<DVec3> {
    let geometry = site.geometry;
    let mesh = geometry.mesh_of(item);
    if mesh.face_count() == 0 {
        return None;
    }
    let dice = &mut surveyor.dice;
    let face = mesh.face(dice.below(mesh.face_count() as usize) as u32);
    let transform = geometry.item(item).transform();
    let corner = |i: usize| DVec3::from(transform.point_f64(mesh.positions()[face[i] as usize]));
    let last = 2 + dice.below(face.len() - 2);
    let [mut u, mut v] = [dice.fraction(), dice.fraction()];
    if u + v > 1.0 {
        [u, v] = [1.0 - u, 1.0 - v];
    }
    let start = corner(0) * (1.0 - u - v) + corner(last - 1) * u + corner(last) * v;
    let direction = super::direction(dice);
    let size = f64::from(geometry.bounds().longest_side());
    // Off the surface by what f32 loses, so that the ray does not end where it begins.
    let start = start + direction * (1e-5 * size);
    let free = surveyor.budget.cast(geometry, start, direction)?.distance;
    let place = start + direction * (free * (0.01 + 0.98 * surveyor.dice.fraction()));
    let seen = surveyor.cast_around(site, place).seen();
    let clearance = (CLEAR_OF_SIZE * size).min(CLEARANCE * surveyor.metre);
    let is_open = 2 * surveyor.open_sides(&seen) >= seen.hits()
        && !super::is_near_a_face(geometry, place, clearance, &surveyor.budget)
        && !surveyor.is_inside_solid(geometry, &site.sides, place);
    is_open.then_some(place)
}
