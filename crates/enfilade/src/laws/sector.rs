//! The sector of the eye, by a linear search over all sectors.

use super::EPSILON;
use crate::ids::SectorId;
use crate::scene::Scene;
use crate::view::View;
use glam::DVec3;
use smallvec::SmallVec;

/// Returns the sector of a view's eye, as the docs of [`Scene::sector_of`] and [`Scene::locate`] define it.
pub(super) fn sector_of_eye(scene: &Scene, view: &View) -> Option<SectorId> {
    if let Some(named) = view.sector {
        return scene.sectors().find(|&id| id == named);
    }
    let [eye, toward] = [view.eye(), view.toward()].map(DVec3::from);
    let away = |(_, min, max): &(SectorId, DVec3, DVec3)| (eye.clamp(*min, *max) - eye).length_squared();
    sector_around(scene, eye, toward)
        .or_else(|| {
            let nearest = solid(scene).min_by(|a, b| away(a).total_cmp(&away(b)));
            nearest.map(|(id, ..)| id)
        })
        .or_else(|| scene.sectors().next())
}

/// Sectors that a ray may start in.
pub(super) type Starts = SmallVec<[SectorId; 2]>;

/// Returns the sectors that a ray of a parallel view may start in, as the docs of [`View`] define it, given that of the eye:
/// at `to_near` from `origin`. Several where that is in a side of a box, so that rounding decides.
pub(super) fn sectors_of_start(scene: &Scene, of_eye: SectorId, origin: DVec3, to_near: DVec3) -> Starts {
    let own = solid(scene).find(|&(id, ..)| id == of_eye);
    let sector_at = |part: f64| {
        let start = origin + to_near * part;
        if own.is_some_and(|(_, min, max)| start.cmpge(min).all() && start.cmple(max).all()) {
            return of_eye;
        }
        sector_around(scene, start, start + to_near).unwrap_or(of_eye)
    };
    let mut starts: Starts = [1.0 - EPSILON, 1.0, 1.0 + EPSILON]
        .map(sector_at)
        .into_iter()
        .collect();
    starts.sort_unstable();
    starts.dedup();
    if starts.len() > 1 {
        let [start, off] = [origin + to_near, EPSILON * to_near.abs()];
        let touched =
            |min: DVec3, max: DVec3| (start + off).cmpge(min).all() && (start - off).cmple(max).all();
        starts.extend(
            solid(scene)
                .filter(|&(_, min, max)| touched(min, max))
                .map(|(id, ..)| id),
        );
        starts.push(of_eye);
        starts.sort_unstable();
        starts.dedup();
    }
    starts
}

/// Returns the sectors with geometry, with the minimum and the maximum of their boxes.
fn solid(scene: &Scene) -> impl Iterator<Item = (SectorId, DVec3, DVec3)> + '_ {
    let all = scene.sectors().map(|id| (id, scene.bounds(id)));
    all.filter(|(_, bounds)| !bounds.is_empty()).map(|(id, bounds)| {
        let [min, mut max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
        if scene.is_open_above(id) {
            max.y = f64::INFINITY;
        }
        (id, min, max)
    })
}

/// Returns the sector whose box contains a point.
fn sector_around(scene: &Scene, eye: DVec3, toward: DVec3) -> Option<SectorId> {
    let solid = || solid(scene);
    let strictly = solid().filter(|&(_, min, max)| eye.cmpgt(min).all() && eye.cmplt(max).all());
    let touching = solid().filter(|&(_, min, max)| eye.cmpge(min).all() && eye.cmple(max).all());
    let volume = |(_, min, max): &(SectorId, DVec3, DVec3)| (max - min).element_product();
    let ground = |(_, min, max): &(SectorId, DVec3, DVec3)| (max.x - min.x) * (max.z - min.z);
    let ahead = |(_, min, max): &(SectorId, DVec3, DVec3)| {
        let middle = 0.5 * (min + max);
        let finite = |axis: usize| middle[axis].is_finite();
        let axes = (0..3).filter(|&axis| finite(axis));
        axes.map(|axis| (middle[axis] - eye[axis]) * (toward[axis] - eye[axis]))
            .sum::<f64>()
    };
    strictly
        .min_by(|a, b| {
            volume(a)
                .total_cmp(&volume(b))
                .then(ground(a).total_cmp(&ground(b)))
        })
        .or_else(|| touching.max_by(|a, b| ahead(a).total_cmp(&ahead(b))))
        .map(|(id, ..)| id)
}
