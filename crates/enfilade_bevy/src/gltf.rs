//! Rooms and portals of glTF files, by the extras that Enfilade's importer reads, too. Names count in files with such extras
//! only: a stock scene may have a `bath-room` without portals.
//!
//! | extras of a node | its name ends in | it becomes |
//! |---|---|---|
//! | `{"enfilade": {"kind": "room"}}` | `-room` | a [`Sector`] with all below it; its `method` is for pictures that the CPU draws |
//! | `{"enfilade": {"kind": "portal", "to": "Garden-room", "one_way": true}}` | `-portal` | a [`Portal`] with the outline of its mesh, which is hidden |
//! | `{"enfilade": {"kind": "mirror"}}` | `-mirror` | a [`Mirror`] with the outline of its mesh |
//! | `{"enfilade": {"kind": "door"}}` | | [`NotOccluder`]: it opens |

use crate::components::{AlwaysVisible, Mirror, NotOccluder, Portal, Sector};
use crate::scene::EnfiladeScene;
use bevy_asset::Assets;
use bevy_camera::visibility::Visibility;
use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use bevy_gltf::{GltfExtras, GltfSceneName};
use bevy_log::{warn, warn_once};
use bevy_math::{Mat3, Quat, Vec2, Vec3};
use bevy_mesh::{Mesh, Mesh3d};
use bevy_transform::prelude::{GlobalTransform, Transform};
use serde::Deserialize;

/// `extras` of a node.
#[derive(Deserialize)]
struct Extras {
    enfilade: Option<Mark>,
}

#[derive(Clone, Default, Deserialize)]
struct Mark {
    kind: Option<String>,
    to: Option<String>,
    #[serde(default, deserialize_with = "flag")]
    one_way: bool,
    exit: Option<String>,
}

/// Reads `true`, or 1, as which Blender writes it.
fn flag<'de, D: serde::Deserializer<'de>>(from: D) -> Result<bool, D::Error> {
    let value = serde_json::Value::deserialize(from)?;
    Ok(value == true || value.as_f64() == Some(1.0))
}

/// A node whose mark was read.
#[derive(Component)]
pub(crate) struct MarkRead;

/// A portal whose room on the other side, or whose mesh, is not there yet. Until it is, nothing is hidden.
#[derive(Component)]
pub(crate) struct PendingOpening(Mark);

type NewNode<'a> = (Entity, Option<&'a Name>, &'a GltfExtras);

