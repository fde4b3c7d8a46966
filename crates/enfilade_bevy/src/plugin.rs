//! The plugin: systems, their order, and diagnostics.

use crate::cameras::{self, EnfiladeCameras, SyncStart};
use crate::components::{
    AlwaysVisible, FreezeVisibility, Mirror, NoVisibilityCulling, NotOccluder, Occluder, OccluderProxy,
    Portal, Sector,
};
use crate::messages::{EntityVisibilityChanged, SectorVisibilityChanged};
use crate::scene::{self, EnfiladeScene};
use crate::settings::EnfiladeSettings;
use bevy_app::prelude::*;
use bevy_asset::{AssetEventSystems, Assets};
use bevy_camera::visibility::VisibilitySystems;
use bevy_diagnostic::{Diagnostic, DiagnosticPath, Diagnostics, RegisterDiagnostic};
use bevy_ecs::prelude::*;
use bevy_log::warn;
use bevy_mesh::Mesh;
use bevy_platform::time::Instant;

/// Culls for all cameras.
#[derive(Clone, Copy, Debug, Default)]
pub struct EnfiladePlugin {
    /// The settings to begin with.
    pub settings: EnfiladeSettings,
}

/// What the plugin does, in `PostUpdate`, after Bevy has listed what is in the frustums.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EnfiladeSystems {
    /// Finds what is opaque, and rooms in glTF files.
    Read,
    /// Synchronizes the scene with the world.
    Sync,
    /// Removes hidden entities from the lists of the cameras.
    Cull,
}

impl EnfiladePlugin {
    /// Milliseconds to synchronize the scene with the world.
    pub const SYNC_TIME: DiagnosticPath = DiagnosticPath::const_new("enfilade/sync_time");
    /// Milliseconds of the looks of all cameras.
    pub const LOOK_TIME: DiagnosticPath = DiagnosticPath::const_new("enfilade/look_time");
    /// Entities with meshes that are left to draw, of all cameras.
    pub const VISIBLE: DiagnosticPath = DiagnosticPath::const_new("enfilade/visible");
    /// Entities with meshes in the frustums that are hidden, of all cameras.
    pub const HIDDEN: DiagnosticPath = DiagnosticPath::const_new("enfilade/hidden");
}

impl Plugin for EnfiladePlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(self.settings)
            .insert_resource(EnfiladeScene::new(self.settings.method))
            .init_resource::<EnfiladeCameras>()
            .insert_resource(SyncStart(Instant::now()))
            .add_message::<EntityVisibilityChanged>()
            .add_message::<SectorVisibilityChanged>()
            .register_type::<AlwaysVisible>()
            .register_type::<FreezeVisibility>()
            .register_type::<Mirror>()
            .register_type::<NoVisibilityCulling>()
            .register_type::<NotOccluder>()
            .register_type::<Occluder>()
            .register_type::<OccluderProxy>()
            .register_type::<Portal>()
            .register_type::<Sector>()
            .register_diagnostic(Diagnostic::new(EnfiladePlugin::SYNC_TIME).with_suffix("ms"))
            .register_diagnostic(Diagnostic::new(EnfiladePlugin::LOOK_TIME).with_suffix("ms"))
            .register_diagnostic(Diagnostic::new(EnfiladePlugin::VISIBLE))
            .register_diagnostic(Diagnostic::new(EnfiladePlugin::HIDDEN))
            .configure_sets(
                PostUpdate,
                (
                    EnfiladeSystems::Read,
                    EnfiladeSystems::Sync,
                    EnfiladeSystems::Cull,
                )
                    .chain()
                    .run_if(resource_exists::<Assets<Mesh>>)
                    .after(VisibilitySystems::CheckVisibility)
                    .after(AssetEventSystems)
                    .before(VisibilitySystems::MarkNewlyHiddenEntitiesInvisible),
            )
            .add_systems(
                PostUpdate,
                (
                    (start_clock, scene::sync, cameras::note_sync_time)
                        .chain()
                        .in_set(EnfiladeSystems::Sync),
                    (cameras::cull, measure).chain().in_set(EnfiladeSystems::Cull),
                ),
            );
        #[cfg(feature = "pbr")]
        app.init_resource::<Assets<bevy_pbr::StandardMaterial>>()
            .init_resource::<Assets<bevy_image::Image>>()
            .add_message::<bevy_asset::AssetEvent<bevy_pbr::StandardMaterial>>()
            .add_message::<bevy_asset::AssetEvent<bevy_image::Image>>()
            .add_systems(
                PostUpdate,
                (
                    crate::automatic::standard_material::find_opaque,
                    crate::automatic::find_samples,
                )
                    .in_set(EnfiladeSystems::Read),
            );
        #[cfg(feature = "gltf")]
        app.add_systems(PostUpdate, crate::gltf::read_extras.in_set(EnfiladeSystems::Read));
    }

    fn finish(&self, app: &mut App) {
        if !app.world().contains_resource::<Assets<Mesh>>() {
            warn!(
                "Enfilade has nothing to cull: add Bevy's DefaultPlugins, or its AssetPlugin, MeshPlugin and VisibilityPlugin"
            );
        }
    }
}

fn start_clock(mut start: ResMut<SyncStart>) {
    start.0 = Instant::now();
}

fn measure(cameras: Res<EnfiladeCameras>, mut diagnostics: Diagnostics) {
    let stats = cameras.stats();
    let milliseconds = |time: std::time::Duration| 1e3 * time.as_secs_f64();
    diagnostics.add_measurement(&EnfiladePlugin::SYNC_TIME, || milliseconds(stats.sync_time));
    diagnostics.add_measurement(&EnfiladePlugin::LOOK_TIME, || milliseconds(stats.look_time));
    diagnostics.add_measurement(&EnfiladePlugin::VISIBLE, || stats.visible as f64);
    diagnostics.add_measurement(&EnfiladePlugin::HIDDEN, || stats.hidden as f64);
}
