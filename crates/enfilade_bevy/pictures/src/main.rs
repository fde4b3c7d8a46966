//! Compares what Bevy draws with and without Enfilade: the pictures, which must be the same, and how much is drawn.
//!
//! `cargo run --release -p enfilade_bevy_pictures -- SCENE.glb VIEWS.jsonl FRAMES [--without-rooms]`: the views are those
//! that `enfilade look --path` reads, and the path leads from one to the next. In every tenth frame, a second camera looks the
//! other way. A software driver will do. Without rooms, the file's extras are ignored, and the path may lead through walls.
//! Where FRAMES is `300:192`, only frame 192 of the 300 is drawn.
//!
//! Where pictures differ, rays say whether the face that is nearest at a sample was drawn. If it was, the difference is the
//! renderer's: at samples beside an edge, or on a sliver, whose depth a rasterizer extrapolates, it may draw over a nearer face
//! what is behind it.
//!
//! The palace, `crates/enfilade_scenes/src/palace.glb`, is compressed by extensions that Bevy does not read;
//! `tools/palace` writes it without them.
#![forbid(unsafe_code)]
#![expect(clippy::print_stdout, reason = "the answer")]

use anyhow::{Context, Result, bail, ensure};
use bevy::asset::{RenderAssetUsages, UnapprovedPathMode};
use bevy::camera::RenderTarget;
use bevy::camera::visibility::VisibleEntities;
use bevy::diagnostic::DiagnosticsStore;
use bevy::gltf::{GltfAssetLabel, GltfExtras};
use bevy::light::cluster::GlobalClusterSettings;
use bevy::light::{CascadeShadowConfigBuilder, DirectionalLightShadowMap, ShadowFilteringMethod};
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::render_resource::{TextureFormat, TextureUsages};
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};
use bevy::world_serialization::WorldAssetRoot;
use enfilade_bevy::{EnfiladePlugin, EnfiladeScene, NoVisibilityCulling};
use std::any::TypeId;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::Instant;

const SIZE: UVec2 = UVec2::new(320, 240);
/// By how much a channel of equal pictures may differ, of 255: where faces are equally far, the order in which they are drawn
/// decides, and that is another one if fewer are drawn.
const ROUNDING: u8 = 1;
/// The samples of a pixel, of four: those of Vulkan, from its left upper corner.
const SAMPLES: [Vec2; 4] = [
    Vec2::new(0.375, 0.125),
    Vec2::new(0.875, 0.375),
    Vec2::new(0.125, 0.625),
    Vec2::new(0.625, 0.875),
];
/// In one frame of so many, the second camera draws too, and rays through all samples say how many entities any culling must
/// draw.
const TENTH: usize = 10;
/// Frames from one line of progress to the next.
const PROGRESS: usize = 25;
/// Updates that the last pictures may take.
const PATIENCE: usize = 200;

fn main() -> Result<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let (scene, views, frames, has_rooms) = match args[..] {
        [scene, views, frames] => (scene, views, frames, true),
        [scene, views, frames, "--without-rooms"] => (scene, views, frames, false),
        _ => bail!("usage: enfilade_bevy_pictures SCENE.glb VIEWS.jsonl FRAMES [--without-rooms]"),
    };
    let (frames, only) = frames
        .split_once(':')
        .map_or((frames, None), |(all, only)| (all, Some(only)));
    let number = |text: &str| {
        text.parse::<usize>()
            .context("FRAMES is a number, or two with a colon")
    };
    let only = only.map(number).transpose()?;
    let mut path: Vec<_> = read_path(views, number(frames)?)?
        .into_iter()
        .enumerate()
        .collect();
    path.retain(|(number, _)| only.is_none_or(|only| *number == only));
    let frames = path.len();
    let start = Instant::now();
    let mut stage = Stage::open(Path::new(scene), has_rooms)?;
    println!("{scene}: opened in {:.0} s", start.elapsed().as_secs_f64());
    let mut sums = Sums::default();
    for (done, (number, place)) in path.into_iter().enumerate() {
        if done > 0 && done % PROGRESS == 0 {
            println!(
                "frame {done} of {frames}: {:.0} s, {} pictures lack something",
                start.elapsed().as_secs_f64(),
                sums.lacking
            );
        }
        let is_tenth = number % TENTH == 0 || frames == 1;
        stage.look_from(place, is_tenth);
        stage.draw(number, Drawn::With);
        let drawn = stage.drawn();
        let count = drawn.iter().map(|by| by.entities.len()).sum::<usize>();
        sums.with += count;
        sums.views += drawn.len();
        sums.times.push(stage.plugin_ms());
        if is_tenth {
            let scene = stage.app.world().resource::<EnfiladeScene>();
            sums.nearest += drawn.iter().map(|by| by.nearest_count(scene)).sum::<usize>();
            sums.nearest_or_not += count;
        }
        sums.drawn.insert(number, drawn);
        stage.draw(number, Drawn::Without);
        sums.without += stage.drawn().iter().map(|by| by.entities.len()).sum::<usize>();
        sums.compare(&mut stage)?;
    }
    for _ in 0..PATIENCE {
        if sums.compared == sums.views {
            break;
        }
        stage.app.update();
        sums.compare(&mut stage)?;
    }
    ensure!(sums.compared == sums.views, "no picture came");
    sums.times.sort_by(f64::total_cmp);
    let time = |part: f64| sums.times[((sums.times.len() - 1) as f64 * part) as usize];
    let entities = stage.app.world().resource::<EnfiladeScene>().scene().item_count();
    println!(
        "{scene}: {entities} entities, {} pictures of {frames} frames: {} pictures lack something, {} pixels differ though the \
         nearest face is drawn, {} by one level; entities drawn per view {:.1} of {:.1} \
         in the frustum, {:.1} % less ({:.1} % of them are nearest at a sample); plugin {:.2} ms (median), {:.2} ms (p99)",
        sums.views,
        sums.lacking,
        sums.renderers,
        sums.rounded,
        sums.with as f64 / sums.views as f64,
        sums.without as f64 / sums.views as f64,
        100.0 * (1.0 - sums.with as f64 / sums.without as f64),
        100.0 * sums.nearest as f64 / sums.nearest_or_not as f64,
        time(0.5),
        time(0.99)
    );
    ensure!(sums.lacking == 0, "pictures lack something");
    Ok(())
}