/// Reads the names and extras of new nodes.
pub(crate) fn read_extras(
    mut commands: Commands,
    new: Query<NewNode, Added<GltfExtras>>,
    names: Query<(Entity, &Name), Without<MarkRead>>,
    parents: Query<&ChildOf>,
    scenes: Query<(), With<GltfSceneName>>,
    unfinished: Query<(Entity, Ref<PendingOpening>, Option<&Name>, &GlobalTransform)>,
    mut scene: ResMut<EnfiladeScene>,
    rooms: Query<(Entity, &Name), With<Sector>>,
    children: Query<&Children>,
    meshes: Query<(Entity, &Mesh3d, &GlobalTransform)>,
    assets: Res<Assets<Mesh>>,
) {
    let mut are_awaited = false;
    let mut found: Vec<(Entity, &str, Mark)> = Vec::new();
    for (entity, name, extras) in &new {
        let name = name.map_or("", |name| name.as_str());
        found.push((entity, name, mark_of(name, extras)));
    }
    let with_marks = found.iter().filter(|(.., marked)| marked.kind.is_some());
    let files: EntityHashSet = with_marks
        .map(|&(entity, ..)| file_of(entity, &parents, &scenes))
        .collect();
    let in_files = files.iter().flat_map(|&file| children.iter_descendants(file));
    let mut named: Vec<(Entity, &str, Mark)> = Vec::new();
    for (entity, name) in names.iter_many(in_files) {
        let kind = kind_of(name).map(ToOwned::to_owned);
        match found.iter_mut().find(|(other, ..)| *other == entity) {
            Some((.., marked)) => marked.kind = marked.kind.take().or(kind),
            None if kind.is_some() => named.push((
                entity,
                name,
                Mark {
                    kind,
                    ..Mark::default()
                },
            )),
            None => {}
        }
    }
    for (entity, name, marked) in found.into_iter().chain(named) {
        commands.entity(entity).insert(MarkRead);
        match marked.kind.as_deref() {
            Some("room") => {
                commands.entity(entity).insert(Sector);
            }
            Some("door") => {
                for below in std::iter::once(entity).chain(children.iter_descendants(entity)) {
                    commands.entity(below).insert(NotOccluder);
                }
            }
            // Bevy draws one world: one does not see another place through it.
            Some("portal") if marked.exit.is_some() => {}
            Some("portal" | "mirror") => {
                are_awaited = true;
                commands.entity(entity).insert(PendingOpening(marked));
            }
            Some("terrain") | None => {}
            Some(other) => warn!("{name}: kinds are room, portal, mirror, terrain and door, not `{other}`"),
        }
    }
    for (entity, portal, name, transform) in &unfinished {
        let marked = &portal.0;
        let name = name.map_or_else(|| entity.to_string(), ToString::to_string);
        let below: Vec<Entity> = std::iter::once(entity)
            .chain(children.iter_descendants(entity))
            .collect();
        let mut points = Vec::new();
        let mut normal = Vec3::ZERO;
        let mut has_all = false;
        for (_, mesh, at) in meshes.iter_many(&below) {
            let Some(mesh) = assets.get(&mesh.0) else {
                has_all = false;
                break;
            };
            has_all = true;
            read(mesh, at, &mut points, &mut normal);
        }
        let to = match &marked.to {
            None => Some(None),
            Some(wanted) => {
                let mut rooms = rooms.iter().filter(|(_, name)| name.as_str() == wanted);
                rooms.next().map(|(room, _)| Some(room))
            }
        };
        let Some(to) = to.filter(|_| has_all) else {
            are_awaited = true;
            // Rooms of the same file are there in the next frame.
            if !portal.is_added() {
                warn_once!(
                    "portal {name}: its mesh or its room is not there; while this is so, Enfilade hides nothing"
                );
            }
            continue;
        };
        // The opening is at its place once transforms are propagated.
        are_awaited = true;
        commands.entity(entity).remove::<PendingOpening>();
        // Without corners it is refused, and nothing is hidden.
        let (at, corners) = outline(&points, normal, transform).unwrap_or_else(|| {
            warn!("portal {name}: its mesh must be flat");
            (Transform::IDENTITY, Vec::new())
        });
        let opening = (Name::new(name), at, Visibility::default(), ChildOf(entity));
        let opening = commands.spawn(opening).id();
        if marked.kind.as_deref() == Some("mirror") {
            commands.entity(opening).insert(Mirror { corners });
            for below in below {
                commands.entity(below).insert(AlwaysVisible);
            }
        } else {
            let portal = Portal {
                to,
                two_way: !marked.one_way,
                ..Portal::new(corners)
            };
            commands.entity(opening).insert(portal);
            for (below, ..) in meshes.iter_many(&below) {
                commands.entity(below).insert(Visibility::Hidden);
            }
        }
    }
    scene.portals.are_awaited = are_awaited;
}

/// Returns the root of the file that a node is of.
fn file_of(node: Entity, parents: &Query<&ChildOf>, scenes: &Query<(), With<GltfSceneName>>) -> Entity {
    let mut root = node;
    for ancestor in parents.iter_ancestors(node) {
        root = ancestor;
        if scenes.contains(root) {
            break;
        }
    }
    root
}

/// Returns the kind of a node that its name ends in, before Blender's numeric suffix: `Hall-portal.001`.
fn kind_of(name: &str) -> Option<&'static str> {
    let name = match name.rsplit_once('.') {
        Some((before, digits)) if digits.len() >= 3 && digits.bytes().all(|digit| digit.is_ascii_digit()) => {
            before
        }
        _ => name,
    };
    let (_, ending) = name.rsplit_once('-')?;
    ["room", "portal", "mirror"]
        .into_iter()
        .find(|&kind| kind == ending)
}

