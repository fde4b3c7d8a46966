//! Culls for the cameras: looks, and removes hidden entities from their lists of visible ones.
//!
//! [`VisibleEntities`] of a camera decide what is drawn for it, and nothing else: shadows, picking, other cameras and
//! `ViewVisibility`, which is one flag for all views, do not change.

use crate::automatic::CameraSamples;
use crate::components::{FreezeVisibility, NoVisibilityCulling, PvsCells};
use crate::messages::{EntityVisibilityChanged, SectorVisibilityChanged};
use crate::pvs::{EntityCells, cell_of};
use crate::rooms::OUTDOORS;
use crate::scene::{EnfiladeScene, layer_bits};
use crate::settings::{EnfiladeSettings, Samples};
use bevy_camera::Camera;
use bevy_camera::visibility::{NoCpuCulling, RenderLayers, VisibleEntities};
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_log::warn_once;
use bevy_math::{DMat4, DVec3};
use bevy_mesh::Mesh3d;
use bevy_platform::collections::HashMap;
use bevy_platform::time::Instant;
use bevy_tasks::ComputeTaskPool;
use bevy_transform::prelude::GlobalTransform;
use enfilade::{ClipDepth, Scene, SectorId, View, Viewer, ViewerOptions, VisibleKeys, VisibleSet};
use std::any::TypeId;
use std::time::Duration;

/// What the cameras see.
#[derive(Resource, Default)]
pub struct EnfiladeCameras {
    states: HashMap<Entity, CameraState>,
    stats: LookStats,
}

/// Numbers of the last frame, all cameras together.
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub struct LookStats {
    /// Time to synchronize the scene with the world.
    pub sync_time: Duration,
    /// Time of the looks, and of what follows from them.
    pub look_time: Duration,
    /// Cameras that were culled for.
    pub cameras: usize,
    /// Entities with meshes that are left to draw.
    pub visible: usize,
    /// Entities with meshes in the frustums that were found to be hidden.
    pub hidden: usize,
}

/// What is kept of a camera from frame to frame.
#[derive(Default)]
struct CameraState {
    /// One for each of the samples that are looked at; the first always.
    viewers: [Viewer; 4],
    keys: VisibleKeys,
    cells: EntityCells,
    frozen: Option<View>,
    is_culled: bool,
    is_by_pvs: bool,
    /// Whether a look of the last frame hit a limit.
    hit_limit: bool,
    /// Culled entities that are left to draw, sorted.
    visible: Vec<Entity>,
    /// Entities in the frustum that are hidden, sorted.
    hidden: Vec<Entity>,
    sectors: Vec<SectorId>,
}

impl EnfiladeCameras {
    /// Returns the numbers of the last frame.
    pub fn stats(&self) -> LookStats {
        self.stats
    }

    /// Returns the visible set of a camera, with its passages; `None` if it is not culled for, or by a PVS. With
    /// [`Samples::Four`], it is that of the first look.
    pub fn visible_set(&self, camera: Entity) -> Option<&VisibleSet> {
        let state = self.culled(camera).filter(|state| !state.is_by_pvs)?;
        Some(state.viewers[0].visible())
    }

    /// Returns whether an entity that may be culled is left to draw for a camera.
    pub fn sees(&self, camera: Entity, entity: Entity) -> bool {
        self.culled(camera)
            .is_none_or(|state| state.visible.binary_search(&entity).is_ok())
    }

    /// Returns the entities in a camera's frustum that are hidden from it, sorted.
    pub fn hidden(&self, camera: Entity) -> &[Entity] {
        self.culled(camera).map_or(&[], |state| &state.hidden)
    }

    /// Returns the view of a camera whose visible set is frozen.
    pub fn frozen_view(&self, camera: Entity) -> Option<&View> {
        self.culled(camera)?.frozen.as_ref()
    }

    fn culled(&self, camera: Entity) -> Option<&CameraState> {
        self.states.get(&camera).filter(|state| state.is_culled)
    }
}

/// A camera, and what decides how it is culled for.
#[derive(QueryData)]
#[query_data(mutable)]
pub(crate) struct CulledCamera {
    entity: Entity,
    camera: &'static Camera,
    transform: &'static GlobalTransform,
    visible: &'static mut VisibleEntities,
    layers: Option<&'static RenderLayers>,
    samples: Option<&'static CameraSamples>,
    pvs: Option<&'static PvsCells>,
    is_frozen: Has<FreezeVisibility>,
    is_left_alone: Has<NoVisibilityCulling>,
    has_no_cpu_culling: Has<NoCpuCulling>,
}

/// Records how long synchronizing took.
pub(crate) fn note_sync_time(mut cameras: ResMut<EnfiladeCameras>, start: Res<SyncStart>) {
    cameras.stats.sync_time = start.0.elapsed();
}

/// When synchronizing began.
#[derive(Resource)]
pub(crate) struct SyncStart(pub(crate) Instant);

