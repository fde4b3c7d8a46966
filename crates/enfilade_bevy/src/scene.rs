//! The scene that mirrors Bevy's world, and the system that synchronizes it.
//!
//! Idea: what changed since the last frame is read from Bevy's change detection, and applied as one edit by
//! `enfilade_sync`. An entity is an item of the room that it is a descendant of; others are outdoors, and in each room whose
//! box they reach into. All rooms are in the space of the world.
//! Cost: a comparison of ticks per component and frame; then O(log entities) per change.

use crate::automatic::AutomaticOccluder;
use crate::components::{
    AlwaysVisible, MethodOf, Mirror, NotOccluder, Occluder, OccluderProxy, Portal, Sector,
};
use crate::meshes::{BuiltMesh, OccluderMeshes, materials};
use crate::portals::{OpeningQuery, Portals};
use crate::rooms::{OUTDOORS, Rooms, RoomsChanged};
use crate::settings::EnfiladeSettings;
use bevy_asset::{AssetEvent, Assets, RenderAssetUsages};
use bevy_camera::primitives::Aabb;
use bevy_camera::visibility::{
    DynamicSkinnedMeshBounds, InheritedVisibility, NoCpuCulling, NoFrustumCulling, RenderLayers,
    VisibilityRange,
};
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_ecs::system::SystemParam;
use bevy_log::warn;
use bevy_math::{Affine3A, Vec3};
use bevy_mesh::morph::MeshMorphWeights;
use bevy_mesh::skinning::SkinnedMesh;
use bevy_mesh::{Mesh, Mesh3d};
use bevy_platform::collections::{HashMap, HashSet};
use bevy_transform::prelude::GlobalTransform;
use enfilade::{GeometryBuilder, ItemOptions, Method, Ray, RayEnd, Scene, SceneError, SectorId, Transform};
use enfilade_sync::{Changes, EntityMap, Spawn};

/// The number of no mesh: an entity is culled by its box.
const NO_MESH: u64 = u64::MAX;

/// The scene that mirrors the entities with meshes, in the space of Bevy's world.
#[derive(Resource)]
pub struct EnfiladeScene {
    pub(crate) scene: Scene,
    pub(crate) entities: EntityMap,
    /// Occluders that are not drawn.
    proxies: EntityMap,
    meshes: OccluderMeshes,
    tracked: HashMap<Entity, TrackedEntity>,
    /// A bit for each entity that is tracked, by its index: asked of all that is in the frustums.
    tracked_bits: Vec<u64>,
    pub(crate) rooms: Rooms,
    pub(crate) portals: Portals,
    /// Whether changes were missed, so that all entities are to be read.
    is_stale: bool,
    method: Method,
    pending: PendingChanges,
}

/// An entity that is in the scene.
struct TrackedEntity {
    spawn: Spawn,
    proxy: Option<Spawn>,
    sectors: Vec<SectorId>,
    /// The room that it is a descendant of.
    owner: Option<SectorId>,
    mirrors: bool,
    /// Counts its changes.
    version: u64,
}

/// Changes for the next edit; kept for their memory.
#[derive(Default)]
struct PendingChanges {
    despawned: Vec<enfilade_sync::Entity>,
    spawned: Vec<Spawn>,
    moved: Vec<(enfilade_sync::Entity, Transform)>,
    proxies_despawned: Vec<enfilade_sync::Entity>,
    proxies_spawned: Vec<Spawn>,
    proxies_moved: Vec<(enfilade_sync::Entity, Transform)>,
    built: Vec<BuiltMesh>,
}

impl PendingChanges {
    fn clear(&mut self) {
        self.despawned.clear();
        self.spawned.clear();
        self.moved.clear();
        self.proxies_despawned.clear();
        self.proxies_spawned.clear();
        self.proxies_moved.clear();
        self.built.clear();
    }

