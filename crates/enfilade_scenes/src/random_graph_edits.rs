//! Random changes of sectors, openings and portals, to test properties that must hold for every edited scene.

use crate::random::Random;
use enfilade::{ConvexPolygon, ItemIndex, OpeningId, PortalId, Scene, SceneError, SectorId, Transform};
use std::sync::Arc;

/// Adds and removes sectors, openings and portals at random, `count` times, and moves items between sectors. Keeps the
/// first sector. The changes depend on the scene, `at_first` and `random` only.
///
/// While there are more than `at_first` sectors, none is added. Returns the number of changes that were possible.
///
/// # Errors
/// As [`Edit::finish`](enfilade::Edit::finish).
pub fn random_graph_edits(
    scene: &mut Scene,
    count: usize,
    at_first: usize,
    random: &mut Random,
) -> Result<usize, SceneError> {
    let mut done = 0;
    for _ in 0..count {
        let editable: Vec<SectorId> = scene
            .sectors()
            .filter(|&id| scene.geometry(id).is_some())
            .collect();
        let sector = random.pick(&editable);
        done += usize::from(match random.below(8) {
            0 | 1 if editable.len() <= at_first => redirect(scene, random)?,
            0 => sector != SectorId(0) && scene.remove_sector(sector),
            1 => random_portal(scene, random).is_some_and(|portal| scene.remove_portal(portal)),
            2 | 3 => open(scene, sector, random.pick(&editable), random)?,
            4 => close(scene, sector, random)?,
            _ => carry(scene, sector, random.pick(&editable), random)?,
        });
    }
    Ok(done)
}

fn random_portal(scene: &Scene, random: &mut Random) -> Option<PortalId> {
    let all: Vec<PortalId> = (0..scene.portals().len() as u32)
        .map(PortalId)
        .filter(|&portal| scene.has_portal(portal))
        .collect();
    (!all.is_empty()).then(|| random.pick(&all))
}

/// Lets a portal lead into a copy of its sector.
fn redirect(scene: &mut Scene, random: &mut Random) -> Result<bool, SceneError> {
    let Some(id) = random_portal(scene, random) else {
        return Ok(false);
    };
    let portal = scene.portals()[id.0 as usize].clone();
    let (Some(geometry), Some(method)) = (scene.geometry(portal.to), scene.method(portal.to)) else {
        return Ok(false);
    };
    let (name, geometry) = (scene.sector_name(portal.to).to_owned(), Arc::clone(geometry));
    let copy = scene.add_sector(&name, geometry, method)?;
    scene.remove_portal(id);
    scene.add_portal((portal.from, portal.opening), copy, portal.there_from_here)?;
    Ok(true)
}

/// Adds a square opening with a portal: into another sector as it is, turned or smaller, or a mirror.
fn open(scene: &mut Scene, sector: SectorId, to: SectorId, random: &mut Random) -> Result<bool, SceneError> {
    let bounds = scene.bounds(sector);
    if bounds.is_empty() {
        return Ok(false);
    }
    let corner = random.point_in(&bounds);
    let side = bounds.longest_side() * random.between(0.05, 0.3);
    let turn = Transform::rotation(random.point(1.0), f64::from(random.between(0.0, 6.0)));
    let [along, up] = [[side, 0.0, 0.0], [0.0, side, 0.0]].map(|way| turn.direction(way));
    let Ok(outline) = ConvexPolygon::rectangle(corner, along, up) else {
        return Ok(false);
    };
    let there = match random.below(4) {
        0 => Transform::reflection(corner, outline.normal()),
        1 => Transform::translation(scene.bounds(to).center()) * turn,
        2 => Transform::scaling([0.5; 3]),
        _ => Transform::IDENTITY,
    };
    let mut edit = scene.edit();
    let added = edit.add_opening(sector, "random", outline);
    edit.finish()?;
    Ok(added.is_ok_and(|opening| scene.add_portal((sector, opening), to, there).is_ok()))
}

/// Removes an opening.
fn close(scene: &mut Scene, sector: SectorId, random: &mut Random) -> Result<bool, SceneError> {
    let openings = scene.sector(sector).openings().len();
    let mut edit = scene.edit();
    let removed = edit.remove_opening(sector, OpeningId(random.below(openings.max(1)) as u16));
    edit.finish()?;
    Ok(removed.is_ok())
}

/// Moves a random item into another sector.
fn carry(scene: &mut Scene, from: SectorId, to: SectorId, random: &mut Random) -> Result<bool, SceneError> {
    let (Some(geometry), bounds) = (scene.geometry(from), scene.bounds(to)) else {
        return Ok(false);
    };
    if geometry.items().is_empty() || bounds.is_empty() {
        return Ok(false);
    }
    let item = ItemIndex(random.below(geometry.items().len()) as u32);
    let placed = geometry.item(item);
    let [goal, start] = [random.point_in(&bounds), placed.bounds.center()];
    let step = Transform::translation([0, 1, 2].map(|axis| goal[axis] - start[axis]));
    let (id, there) = (geometry.id_of(item), step * placed.transform());
    let mut edit = scene.edit();
    let moved = edit.move_to(from, id, to, there);
    edit.finish()?;
    Ok(moved.is_ok())
}