/// Removes hidden entities from the lists of the cameras.
pub(crate) fn cull(
    settings: Res<EnfiladeSettings>,
    scene: Res<EnfiladeScene>,
    mut cameras: ResMut<EnfiladeCameras>,
    mut views: Query<CulledCamera>,
    parents: Query<&ChildOf>,
    mut entities_changed: MessageWriter<EntityVisibilityChanged>,
    mut sectors_changed: MessageWriter<SectorVisibilityChanged>,
) {
    let start = Instant::now();
    let EnfiladeCameras { states, stats } = &mut *cameras;
    (stats.cameras, stats.visible, stats.hidden) = (0, 0, 0);
    states.retain(|&camera, _| views.contains(camera));
    for mut view in &mut views {
        let state = states.entry(view.entity).or_default();
        let was_culled = std::mem::replace(&mut state.is_culled, false);
        let leaves_alone = view.is_left_alone || view.has_no_cpu_culling || !view.camera.is_active;
        let mesh = TypeId::of::<Mesh3d>();
        let is_used = was_culled || !view.visible.get(mesh).is_empty();
        let mut seen = None;
        if settings.enabled && scene.is_ready() && !leaves_alone && is_used {
            let own = view_of(&view, &scene, scene.rooms.owner(view.entity, &parents));
            // One that is frozen stays, wherever the camera flies.
            seen = state.frozen.filter(|_| view.is_frozen).or(own);
            state.frozen = seen.filter(|_| view.is_frozen);
        }
        let found = match (seen, view.pvs) {
            (None, _) => None,
            (Some(seen), Some(pvs)) => {
                let list = view.visible.get_mut(mesh);
                Some((state.cull_by_pvs(list, pvs, &seen, &scene), Vec::new()))
            }
            (Some(seen), None) => {
                let of_camera = view.samples.map(|samples| samples.0);
                let samples = settings.samples.or(of_camera).unwrap_or(Samples::Any);
                let mut options = settings.options;
                options.layers = layer_bits(view.layers).0;
                let list = view.visible.get_mut(mesh);
                state.cull_by_looks(list, samples, options, &seen, &scene)
            }
        };
        let Some((visible, sectors)) = found else {
            for entity in state.show_all() {
                entities_changed.write(EntityVisibilityChanged {
                    camera: view.entity,
                    entity,
                    visible: true,
                });
            }
            continue;
        };
        state.is_culled = true;
        state.is_by_pvs = view.pvs.is_some();
        stats.cameras += 1;
        stats.visible += view.visible.get(mesh).len();
        stats.hidden += state.hidden.len();
        let camera = view.entity;
        for (entity, visible) in differences(&state.visible, &visible) {
            entities_changed.write(EntityVisibilityChanged {
                camera,
                entity,
                visible,
            });
        }
        for (sector, visible) in differences(&state.sectors, &sectors) {
            if let Some(sector) = scene.rooms.entity(sector) {
                sectors_changed.write(SectorVisibilityChanged {
                    camera,
                    sector,
                    visible,
                });
            }
        }
        state.visible = visible;
        state.sectors = sectors;
    }
    stats.look_time = start.elapsed();
}

impl CameraState {
    /// Records that nothing is hidden any more. Returns the entities that were.
    fn show_all(&mut self) -> Vec<Entity> {
        let hidden = std::mem::take(&mut self.hidden);
        self.visible.extend_from_slice(&hidden);
        self.visible.sort_unstable();
        hidden
    }

    /// Removes from a list what a PVS hides. Returns the entities left in it that may be culled.
    fn cull_by_pvs(
        &mut self,
        list: &mut Vec<Entity>,
        pvs: &PvsCells,
        seen: &View,
        scene: &EnfiladeScene,
    ) -> Vec<Entity> {
        let from = cell_of(pvs, DVec3::from(seen.eye()));
        let mut visible = Vec::with_capacity(self.visible.len());
        self.hidden.clear();
        list.retain(|&entity| {
            let Some(bounds) = scene.bounds(entity) else {
                return true;
            };
            let is_seen = from.is_none_or(|from| self.cells.may_be_seen(pvs, from, entity, bounds));
            let side = if is_seen { &mut visible } else { &mut self.hidden };
            side.push(entity);
            is_seen
        });
        visible
    }