    fn despawn(&mut self, tracked: &TrackedEntity) {
        let key = tracked.spawn.entity.key;
        for &sector in &tracked.sectors {
            self.despawned.push(enfilade_sync::Entity::new(key, sector));
            if tracked.proxy.is_some() {
                self.proxies_despawned
                    .push(enfilade_sync::Entity::new(key, sector));
            }
        }
    }

    fn spawn(&mut self, tracked: &TrackedEntity) {
        let in_sector = |spawn: &Spawn, sector| Spawn {
            entity: enfilade_sync::Entity::new(spawn.entity.key, sector),
            ..*spawn
        };
        for &sector in &tracked.sectors {
            self.spawned.push(in_sector(&tracked.spawn, sector));
            if let Some(proxy) = &tracked.proxy {
                self.proxies_spawned.push(in_sector(proxy, sector));
            }
        }
    }

    fn shift(&mut self, tracked: &TrackedEntity) {
        let (key, transform) = (tracked.spawn.entity.key, tracked.spawn.transform);
        for &sector in &tracked.sectors {
            self.moved
                .push((enfilade_sync::Entity::new(key, sector), transform));
            if tracked.proxy.is_some() {
                self.proxies_moved
                    .push((enfilade_sync::Entity::new(key, sector), transform));
            }
        }
    }
}

impl EnfiladeScene {
    pub(crate) fn new(method: Method) -> EnfiladeScene {
        EnfiladeScene {
            scene: empty_scene(method),
            entities: EntityMap::new(),
            proxies: EntityMap::new(),
            meshes: OccluderMeshes::default(),
            tracked: HashMap::default(),
            tracked_bits: Vec::new(),
            rooms: Rooms::default(),
            portals: Portals::default(),
            is_stale: true,
            method,
            pending: PendingChanges::default(),
        }
    }

    /// Drops what is known of the world, to read it again.
    fn reset(&mut self, method: Method) {
        let are_awaited = self.portals.are_awaited;
        *self = EnfiladeScene::new(method);
        self.portals.are_awaited = are_awaited;
    }

    /// Returns the scene, for rays and other queries. Keys of items are [`Entity::to_bits`].
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Returns the first entity on the way from an eye to a point, such as what hides that point; `None` if the way is free.
    /// Entities without triangles in the scene, whose boxes are culled, are not met.
    pub fn first_between(&self, eye: Vec3, point: Vec3) -> Option<Entity> {
        let sector = self.rooms.at(eye.to_array()).unwrap_or(OUTDOORS);
        let ray = Ray {
            origin: eye.to_array(),
            direction: (point - eye).to_array(),
        };
        let cast = self.scene.cast(sector, &ray);
        match cast.end {
            RayEnd::Face(hit) if cast.distance < 1.0 => Entity::try_from_bits(hit.key),
            _ => None,
        }
    }

    /// Returns whether an entity is in the scene, so that it may be culled.
    pub fn contains(&self, entity: Entity) -> bool {
        let index = entity.index_u32() as usize;
        (self.tracked_bits.get(index / 64)).is_some_and(|bits| bits >> (index % 64) & 1 != 0)
    }

    /// Returns whether an entity hides others with triangles of its own or of its proxy, by now.
    pub fn is_occluder(&self, entity: Entity) -> bool {
        let has_mesh = |map: &EntityMap, spawn: &Spawn, sector| {
            let entity = enfilade_sync::Entity::new(spawn.entity.key, sector);
            let representation = map.representation(entity);
            spawn.options.is_occluder
                && matches!(representation, Some(enfilade_sync::Representation::Mesh(_)))
        };
        self.tracked.get(&entity).is_some_and(|tracked| {
            let proxy = tracked.proxy.as_ref().map(|proxy| (&self.proxies, proxy));
            let own = (&self.entities, &tracked.spawn);
            let sectors = &tracked.sectors;
            std::iter::once(own)
                .chain(proxy)
                .any(|(map, spawn)| sectors.iter().any(|&sector| has_mesh(map, spawn, sector)))
        })
    }

