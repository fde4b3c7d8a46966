//! Portals and mirrors: openings of the scene's sectors.
//!
//! Idea: whenever one of them moves or leads elsewhere, all are rebuilt; a door that opens or closes is a flag.

use crate::components::{Mirror, Portal};
use crate::rooms::{OUTDOORS, Rooms};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_log::warn;
use bevy_math::{Affine3A, Vec2, Vec3};
use bevy_platform::collections::HashMap;
use bevy_transform::prelude::GlobalTransform;
use enfilade::{ConvexPolygon, OpeningId, PortalId, Scene, SectorId, Transform};
use std::cmp::Ordering;

/// The openings of the scene.
#[derive(Default)]
pub(crate) struct Portals {
    scene_portals: HashMap<Entity, ScenePortal>,
    /// Sectors with openings.
    with_openings: Vec<SectorId>,
    /// Whether all are to be rebuilt.
    pub(crate) is_dirty: bool,
    /// Whether each portal leads somewhere. If not, something could be hidden that is seen through it.
    pub(crate) are_complete: bool,
    /// Whether some are still to be read from a file.
    pub(crate) are_awaited: bool,
    /// Rooms that were found to have no portal.
    closed: Vec<Entity>,
    /// Portals of which it was not certain on which side of them their rooms are.
    doubted: Vec<Entity>,
}

/// A portal of the world, as it is in the scene.
struct ScenePortal {
    of: Portal,
    portals: Vec<PortalId>,
}

/// An opening to be added: its sector, the outline as seen from there, where it leads, and how.
struct OpeningSpec {
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
    names: Query<'w, 's, &'static Name>,
}

