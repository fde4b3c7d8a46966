//! The command line.

use crate::app::App;
use crate::overlay::Overlays;
use crate::path;
use crate::session::Session;
use crate::steps::StepMode;
use crate::walker::Walker;
use crate::world::MEMORY;
use anyhow::{Context, Result, anyhow, bail};
use clap::Parser;
use enfilade::{Camera, Method};
use enfilade_draw::Show;
use std::path::{Path, PathBuf};

/// Walks through a scene, freezes what is visible, and says why things are hidden.
#[derive(Clone, Debug, Parser)]
#[command(name = "enfilade-viewer", version, max_term_width = 100)]
pub struct Args {
    /// A .glb, .gltf, .obj, .bsp, .enf or terrain .json file, or @NAME for a built-in scene
    #[arg(default_value = "@enfilade", value_parser = scene)]
    pub scene: String,
    /// Start at this camera of the scene
    #[arg(long, value_name = "NAME", conflicts_with = "eye")]
    pub camera: Option<String>,
    /// Start here, in scene units
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "toward")]
    pub eye: Option<[f64; 3]>,
    /// Look at this position
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "eye")]
    pub toward: Option<[f64; 3]>,
    /// Take this direction as up: x, y, z, -x, -y, -z or X,Y,Z [default: the camera's, else the axis that the floors of an OBJ
    /// file face, else y]
    #[arg(long, value_name = "AXIS", value_parser = up, allow_hyphen_values = true)]
    pub up: Option<[f32; 3]>,
    /// Take a scene unit as m, cm, mm, ft, in or a number of metres [default: 1 m, or what makes rooms as high as rooms are]
    #[arg(long, value_name = "UNIT", value_parser = unit)]
    pub unit: Option<f64>,
    /// Replay this camera path: the JSON lines that `enfilade look --path` reads, and the viewer saves
    #[arg(long, value_name = "FILE.jsonl", conflicts_with_all = ["camera", "eye", "freeze"])]
    pub path: Option<PathBuf>,
    /// Use this method in all sectors that it suits
    #[arg(long, value_name = "NAME", value_parser = method)]
    pub method: Option<Method>,
    /// Set the size of the window, in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x800", value_parser = size)]
    pub size: [u32; 2],
    /// Write one frame to this file, without a window
    #[arg(long, value_name = "FILE.png")]
    pub screenshot: Option<PathBuf>,
    /// Freeze the visible set
    #[arg(long)]
    pub freeze: bool,
    /// Look at the frozen set from above
    #[arg(long, requires = "freeze")]
    pub above: bool,
    /// Draw these over the picture, comma-separated: frustum, portals, apertures, sectors, occluders, boxes
    #[arg(long, value_name = "LIST", value_parser = overlays)]
    pub overlays: Option<Overlays>,
    /// Click at this position of the window, in pixels, to explain what is there
    #[arg(long, value_name = "X,Y", value_parser = pixel, requires = "screenshot")]
    pub click: Option<[f32; 2]>,
    /// Let the sun cast shadows. A scene without lights gets one
    #[arg(long)]
    pub shadows: bool,
    /// Explain the first item whose name contains this text
    #[arg(long, value_name = "NAME")]
    pub explain: Option<String>,
    /// Show a diagnostic picture: overdraw, items, sectors, order or cover
    #[arg(long, value_name = "WHAT", value_parser = show)]
    pub show: Option<Show>,
    /// Step through the look, with this many steps done
    #[arg(long, value_name = "STEPS", value_parser = steps, requires = "screenshot")]
    pub steps: Option<usize>,
    /// Show the picture of the scene alone, without panels
    #[arg(long)]
    pub no_panels: bool,
    /// Serve the viewer as a web page on 127.0.0.1, with the scene
    #[arg(long, conflicts_with = "screenshot")]
    pub web: bool,
    /// Port of the web page; 0 chooses a free one
    #[arg(long, value_name = "PORT", default_value_t = 0, requires = "web")]
    pub port: u16,
}

impl Args {
    /// Checks what can be checked before a window opens.
    ///
    /// # Errors
    /// If a file cannot be opened, or a click is outside the window.
    pub fn check(&self) -> Result<()> {
        let scene = Some(Path::new(&self.scene)).filter(|_| !self.scene.starts_with('@'));
        for file in scene.into_iter().chain(self.path.as_deref()) {
            // Not opened: opening a pipe blocks until someone writes.
            let there = std::fs::metadata(file).with_context(|| file.display().to_string())?;
            if !there.is_file() {
                bail!(
                    "{}: it is not a file, but a folder, a pipe or a device; name a file",
                    file.display()
                );
            }
        }
        if let Some([x, y]) = self.click {
            let [width, height] = self.size;
            if !(0.0..width as f32).contains(&x) || !(0.0..height as f32).contains(&y) {
                bail!("--click {x},{y} is outside the window of {width}x{height} pixels");
            }
        }
        Ok(())
    }

    /// Applies the options to a viewer whose scene is open.
    ///
    /// # Errors
    /// If the scene has no such camera, or the method suits no sector.
    pub fn apply(&self, app: &mut App) -> Result<()> {
        app.panels = !self.no_panels;
        if let Some(overlays) = self.overlays {
            app.overlays = overlays;
        }
        app.show_diagnostic(self.show);
        if self.shadows {
            app.cast_shadows();
        }
        if let Some(file) = &self.path {
            let bytes = enfilade_import::file_bytes(file, MEMORY)?;
            app.replay(
                path::read(&String::from_utf8_lossy(&bytes)).with_context(|| file.display().to_string())?,
            );
        }
        let Some(session) = &mut app.session else {
            return Ok(());
        };
        if self.up.is_some() || self.unit.is_some() {
            self.stand(session);
        }
        if let Some(camera) = self.start(session)? {
            let world = &session.world;
            session.walker = Walker::new(&world.scene, &camera, world.metre);
        }
        session.look(session.view.size());
        if let Some(method) = self.method {
            session.set_method(method, None).map_err(|why| anyhow!("{why}"))?;
        }
        if let Some(name) = &self.explain {
            let found = session.find(name, 1);
            let (sector, item, _) = found
                .first()
                .with_context(|| format!("no item is called `{name}`"))?;
            session.select_item(*sector, *item);
        }
        if let Some(done) = self.steps {
            let mut mode = StepMode::new(session);
            mode.go_to(session, done);
            app.steps = Some(mode);
        }
        if self.freeze {
            session.toggle_frozen();
            if self.above {
                session.rise();
            }
        }
        Ok(())
    }