    fn set_tracked(&mut self, entity: Entity, is_tracked: bool) {
        let (word, bit) = (entity.index_u32() as usize / 64, entity.index_u32() % 64);
        if word >= self.tracked_bits.len() {
            self.tracked_bits.resize(word + 1, 0);
        }
        self.tracked_bits[word] = self.tracked_bits[word] & !(1 << bit) | u64::from(is_tracked) << bit;
    }

    /// Returns whether the scene is synchronized with the world, so that cameras can be culled for.
    pub(crate) fn is_ready(&self) -> bool {
        !self.is_stale && self.portals.are_complete && !self.portals.are_awaited
    }

    /// Returns whether meshes of occluders are being built on the task pool; until they are, less is hidden.
    pub fn is_building(&self) -> bool {
        self.meshes.is_busy()
    }

    /// Returns the box of an entity in the space of the world, and the number of its changes.
    pub(crate) fn bounds(&self, entity: Entity) -> Option<(enfilade::Aabb, u64)> {
        let tracked = self.tracked.get(&entity)?;
        Some((world_box(&tracked.spawn), tracked.version))
    }
}

fn empty_scene(method: Method) -> Scene {
    let geometry = GeometryBuilder::new(materials());
    let geometry = geometry.build().expect("nothing can be wrong with no items");
    Scene::single(geometry.clone(), method)
        .or_else(|_| Scene::single(geometry, EnfiladeSettings::default().method))
        .expect("the default method suits an empty scene")
}

/// What the scene knows of an entity.
#[derive(QueryData)]
pub(crate) struct EntityData {
    mesh: &'static Mesh3d,
    transform: &'static GlobalTransform,
    bounds: Option<&'static Aabb>,
    inherited: Option<&'static InheritedVisibility>,
    layers: Option<&'static RenderLayers>,
    occluder: Option<&'static Occluder>,
    automatic: Option<&'static AutomaticOccluder>,
    proxy: Option<&'static OccluderProxy>,
    is_no_occluder: Has<NotOccluder>,
    fades: Has<VisibilityRange>,
    is_always_visible: Has<AlwaysVisible>,
    is_portal: Has<Portal>,
    is_mirror: Has<Mirror>,
    has_no_frustum_culling: Has<NoFrustumCulling>,
    has_no_cpu_culling: Has<NoCpuCulling>,
    is_skinned: Has<SkinnedMesh>,
    has_dynamic_bounds: Has<DynamicSkinnedMeshBounds>,
    morphs: Has<MeshMorphWeights>,
}

/// The components that decide how an entity is represented.
type DataChanged = (
    With<Mesh3d>,
    Or<(
        Or<(
            Changed<Mesh3d>,
            Changed<Aabb>,
            Changed<InheritedVisibility>,
            Changed<RenderLayers>,
            Changed<Occluder>,
            Changed<AutomaticOccluder>,
            Changed<OccluderProxy>,
        )>,
        Or<(
            Added<NotOccluder>,
            Added<AlwaysVisible>,
            Added<VisibilityRange>,
            Added<NoFrustumCulling>,
            Added<NoCpuCulling>,
            Added<SkinnedMesh>,
            Added<DynamicSkinnedMeshBounds>,
            Added<MeshMorphWeights>,
        )>,
    )>,
);