#[derive(Default)]
struct Sums {
    compared: usize,
    /// Pictures with a sample whose nearest face was not drawn.
    lacking: usize,
    /// Pixels that differ though the nearest face was drawn at all samples.
    renderers: usize,
    /// Pixels that differ by rounding.
    rounded: usize,
    /// Pictures with Enfilade, and as many without.
    views: usize,
    /// What was drawn with Enfilade in each frame, by each active camera, and from where.
    drawn: BTreeMap<usize, Vec<Drawing>>,
    with: usize,
    without: usize,
    /// Of the frames for which rays were cast: the entities that are nearest at a sample, and all that were drawn.
    nearest: usize,
    nearest_or_not: usize,
    times: Vec<f64>,
}

impl Sums {
    /// Compares the pictures that have arrived in pairs.
    fn compare(&mut self, stage: &mut Stage) -> Result<()> {
        let mut captured = stage.app.world_mut().resource_mut::<Captured>();
        let pairs: Vec<_> = captured
            .0
            .extract_if(.., |_, pair| pair.iter().all(Option::is_some))
            .collect();
        for ((frame, camera), pair) in pairs {
            let [with, without] = pair.map(Option::unwrap_or_default);
            let [a, b] = [&with, &without].map(|picture| picture.as_chunks::<4>().0);
            let apart = |a: &[u8; 4], b: &[u8; 4]| (0..4).map(|part| a[part].abs_diff(b[part])).max();
            let is_apart = |&number: &usize| apart(&a[number], &b[number]) > Some(ROUNDING);
            let differing: Vec<usize> = (0..a.len()).filter(is_apart).collect();
            self.rounded += a.iter().zip(b).filter(|(a, b)| a != b).count() - differing.len();
            if !differing.is_empty() {
                let drawing = &self.drawn[&frame][camera];
                let scene = stage.app.world().resource::<EnfiladeScene>();
                let lacks: Vec<Entity> = differing
                    .iter()
                    .filter_map(|&pixel| drawing.lacks(scene, pixel))
                    .collect();
                println!(
                    "frame {frame}, camera {camera}: {} pixels differ, the first at {}, {}; {} of them lack {lacks:?}",
                    differing.len(),
                    differing[0] % SIZE.x as usize,
                    differing[0] / SIZE.x as usize,
                    lacks.len(),
                );
                self.lacking += usize::from(!lacks.is_empty());
                self.renderers += differing.len() - lacks.len();
                save(&with, &format!("with-{frame}-{camera}.png"))?;
                save(&without, &format!("without-{frame}-{camera}.png"))?;
            } else if frame % 50 == 0 {
                save(&with, &format!("frame-{frame}-{camera}.png"))?;
            }
            self.compared += 1;
        }
        Ok(())
    }
}

/// What a camera drew.
struct Drawing {
    place: Transform,
    lens: PerspectiveProjection,
    entities: BTreeSet<Entity>,
}

impl Drawing {
    /// Returns an entity that is nearest at a sample of a pixel, but was not drawn.
    fn lacks(&self, scene: &EnfiladeScene, pixel: usize) -> Option<Entity> {
        self.nearest(scene, pixel)
            .find(|entity| !self.entities.contains(entity))
    }

