//! Which views are looked at: from the command line, the scene, a file of views or the survey.

use crate::args::CameraArgs;
use crate::open::Opened;
use crate::out;
use crate::progress::Progress;
use crate::read::read_file;
use crate::text::{plural, short};
use crate::values::among;
use anyhow::{Context, Result, anyhow, bail};
use enfilade::{Ray, Scene, SectorId, Survey, SurveyView, View, Viewer, survey_hard};
use glam::DVec3;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A place to look from, that came with a scene.
#[derive(Clone, Debug)]
pub(crate) struct Camera {
    pub(crate) name: String,
    pub(crate) eye: [f32; 3],
    pub(crate) toward: [f32; 3],
    pub(crate) up: [f32; 3],
    /// Radians.
    pub(crate) fov_y: f32,
    /// What is nearer is not seen; `None` where the scene does not say.
    near: Option<f32>,
    /// Where to look from; `None`: where the eye stands.
    sector: Option<SectorId>,
    /// What an orthographic one shows from bottom to top.
    pub(crate) height: Option<f32>,
}

impl From<enfilade_import::Camera> for Camera {
    fn from(camera: enfilade_import::Camera) -> Camera {
        let enfilade_import::Camera {
            name,
            eye,
            toward,
            up,
            fov_y,
            near,
            sector,
            height,
        } = camera;
        Camera {
            name,
            eye,
            toward,
            up,
            fov_y,
            near: Some(near),
            sector,
            height,
        }
    }
}

impl From<enfilade_scenes::Camera> for Camera {
    fn from(camera: enfilade_scenes::Camera) -> Camera {
        let enfilade_scenes::Camera {
            name,
            eye,
            toward,
            up,
            fov_y,
            ..
        } = camera;
        Camera {
            name,
            eye,
            toward,
            up,
            fov_y,
            near: None,
            sector: None,
            height: None,
        }
    }
}

impl Camera {
    /// What it sees on a screen; `fov` and `up` of the command line come first.
    fn view(&self, args: &CameraArgs) -> View {
        let mut view = View::new(self.eye, self.toward, args.size);
        view.up = args.up.unwrap_or(self.up);
        view.fov_y = args.fov.map_or(self.fov_y, f32::to_radians);
        view.near = self.near.unwrap_or(view.near);
        view.sector = self.sector;
        view
    }
}

/// The views that are asked for, each one sound. None only where a survey finds no open space.
pub(crate) fn views(args: &CameraArgs, opened: &Opened) -> Result<Vec<View>> {
    let views = if let (Some(eye), Some(toward)) = (args.eye, args.toward) {
        vec![checked(plain(args, eye, toward), || {
            "--eye and --toward".to_owned()
        })?]
    } else if let Some(path) = &args.path {
        read_path(path, args)?
    } else if let Some(count) = args.survey {
        return surveyed(args, &opened.scene, count as usize);
    } else if let Some(count) = args.survey_hard {
        return hard(args, &opened.scene, count as usize);
    } else if let Some(name) = &args.camera {
        vec![named(name, args, opened)?]
    } else if let Some(camera) = opened.cameras.first() {
        vec![checked(camera.view(args), || {
            format!("{}: camera `{}`", opened.file, camera.name)
        })?]
    } else {
        return first_picture(args, opened).map(|view| vec![view]);
    };
    warn_of_solids(opened, &views);
    Ok(views)
}

/// Says where an eye seems to be inside something solid.
fn warn_of_solids(opened: &Opened, views: &[View]) {
    // A long path is not asked about to its end: that would take longer than the looks.
    const ASKED: usize = 100;
    let backs_around: Vec<&View> = (views.iter().take(ASKED))
        .filter(|view| is_among_backs(&opened.scene, view))
        .collect();
    if backs_around.is_empty() {
        return;
    }
    if survey(&opened.scene, 0).seems_inverted {
        out::warn(format_args!(
            "{}: its winding seems inverted: floors are seen from the backs of their faces, which one-sided materials hide",
            opened.file
        ));
        return;
    }
    for view in backs_around {
        let [x, y, z] = view.eye;
        out::warn(format_args!(
            "the eye at {x},{y},{z} seems to be inside something solid: around it are backs of faces"
        ));
    }
}

fn plain(args: &CameraArgs, eye: [f32; 3], toward: [f32; 3]) -> View {
    let mut view = View::new(eye, toward, args.size);
    view.up = args.up.unwrap_or(view.up);
    view.fov_y = args.fov.map_or(view.fov_y, f32::to_radians);
    view
}

fn checked(view: View, place: impl FnOnce() -> String) -> Result<View> {
    view.check().with_context(place)?;
    Ok(view)
}