/// Entities that lost one of these components, or are gone.
#[derive(SystemParam)]
pub(crate) struct ComponentsRemoved<'w, 's> {
    mesh: RemovedComponents<'w, 's, Mesh3d>,
    bounds: RemovedComponents<'w, 's, Aabb>,
    layers: RemovedComponents<'w, 's, RenderLayers>,
    occluder: RemovedComponents<'w, 's, Occluder>,
    automatic: RemovedComponents<'w, 's, AutomaticOccluder>,
    proxy: RemovedComponents<'w, 's, OccluderProxy>,
    not_occluder: RemovedComponents<'w, 's, NotOccluder>,
    always_visible: RemovedComponents<'w, 's, AlwaysVisible>,
    range: RemovedComponents<'w, 's, VisibilityRange>,
    no_frustum_culling: RemovedComponents<'w, 's, NoFrustumCulling>,
    no_cpu_culling: RemovedComponents<'w, 's, NoCpuCulling>,
    skinned: RemovedComponents<'w, 's, SkinnedMesh>,
    dynamic_bounds: RemovedComponents<'w, 's, DynamicSkinnedMeshBounds>,
    morphs: RemovedComponents<'w, 's, MeshMorphWeights>,
}

impl ComponentsRemoved<'_, '_> {
    fn read(&mut self) -> impl Iterator<Item = Entity> {
        self.mesh
            .read()
            .chain(self.bounds.read())
            .chain(self.layers.read())
            .chain(self.occluder.read())
            .chain(self.automatic.read())
            .chain(self.proxy.read())
            .chain(self.not_occluder.read())
            .chain(self.always_visible.read())
            .chain(self.range.read())
            .chain(self.no_frustum_culling.read())
            .chain(self.no_cpu_culling.read())
            .chain(self.skinned.read())
            .chain(self.dynamic_bounds.read())
            .chain(self.morphs.read())
    }
}

