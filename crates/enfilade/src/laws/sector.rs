//! The sector of the eye, by a linear search over all sectors.

use crate::ids::SectorId;
use crate::scene::Scene;
use crate::view::View;
use glam::DVec3;

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

/// Returns the sector that a ray of a parallel view starts in, as the docs of [`View`] define it, given that of the eye.
pub(super) fn sector_of_start(scene: &Scene, of_eye: SectorId, start: DVec3, ahead: DVec3) -> SectorId {
    let own = solid(scene).find(|&(id, ..)| id == of_eye);
    if own.is_some_and(|(_, min, max)| start.cmpge(min).all() && start.cmple(max).all()) {
        return of_eye;
    }
    sector_around(scene, start, start + ahead).unwrap_or(of_eye)
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
