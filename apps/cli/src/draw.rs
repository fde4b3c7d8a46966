//! `draw`: renders the views.

use crate::Outcome;
use crate::args::DrawArgs;
use crate::cameras;
use crate::json::Sink;
#[cfg(feature = "levels")]
use crate::levels::Leveled;
use crate::measure::{self, PASSES};
use crate::open::{Purpose, configure, open};
use crate::out;
use crate::picture::{draw, png, settings};
use crate::prepare::{PreparedScene, SkippedMethod, left_out, prepare};
use crate::progress::Progress;
use crate::report::{Report, Reports};
use crate::run_files::RunFiles;
use crate::save::Destination;
use crate::text::{count, ms, plural};
use crate::values::Choice;
use anyhow::{Result, bail};
use enfilade::{ChoiceGoal, Method, Viewer};
use enfilade_draw::{Exposure, Legend, Samples, Show, with_sun};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Runs `draw`.
pub(crate) fn run(args: &DrawArgs) -> Result<Outcome> {
    if !args
        .output
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("png"))
    {
        bail!(
            "cannot write {}: pictures are PNG, so the name must end in .png",
            args.output.display()
        );
    }
    for (option, given) in [
        ("--shadows", args.shadows),
        ("--ambient-occlusion", args.ambient_occlusion > 0),
    ] {
        if given && args.show != Show::Image {
            bail!("{option} works with --show image only; leave out one of the two");
        }
    }
    if args.samples > 1 && args.show != Show::Image {
        bail!(
            "--samples {} works with --show image only; leave out one of the two",
            args.samples
        );
    }
    #[cfg(not(feature = "levels"))]
    if args.levels.is_some() {
        bail!(
            "this program was built without levels of detail; leave out --levels, or build it with \
             `cargo build --release -p enfilade-cli --features levels` (needs a C++ compiler)"
        );
    }
    let mut files = RunFiles::of(&args.scene.scene, args.cameras.path.as_deref())?;
    // Numbered names are in the same folder, so testing this one is enough.
    files.writes(&args.output)?;
    let sink = Sink::new(&args.json, &mut files)?;
    configure(&args.methods.how)?;
    let choice = args.methods.choice();
    let mut opened = open(
        &args.scene.scene,
        if args.show == Show::Image {
            Purpose::Pictures
        } else {
            Purpose::Visibility
        },
        choice,
        &args.methods.how.portals,
        &args.methods.how.limits,
        &mut files,
    )?;
    opened.upright.set(&args.cameras.upright);
    let views = cameras::views(&args.cameras, &opened)?;
    let (mut prepared, mut skipped) = prepare(
        &opened,
        choice,
        ChoiceGoal::Draw,
        &args.methods.how,
        views.first(),
    )?;
    if args.show == Show::Cover {
        prepared = with_shapes(prepared, choice, &mut skipped)?;
    }
    let destinations = prepared
        .iter()
        .map(|prepared| destinations(args, choice, prepared, views.len(), &mut files))
        .collect::<Result<Vec<_>>>()?;
    if args.shadows {
        for prepared in &mut prepared {
            prepared.scene = with_sun(&prepared.scene);
        }
    }
    let mut settings = settings(args.show);
    settings.shadows = args.shadows;
    settings.ambient_occlusion = args.ambient_occlusion;
    settings.exposure = Exposure::Eye(args.exposure);
    if args.samples == 4 {
        settings.samples = Samples::Four;
    }
    let measured = args.json.file.is_some();
    let passes = if measured { 2 + 3 * PASSES } else { 1 };
    let progress = Progress::steps("drawing", prepared.len() * views.len() * passes);
    let (mut reports, mut said) = (Vec::new(), String::new());
    for (prepared, destinations) in prepared.iter_mut().zip(&destinations) {
        let mut viewer = prepared.viewer();
        #[cfg(feature = "levels")]
        let mut leveled = args
            .levels
            .map(|pixels| Leveled::new(prepared, pixels))
            .transpose()?;
        let mut shaded = Vec::new();
        for (view, destination) in views.iter().zip(destinations) {
            #[cfg(feature = "levels")]
            let by_levels = match &mut leveled {
                Some(leveled) => leveled.settle(prepared, &mut viewer, view)?,
                None => String::new(),
            };
            #[cfg(not(feature = "levels"))]
            let by_levels = String::new();
            // Build the data that all pictures share before the timing starts.
            prepared.stage();
            let start = Instant::now();
            let picture = draw(prepared, &mut viewer, view, &settings);
            let took = start.elapsed().as_secs_f64() * 1e3;
            let legend =
                Legend::new(args.show, &prepared.scene, viewer.visible()).filter(|_| !args.no_legend);
            let image = match legend {
                Some(legend) => legend.below(picture.image),
                None => picture.image,
            };
            destination.write(&png(&image)?)?;
            shaded.push(picture.shaded);
            let lights = (args.show == Show::Image).then_some(picture.lights_shining);
            said += &line(destination.name(), prepared, &viewer, lights, took, &by_levels);
            progress.step();
        }
        if measured {
            let draws = measure::draws(prepared, &views, &mut viewer, &settings, &progress);
            let walks = measure::walks(prepared, &views, &mut viewer, &progress);
            let looks = measure::looks(prepared, &views, &mut prepared.viewer(), &progress);
            let mut report = Report::new(&opened, prepared, &views, args.cameras.size, looks);
            report.add_times(&draws, &walks);
            for ((view, destination), shaded) in report.views.iter_mut().zip(destinations).zip(shaded) {
                view.picture = Some(destination.name().display().to_string());
                view.samples_shaded = Some(shaded);
            }
            reports.push(report);
        }
    }
    drop(progress);
    if !args.json.takes_stdout() {
        out::print(&(said + &left_out(&skipped)))?;
    }
    sink.write(&Reports::new(choice == Choice::All, reports, skipped))?;
    Ok(Outcome::Done)
}