fn named(name: &str, args: &CameraArgs, opened: &Opened) -> Result<View> {
    let file = &opened.file;
    if opened.cameras.is_empty() {
        bail!("{file}: there are no cameras in it; use --eye and --toward, --path or --survey");
    }
    let camera = opened
        .cameras
        .iter()
        .find(|camera| camera.name == name)
        .ok_or_else(|| {
            let names = opened.cameras.iter().map(|camera| camera.name.as_str());
            anyhow!("{file}: there is no camera `{name}`; {}", among(name, names))
        })?;
    checked(camera.view(args), || format!("{file}: camera `{name}`"))
}

fn surveyed(args: &CameraArgs, scene: &Scene, count: usize) -> Result<Vec<View>> {
    let found = survey(scene, count);
    match found.views.len() {
        0 => out::warn("the survey found no open space for a camera; use --eye and --toward"),
        fewer if fewer < count => out::warn(format_args!(
            "the survey finds only {fewer} of {count} places to stand"
        )),
        _ => {}
    }
    if !found.views.is_empty() {
        out::note(describe(&found));
    }
    Ok(found.views.iter().map(|place| at(args, place)).collect())
}

/// How the places of a survey were found.
fn describe(found: &Survey) -> String {
    let places = plural(found.views.len(), "view");
    if found.rooms == 0 {
        return format!("survey: {places} in open space; no room was found");
    }
    let metre = if found.metre == 1.0 {
        String::new()
    } else {
        format!(", taking a metre for {} units", short(found.metre))
    };
    let roofs = match found.views.iter().filter(|place| place.on_roof).count() {
        0 => String::new(),
        roofs => format!(", {roofs} of them above roofs"),
    };
    let inverted = if found.seems_inverted {
        "; the winding of the file seems inverted"
    } else {
        ""
    };
    let rooms = plural(found.rooms, "room");
    format!("survey: {places} 1.6 m above the floors of {rooms} and streets{roofs}{metre}{inverted}")
}

fn hard(args: &CameraArgs, scene: &Scene, count: usize) -> Result<Vec<View>> {
    let found = survey_hard(scene, count);
    match found.len() {
        0 => out::warn("the survey finds no faces or openings; use --eye and --toward"),
        fewer if fewer < count => out::warn(format_args!(
            "the survey finds only {fewer} of {count} places that are hard"
        )),
        _ => {}
    }
    Ok(found.iter().map(|place| at(args, place)).collect())
}

fn at(args: &CameraArgs, place: &SurveyView) -> View {
    plain(args, place.eye, place.toward)
}

/// Where no camera is given: outdoors all of the scene from outside, else of some places that from which most can be seen.
fn first_picture(args: &CameraArgs, opened: &Opened) -> Result<View> {
    const PLACES: usize = 24;
    const OTHERS: &str = "others: --survey 8, or --eye and --toward";
    let (scene, file) = (&opened.scene, &opened.file);
    let found = survey(scene, PLACES);
    if found.views.is_empty() {
        out::warn(
            "the survey found no open space, so the camera is outside the scene; use --eye and --toward",
        );
        return Ok(from_outside(args, scene));
    }
    let under_sky = found.views.iter().filter(|place| is_under_sky(scene, place));
    if 4 * under_sky.count() >= 3 * found.views.len() {
        out::note(format_args!(
            "{file}: it has no camera and most of it is outdoors; this is all of it from outside ({OTHERS})"
        ));
        return Ok(from_outside(args, scene));
    }
    out::note(format_args!(
        "{file}: it has no camera; this is the view of the survey that shows most ({OTHERS})"
    ));
    let mut viewer = Viewer::new();
    let (mut best, mut most) = (&found.views[0], -1.0);
    for place in &found.views {
        let mut view = at(args, place);
        view.size = [160, 90];
        // Items count by the root of their size: neither one wall nor a hundred specks make a picture.
        let items = viewer.look(scene, &view).items().iter();
        let shown: f64 = items.map(|item| f64::from(item.size_px).sqrt()).sum();
        if shown > most {
            (best, most) = (place, shown);
        }
    }
    Ok(at(args, best))
}

/// Is nothing above a place?
fn is_under_sky(scene: &Scene, place: &SurveyView) -> bool {
    let up = Ray {
        origin: place.eye,
        direction: [0.0, 1.0, 0.0],
    };
    scene.sector(place.sector).cast(&up).is_none()
}

fn survey(scene: &Scene, count: usize) -> Survey {
    let _progress = Progress::spinner("looking for places to stand");
    enfilade::survey(scene, count)
}

