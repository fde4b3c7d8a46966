//! Portals and mirrors: openings of the scene's sectors.
//!
//! Idea: whenever one of them moves or leads elsewhere, all are made anew; a door that opens or closes is a flag.

use crate::components::{Mirror, Portal};
use crate::rooms::{OUTDOORS, Rooms};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_log::warn;
use bevy_math::{Affine3A, Vec2, Vec3};
use bevy_platform::collections::HashMap;
use bevy_transform::prelude::GlobalTransform;
use enfilade::{ConvexPolygon, OpeningId, PortalId, Scene, SectorId, Transform};

/// The openings of the scene.
#[derive(Default)]
pub(crate) struct Portals {
    made: HashMap<Entity, Made>,
    /// Sectors with openings.
    with_openings: Vec<SectorId>,
    /// Whether all are to be made anew.
    pub(crate) is_dirty: bool,
    /// Whether each portal leads somewhere. If not, something could be hidden that is seen through it.
    pub(crate) are_complete: bool,
    /// Whether some are still to be read from a file.
    pub(crate) are_awaited: bool,
}

/// A portal of the world, as it is in the scene.
struct Made {
    of: Portal,
    portals: Vec<PortalId>,
}

/// An opening to be made: its sector, the outline as seen from there, where it leads, and how.
struct Wanted {
    from: SectorId,
    outline: ConvexPolygon,
    to: SectorId,
    there_from_here: Transform,
}

type PortalData = (
    Entity,
    Ref<'static, Portal>,
    Ref<'static, GlobalTransform>,
    Option<&'static Name>,
);
type MirrorData = (
    Entity,
    Ref<'static, Mirror>,
    Ref<'static, GlobalTransform>,
    Option<&'static Name>,
);

/// Portals and mirrors of the world.
#[derive(SystemParam)]
pub(crate) struct OpeningQuery<'w, 's> {
    portals: Query<'w, 's, PortalData>,
    mirrors: Query<'w, 's, MirrorData>,
    removed: (
        RemovedComponents<'w, 's, Portal>,
        RemovedComponents<'w, 's, Mirror>,
    ),
}

impl Portals {
    /// Takes what has changed of portals and mirrors.
    pub(crate) fn take(
        &mut self,
        scene: &mut Scene,
        rooms: &Rooms,
        world: &mut OpeningQuery,
        parents: &Query<&ChildOf>,
    ) {
        let are_gone = (world.removed.0.read().count() + world.removed.1.read().count()) > 0;
        self.is_dirty |= are_gone;
        for (entity, portal, transform, _) in &world.portals {
            if !portal.is_changed() && !transform.is_changed() {
                continue;
            }
            let made = self.made.get_mut(&entity).filter(|_| !transform.is_changed());
            match made {
                Some(made) if same_but_open(&made.of, &portal) => {
                    made.of.open = portal.open;
                    for &made in &made.portals {
                        scene.set_open(made, portal.open);
                    }
                }
                _ => self.is_dirty = true,
            }
        }
        self.is_dirty |= world
            .mirrors
            .iter()
            .any(|(_, mirror, transform, _)| mirror.is_changed() || transform.is_changed());
        if std::mem::take(&mut self.is_dirty) {
            self.make(scene, rooms, world, parents);
        }
    }

    fn make(&mut self, scene: &mut Scene, rooms: &Rooms, world: &OpeningQuery, parents: &Query<&ChildOf>) {
        self.clear(scene);
        self.are_complete = true;
        let mut portals: Vec<_> = world.portals.iter().collect();
        portals.sort_unstable_by_key(|(entity, ..)| *entity);
        for (entity, portal, transform, name) in portals {
            let outline = placed(&portal.corners, &transform.affine());
            let owner = rooms.owner(entity, parents);
            let wanted = wanted(&portal, &outline, owner, rooms);
            let portals = self.add_all(scene, (entity, name), wanted);
            for &made in &portals {
                scene.set_open(made, portal.open);
            }
            let of = Portal::clone(&portal);
            self.made.insert(entity, Made { of, portals });
        }
        let mut mirrors: Vec<_> = world.mirrors.iter().collect();
        mirrors.sort_unstable_by_key(|(entity, ..)| *entity);
        for (entity, mirror, transform, name) in mirrors {
            let affine = transform.affine();
            let outline = placed(&mirror.corners, &affine);
            let front = (affine.matrix3 * Vec3::Z).normalize_or_zero();
            let reflected = reflected(&outline, front, rooms.owner(entity, parents), rooms);
            self.add_all(scene, (entity, name), reflected);
        }
    }

    /// Adds the openings of a portal or mirror; returns where they lead.
    fn add_all(
        &mut self,
        scene: &mut Scene,
        (entity, name): (Entity, Option<&Name>),
        wanted: Result<Vec<Wanted>, String>,
    ) -> Vec<PortalId> {
        let mut portals = Vec::new();
        let added = wanted.and_then(|all| {
            for wanted in all {
                portals.push(self.add(scene, wanted)?);
            }
            Ok(())
        });
        if let Err(why) = added {
            let name = name.map_or_else(|| entity.to_string(), ToString::to_string);
            warn!("portal {name}: {why}; until then, Enfilade hides nothing");
            self.are_complete = false;
        }
        portals
    }

