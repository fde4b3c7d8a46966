//! Which entities hide others by their material.

use crate::{Occluder, Samples};
use bevy_ecs::prelude::*;

/// The material of an entity draws all of its faces, or those of one side, and nothing is seen through them.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(not(feature = "pbr"), expect(dead_code, reason = "no material is read"))]
pub(crate) enum AutomaticOccluder {
    /// Front faces are drawn.
    Front,
    /// Back faces are drawn: Bevy's loader of glTF files asks for it where a transform mirrors.
    Back,
    /// Both.
    Both,
}

impl AutomaticOccluder {
    /// Returns which sides hide, with a transform that mirrors or not; `None` if the mesh is drawn inside out.
    pub(crate) fn sides(self, mirrors: bool) -> Option<Occluder> {
        match (self, mirrors) {
            (AutomaticOccluder::Both, _) => Some(Occluder::TwoSided),
            (AutomaticOccluder::Front, false) | (AutomaticOccluder::Back, true) => Some(Occluder::OneSided),
            (AutomaticOccluder::Front, true) | (AutomaticOccluder::Back, false) => None,
        }
    }
}

/// The samples that a camera's picture has.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CameraSamples(pub(crate) Samples);

/// Reads the antialiasing of cameras.
#[cfg(feature = "pbr")]
pub(crate) fn find_samples(
    mut commands: Commands,
    cameras: Query<(
        Entity,
        &bevy_render::view::Msaa,
        Has<bevy_render::camera::TemporalJitter>,
        Has<bevy_camera::MainPassResolutionOverride>,
        Option<&CameraSamples>,
    )>,
) {
    use bevy_render::view::Msaa;
    for (entity, msaa, jitters, is_scaled, was) in &cameras {
        let samples = match msaa {
            Msaa::Off if !jitters && !is_scaled => Samples::Centers,
            Msaa::Sample4 if !jitters && !is_scaled => Samples::Four,
            _ => Samples::Any,
        };
        if was != Some(&CameraSamples(samples)) {
            commands.entity(entity).try_insert(CameraSamples(samples));
        }
    }
}

/// Reads the `StandardMaterial`s.
#[cfg(feature = "pbr")]
pub(crate) mod standard_material {
    use super::*;
    use bevy_asset::{AssetEvent, AssetId, Assets};
    use bevy_material::AlphaMode;
    use bevy_mesh::Mesh3d;
    use bevy_pbr::{MeshMaterial3d, StandardMaterial};
    use bevy_platform::collections::HashSet;

    type Uses = (
        Entity,
        &'static MeshMaterial3d<StandardMaterial>,
        Option<&'static AutomaticOccluder>,
    );

    /// Marks the entities whose material is opaque.
    pub(crate) fn find_opaque(
        mut commands: Commands,
        materials: Res<Assets<StandardMaterial>>,
        mut events: MessageReader<AssetEvent<StandardMaterial>>,
        changed: Query<Uses, (With<Mesh3d>, Changed<MeshMaterial3d<StandardMaterial>>)>,
        all: Query<Uses, With<Mesh3d>>,
        mut removed: RemovedComponents<MeshMaterial3d<StandardMaterial>>,
    ) {
        for entity in removed.read() {
            if let Ok(mut entity) = commands.get_entity(entity) {
                entity.try_remove::<AutomaticOccluder>();
            }
        }
        let changed_materials: HashSet<AssetId<StandardMaterial>> = events
            .read()
            .filter_map(|event| match event {
                AssetEvent::Added { id } | AssetEvent::Modified { id } | AssetEvent::Removed { id } => {
                    Some(*id)
                }
                _ => None,
            })
            .collect();
        let uses_changed = |(_, material, _): &(Entity, &MeshMaterial3d<StandardMaterial>, _)| {
            changed_materials.contains(&material.id())
        };
        let of_materials = all
            .iter()
            .filter(|_| !changed_materials.is_empty())
            .filter(uses_changed);
        for (entity, material, was) in changed.iter().chain(of_materials) {
            let now = materials.get(material.id()).and_then(opaque_sides);
            if now == was.copied() {
                continue;
            }
            match now {
                Some(now) => commands.entity(entity).try_insert(now),
                None => commands.entity(entity).try_remove::<AutomaticOccluder>(),
            };
        }
    }

    fn opaque_sides(material: &StandardMaterial) -> Option<AutomaticOccluder> {
        use wgpu_types::Face;
        let is_opaque = material.alpha_mode == AlphaMode::Opaque
            && material.specular_transmission == 0.0
            && material.diffuse_transmission == 0.0
            && material.depth_bias == 0.0;
        is_opaque.then_some(match material.cull_mode {
            Some(Face::Back) => AutomaticOccluder::Front,
            Some(Face::Front) => AutomaticOccluder::Back,
            None => AutomaticOccluder::Both,
        })
    }
}