/// All of a scene, from before it and above.
fn from_outside(args: &CameraArgs, scene: &Scene) -> View {
    let boxes = scene
        .sectors()
        .map(|id| scene.bounds(id))
        .filter(|bounds| !bounds.is_empty());
    let nowhere = || plain(args, [0.0; 3], [0.0, 0.0, -1.0]);
    let Some(bounds) = boxes.reduce(|a, b| a.union(&b)) else {
        return nowhere();
    };
    let center = DVec3::from(bounds.center().map(f64::from));
    let away = DVec3::new(0.35, 0.7, 0.8).normalize();
    let right = DVec3::Y.cross(away).normalize();
    let [width, height] = args.size.map(f64::from);
    let lens = plain(args, [0.0; 3], [0.0, 0.0, -1.0]);
    let tan_y = (0.5 * f64::from(lens.fov_y)).tan();
    let tan_x = tan_y * width / height;
    let corners = (0..8).map(|corner| {
        let end = |axis: usize| {
            if corner >> axis & 1 == 0 {
                bounds.min[axis]
            } else {
                bounds.max[axis]
            }
        };
        DVec3::from([0, 1, 2].map(|axis| f64::from(end(axis)))) - center
    });
    // Along each screen axis the planes of the frustum that touch the box meet where the eye is nearest.
    let nearest = |side: DVec3, tan: f64| {
        let touch = |side: DVec3| {
            let each = corners.clone().map(|c| c.dot(side) / tan + c.dot(away));
            each.fold(1e-3, f64::max)
        };
        0.5 * (touch(side) + touch(-side))
    };
    let upward = away.cross(right);
    let distance = 1.05 * nearest(right, tan_x).max(nearest(upward, tan_y));
    // From there the box is in the middle of the picture if it is as far from both edges.
    let middle = |side: DVec3| {
        let ends = |shift: f64| {
            let seen = (corners.clone()).map(|c| (c.dot(side) - shift) / (distance - c.dot(away)).max(1e-3));
            seen.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| {
                [low.min(at), high.max(at)]
            })
        };
        let mut between = [-distance, distance];
        for _ in 0..40 {
            let shift = 0.5 * (between[0] + between[1]);
            let [low, high] = ends(shift);
            between[usize::from(low + high <= 0.0)] = shift;
        }
        side * between[0]
    };
    let center = center + middle(right) + middle(upward);
    let eye = center + away * distance;
    let view = plain(args, eye.as_vec3().to_array(), center.as_vec3().to_array());
    // Coordinates may be so large that the step away is lost in them.
    if view.check().is_ok() { view } else { nowhere() }
}

/// A line of a path.
#[derive(Deserialize)]
struct Line {
    eye: [f32; 3],
    toward: [f32; 3],
    up: Option<[f32; 3]>,
    fov: Option<f32>,
    #[serde(flatten)]
    others: BTreeMap<String, serde_json::Value>,
}

/// More than this is no path: views by the hundred thousand.
const LONGEST_PATH_BYTES: u64 = 64 << 20;

/// A line is no longer than this. What is not read of it takes much more memory than its text.
const LONGEST_LINE_BYTES: usize = 1 << 16;

fn read_path(path: &Path, args: &CameraArgs) -> Result<Vec<View>> {
    let name = path.display();
    let bytes = read_file(path, LONGEST_PATH_BYTES, "make several paths of it")?;
    let mut views = Vec::new();
    let mut unread = BTreeSet::new();
    for (number, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let place = || format!("{name}, line {}", number + 1);
        let text = str::from_utf8(line).with_context(place)?;
        if text.trim().is_empty() {
            continue;
        }
        let wants = r#"a line is {"eye":[x,y,z],"toward":[x,y,z]}, with "up" and "fov" if need be"#;
        if text.len() > LONGEST_LINE_BYTES {
            bail!(
                "{}: it has more than {LONGEST_LINE_BYTES} bytes; {wants}",
                place()
            );
        }
        let line: Line =
            serde_json::from_str(text).map_err(|error| anyhow!("{}: {error}; {wants}", place()))?;
        let mut view = plain(args, line.eye, line.toward);
        view.up = line.up.unwrap_or(view.up);
        view.fov_y = line.fov.map_or(view.fov_y, f32::to_radians);
        views.push(checked(view, place)?);
        unread.extend(line.others.into_keys().filter(|key| key != "name"));
    }
    if views.is_empty() {
        bail!("{name}: there is no view in it");
    }
    if !unread.is_empty() {
        let unread: Vec<String> = unread.iter().map(|key| format!("`{key}`")).collect();
        out::warn(format_args!("{name}: not read: {}", unread.join(", ")));
    }
    Ok(views)
}

/// Do rays in all directions end, most of them at the backs of faces? `false` when unsure.
fn is_among_backs(scene: &Scene, view: &View) -> bool {
    let Some(sector) = scene.sector_of(view) else {
        return false;
    };
    let steps = [-1.0_f32, 0.0, 1.0];
    let directions = steps
        .into_iter()
        .flat_map(|x| steps.map(|y| [x, y]))
        .flat_map(|[x, y]| steps.map(|z| [x, y, z]));
    let (mut rays, mut from_behind) = (0, 0);
    for direction in directions.filter(|direction| *direction != [0.0; 3]) {
        let Some(hit) = scene.sector(sector).cast(&Ray {
            origin: view.eye,
            direction,
        }) else {
            return false;
        };
        rays += 1;
        from_behind += usize::from(hit.from_behind);
    }
    // Not all: a wall that reaches into the floor holds some of the floor's front.
    4 * from_behind >= 3 * rays
}