    /// Returns how many of the entities are nearest at a sample.
    fn nearest_count(&self, scene: &EnfiladeScene) -> usize {
        let pixels = 0..SIZE.element_product() as usize;
        let nearest: BTreeSet<Entity> = pixels.flat_map(|pixel| self.nearest(scene, pixel)).collect();
        // Rays enter mirrors, and meet what is behind the camera.
        nearest.intersection(&self.entities).count()
    }

    /// Returns what is nearest at the samples of a pixel.
    fn nearest(&self, scene: &EnfiladeScene, pixel: usize) -> impl Iterator<Item = Entity> {
        let corner = UVec2::new(pixel as u32 % SIZE.x, pixel as u32 / SIZE.x).as_vec2();
        let size = SIZE.as_vec2();
        SAMPLES.into_iter().filter_map(move |sample| {
            let at = (corner + sample) / size * 2.0 - 1.0;
            let half = (self.lens.fov / 2.0).tan();
            let ahead = Vec3::new(at.x * half * size.x / size.y, -at.y * half, -1.0);
            let [from, to] = [self.lens.near, self.lens.far].map(|depth| self.place * (ahead * depth));
            scene.first_between(from, to)
        })
    }
}

/// Reads views, and returns places on the way from each to the next.
fn read_path(file: &str, frames: usize) -> Result<Vec<Transform>> {
    let text = std::fs::read_to_string(file).with_context(|| file.to_owned())?;
    let mut stops = Vec::new();
    for line in text.lines().filter(|line| !line.trim().is_empty()) {
        let view: serde_json::Value = serde_json::from_str(line).with_context(|| file.to_owned())?;
        let point = |key: &str| -> Result<Vec3> {
            let parts: Vec<f32> =
                serde_json::from_value(view[key].clone()).with_context(|| format!("{file}: {key}"))?;
            let parts: [f32; 3] = parts.try_into().ok().context("three numbers")?;
            Ok(parts.into())
        };
        stops.push(Transform::from_translation(point("eye")?).looking_at(point("toward")?, Vec3::Y));
    }
    ensure!(!stops.is_empty(), "{file} has no views");
    let last = (stops.len() - 1) as f32;
    Ok((0..frames)
        .map(|number| {
            let at = number as f32 / (frames - 1).max(1) as f32 * last;
            let from = stops[at as usize];
            let to = stops[(at as usize + 1).min(stops.len() - 1)];
            Transform {
                translation: from.translation.lerp(to.translation, at.fract()),
                rotation: from.rotation.slerp(to.rotation, at.fract()),
                scale: Vec3::ONE,
            }
        })
        .collect())
}

/// A scene in Bevy, without a window.
struct Stage {
    app: App,
    cameras: [Entity; 2],
    targets: [Handle<Image>; 2],
    /// How many of the cameras draw.
    active: usize,
}

#[derive(Clone, Copy)]
enum Drawn {
    With,
    Without,
}

/// Pictures with and without Enfilade, by frame and camera. They arrive some updates after they were asked for.
#[derive(Resource, Default)]
struct Captured(BTreeMap<(usize, usize), [Option<Vec<u8>>; 2]>);

