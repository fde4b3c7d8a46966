//! Hands the items of a scene to room detection.

use enfilade::{Alpha, Geometry, Item, ItemIndex, MeshId, Portal, PortalId, Scene, SectorId, Transform};
use enfilade_bake::{AuthoredDoor, RoomItem, RoomMesh, RoomsInput};
use std::collections::HashMap;

/// The items of a scene, as input of [`find_rooms`](enfilade_bake::find_rooms).
pub struct SceneRoomItems<'a> {
    /// The input.
    pub input: RoomsInput<'a>,
    /// The sector and index of each item of the input.
    pub items: Vec<(SectorId, ItemIndex)>,
}

impl<'a> SceneRoomItems<'a> {
    /// Collects the items that have faces. `is_movable` says which are leaves of doors. Terrain that is read from its file
    /// on demand is left out.
    pub fn of(scene: &'a Scene, is_movable: impl Fn(SectorId, ItemIndex) -> bool) -> SceneRoomItems<'a> {
        let mut found = SceneRoomItems {
            input: RoomsInput::default(),
            items: Vec::new(),
        };
        for sector in scene.sectors() {
            let Some(geometry) = scene.geometry(sector) else {
                continue;
            };
            let mut meshes: HashMap<(MeshId, bool), usize> = HashMap::new();
            for item in (0..geometry.items().len() as u32).map(ItemIndex) {
                if !geometry.holds(item) || geometry.mesh_of(item).face_count() == 0 {
                    continue;
                }
                let Item { mesh, options, .. } = geometry.item(item);
                let mesh = *meshes.entry((*mesh, options.is_occluder)).or_insert_with(|| {
                    found.input.meshes.push(mesh_of(geometry, item));
                    found.input.meshes.len() - 1
                });
                found.input.items.push(RoomItem {
                    name: geometry.name(item),
                    mesh,
                    world_from_item: geometry.item(item).transform().columns_f64(),
                    movable: is_movable(sector, item),
                });
                found.items.push((sector, item));
            }
        }
        found
    }
}

/// Returns the doors between the sectors of a scene, for [`AuthoredRooms`](enfilade_bake::AuthoredRooms): portals that
/// lead to the other side of their opening, without mirrors and teleports.
pub fn authored_doors(scene: &Scene) -> Vec<AuthoredDoor> {
    let portals = scene.portals().iter().zip(0..).filter(|&(portal, number)| {
        let is_between = portal.there_from_here == Transform::IDENTITY && portal.from != portal.to;
        scene.has_portal(PortalId(number)) && is_between
    });
    let door = |(portal, _): (&Portal, u32)| {
        let opening = scene
            .geometry(portal.from)?
            .openings()
            .get(usize::from(portal.opening.0))?;
        let corners = opening.outline.corners().iter();
        Some(AuthoredDoor {
            rooms: [portal.from.0, portal.to.0],
            outline: corners.map(|corner| corner.map(f64::from)).collect(),
        })
    };
    portals.filter_map(door).collect()
}

/// Splits the triangles of an item's mesh by opacity of their clusters.
fn mesh_of(geometry: &Geometry, item: ItemIndex) -> RoomMesh<'_> {
    let mesh = geometry.mesh_of(item);
    let mut split = RoomMesh {
        positions: mesh.positions(),
        opaque: Vec::new(),
        see_through: Vec::new(),
    };
    for cluster in mesh.clusters() {
        let triangles = match geometry.material_of(item, cluster).alpha {
            Alpha::Opaque => &mut split.opaque,
            Alpha::Mask | Alpha::Blend => &mut split.see_through,
        };
        for face in cluster.faces.clone() {
            let corners = mesh.face(face);
            triangles.extend((2..corners.len()).map(|last| [corners[0], corners[last - 1], corners[last]]));
        }
    }
    split
}