fn mark_of(name: &str, extras: &GltfExtras) -> Mark {
    let from_extras = match serde_json::from_str::<Extras>(&extras.value) {
        Ok(extras) => extras.enfilade,
        Err(why) if extras.value.contains("\"enfilade\"") => {
            warn!("{name}: its extras cannot be read: {why}");
            None
        }
        // Extras of another program.
        Err(_) => None,
    };
    from_extras.unwrap_or_default()
}

/// Reads the points of a mesh in the space of the world, and adds up the normals of its triangles.
fn read(mesh: &Mesh, at: &GlobalTransform, points: &mut Vec<Vec3>, normal: &mut Vec3) {
    let Some((positions, triangles)) = crate::meshes::triangles(mesh) else {
        return;
    };
    let placed = positions
        .iter()
        .map(|&position| at.transform_point(position.into()));
    let placed: Vec<Vec3> = placed.collect();
    for triangle in triangles.as_chunks::<3>().0 {
        let [a, b, c] = triangle.map(|corner| placed[corner as usize]);
        *normal += (b - a).cross(c - a);
    }
    points.extend(placed);
}

/// Returns the convex outline of flat points, as corners in the XY plane of a child of the node.
fn outline(points: &[Vec3], normal: Vec3, parent: &GlobalTransform) -> Option<(Transform, Vec<Vec2>)> {
    let normal = normal.try_normalize()?;
    let origin = *points.first()?;
    let side = normal.any_orthonormal_vector();
    let turn = Quat::from_mat3(&Mat3::from_cols(side, normal.cross(side), normal));
    let flat: Vec<Vec2> = points
        .iter()
        .map(|&point| (turn.inverse() * (point - origin)).truncate())
        .collect();
    let depth = points.iter().map(|&point| (point - origin).dot(normal).abs());
    let size = flat.iter().map(|point| point.length()).fold(0.0, f32::max);
    if depth.fold(0.0, f32::max) > 0.01 * size {
        return None;
    }
    let at = GlobalTransform::from(Transform::from_translation(origin).with_rotation(turn));
    Some((at.reparented_to(parent), hull(flat)))
}

/// Returns the convex hull of points, counter-clockwise (Andrew, 1979).
fn hull(mut points: Vec<Vec2>) -> Vec<Vec2> {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let mut hull: Vec<Vec2> = Vec::new();
    for pass in 0..2 {
        let first = hull.len();
        for number in 0..points.len() {
            let point = match pass {
                0 => points[number],
                _ => points[points.len() - 1 - number],
            };
            while hull.len() >= first + 2 {
                let [a, b] = [hull[hull.len() - 2], hull[hull.len() - 1]];
                // Nearly straight corners are noise of the file's numbers.
                if (b - a).perp_dot(point - b) > 1e-6 * (b - a).length() * (point - b).length() {
                    break;
                }
                hull.pop();
            }
            hull.push(point);
        }
        hull.pop();
    }
    hull
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hull_of_a_grid_is_its_four_corners() {
        let grid = (0..5).flat_map(|x| (0..4).map(move |y| Vec2::new(x as f32, y as f32)));
        let hull = hull(grid.collect());
        let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]];
        assert_eq!(hull, corners.map(Vec2::from));
    }

    #[test]
    fn names_are_read_as_blender_writes_them() {
        let kinds = [
            "Hall-room",
            "Hall-portal.001",
            "a-mirror.1",
            "bath-rooms",
            "room",
            "Hall-room.b",
        ]
        .map(kind_of);
        assert_eq!(kinds, [Some("room"), Some("portal"), None, None, None, None]);
        let extras = r#"{"enfilade": {"kind": "portal", "one_way": 1}}"#;
        let value = extras.to_owned();
        assert!(mark_of("a node", &GltfExtras { value }).one_way);
    }

    #[test]
    fn extras_of_other_programs_are_ignored() {
        let kind = |value: &str| {
            let value = value.to_owned();
            mark_of("a node", &GltfExtras { value }).kind
        };
        let portal = r#"{"enfilade": {"kind": "portal", "to": "Yard-room", "one_way": true}, "a": 1}"#;
        assert_eq!(kind(portal).as_deref(), Some("portal"));
        assert_eq!(kind(r#"{"enfilade_like": 3}"#), None);
        assert_eq!(kind(r#"["enfilade"]"#), None);
        assert_eq!(kind("not JSON"), None);
    }
}