impl Stage {
    fn open(file: &Path, has_rooms: bool) -> Result<Stage> {
        let file = file.canonicalize().with_context(|| file.display().to_string())?;
        let folder = file
            .parent()
            .context("a file in a folder")?
            .to_string_lossy()
            .into_owned();
        let name = file.file_name().context("a file")?.to_string_lossy().into_owned();
        let mut app = App::new();
        app.add_plugins(
            DefaultPlugins
                .set(AssetPlugin {
                    file_path: folder,
                    unapproved_path_mode: UnapprovedPathMode::Allow,
                    ..AssetPlugin::default()
                })
                .set(RenderPlugin {
                    // The first picture has all that it shows.
                    synchronous_pipeline_compilation: true,
                    ..RenderPlugin::default()
                })
                .set(WindowPlugin {
                    primary_window: None,
                    exit_condition: bevy::window::ExitCondition::DontExit,
                    ..WindowPlugin::default()
                }),
        )
        .add_plugins(EnfiladePlugin::default())
        .insert_resource(DirectionalLightShadowMap { size: 512 })
        .init_resource::<Captured>();
        if !has_rooms {
            app.add_observer(|added: On<Add, GltfExtras>, mut commands: Commands| {
                commands.entity(added.entity).remove::<GltfExtras>();
            });
        }
        app.finish();
        app.cleanup();
        // Lights gathered by the GPU are added up in any order.
        app.world_mut()
            .resource_mut::<GlobalClusterSettings>()
            .gpu_clustering = None;
        let scene = app
            .world()
            .resource::<AssetServer>()
            .load(GltfAssetLabel::Scene(0).from_asset(name));
        app.world_mut().spawn(WorldAssetRoot(scene.clone()));
        let sun = Transform::from_xyz(3.0, 9.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y);
        let light = DirectionalLight {
            shadow_maps_enabled: true,
            ..DirectionalLight::default()
        };
        // One cascade, and a short one: software drivers take long.
        let cascades = CascadeShadowConfigBuilder {
            num_cascades: 1,
            maximum_distance: 40.0,
            ..CascadeShadowConfigBuilder::default()
        };
        app.world_mut().spawn((light, cascades.build(), sun));
        let targets = [0, 1].map(|_| {
            let mut image = Image::new_target_texture(SIZE.x, SIZE.y, TextureFormat::Rgba8UnormSrgb, None);
            image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
            image.asset_usage = RenderAssetUsages::default();
            app.world_mut().resource_mut::<Assets<Image>>().add(image)
        });
        let cameras = [0, 1].map(|number: usize| {
            let camera = Camera {
                order: number as isize,
                ..Camera::default()
            };
            let light = AmbientLight {
                brightness: 400.0,
                ..AmbientLight::default()
            };
            let target = RenderTarget::Image(targets[number].clone().into());
            // The others take nine samples or more of the shadow map.
            let shadows = ShadowFilteringMethod::Hardware2x2;
            app.world_mut()
                .spawn((Camera3d::default(), camera, target, light, shadows))
                .id()
        });
        for _ in 0..20_000 {
            app.update();
            let server = app.world().resource::<AssetServer>();
            if let bevy::asset::LoadState::Failed(why) = server.load_state(&scene) {
                bail!("{}: {why}", file.display());
            }
            let enfilade = app.world().resource::<EnfiladeScene>();
            if enfilade.scene().item_count() > 0 && !enfilade.is_building() {
                return Ok(Stage {
                    app,
                    cameras,
                    targets,
                    active: 2,
                });
            }
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        bail!("{}: no mesh came", file.display())
    }

    /// Moves the cameras; the second draws only if `both`.
    fn look_from(&mut self, place: Transform, both: bool) {
        let turned = place.with_rotation(place.rotation * Quat::from_rotation_y(std::f32::consts::PI));
        self.active = if both { 2 } else { 1 };
        for (number, place) in [place, turned].into_iter().enumerate() {
            let mut camera = self.app.world_mut().entity_mut(self.cameras[number]);
            camera.insert(place);
            if let Some(mut camera) = camera.get_mut::<Camera>() {
                camera.is_active = number < self.active;
            }
        }
    }

    /// Draws a frame with or without Enfilade.
    fn draw(&mut self, frame: usize, drawn: Drawn) {
        for camera in self.cameras {
            let mut camera = self.app.world_mut().entity_mut(camera);
            match drawn {
                Drawn::With => camera.remove::<NoVisibilityCulling>(),
                Drawn::Without => camera.insert(NoVisibilityCulling),
            };
        }
        for camera in 0..self.active {
            let target = self.targets[camera].clone();
            let capture = move |shot: On<ScreenshotCaptured>, mut captured: ResMut<Captured>| {
                captured.0.entry((frame, camera)).or_default()[drawn as usize] = shot.image.data.clone();
            };
            self.app
                .world_mut()
                .spawn(Screenshot::image(target))
                .observe(capture);
        }
        self.app.update();
    }

    /// Returns what the active cameras drew in the last frame.
    fn drawn(&self) -> Vec<Drawing> {
        let cameras = &self.cameras[..self.active];
        cameras.iter().map(|&camera| self.drawn_by(camera)).collect()
    }

    fn drawn_by(&self, camera: Entity) -> Drawing {
        let world = self.app.world();
        let list = world.get::<VisibleEntities>(camera);
        let entities = list.map_or(&[][..], |list| list.get(TypeId::of::<Mesh3d>()));
        let lens = match world.get::<Projection>(camera) {
            Some(Projection::Perspective(lens)) => lens.clone(),
            _ => PerspectiveProjection::default(),
        };
        Drawing {
            place: world.get::<Transform>(camera).copied().unwrap_or_default(),
            lens,
            entities: entities.iter().copied().collect(),
        }
    }

    fn plugin_ms(&self) -> f64 {
        let store = self.app.world().resource::<DiagnosticsStore>();
        let times = [EnfiladePlugin::SYNC_TIME, EnfiladePlugin::LOOK_TIME];
        let last = |path| store.get(path).and_then(|diagnostic| diagnostic.value());
        times.iter().filter_map(last).sum()
    }
}

fn save(picture: &[u8], file: &str) -> Result<()> {
    let folder = std::env::temp_dir().join("enfilade-bevy-pictures");
    std::fs::create_dir_all(&folder)?;
    let image: image::RgbaImage =
        image::ImageBuffer::from_raw(SIZE.x, SIZE.y, picture.to_vec()).context("a picture of this size")?;
    image.save(folder.join(file))?;
    Ok(())
}
