//! Selects the views: from the command line, the scene's cameras, a file of views or the survey.

use crate::args::CameraArgs;
use crate::open::OpenedScene;
use crate::out;
use crate::progress::Progress;
use crate::read::read_file;
use crate::report::single;
use crate::text::{plural, short};
use crate::upright::{Source, Upright, up_for_people};
use crate::values::among;
use anyhow::{Context, Result, anyhow, bail};
use enfilade::{Camera, Ray, Scene, Survey, SurveyView, View, ViewError, Viewer, survey_hard, survey_with};
use glam::{DQuat, DVec3};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Returns the selected views, all valid. Empty only if the survey finds no open space.
pub(crate) fn views(args: &CameraArgs, opened: &OpenedScene) -> Result<Vec<View>> {
    let views = if let (Some(eye), Some(toward)) = (args.eye, args.toward) {
        let view = projected(&camera(args, opened, eye, toward), args);
        vec![view.context("--eye and --toward")?]
    } else if let Some(path) = &args.path {
        read_path(path, args, opened)?
    } else if let Some(count) = args.survey {
        return surveyed(args, opened, count as usize);
    } else if let Some(count) = args.survey_hard {
        return hard(args, opened, count as usize);
    } else if let Some(name) = &args.camera {
        vec![named(name, args, opened)?]
    } else if let Some(camera) = opened.cameras.first() {
        vec![view_of(camera, args, opened)?]
    } else {
        return first_picture(args, opened).map(|view| vec![view]);
    };
    warn_of_solids(opened, &views);
    Ok(views)
}

/// Warns of eyes that seem to be inside something solid.
fn warn_of_solids(opened: &OpenedScene, views: &[View]) {
    let inside = inside_solids(&opened.scene, views);
    if inside.is_empty() {
        return;
    }
    if survey(opened, 0).seems_inverted {
        out::warn(format_args!(
            "{}: the winding seems inverted: floors show their back faces, which single-sided materials cull",
            opened.file
        ));
        return;
    }
    warn_of_each(&inside);
}

/// Returns the views that seem to be inside something solid.
fn inside_solids<'a>(scene: &Scene, views: &'a [View]) -> Vec<&'a View> {
    // Only the first views of a long path are tested: testing all would take longer than the looks.
    const TESTED: usize = 100;
    let tested = views.iter().take(TESTED);
    tested.filter(|view| is_inside_solid(scene, view)).collect()
}

fn warn_of_each(inside: &[&View]) {
    for view in inside {
        let [x, y, z] = view.eye().map(single);
        out::warn(format_args!(
            "the eye at {x},{y},{z} seems to be inside something solid: it is surrounded by back faces"
        ));
    }
}

/// Returns a camera with the up vector of the scene, and `--fov` of the command line.
fn camera(args: &CameraArgs, opened: &OpenedScene, eye: [f32; 3], toward: [f32; 3]) -> Camera {
    let camera = Camera {
        up: opened.upright.up_f64().into(),
        ..Camera::new(eye, toward)
    };
    with_options(args, camera)
}

/// Returns the same camera with `--fov` and `--up` of the command line.
fn with_options(args: &CameraArgs, camera: Camera) -> Camera {
    Camera {
        up: args.upright.up.map_or(camera.up, |up| up.map(f64::from)),
        fov_y: args.fov.map_or(camera.fov_y, f32::to_radians),
        ..camera
    }
}

/// Returns the view of a camera: in parallel, if `--parallel` is given.
fn projected(camera: &Camera, args: &CameraArgs) -> Result<View, ViewError> {
    let Some(height) = args.parallel else {
        return camera.view(args.size);
    };
    let view = View::parallel(camera.eye, camera.toward, camera.up, height, args.size)?;
    Ok(match camera.sector {
        Some(sector) => view.in_sector(sector),
        None => view,
    })
}

/// Returns the view of a camera of the scene.
fn view_of(camera: &Camera, args: &CameraArgs, opened: &OpenedScene) -> Result<View> {
    let view = projected(&with_options(args, camera.clone()), args);
    view.with_context(|| format!("{}: camera `{}`", opened.file, camera.name))
}

fn named(name: &str, args: &CameraArgs, opened: &OpenedScene) -> Result<View> {
    let file = &opened.file;
    if opened.cameras.is_empty() {
        bail!("{file}: it has no cameras; use --eye and --toward, --path or --survey");
    }
    let camera = opened
        .cameras
        .iter()
        .find(|camera| camera.name == name)
        .ok_or_else(|| {
            let names = opened.cameras.iter().map(|camera| camera.name.as_str());
            anyhow!("{file}: no camera `{name}`; {}", among(name, names))
        })?;
    view_of(camera, args, opened)
}