/// Bevy's world, as the scene reads it.
#[derive(SystemParam)]
pub(crate) struct World<'w, 's> {
    assets: Res<'w, Assets<Mesh>>,
    mesh_events: MessageReader<'w, 's, AssetEvent<Mesh>>,
    data: Query<'w, 's, EntityData>,
    all: Query<'w, 's, Entity, With<Mesh3d>>,
    data_changed: Query<'w, 's, Entity, DataChanged>,
    moved: Query<'w, 's, (Entity, &'static GlobalTransform), (With<Mesh3d>, Changed<GlobalTransform>)>,
    removed: ComponentsRemoved<'w, 's>,
    rooms: Query<'w, 's, (Entity, Option<&'static MethodOf>, Option<&'static Name>), With<Sector>>,
    rooms_changed: RoomsChanged<'w, 's>,
    methods_changed: Query<'w, 's, Entity, Changed<MethodOf>>,
    methods_removed: RemovedComponents<'w, 's, MethodOf>,
    parents: Query<'w, 's, &'static ChildOf>,
    openings: OpeningQuery<'w, 's>,
}

/// Synchronizes the scene with Bevy's world.
pub(crate) fn sync(settings: Res<EnfiladeSettings>, mut scene: ResMut<EnfiladeScene>, mut world: World) {
    let scene = &mut *scene;
    if !settings.enabled {
        if !scene.is_stale {
            scene.reset(settings.method);
        }
        return;
    }
    if scene.method != settings.method {
        scene.reset(settings.method);
    }
    let is_stale = std::mem::take(&mut scene.is_stale);
    scene.pending.clear();
    scene.read_mesh_events(&mut world, is_stale);
    let rooms_changed = scene.update_rooms(&mut world, is_stale);

    let mut touched: HashSet<Entity> = HashSet::default();
    touched.extend(world.removed.read());
    touched.extend(world.data_changed.iter());
    if is_stale || rooms_changed {
        touched.extend(&world.all);
        touched.extend(scene.tracked.keys().copied());
    }
    let mut owned_changed = rooms_changed;
    let mut free: Vec<Entity> = Vec::new();
    for (entity, transform) in &world.moved {
        let Some(tracked) = scene.tracked.get_mut(&entity) else {
            continue;
        };
        let affine = transform.affine();
        if tracked.mirrors != mirrors(&affine) {
            touched.insert(entity);
        }
        if touched.contains(&entity) {
            continue;
        }
        tracked.spawn.transform = transform_of(&affine);
        tracked.version += 1;
        owned_changed |= tracked.owner.is_some();
        if tracked.owner.is_none() && !scene.rooms.is_empty() {
            free.push(entity);
        }
        scene.pending.shift(tracked);
    }
    // In a fixed order: visible sets depend on the order of additions where faces coincide.
    let mut touched: Vec<Entity> = touched.into_iter().collect();
    touched.sort_unstable();
    for entity in touched {
        let was = scene.tracked.remove(&entity);
        if was.is_some() {
            scene.set_tracked(entity, false);
        }
        if let Some(was) = &was {
            scene.pending.despawn(was);
            owned_changed |= was.owner.is_some();
        }
        let Ok(described) = world.data.get(entity) else {
            continue;
        };
        let owner = scene.rooms.owner(entity, &world.parents);
        let version = was.map_or(0, |was| was.version + 1);
        let Some(mut tracked) = scene.describe(entity, &described, owner, version, &world.assets) else {
            continue;
        };
        owned_changed |= owner.is_some();
        match owner {
            Some(room) => tracked.sectors = vec![room],
            None if scene.rooms.is_empty() => tracked.sectors = vec![OUTDOORS],
            None => free.push(entity),
        }
        scene.pending.spawn(&tracked);
        scene.tracked.insert(entity, tracked);
        scene.set_tracked(entity, true);
    }
    if owned_changed && scene.update_boxes() {
        let is_free = |(_, tracked): &(&Entity, &TrackedEntity)| tracked.owner.is_none();
        free.extend(scene.tracked.iter().filter(is_free).map(|(entity, _)| *entity));
        free.sort_unstable();
        free.dedup();
        scene.portals.is_dirty = true;
    }
    for entity in free {
        scene.place_free(entity);
    }
    if let Err(why) = scene.apply() {
        // Entities would stay where they were, and hide what they do not.
        warn!("Enfilade cannot update its scene, and reads the whole world again: {why}");
        scene.reset(settings.method);
        return;
    }
    scene.portals.is_dirty |= rooms_changed || is_stale;
    let EnfiladeScene {
        scene,
        rooms,
        portals,
        ..
    } = scene;
    portals.update(scene, rooms, &mut world.openings, &world.parents);
}

impl EnfiladeScene {
    fn read_mesh_events(&mut self, world: &mut World, is_stale: bool) {
        let built = &mut self.pending.built;
        self.meshes.poll(built);
        for event in world.mesh_events.read() {
            // All meshes are read anyway.
            if is_stale {
                continue;
            }
            match *event {
                AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                    self.meshes.changed(id, &world.assets, built);
                }
                AssetEvent::Removed { id } => self.meshes.removed(id, built),
                AssetEvent::Unused { .. } | AssetEvent::LoadedWithDependencies { .. } => {}
            }
        }
    }