    fn add(&mut self, scene: &mut Scene, wanted: Wanted) -> Result<PortalId, String> {
        let mut edit = scene.edit();
        let added = edit.add_opening(wanted.from, "", wanted.outline);
        let opening = added.map_err(|why| why.to_string())?;
        edit.finish().map_err(|why| why.to_string())?;
        self.with_openings.push(wanted.from);
        let portal = scene.add_portal((wanted.from, opening), wanted.to, wanted.there_from_here);
        portal.map_err(|why| why.to_string())
    }

    fn clear(&mut self, scene: &mut Scene) {
        self.made.clear();
        self.with_openings.sort_unstable();
        self.with_openings.dedup();
        for sector in self.with_openings.drain(..) {
            let count = if scene.has_sector(sector) {
                scene.sector(sector).openings().len()
            } else {
                0
            };
            let mut edit = scene.edit();
            for opening in (0..count).rev() {
                // Refused only if the sector is gone.
                let _ = edit.remove_opening(sector, OpeningId(opening as u16));
            }
            let _ = edit.finish();
        }
    }
}

fn same_but_open(a: &Portal, b: &Portal) -> bool {
    (&a.corners, a.to, a.two_way) == (&b.corners, b.to, b.two_way)
}

pub(crate) fn placed(corners: &[Vec2], affine: &Affine3A) -> Vec<Vec3> {
    let placed = corners
        .iter()
        .map(|corner| affine.transform_point3(corner.extend(0.0)));
    placed.collect()
}

fn middle(outline: &[Vec3]) -> Vec3 {
    outline.iter().sum::<Vec3>() / outline.len().max(1) as f32
}

/// Returns the polygon of an outline, seen from the side that a direction points to.
fn polygon(outline: &[Vec3], toward: Vec3) -> Result<ConvexPolygon, String> {
    let corners: Vec<[f32; 3]> = outline.iter().map(Vec3::to_array).collect();
    let polygon = ConvexPolygon::new(&corners).map_err(|why| why.to_string())?;
    Ok(match Vec3::from(polygon.normal()).dot(toward) < 0.0 {
        true => polygon.flipped(),
        false => polygon,
    })
}

/// Returns the room beside an outline, on the side that a direction points to: walls are thicker than the boxes of rooms
/// know, so it is looked for up to half of the outline's size away.
fn room_beside(outline: &[Vec3], toward: Vec3, rooms: &Rooms) -> Option<SectorId> {
    let middle = middle(outline);
    let size = outline
        .iter()
        .map(|corner| corner.distance(middle))
        .fold(0.0, f32::max);
    let distances = [0.01, 0.05, 0.1, 0.2, 0.35, 0.5];
    distances
        .iter()
        .find_map(|part| rooms.at((middle + part * size * toward).to_array()))
}

fn wanted(
    portal: &Portal,
    outline: &[Vec3],
    owner: Option<SectorId>,
    rooms: &Rooms,
) -> Result<Vec<Wanted>, String> {
    if rooms.is_empty() {
        return Err("there is no `Sector` that it leads into or out of".to_owned());
    }
    let normal = Vec3::from(polygon(outline, Vec3::ZERO)?.normal());
    let beside = [normal, -normal].map(|toward| room_beside(outline, toward, rooms));
    let to = match portal.to {
        Some(to) => Some(rooms.sector(to).ok_or("`to` has no `Sector`")?),
        None => None,
    };
    // The side of its own room, or of any, or the far side of where it leads.
    let known = |side: usize, room| beside[side] == room;
    let side = match (owner, to) {
        (Some(_), _) if known(0, owner) != known(1, owner) => usize::from(known(1, owner)),
        (_, Some(_)) if known(0, to) != known(1, to) => usize::from(known(0, to)),
        _ => 0,
    };
    let toward = [normal, -normal][side];
    let from = owner.or(beside[side]).unwrap_or(OUTDOORS);
    let other = to
        .or(beside[1 - side].filter(|&room| room != from))
        .unwrap_or(OUTDOORS);
    if from == other {
        return Err(
            "it is not between two rooms, or a room and outdoors; make it a descendant of one, set `to`, or move it"
                .to_owned(),
        );
    }
    let outline = polygon(outline, toward)?;
    let mut wanted = vec![Wanted {
        from,
        outline: outline.clone(),
        to: other,
        there_from_here: Transform::IDENTITY,
    }];
    if portal.two_way {
        wanted.push(Wanted {
            from: other,
            outline: outline.flipped(),
            to: from,
            there_from_here: Transform::IDENTITY,
        });
    }
    Ok(wanted)
}

fn reflected(
    outline: &[Vec3],
    front: Vec3,
    owner: Option<SectorId>,
    rooms: &Rooms,
) -> Result<Vec<Wanted>, String> {
    let polygon = polygon(outline, front)?;
    let sector = owner.or_else(|| room_beside(outline, front, rooms));
    let sector = sector.unwrap_or(OUTDOORS);
    let there_from_here = Transform::reflection(polygon.corners()[0], polygon.normal());
    Ok(vec![Wanted {
        from: sector,
        outline: polygon,
        to: sector,
        there_from_here,
    }])
}