fn surveyed(args: &CameraArgs, opened: &OpenedScene, count: usize) -> Result<Vec<View>> {
    let found = survey(opened, count);
    match found.views.len() {
        0 => out::warn("the survey found no open space for a camera; use --eye and --toward"),
        fewer if fewer < count => out::warn(format_args!(
            "the survey found only {fewer} of {count} positions to stand at"
        )),
        _ => {}
    }
    if !found.views.is_empty() {
        out::note(describe(opened, &found));
    }
    let views = views_at(args, opened, &found.views)?;
    if !found.seems_inverted {
        warn_of_each(&inside_solids(&opened.scene, &views));
    }
    Ok(views)
}

/// Describes the views of a survey, and the up axis and scale that it assumed.
fn describe(opened: &OpenedScene, found: &Survey) -> String {
    let all = || found.views.iter();
    let under_sky = all().filter(|view| is_under_sky(opened, view)).count();
    let places = match (under_sky, found.views.len() - under_sky) {
        _ if found.rooms == 0 => {
            let views = plural(found.views.len(), "view");
            format!("{views} around the scene or in its open space; it has no floors")
        }
        (0, covered) => {
            let views = plural(covered, "view");
            format!("{views} under ceilings, in {}", plural(found.rooms, "room"))
        }
        (open, 0) => format!("{} under open sky", plural(open, "view")),
        (open, covered) => format!(
            "{} under open sky and {covered} under ceilings",
            plural(open, "view")
        ),
    };
    let roofs = match all().filter(|view| view.on_roof).count() {
        0 => String::new(),
        roofs => format!(", {roofs} of them above roofs"),
    };
    let metre = if found.metre == 1.0 {
        String::new()
    } else {
        format!(", assuming that a metre is {} units", short(found.metre))
    };
    let inverted = if found.seems_inverted {
        "; the winding seems inverted"
    } else {
        ""
    };
    let up = match opened.upright.up_from {
        Source::Floors if opened.upright.up != Upright::default().up => {
            let axis = up_for_people(opened.upright.up);
            format!("; {axis} is up, by the floors (--up sets it)")
        }
        _ => String::new(),
    };
    format!("survey: {places}{roofs}{metre}{inverted}{up}")
}

fn hard(args: &CameraArgs, opened: &OpenedScene, count: usize) -> Result<Vec<View>> {
    let found = survey_hard(&opened.scene, count);
    match found.len() {
        0 => out::warn("the survey found no faces or openings; use --eye and --toward"),
        fewer if fewer < count => out::warn(format_args!(
            "the survey found only {fewer} of {count} hard views"
        )),
        _ => {}
    }
    views_at(args, opened, &found)
}

fn views_at(args: &CameraArgs, opened: &OpenedScene, found: &[SurveyView]) -> Result<Vec<View>> {
    let views = found
        .iter()
        .map(|survey_view| projected(&at(args, opened, survey_view), args));
    Ok(views.collect::<Result<_, _>>()?)
}

fn at(args: &CameraArgs, opened: &OpenedScene, survey_view: &SurveyView) -> Camera {
    camera(args, opened, survey_view.eye, survey_view.toward)
}

/// Returns the default view of a scene without cameras: outdoors the whole scene from outside, else the survey view
/// that shows most.
fn first_picture(args: &CameraArgs, opened: &OpenedScene) -> Result<View> {
    const CANDIDATES: usize = 24;
    const OTHERS: &str = "others: --survey 8, or --eye and --toward";
    let (scene, file) = (&opened.scene, &opened.file);
    let found = survey(opened, CANDIDATES);
    if found.views.is_empty() {
        out::warn(
            "the survey found no open space, so the camera is outside the scene; use --eye and --toward",
        );
        return from_outside(args, opened);
    }
    let under_sky = found
        .views
        .iter()
        .filter(|survey_view| is_under_sky(opened, survey_view));
    if 4 * under_sky.count() >= 3 * found.views.len() {
        out::note(format_args!(
            "{file}: it has no camera and is mostly outdoors; showing all of it from outside ({OTHERS})"
        ));
        return from_outside(args, opened);
    }
    out::note(format_args!(
        "{file}: it has no camera; showing the survey view that shows most ({OTHERS})"
    ));
    let mut viewer = Viewer::new();
    let (mut best, mut best_shown) = (&found.views[0], -1.0);
    for survey_view in &found.views {
        let view = at(args, opened, survey_view).view([160, 90])?;
        // Weighted by the square root of their size: neither one large wall nor a hundred specks should win.
        let items = viewer.look(scene, &view).items().iter();
        let shown: f64 = items.map(|item| f64::from(item.size_px).sqrt()).sum();
        if shown > best_shown {
            (best, best_shown) = (survey_view, shown);
        }
    }
    Ok(projected(&at(args, opened, best), args)?)
}

/// Whether a ray straight up from a view hits nothing.
fn is_under_sky(opened: &OpenedScene, survey_view: &SurveyView) -> bool {
    let up = Ray {
        origin: survey_view.eye,
        direction: opened.upright.up,
    };
    opened.scene.sector(survey_view.sector).cast(&up).is_none()
}