    /// Adds and removes rooms. Returns whether entities may be in other rooms than before.
    fn update_rooms(&mut self, world: &mut World, is_stale: bool) -> bool {
        let (added, removed, children, orphans) = &mut world.rooms_changed;
        let was_empty = self.rooms.is_empty();
        let has_changed =
            (is_stale && !world.rooms.is_empty()) | !added.is_empty() | (removed.read().count() > 0);
        let hierarchy_changed = !children.is_empty() | (orphans.read().count() > 0);
        let methods_changed = !world.methods_changed.is_empty() | (world.methods_removed.read().count() > 0);
        if has_changed {
            let gone: Vec<(Entity, SectorId)> = (self.rooms.sectors.iter())
                .filter(|(entity, _)| !world.rooms.contains(**entity))
                .map(|(entity, sector)| (*entity, *sector))
                .collect();
            for (entity, sector) in gone {
                self.rooms.sectors.remove(&entity);
                self.clear_room(sector);
            }
            let mut new: Vec<_> = world
                .rooms
                .iter()
                .filter(|(entity, ..)| !self.rooms.sectors.contains_key(entity))
                .collect();
            new.sort_unstable_by_key(|(entity, ..)| *entity);
            for (entity, _, name) in new {
                let geometry = GeometryBuilder::new(materials());
                let geometry = geometry.build().expect("nothing can be wrong with no items");
                let name = name.map_or_else(|| format!("room {entity}"), ToString::to_string);
                match self.scene.add_sector(
                    &name,
                    geometry,
                    self.scene.method(OUTDOORS).unwrap_or(self.method),
                ) {
                    Ok(sector) => {
                        self.rooms.sectors.insert(entity, sector);
                    }
                    Err(why) => warn!("{name}: {why}"),
                }
            }
        }
        if has_changed || methods_changed {
            for (entity, method, name) in &world.rooms {
                let wanted = method.map_or(self.method, |method| method.0);
                if let Some(sector) = self.rooms.sector(entity)
                    && self.scene.method(sector) != Some(wanted)
                    && let Err(why) = self.scene.set_method(sector, wanted)
                {
                    let name = name.map_or_else(|| format!("room {entity}"), ToString::to_string);
                    warn!("{name}: {why}");
                }
            }
        }
        has_changed || (hierarchy_changed && !(was_empty && self.rooms.is_empty()))
    }

    /// Removes a room. Its entities are read again.
    fn clear_room(&mut self, sector: SectorId) {
        for tracked in self.tracked.values_mut() {
            if tracked.sectors.contains(&sector) {
                self.pending.despawn(tracked);
                tracked.sectors.clear();
            }
        }
        // Only its own items are left, which go with it.
        let _ = self.apply();
        self.pending.clear();
        self.scene.remove_sector(sector);
        self.rooms.boxes.retain(|(room, _)| *room != sector);
        self.portals.is_dirty = true;
    }

    /// Updates the boxes of rooms; returns whether they differ.
    fn update_boxes(&mut self) -> bool {
        let owned = self.tracked.values();
        let owned = owned.filter_map(|tracked| Some((tracked.owner?, world_box(&tracked.spawn))));
        self.rooms.set_boxes(owned)
    }

    /// Moves what is in no room to the sectors that it reaches into.
    fn place_free(&mut self, entity: Entity) {
        let Some(tracked) = self.tracked.get_mut(&entity) else {
            return;
        };
        let sectors = match self.rooms.is_empty() {
            true => vec![OUTDOORS],
            false => self.rooms.reached(&world_box(&tracked.spawn)),
        };
        if sectors != tracked.sectors {
            self.pending.despawn(tracked);
            tracked.sectors = sectors;
            self.pending.spawn(tracked);
        }
    }

    fn apply(&mut self) -> Result<(), SceneError> {
        let pending = &mut self.pending;
        for (number, mesh) in pending.built.drain(..) {
            self.entities.set_mesh(number, mesh.clone());
            self.proxies.set_mesh(number, mesh);
        }
        let maps = [
            (
                &mut self.entities,
                &pending.despawned,
                &pending.spawned,
                &pending.moved,
            ),
            (
                &mut self.proxies,
                &pending.proxies_despawned,
                &pending.proxies_spawned,
                &pending.proxies_moved,
            ),
        ];
        for (map, despawned, spawned, moved) in maps {
            let changes = Changes {
                despawned,
                spawned,
                moved,
            };
            map.sync(&mut self.scene, &changes)?;
        }
        Ok(())
    }

