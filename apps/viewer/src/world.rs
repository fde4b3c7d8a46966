//! A scene that is open in the viewer.

use anyhow::{Context, Result, anyhow};
use enfilade::{Camera, Method, Scene, SurveyOptions, survey_with};
use enfilade_draw::{Stage, with_sun};
use enfilade_import::{ReadOptions, survey_options};
use std::path::Path;

/// Limit of the memory for reading a file, and for what a method builds, in bytes.
pub const MEMORY: u64 = 4_000_000_000;

/// A scene with what the viewer needs of its file.
pub struct World {
    /// The name that the user gave.
    pub name: String,
    /// The scene.
    pub scene: Scene,
    /// Its light and textures.
    pub stage: Stage,
    /// Cameras to start at; at least one.
    pub cameras: Vec<Camera>,
    /// Scene units per metre, as the survey of the scene estimates them.
    pub metre: f64,
    /// The up vector and the unit of the scene.
    pub survey: SurveyOptions,
    /// Warnings of the reader.
    pub warnings: Vec<String>,
    /// Whether the cameras are those of the file.
    has_cameras: bool,
}

impl World {
    /// Opens a file, or a built-in scene by `@NAME`.
    ///
    /// # Errors
    /// If the scene cannot be read or built. The message says why, and what to do.
    pub fn open(name: &str) -> Result<World> {
        World::open_with(name, &|_| ())
    }

    /// As [`World::open`], and says what it does next.
    ///
    /// # Errors
    /// As [`World::open`].
    pub fn open_with(name: &str, say: &dyn Fn(&'static str)) -> Result<World> {
        if let Some(built_in) = name.strip_prefix('@') {
            let found = enfilade_scenes::built_in(built_in).ok_or_else(|| {
                let names: Vec<String> = enfilade_scenes::NAMES
                    .iter()
                    .map(|name| format!("@{name}"))
                    .collect();
                anyhow!("no built-in scene {name}; there are {}", names.join(", "))
            })?;
            let options = SurveyOptions::default();
            return Ok(World::new(
                name,
                found.scene,
                found.cameras,
                options,
                Vec::new(),
                say,
            ));
        }
        say("reading the file");
        let import = enfilade_import::read(Path::new(name), &options())?;
        World::of_import(name, &import, say)
    }

    /// Opens a file of these bytes: one that needs no other files beside it.
    ///
    /// # Errors
    /// As [`World::open`].
    pub fn of_bytes(name: &str, bytes: &[u8]) -> Result<World> {
        let import = enfilade_import::read_bytes(bytes, None, &options()).with_context(|| name.to_owned())?;
        World::of_import(name, &import, &|_| ())
    }

    fn of_import(name: &str, import: &enfilade_import::Import, say: &dyn Fn(&'static str)) -> Result<World> {
        say("building the hierarchies of its sectors");
        let scene = import
            .scene(Method::Masked, MEMORY)
            .or_else(|_| import.scene(Method::FloatingHorizon, MEMORY))
            .with_context(|| name.to_owned())?;
        let warnings = import.warnings.iter().map(ToString::to_string).collect();
        let options = if import.tells_up() {
            SurveyOptions::default()
        } else {
            survey_options(&scene)
        };
        Ok(World::new(
            name,
            scene,
            import.cameras.clone(),
            options,
            warnings,
            say,
        ))
    }

    /// Adds a sun to a scene without lights.
    pub fn add_sun(&mut self) {
        self.scene = with_sun(&self.scene);
        self.stage = Stage::new(&self.scene);
    }

    fn new(
        name: &str,
        scene: Scene,
        cameras: Vec<Camera>,
        options: SurveyOptions,
        warnings: Vec<String>,
        say: &dyn Fn(&'static str),
    ) -> World {
        say("tracing its lights");
        let mut world = World {
            name: name.to_owned(),
            stage: Stage::new(&scene),
            scene,
            has_cameras: !cameras.is_empty(),
            cameras,
            metre: 1.0,
            survey: options,
            warnings,
        };
        say("surveying the scene");
        world.stand(options);
        world
    }

    /// Surveys the scene with these options: for the length of a metre, and for cameras if the file has none.
    pub fn stand(&mut self, options: SurveyOptions) {
        self.survey = options;
        let mut options = options;
        if self.has_cameras {
            // For the length of a metre the sector of the first camera will do.
            options.sector = self.cameras.first().and_then(|camera| {
                let view = camera.view([1, 1]).ok()?;
                camera.sector.or_else(|| self.scene.sector_of(&view))
            });
            self.metre = survey_with(&self.scene, 1, &options).metre;
            return;
        }
        let found = survey_with(&self.scene, 4, &options);
        self.metre = found.metre;
        let up = options.up.map(f64::from);
        let named = (1..).zip(&found.views).map(|(number, view)| Camera {
            name: format!("survey {number}"),
            sector: Some(view.sector),
            up,
            ..Camera::new(view.eye, view.toward)
        });
        self.cameras = named.collect();
        if self.cameras.is_empty() {
            self.cameras.push(Camera {
                up,
                ..outside(&self.scene)
            });
        }
    }
}

/// Returns a camera that sees all of a scene from outside.
fn outside(scene: &Scene) -> Camera {
    let bounds = scene
        .sectors()
        .map(|id| scene.bounds(id))
        .fold(enfilade::Aabb::EMPTY, |all, bounds| all.union(&bounds));
    let (center, size) = (bounds.center(), bounds.longest_side().max(1e-3));
    let eye = [center[0] + size, center[1] + 0.6 * size, center[2] + size];
    Camera {
        name: "outside".to_owned(),
        ..Camera::new(eye, center)
    }
}

pub(crate) fn options() -> ReadOptions {
    ReadOptions {
        limit_bytes: MEMORY,
        skip_bad_portals: true,
        ..ReadOptions::default()
    }
}