    /// Stands the scene on the floors that `--up` and `--unit` tell.
    fn stand(&self, session: &mut Session) {
        let world = &mut session.world;
        let mut options = world.survey;
        options.up = self.up.unwrap_or(options.up);
        options.metre = self.unit.map(f64::recip).or(options.metre);
        world.stand(options);
        let mut camera = world.cameras[0].clone();
        camera.up = self.up.map_or(camera.up, |up| up.map(f64::from));
        session.walker = Walker::new(&world.scene, &camera, world.metre);
    }

    fn start(&self, session: &Session) -> Result<Option<Camera>> {
        if let (Some(eye), Some(toward)) = (self.eye, self.toward) {
            return Ok(Some(Camera {
                up: session.world.survey.up.map(f64::from),
                ..Camera::new(eye, toward)
            }));
        }
        let Some(name) = &self.camera else { return Ok(None) };
        let cameras = &session.world.cameras;
        let found = cameras.iter().find(|camera| &camera.name == name).cloned();
        let names: Vec<&str> = cameras.iter().map(|camera| camera.name.as_str()).collect();
        found.map(Some).with_context(|| {
            format!(
                "no camera `{name}` in {}; there are {}",
                session.world.name,
                names.join(", ")
            )
        })
    }
}

fn numbers<const N: usize>(text: &str) -> Result<[f64; N]> {
    let parts: Vec<f64> = text
        .split(',')
        .map(|part| {
            part.trim()
                .parse()
                .with_context(|| format!("`{part}` is no number"))
        })
        .collect::<Result<_>>()?;
    let count = parts.len();
    let numbers: [f64; N] = parts
        .try_into()
        .map_err(|_| anyhow!("{N} numbers are wanted, not {count}"))?;
    if numbers.iter().any(|number| !number.is_finite()) {
        bail!("it is not finite");
    }
    Ok(numbers)
}

fn scene(text: &str) -> Result<String> {
    if text.ends_with(".jsonl") {
        bail!("it is a camera path, not a scene; replay it in a scene with --path {text}");
    }
    Ok(text.to_owned())
}

fn point(text: &str) -> Result<[f64; 3]> {
    numbers(text)
}

fn up(text: &str) -> Result<[f32; 3]> {
    let vector = match text.trim_start_matches('+') {
        "x" => [1.0, 0.0, 0.0],
        "y" => [0.0, 1.0, 0.0],
        "z" => [0.0, 0.0, 1.0],
        "-x" => [-1.0, 0.0, 0.0],
        "-y" => [0.0, -1.0, 0.0],
        "-z" => [0.0, 0.0, -1.0],
        _ => numbers(text)?,
    };
    if vector == [0.0; 3] {
        bail!("an up vector needs a length above 0, such as 0,0,1");
    }
    Ok(vector.map(|part| part as f32))
}

fn unit(text: &str) -> Result<f64> {
    let metres = match text {
        "m" => 1.0,
        "cm" => 0.01,
        "mm" => 0.001,
        "in" => 0.0254,
        "ft" => 0.3048,
        _ => text.parse().unwrap_or(f64::NAN),
    };
    if metres > 0.0 && metres <= 1e6 {
        Ok(metres)
    } else {
        bail!("expected m, cm, mm, ft, in or a number of metres, such as 0.01")
    }
}

fn steps(text: &str) -> Result<usize> {
    text.parse()
        .map_err(|_| anyhow!("the number of steps is wanted, such as 12"))
}

fn pixel(text: &str) -> Result<[f32; 2]> {
    Ok(numbers(text)?.map(|number| number as f32))
}

fn size(text: &str) -> Result<[u32; 2]> {
    let parse = |part: &str| part.parse().ok().filter(|side| (64..=8192).contains(side));
    let sides = text
        .split_once('x')
        .and_then(|(width, height)| Some([parse(width)?, parse(height)?]));
    sides.context("a size is WxH, such as 1280x800, with sides from 64 to 8192")
}

fn method(text: &str) -> Result<Method> {
    let names: Vec<&str> = Method::ALL.iter().map(|method| method.name()).collect();
    let found = Method::ALL.into_iter().find(|method| method.name() == text);
    found.with_context(|| format!("there are {}", names.join(", ")))
}

fn show(text: &str) -> Result<Show> {
    let found = Show::by_name(text).filter(|&show| show != Show::Image);
    found.context("there are overdraw, items, sectors, order and cover")
}

fn overlays(text: &str) -> Result<Overlays> {
    let mut overlays = Overlays::NONE;
    for name in text.split(',').filter(|name| !name.is_empty()) {
        let mut all = overlays.all();
        let names: Vec<&str> = all.iter().map(|(known, _)| *known).collect();
        match all.iter_mut().find(|(known, _)| *known == name) {
            Some((_, flag)) => **flag = true,
            None => bail!("no overlay `{name}`; there are {}", names.join(", ")),
        }
    }
    Ok(overlays)
}