    /// Describes an entity for the scene; `None` if it is to be left alone.
    fn describe(
        &mut self,
        entity: Entity,
        of: &EntityDataItem,
        owner: Option<SectorId>,
        version: u64,
        assets: &Assets<Mesh>,
    ) -> Option<TrackedEntity> {
        let is_left_alone = of.is_always_visible
            || of.is_portal
            || of.is_mirror
            || of.has_no_frustum_culling
            || of.has_no_cpu_culling
            || of.morphs
            || (of.is_skinned && !of.has_dynamic_bounds);
        if is_left_alone || of.inherited.is_some_and(|inherited| !inherited.get()) {
            return None;
        }
        let affine = of.transform.affine();
        let bounds = box_of(of.bounds?);
        let (layers, are_known) = layer_bits(of.layers);
        let may_hide = !of.is_no_occluder && !of.fades && !of.is_skinned && are_known;
        let sides = match of.occluder {
            Some(&sides) => Some(sides).filter(|_| sides == Occluder::TwoSided || !mirrors(&affine)),
            None => of
                .automatic
                .and_then(|automatic| automatic.sides(mirrors(&affine))),
        };
        let proxy = of.proxy.filter(|_| may_hide);
        // A mesh of the main world alone is drawn by no renderer. One that is not loaded is described again when it has a box.
        let is_drawn = |mesh: &Mesh| mesh.asset_usage.contains(RenderAssetUsages::RENDER_WORLD);
        let may_be_drawn = assets.get(of.mesh.id()).is_none_or(is_drawn);
        let sides = sides.filter(|_| may_hide && proxy.is_none() && may_be_drawn);
        let built = &mut self.pending.built;
        let mut spawn = |mesh: Option<(&Mesh3d, Occluder)>, is_drawn| Spawn {
            entity: enfilade_sync::Entity::new(entity.to_bits(), OUTDOORS),
            mesh: mesh.map_or(NO_MESH, |(mesh, sides)| {
                self.meshes.number((mesh.id(), sides), assets, built)
            }),
            bounds,
            transform: transform_of(&affine),
            options: ItemOptions {
                is_occluder: mesh.is_some(),
                is_drawn,
                layers,
                ..ItemOptions::default()
            },
        };
        Some(TrackedEntity {
            spawn: spawn(sides.map(|sides| (of.mesh, sides)), true),
            proxy: proxy.map(|proxy| {
                let mesh = Mesh3d(proxy.0.clone());
                spawn(Some((&mesh, Occluder::OneSided)), false)
            }),
            sectors: Vec::new(),
            owner,
            mirrors: mirrors(&affine),
            version,
        })
    }
}

fn mirrors(affine: &Affine3A) -> bool {
    affine.matrix3.determinant() < 0.0
}

pub(crate) fn transform_of(affine: &Affine3A) -> Transform {
    let [x, y, z] = [
        affine.matrix3.x_axis,
        affine.matrix3.y_axis,
        affine.matrix3.z_axis,
    ];
    Transform::from_columns([x, y, z, affine.translation].map(|column| column.to_array()))
}

/// Returns the corners of a box of Bevy's, which keeps its centre and half its size: grown by what rounding may have lost.
fn box_of(bounds: &Aabb) -> enfilade::Aabb {
    let (center, half) = (bounds.center.to_array(), bounds.half_extents.to_array());
    let grown = [0, 1, 2].map(|axis| half[axis] + 4.0 * f32::EPSILON * (half[axis] + center[axis].abs()));
    enfilade::Aabb {
        min: [0, 1, 2].map(|axis| center[axis] - grown[axis]),
        max: [0, 1, 2].map(|axis| center[axis] + grown[axis]),
    }
}

fn world_box(spawn: &Spawn) -> enfilade::Aabb {
    let corners = spawn.bounds.corners();
    enfilade::Aabb::of(corners.map(|corner| spawn.transform.point(corner)))
}

/// Returns a bit per layer, and whether each layer has its own: those beyond 30 share one.
pub(crate) fn layer_bits(layers: Option<&RenderLayers>) -> (u32, bool) {
    let Some(layers) = layers else { return (1, true) };
    let bits = layers.iter().fold(0, |bits, layer| bits | 1 << layer.min(31));
    (bits, bits >> 31 == 0)
}