fn survey(opened: &OpenedScene, count: usize) -> Survey {
    let _progress = Progress::spinner("surveying");
    survey_with(&opened.scene, count, &opened.upright.survey_options())
}

/// Returns a view of the whole scene, from the front and above.
fn from_outside(args: &CameraArgs, opened: &OpenedScene) -> Result<View> {
    let scene = &opened.scene;
    let boxes = scene
        .sectors()
        .map(|id| scene.bounds(id))
        .filter(|bounds| !bounds.is_empty());
    let lens = camera(args, opened, [0.0; 3], [0.0, 0.0, -1.0]);
    let nowhere = || Ok(projected(&lens, args)?);
    let Some(bounds) = boxes.reduce(|a, b| a.union(&b)) else {
        return nowhere();
    };
    let center = DVec3::from(bounds.center().map(f64::from));
    let up = opened.upright.up_f64();
    let away = DQuat::from_rotation_arc(DVec3::Y, up.normalize()) * DVec3::new(0.35, 0.7, 0.8).normalize();
    let right = up.cross(away).normalize();
    let [width, height] = args.size.map(f64::from);
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
    // Along each screen axis, the two frustum planes that touch the box intersect at the nearest possible eye.
    let nearest = |side: DVec3, tan: f64| {
        let touch = |side: DVec3| {
            let each = corners.clone().map(|c| c.dot(side) / tan + c.dot(away));
            each.fold(1e-3, f64::max)
        };
        0.5 * (touch(side) + touch(-side))
    };
    let upward = away.cross(right);
    let distance = 1.05 * nearest(right, tan_x).max(nearest(upward, tan_y));
    // Centre the box at that distance: bisect for equal margins at both edges.
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
    let camera = camera(
        args,
        opened,
        eye.as_vec3().to_array(),
        center.as_vec3().to_array(),
    );
    let view = projected(&camera, args);
    // With huge coordinates the step away may be lost in rounding.
    view.or_else(|_| nowhere())
}

/// One line of a `--path` file.
#[derive(Deserialize)]
struct PathLine {
    eye: [f32; 3],
    toward: [f32; 3],
    up: Option<[f32; 3]>,
    fov: Option<f32>,
    #[serde(flatten)]
    others: BTreeMap<String, serde_json::Value>,
}

/// Maximum size of a path file: hundreds of thousands of views.
const MAX_PATH_BYTES: u64 = 64 << 20;

/// Maximum length of a line. Unknown keys are parsed into values that take much more memory than their text.
const MAX_LINE_BYTES: usize = 1 << 16;

fn read_path(path: &Path, args: &CameraArgs, opened: &OpenedScene) -> Result<Vec<View>> {
    let name = path.display();
    let bytes = read_file(path, MAX_PATH_BYTES, "split it into several paths")?;
    let mut views = Vec::new();
    let mut unread = BTreeSet::new();
    for (number, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let location = || format!("{name}, line {}", number + 1);
        let text = str::from_utf8(line).with_context(location)?;
        if text.trim().is_empty() {
            continue;
        }
        let wants = r#"expected {"eye":[x,y,z],"toward":[x,y,z]}, optionally with "up" and "fov""#;
        if text.len() > MAX_LINE_BYTES {
            bail!("{}: it has more than {MAX_LINE_BYTES} bytes; {wants}", location());
        }
        let line: PathLine =
            serde_json::from_str(text).map_err(|error| anyhow!("{}: {error}; {wants}", location()))?;
        let camera = camera(args, opened, line.eye, line.toward);
        let camera = Camera {
            up: line.up.map_or(camera.up, |up| up.map(f64::from)),
            fov_y: line.fov.map_or(camera.fov_y, f32::to_radians),
            ..camera
        };
        views.push(projected(&camera, args).with_context(location)?);
        unread.extend(line.others.into_keys().filter(|key| key != "name"));
    }
    if views.is_empty() {
        bail!("{name}: it has no view; add one line per view");
    }
    if !unread.is_empty() {
        let unread: Vec<String> = unread.iter().map(|key| format!("`{key}`")).collect();
        out::warn(format_args!(
            "{name}: unknown keys are ignored: {}",
            unread.join(", ")
        ));
    }
    Ok(views)
}

/// Returns `true` if rays in all 26 directions hit something, most of them back faces. `false` when unsure.
fn is_inside_solid(scene: &Scene, view: &View) -> bool {
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
            origin: view.eye().map(single),
            direction,
        }) else {
            return false;
        };
        rays += 1;
        from_behind += usize::from(hit.from_behind);
    }
    // Not all need to hit back faces: a wall that reaches into the floor contains part of the floor's front.
    4 * from_behind >= 3 * rays
}