/// Returns the destinations of a method's pictures, one per view.
fn destinations(
    args: &DrawArgs,
    choice: Choice,
    prepared: &PreparedScene,
    views: usize,
    files: &mut RunFiles,
) -> Result<Vec<Destination>> {
    let base = if choice == Choice::All {
        with_word(&args.output, prepared.method)
    } else {
        args.output.clone()
    };
    (0..views)
        .map(|number| match numbered(&base, number, views) {
            // The run already has this one as an output.
            file if file == args.output => Destination::new(&file),
            file => files.writes_too(&file),
        })
        .collect()
}

/// Keeps the methods whose covers can be shown. With [`Choice::All`] the others are skipped; else they are an error.
fn with_shapes(
    prepared: Vec<PreparedScene>,
    choice: Choice,
    skipped: &mut Vec<SkippedMethod>,
) -> Result<Vec<PreparedScene>> {
    let mut kept = Vec::new();
    for prepared in prepared {
        let shapeless = prepared
            .methods()
            .into_iter()
            .find(|method| method.cover_shape().is_none());
        match shapeless {
            None => kept.push(prepared),
            Some(method) if choice == Choice::All => skipped.push(SkippedMethod {
                method: method.name(),
                why: "its cover cannot be shown".to_owned(),
            }),
            Some(method) => {
                let all = Method::ALL.into_iter();
                let names = all
                    .filter(|method| method.cover_shape().is_some())
                    .map(Method::name);
                bail!(
                    "the cover of {method} cannot be shown; use a --method whose cover can: {}",
                    names.collect::<Vec<_>>().join(", ")
                );
            }
        }
    }
    Ok(kept)
}

/// Returns the output line of a picture:
/// `a.png: 43 items, 34,120 triangles by hierarchical-z in 21.3 ms; 2 of 5 lights shine on them`.
fn line(
    file: &Path,
    prepared: &PreparedScene,
    viewer: &Viewer,
    lights: Option<usize>,
    took: f64,
    by_levels: &str,
) -> String {
    let set = viewer.visible();
    let all = prepared.scene.lights().len();
    let lights = match lights {
        Some(lights) if all > 0 => format!("; {lights} of {all} lights shine on them"),
        _ => String::new(),
    };
    format!(
        "{}: {}, {} triangles by {} in {} ms{by_levels}{lights}\n",
        file.display(),
        plural(measure::distinct(set).len(), "item"),
        count(set.triangle_count(&prepared.scene)),
        prepared.spoken_method(),
        ms(took)
    )
}

/// Inserts a word before the extension: `a.png` becomes `a-word.png`.
fn with_word(file: &Path, word: &str) -> PathBuf {
    let mut name = file.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{word}."));
    name.push(file.extension().unwrap_or_default());
    file.with_file_name(name)
}

/// Numbers the name if there are several: `a-007.png`.
fn numbered(file: &Path, number: usize, of: usize) -> PathBuf {
    let digits = (of.max(1) - 1).to_string().len().max(3);
    if of == 1 {
        file.to_owned()
    } else {
        with_word(file, &format!("{number:0digits$}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn several_pictures_are_numbered() {
        let named = |number, of| numbered(Path::new("out/a.png"), number, of).display().to_string();
        assert_eq!(
            [named(0, 1), named(7, 12), named(7, 12_000)],
            ["out/a.png", "out/a-007.png", "out/a-00007.png"]
        );
    }
}