    /// Removes from a list what looks do not see. Returns the entities left in it that may be culled, and the visible
    /// sectors; `None`, with the list unchanged, if a look hits a limit.
    fn cull_by_looks(
        &mut self,
        list: &mut Vec<Entity>,
        samples: Samples,
        mut options: ViewerOptions,
        seen: &View,
        scene: &EnfiladeScene,
    ) -> Option<(Vec<Entity>, Vec<SectorId>)> {
        let views = match samples {
            Samples::Centers | Samples::Any => [Some(*seen), None, None, None],
            Samples::Four => View::FOUR_SAMPLES.map(|at| seen.at_sample(at).ok()),
        };
        if samples == Samples::Any {
            options.margin_px = 0.5;
        }
        // Where the last looks hit a limit, one tells whether they still do: between mirrors that face each other, each
        // takes long.
        if std::mem::take(&mut self.hit_limit) {
            look(
                &mut self.viewers,
                &scene.scene,
                [views[0], None, None, None],
                options,
            );
            self.hit_limit = !self.viewers[0].visible().complete();
        }
        if self.hit_limit {
            return None;
        }
        look(&mut self.viewers, &scene.scene, views, options);
        let sets = self.viewers.iter().zip(views).filter(|(_, view)| view.is_some());
        let sets: Vec<&VisibleSet> = sets.map(|(viewer, _)| viewer.visible()).collect();
        if !sets.iter().all(|set| set.complete()) {
            self.hit_limit = true;
            return None;
        }
        let passages = sets.iter().flat_map(|set| set.passages());
        let mut sectors: Vec<SectorId> = passages.map(|passage| passage.sector).collect();
        sectors.sort_unstable();
        sectors.dedup();
        let others = sets[1..].iter().flat_map(|set| set.items()).map(|item| item.key);
        self.keys
            .update_with(sets[0], others.chain(scene.entities.always_visible()));

        let mut visible = Vec::with_capacity(self.visible.len());
        self.hidden.clear();
        // Both lists are sorted alike.
        let mut keys = self.keys.all().iter().copied().peekable();
        list.retain(|&entity| {
            let key = entity.to_bits();
            while keys.next_if(|&next| next < key).is_some() {}
            let is_seen = keys.next_if_eq(&key).is_some();
            if !is_seen && !scene.contains(entity) {
                return true;
            }
            let side = if is_seen { &mut visible } else { &mut self.hidden };
            side.push(entity);
            is_seen
        });
        Some((visible, sectors))
    }
}

/// Looks from each view with the viewer of the same index, in parallel where Bevy has threads.
fn look(viewers: &mut [Viewer; 4], scene: &Scene, views: [Option<View>; 4], options: ViewerOptions) {
    let pairs = viewers
        .iter_mut()
        .zip(views)
        .filter_map(|(viewer, view)| Some((viewer, view?)));
    let looks = pairs.map(|(viewer, view)| {
        viewer.options = options;
        move || {
            viewer.look(scene, &view);
        }
    });
    match views.iter().flatten().count() {
        1 => looks.for_each(|mut look| look()),
        _ => {
            ComputeTaskPool::get()
                .scope(|scope| looks.for_each(|mut look| scope.spawn(async move { look() })));
        }
    }
}

/// Returns the view of a camera; `None` if it cannot be culled for.
fn view_of(of: &CulledCameraItem, scene: &EnfiladeScene, owner: Option<SectorId>) -> Option<View> {
    let size = of.camera.physical_viewport_size()?;
    let world_from_eye = DMat4::from(of.transform.affine().as_daffine3());
    let eye_from_world = world_from_eye.inverse().to_cols_array_2d();
    let clip_from_eye = of.camera.clip_from_view().as_dmat4().to_cols_array_2d();
    let view = View::from_matrices(
        eye_from_world,
        clip_from_eye,
        ClipDepth::OneToZero,
        size.to_array(),
    );
    let view = match view {
        Ok(view) => view,
        Err(why) => {
            warn_once!("Enfilade does not cull for the camera {}: {why}", of.entity);
            return None;
        }
    };
    // Occluders hide by the sides that are in front in the world. Here the others are drawn.
    if view.mirrored() != of.camera.invert_culling {
        warn_once!(
            "Enfilade does not cull for the camera {}, which draws back faces: its `invert_culling` is to be set if its \
             transform or projection mirrors, and only then",
            of.entity
        );
        return None;
    }
    if scene.rooms.is_empty() {
        return Some(view.in_sector(OUTDOORS));
    }
    // A camera of a reflection is behind the mirror, where its room is not.
    if view.near_plane().is_some() && owner.is_none() {
        return None;
    }
    let eye = view.eye().map(|part| part as f32);
    match owner.or_else(|| scene.rooms.at(eye)) {
        Some(room) => Some(view.in_sector(room)),
        // In a wall, say. Without a portal there, outdoors is not a place that the author thought of.
        None if scene.scene.sector(OUTDOORS).openings().is_empty() => None,
        None => Some(view.in_sector(OUTDOORS)),
    }
}

/// Returns what is in one of two sorted lists only, and whether that is the second.
fn differences<T: Copy + Ord>(was: &[T], now: &[T]) -> Vec<(T, bool)> {
    let (mut a, mut b) = (was.iter().peekable(), now.iter().peekable());
    let mut differences = Vec::new();
    loop {
        match (a.peek(), b.peek()) {
            (Some(old), Some(new)) if old == new => {
                a.next();
                b.next();
            }
            (Some(old), new) if new.is_none_or(|new| old < new) => {
                differences.push((**old, false));
                a.next();
            }
            (_, Some(new)) => {
                differences.push((**new, true));
                b.next();
            }
            _ => return differences,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_in_one_list_only_came_or_went() {
        let differences = differences(&[1, 3, 5], &[2, 3, 6]);
        assert_eq!(differences, [(1, false), (2, true), (5, false), (6, true)]);
    }
}
