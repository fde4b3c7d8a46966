//! The `enfilade` program: computes what is visible in a scene, verifies it and draws it.
#![forbid(unsafe_code)]

mod args;
mod bake;
mod bench;
mod cameras;
mod check;
mod choose;
mod compare;
mod draw;
mod hints;
mod html;
mod info;
mod invocation;
mod json;
mod leak;
#[cfg(feature = "levels")]
mod levels;
mod link;
mod look;
mod measure;
mod names;
mod non_occluders;
mod open;
mod out;
mod picture;
mod portals;
mod prepare;
mod progress;
mod read;
mod report;
mod rooms;
mod run_files;
mod save;
mod shards;
mod text;
mod upright;
mod values;
mod view;
mod vis;
mod welcome;

use args::{Args, Verb};
use clap::Parser;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use report::Report;
use std::path::Path;
use std::process::ExitCode;

/// Result of a run that completed without an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    /// Exit code 0.
    Done,
    /// Exit code 1: a check found a false cull or a wrong pixel.
    CheckFailed,
    /// Exit code 2: an error that the viewer has printed.
    Failed,
}

impl Outcome {
    /// Returns `CheckFailed` if any report breaks its contract; unchecked reports never do.
    fn of(reports: &[Report]) -> Outcome {
        if reports.iter().any(Report::breaks_its_contract) {
            Outcome::CheckFailed
        } else {
            Outcome::Done
        }
    }
}

fn main() -> ExitCode {
    let args = match Args::try_parse_from(vis::as_mappers_type(std::env::args_os())) {
        Ok(args) => args,
        Err(error) => return refuse(&error),
    };
    let outcome = match args.verb {
        None => welcome::run(),
        Some(Verb::Draw(args)) => draw::run(&args),
        Some(Verb::Look(args)) => look::run(&args),
        Some(Verb::Compare(args)) => compare::run(&args),
        Some(Verb::Bench(args)) => bench::run(args),
        Some(Verb::Choose(args)) => choose::run(&args),
        Some(Verb::Link(args)) => link::run(&args),
        Some(Verb::Vis(args)) => vis::run(args),
        Some(Verb::Portals(args)) => portals::run(&args),
        Some(Verb::Rooms(args)) => rooms::run(&args),
        Some(Verb::View(args)) => view::run(&args),
        Some(Verb::Bake(args)) => bake::run(&args),
        Some(Verb::Hints(args)) => hints::run(&args),
        Some(Verb::Info(args)) => info::run(&args),
    };
    match outcome {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::CheckFailed) => ExitCode::from(1),
        Ok(Outcome::Failed) => ExitCode::from(2),
        Err(error) => {
            out::error(&error);
            ExitCode::from(2)
        }
    }
}

/// Prints the help or a usage error. If the verb is a scene, suggests `look` with it.
fn refuse(error: &clap::Error) -> ExitCode {
    let word = error
        .get(ContextKind::InvalidSubcommand)
        .filter(|_| error.kind() == ErrorKind::InvalidSubcommand);
    if let Some(ContextValue::String(word)) = word
        && (word.starts_with('@') || Path::new(word).extension().is_some())
    {
        out::note(format_args!(
            "error: `{word}` is a scene, not a verb; try `{} look {word}`",
            invocation::program()
        ));
        return ExitCode::from(2);
    }
    if error.use_stderr() {
        // A failure is ignored: if standard error is closed, nothing can report it.
        let _ = error.print();
        return ExitCode::from(2);
    }
    match out::printed(error.print()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            out::error(&why);
            ExitCode::from(2)
        }
    }
}
