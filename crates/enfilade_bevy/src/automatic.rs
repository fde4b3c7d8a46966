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
    use bevy_asset::{AssetEvent, AssetId, Assets, VisitAssetDependencies};
    use bevy_image::Image;
    use bevy_material::AlphaMode;
    use bevy_mesh::Mesh3d;
    use bevy_pbr::{MeshMaterial3d, StandardMaterial};
    use bevy_platform::collections::HashSet;

    type MaterialUse = (
        Entity,
        &'static MeshMaterial3d<StandardMaterial>,
        Option<&'static AutomaticOccluder>,
    );

    /// Marks the entities whose material is opaque and has all its images: until they are loaded, Bevy draws nothing with it.
    pub(crate) fn find_opaque(
        mut commands: Commands,
        materials: Res<Assets<StandardMaterial>>,
        images: Res<Assets<Image>>,
        mut events: MessageReader<AssetEvent<StandardMaterial>>,
        mut image_events: MessageReader<AssetEvent<Image>>,
        mut lacking_images: Local<HashSet<AssetId<StandardMaterial>>>,
        changed: Query<MaterialUse, (With<Mesh3d>, Changed<MeshMaterial3d<StandardMaterial>>)>,
        all: Query<MaterialUse, With<Mesh3d>>,
        mut removed: RemovedComponents<MeshMaterial3d<StandardMaterial>>,
    ) {
        for entity in removed.read() {
            if let Ok(mut entity) = commands.get_entity(entity) {
                entity.try_remove::<AutomaticOccluder>();
            }
        }
        let mut changed_materials: HashSet<AssetId<StandardMaterial>> = events
            .read()
            .filter_map(|event| match event {
                AssetEvent::Added { id } | AssetEvent::Modified { id } | AssetEvent::Removed { id } => {
                    Some(*id)
                }
                _ => None,
            })
            .collect();
        let is_new = |event: &AssetEvent<Image>| matches!(event, AssetEvent::Added { .. });
        if image_events.read().filter(|event| is_new(event)).count() > 0 {
            changed_materials.extend(lacking_images.drain());
        }
        let has_images = |material: &StandardMaterial| {
            let mut has_all = true;
            material.visit_dependencies(&mut |id| {
                let image = id.try_typed::<Image>();
                has_all &= image.map_or(true, |image| images.contains(image));
            });
            has_all
        };
        let uses_changed = |(_, material, _): &(Entity, &MeshMaterial3d<StandardMaterial>, _)| {
            changed_materials.contains(&material.id())
        };
        let of_materials = all
            .iter()
            .filter(|_| !changed_materials.is_empty())
            .filter(uses_changed);
        for (entity, material, was) in changed.iter().chain(of_materials) {
            let mut now = materials.get(material.id()).and_then(opaque_sides);
            if now.is_some() && !materials.get(material.id()).is_some_and(has_images) {
                lacking_images.insert(material.id());
                now = None;
            }
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
    #[cfg(test)]
    mod tests {
        use super::*;
        use bevy_app::{App, Update};
        use bevy_asset::{AssetApp, AssetPlugin};

        fn an_app() -> App {
            let mut app = App::new();
            app.add_plugins((bevy_app::TaskPoolPlugin::default(), AssetPlugin::default()))
                .init_asset::<Image>()
                .init_asset::<StandardMaterial>()
                .add_systems(Update, find_opaque);
            app
        }

        fn spawn(app: &mut App, material: StandardMaterial) -> Entity {
            let mut materials = app.world_mut().resource_mut::<Assets<StandardMaterial>>();
            let material = MeshMaterial3d(materials.add(material));
            app.world_mut().spawn((Mesh3d::default(), material)).id()
        }

        fn is_opaque(app: &mut App, entity: Entity) -> bool {
            // Events arrive one frame later, and commands at its end.
            (0..3).for_each(|_| app.update());
            app.world().get::<AutomaticOccluder>(entity).is_some()
        }

        #[test]
        fn glass_leaves_and_what_is_shifted_in_depth_hide_nothing() {
            let mut app = an_app();
            let plain = StandardMaterial::default;
            for material in [
                StandardMaterial {
                    alpha_mode: AlphaMode::Blend,
                    ..plain()
                },
                StandardMaterial {
                    alpha_mode: AlphaMode::Mask(0.5),
                    ..plain()
                },
                StandardMaterial {
                    specular_transmission: 0.5,
                    ..plain()
                },
                StandardMaterial {
                    diffuse_transmission: 0.5,
                    ..plain()
                },
                StandardMaterial {
                    depth_bias: 1.0,
                    ..plain()
                },
            ] {
                let entity = spawn(&mut app, material);
                assert!(!is_opaque(&mut app, entity));
            }
            let entity = spawn(&mut app, plain());
            assert!(is_opaque(&mut app, entity));
            let world = app.world_mut();
            let material = world.get::<MeshMaterial3d<StandardMaterial>>(entity);
            let id = material.expect("a material").id();
            let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
            materials.get_mut(id).expect("a material").alpha_mode = AlphaMode::Add;
            assert!(!is_opaque(&mut app, entity));
        }

        #[test]
        fn a_wall_whose_texture_is_still_loading_hides_nothing_because_it_is_not_drawn() {
            let mut app = an_app();
            let images = app.world().resource::<Assets<Image>>();
            let texture = images.reserve_handle();
            let wall = StandardMaterial {
                normal_map_texture: Some(texture.clone()),
                ..StandardMaterial::default()
            };
            let entity = spawn(&mut app, wall);
            assert!(!is_opaque(&mut app, entity));
            let mut images = app.world_mut().resource_mut::<Assets<Image>>();
            images
                .insert(texture.id(), Image::default())
                .expect("a reserved handle");
            assert!(is_opaque(&mut app, entity));
        }
    }
}
