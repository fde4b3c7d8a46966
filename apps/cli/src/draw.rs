//! `draw`: pictures of what is seen.

use crate::Outcome;
use crate::args::DrawArgs;
use crate::cameras;
#[cfg(feature = "levels")]
use crate::levels::Leveled;
use crate::measure::{self, PASSES};
use crate::open::{For, open, settle};
use crate::out;
use crate::prepare::{Prepared, prepare};
use crate::progress::Progress;
use crate::report::{Report, Reports, Sink, Skipped, left_out};
use crate::run_files::RunFiles;
use crate::save::Destination;
use crate::text::{count, ms, plural};
use crate::values::Choice;
use anyhow::{Context, Result, bail};
use enfilade::{Aim, Method, View, Viewer};
use enfilade_draw::{Exposure, Picture, RgbImage, Samples, Settings, Show};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
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
            "cannot write {}: pictures are PNG, so its name must end in .png",
            args.output.display()
        );
    }
    if args.samples > 1 && args.show != Show::Image {
        bail!(
            "--samples {} is for --show image alone; leave one of the two out",
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
    // Names made from this one are in the same folder.
    files.writes(&args.output)?;
    let sink = Sink::new(&args.json, &mut files)?;
    settle(&args.methods.how)?;
    let choice = args.methods.choice();
    let opened = open(
        &args.scene.scene,
        if args.show == Show::Image {
            For::Pictures
        } else {
            For::Answers
        },
        choice,
        args.methods.how.portals,
        &args.methods.how.limits,
        &mut files,
    )?;
    let views = cameras::views(&args.cameras, &opened)?;
    let (mut prepared, mut skipped) = prepare(&opened, choice, Aim::Draw, &args.methods.how, views.first())?;
    if args.show == Show::Cover {
        prepared = with_shapes(prepared, choice, &mut skipped)?;
    }
    let destinations = prepared
        .iter()
        .map(|prepared| destinations(args, choice, prepared, views.len(), &mut files))
        .collect::<Result<Vec<_>>>()?;
    let mut settings = settings(args.show);
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
            // What all pictures share is made once, and is no part of what one takes.
            prepared.stage();
            let start = Instant::now();
            let picture = draw(prepared, &mut viewer, view, &settings);
            let took = start.elapsed().as_secs_f64() * 1e3;
            destination.write(&png(&picture.image)?)?;
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

/// Returns where the pictures of a method go, one for each view.
fn destinations(
    args: &DrawArgs,
    choice: Choice,
    prepared: &Prepared,
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
            // That one is known.
            file if file == args.output => Destination::new(&file),
            file => files.writes_too(&file),
        })
        .collect()
}

/// Those whose covers have a shape to show; of all methods the others are skipped.
fn with_shapes(prepared: Vec<Prepared>, choice: Choice, skipped: &mut Vec<Skipped>) -> Result<Vec<Prepared>> {
    let mut kept = Vec::new();
    for prepared in prepared {
        let shapeless = prepared
            .methods()
            .into_iter()
            .find(|method| method.cover_shape().is_none());
        match shapeless {
            None => kept.push(prepared),
            Some(method) if choice == Choice::All => skipped.push(Skipped {
                method: method.name(),
                why: "its cover has no shape to show".to_owned(),
            }),
            Some(method) => {
                let all = Method::ALL.into_iter();
                let names = all
                    .filter(|method| method.cover_shape().is_some())
                    .map(Method::name);
                bail!(
                    "{method} has no cover to show; choose a --method that has one: {}",
                    names.collect::<Vec<_>>().join(", ")
                );
            }
        }
    }
    Ok(kept)
}

/// `a.png: 43 items, 34,120 triangles by hierarchical-z in 21.3 ms; lights that shine on them: 2 of 5`.
fn line(
    file: &Path,
    prepared: &Prepared,
    viewer: &Viewer,
    lights: Option<usize>,
    took: f64,
    by_levels: &str,
) -> String {
    let set = viewer.visible();
    let all = prepared.scene.lights().len();
    let lights = match lights {
        Some(lights) if all > 0 => format!("; lights that shine on them: {lights} of {all}"),
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

/// `a.png` with a word: `a-word.png`.
fn with_word(file: &Path, word: &str) -> PathBuf {
    let mut name = file.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{word}."));
    name.push(file.extension().unwrap_or_default());
    file.with_file_name(name)
}

/// `a-007.png` where there are several.
fn numbered(file: &Path, number: usize, of: usize) -> PathBuf {
    let digits = (of.max(1) - 1).to_string().len().max(3);
    if of == 1 {
        file.to_owned()
    } else {
        with_word(file, &format!("{number:0digits$}"))
    }
}

/// How the program paints: lights as an eye sees them that has got used to where it stands.
pub(crate) fn settings(show: Show) -> Settings {
    let mut settings = Settings::default();
    settings.show = show;
    settings.exposure = Exposure::Eye(0.0);
    settings
}

/// Draws a view, shading included.
pub(crate) fn draw(prepared: &Prepared, viewer: &mut Viewer, view: &View, settings: &Settings) -> Picture {
    prepared.stage().draw(viewer, &prepared.scene, view, settings)
}

/// Returns a picture as the bytes of a PNG.
pub(crate) fn png(image: &RgbImage) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    // Walls and cells of one colour come to half of what the fastest compression makes of them.
    let png = PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive);
    image
        .write_with_encoder(png)
        .context("a picture that is no PNG")?;
    Ok(bytes)
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