impl Portals {
    /// Updates the openings of portals and mirrors that have changed.
    pub(crate) fn update(
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
            let made = self
                .scene_portals
                .get_mut(&entity)
                .filter(|_| !transform.is_changed());
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
            self.rebuild(scene, rooms, world, parents);
        }
    }

    fn rebuild(&mut self, scene: &mut Scene, rooms: &Rooms, world: &OpeningQuery, parents: &Query<&ChildOf>) {
        self.clear(scene);
        self.are_complete = true;
        let mut portals: Vec<_> = world.portals.iter().collect();
        portals.sort_unstable_by_key(|(entity, ..)| *entity);
        for (entity, portal, transform, name) in portals {
            let outline = placed(&portal.corners, &transform.affine());
            let owner = rooms.owner(entity, parents);
            let wanted = openings_of_portal(&portal, &outline, owner, rooms);
            let is_doubted = wanted.as_ref().is_ok_and(|all| {
                let sides = all.iter().filter(|wanted| wanted.from == all[0].from);
                sides.count() > 1
            });
            if is_doubted && !self.doubted.contains(&entity) {
                self.doubted.push(entity);
                let name = name.map_or_else(|| entity.to_string(), ToString::to_string);
                warn!(
                    "portal {name}: cannot tell on which side of it its rooms are; while it is in view, Enfilade hides \
                     nothing; move it into the wall between them"
                );
            }
            let portals = self.add_all(scene, (entity, name), wanted);
            for &made in &portals {
                scene.set_open(made, portal.open);
            }
            let of = Portal::clone(&portal);
            self.scene_portals.insert(entity, ScenePortal { of, portals });
        }
        let mut mirrors: Vec<_> = world.mirrors.iter().collect();
        mirrors.sort_unstable_by_key(|(entity, ..)| *entity);
        for (entity, mirror, transform, name) in mirrors {
            let affine = transform.affine();
            let outline = placed(&mirror.corners, &affine);
            let front = (affine.matrix3 * Vec3::Z).normalize_or_zero();
            let reflected = opening_of_mirror(&outline, front, rooms.owner(entity, parents), rooms);
            self.add_all(scene, (entity, name), reflected);
        }
        if self.are_complete && !self.are_awaited {
            self.warn_of_closed(scene, rooms, &world.names);
        }
    }

    /// Warns once of each room that no portal leads into.
    fn warn_of_closed(&mut self, scene: &Scene, rooms: &Rooms, names: &Query<&Name>) {
        let mut entered = vec![false; scene.sector_count()];
        for made in self.scene_portals.values().flat_map(|made| &made.portals) {
            entered[scene.portals()[made.0 as usize].to.0 as usize] = true;
        }
        for (&room, &sector) in &rooms.sectors {
            if entered[sector.0 as usize] || self.closed.contains(&room) {
                continue;
            }
            self.closed.push(room);
            let name = names
                .get(room)
                .map_or_else(|_| room.to_string(), ToString::to_string);
            warn!("no portal leads into room {name}: nothing below its `Sector` is seen from elsewhere");
        }
    }

    /// Adds the openings of a portal or mirror; returns where they lead.
    fn add_all(
        &mut self,
        scene: &mut Scene,
        (entity, name): (Entity, Option<&Name>),
        wanted: Result<Vec<OpeningSpec>, String>,
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
            warn!("portal {name}: {why}; while this is so, Enfilade hides nothing");
            self.are_complete = false;
        }
        portals
    }

    fn add(&mut self, scene: &mut Scene, wanted: OpeningSpec) -> Result<PortalId, String> {
        let mut edit = scene.edit();
        let added = edit.add_opening(wanted.from, "", wanted.outline);
        let opening = added.map_err(|why| why.to_string())?;
        edit.finish().map_err(|why| why.to_string())?;
        self.with_openings.push(wanted.from);
        let portal = scene.add_portal((wanted.from, opening), wanted.to, wanted.there_from_here);
        portal.map_err(|why| why.to_string())
    }

    fn clear(&mut self, scene: &mut Scene) {
        self.scene_portals.clear();
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

/// Where rooms beside an outline are looked for: distances in parts of its size, because walls have a thickness that boxes of
/// rooms may or may not include.
const DISTANCES: [f32; 6] = [0.01, 0.05, 0.1, 0.2, 0.35, 0.5];

/// Returns points beside an outline, nearest first.
fn points_beside(outline: &[Vec3], toward: Vec3) -> [Vec3; DISTANCES.len()] {
    let middle = middle(outline);
    let lengths = outline.iter().map(|corner| corner.distance(middle));
    let size = lengths.fold(0.0, f32::max);
    DISTANCES.map(|part| middle + part * size * toward)
}

/// Returns the rooms on the two sides of an outline: that to which the normal points comes first. `None` if that is not
/// certain.
fn rooms_beside(outline: &[Vec3], normal: Vec3, rooms: &Rooms) -> Option<[SectorId; 2]> {
    let sides = [normal, -normal]
        .map(|toward| points_beside(outline, toward).map(|point| rooms.at(point.to_array())));
    let nearest = sides.map(|side| side.into_iter().flatten().next());
    let wall_of = match nearest {
        [Some(a), Some(b)] if a == b => a,
        [None, None] => return None,
        [a, b] => return Some([a, b].map(|room| room.unwrap_or(OUTDOORS))),
    };
    // The wall belongs to one of the rooms: the other is on the side where another one begins, or where this one ends.
    let begins = |is_other: fn(Option<SectorId>, SectorId) -> bool| {
        let at = sides.map(|side| side.iter().position(|&room| is_other(room, wall_of)));
        match at {
            [None, None] => None,
            [Some(a), Some(b)] if a == b => None,
            [a, b] => Some(usize::from(a.unwrap_or(usize::MAX) > b.unwrap_or(usize::MAX))),
        }
    };
    let side = begins(|room, wall_of| room.is_some_and(|room| room != wall_of))
        .or_else(|| begins(|room, _| room.is_none()))?;
    let other = sides[side].into_iter().find(|&room| room != Some(wall_of));
    let other = other.flatten().unwrap_or(OUTDOORS);
    Some(match side {
        0 => [other, wall_of],
        _ => [wall_of, other],
    })
}

/// Returns the directions in which the first of two rooms may be from an outline: both if that is not certain. Looks then
/// lead there and back through it until they reach a limit, and nothing is hidden.
fn sides_of(
    outline: &[Vec3],
    normal: Vec3,
    beside: Option<[SectorId; 2]>,
    [from, to]: [SectorId; 2],
    rooms: &Rooms,
) -> Vec<Vec3> {
    if beside == Some([from, to]) {
        return vec![normal];
    }
    if beside == Some([to, from]) {
        return vec![-normal];
    }
    let within = |toward: Vec3, room: SectorId| {
        let points = points_beside(outline, toward);
        points
            .iter()
            .filter(|point| rooms.reaches(room, point.to_array()))
            .count() as i32
    };
    let before = within(normal, from) + within(-normal, to);
    let behind = within(normal, to) + within(-normal, from);
    match before.cmp(&behind) {
        Ordering::Greater => vec![normal],
        Ordering::Less => vec![-normal],
        Ordering::Equal => vec![normal, -normal],
    }
}

fn openings_of_portal(
    portal: &Portal,
    outline: &[Vec3],
    owner: Option<SectorId>,
    rooms: &Rooms,
) -> Result<Vec<OpeningSpec>, String> {
    if rooms.is_empty() {
        return Err("there is no `Sector` that it leads into or out of".to_owned());
    }
    let normal = Vec3::from(polygon(outline, Vec3::ZERO)?.normal());
    let beside = rooms_beside(outline, normal, rooms);
    let to = match portal.to {
        Some(to) => Some(rooms.sector(to).ok_or("`to` has no `Sector`")?),
        None => None,
    };
    // Beside one that is known is the other.
    let beyond = |known: SectorId| {
        let [a, b] = beside?;
        (a == known).then_some(b).or((b == known).then_some(a))
    };
    let ends = match (owner, to) {
        (Some(owner), Some(to)) => Some([owner, to]),
        (Some(owner), None) => beyond(owner).map(|other| [owner, other]),
        (None, Some(to)) => Some([beyond(to).unwrap_or(OUTDOORS), to]),
        (None, None) => beside,
    };
    let Some([from, other]) = ends.filter(|[from, other]| from != other) else {
        return Err(
            "found no two rooms that it joins; make it a descendant of one of them, set `to`, or move it into the \
             wall between them"
                .to_owned(),
        );
    };
    let mut wanted = Vec::new();
    for toward in sides_of(outline, normal, beside, [from, other], rooms) {
        let outline = polygon(outline, toward)?;
        wanted.push(OpeningSpec {
            from,
            outline: outline.clone(),
            to: other,
            there_from_here: Transform::IDENTITY,
        });
        if portal.two_way {
            wanted.push(OpeningSpec {
                from: other,
                outline: outline.flipped(),
                to: from,
                there_from_here: Transform::IDENTITY,
            });
        }
    }
    Ok(wanted)
}

fn opening_of_mirror(
    outline: &[Vec3],
    front: Vec3,
    owner: Option<SectorId>,
    rooms: &Rooms,
) -> Result<Vec<OpeningSpec>, String> {
    let polygon = polygon(outline, front)?;
    let before = points_beside(outline, front);
    let sector = owner.or_else(|| before.iter().find_map(|point| rooms.at(point.to_array())));
    let sector = sector.unwrap_or(OUTDOORS);
    let there_from_here = Transform::reflection(polygon.corners()[0], polygon.normal());
    Ok(vec![OpeningSpec {
        from: sector,
        outline: polygon,
        to: sector,
        there_from_here,
    }])
}
