//! The program without a verb: draws the built-in scene and times every method on it.

use crate::Outcome;
use crate::args::{Args, LookArgs, Verb};
use crate::cameras;
use crate::invocation::suggested;
use crate::json::SceneReport;
use crate::measure::{self, PASSES};
use crate::open::{Purpose, open};
use crate::out;
use crate::picture::{draw, png, settings};
use crate::prepare::{left_out, prepare};
use crate::progress::Progress;
use crate::run_files::RunFiles;
use crate::text::{count, ms, plural, table};
use crate::values::Choice;
use anyhow::{Result, bail};
use clap::Parser;
use enfilade::{ChoiceGoal, Contract};
use enfilade_draw::{Samples, Show};
use std::path::Path;

const PICTURE: &str = "enfilade.png";

/// Draws the picture, and prints the table and further commands to try.
pub(crate) fn run() -> Result<Outcome> {
    let Some(Verb::Look(args)) =
        Args::try_parse_from(["enfilade", "look", "@enfilade", "--method", "all"])?.verb
    else {
        bail!("the arguments of the welcome run must be those of `look`");
    };
    let LookArgs {
        scene,
        cameras,
        methods,
        ..
    } = &args;
    let mut files = RunFiles::default();
    let destination = files.writes(Path::new(PICTURE))?;
    let opened = open(
        &scene.scene,
        Purpose::Pictures,
        Choice::All,
        &methods.how.portals,
        &methods.how.limits,
        &mut files,
    )?;
    let views = cameras::views(cameras, &opened)?;
    let (prepared, skipped) = prepare(
        &opened,
        Choice::All,
        ChoiceGoal::Draw,
        &methods.how,
        views.first(),
    )?;
    let mut rows = Vec::new();
    let mut shown = None;
    let progress = Progress::steps("drawing the palace", prepared.len() * 2 * (1 + PASSES));
    for prepared in &prepared {
        let mut viewer = prepared.viewer();
        let looks = measure::looks(prepared, &views, &mut viewer, &progress);
        let draws = measure::timed(&views, &progress, |_, view| {
            draw(prepared, &mut viewer, view, &settings(Show::Image));
        });
        // The picture comes from a method that cannot be wrong.
        if prepared.contract != Contract::Approximate {
            shown = Some(prepared);
        }
        for (look, draw_ms) in looks.each.iter().zip(draws) {
            rows.push(vec![
                prepared.method.to_owned(),
                prepared.contract.to_string(),
                look.passages.len().to_string(),
                count(look.visible.len() as u64),
                count(look.triangles_visible),
                ms(look.ms),
                ms(draw_ms),
            ]);
        }
    }
    drop(progress);
    if let (Some(prepared), Some(view)) = (shown, views.first()) {
        let mut settings = settings(Show::Image);
        settings.samples = Samples::Four;
        let picture = draw(prepared, &mut prepared.viewer(), view, &settings);
        destination.write(&png(&picture.image)?)?;
    }
    let SceneReport {
        items,
        triangles,
        sectors,
        portals,
        ..
    } = SceneReport::new(&opened);
    let [width, height] = cameras.size;
    let mut text = format!(
        "Enfilade, the built-in palace: {}, {} triangles, {} connected by {}.\n\
         Visible from its first camera at {width}x{height}:\n\n",
        plural(items, "item"),
        count(triangles),
        plural(sectors, "sector"),
        plural(portals, "portal"),
    );
    text += &table(
        &[
            "method",
            "contract",
            "passages",
            "items",
            "triangles",
            "look ms",
            "draw ms",
        ],
        &rows,
    );
    text += &left_out(&skipped);
    text += &format!("\nThe picture is in {PICTURE}. {}", suggested(NEXT));
    out::print(&text)?;
    Ok(Outcome::Done)
}

const NEXT: &str = "Try next:\n
  enfilade look @enfilade --survey 8 --method all --check --size 640x360
  enfilade draw @enfilade -o items.png --show items
  enfilade look YOUR-FILE.glb --survey 16
";
