//! The `enfilade` program: says what can be seen in a scene, and draws it.
#![forbid(unsafe_code)]

mod args;
mod cameras;
mod check;
mod draw;
mod info;
mod look;
mod measure;
mod names;
mod open;
mod out;
mod prepare;
mod progress;
mod report;
mod save;
mod text;
mod values;
mod welcome;

use args::{Args, Verb};
use clap::Parser;
use std::process::ExitCode;

/// How a run ended that could be carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    /// As it should.
    Done,
    /// A method missed something, or painted what it must not.
    CheckFailed,
}

fn main() -> ExitCode {
    let outcome = match Args::parse().verb {
        None => welcome::run(),
        Some(Verb::Draw(args)) => draw::run(&args),
        Some(Verb::Look(args)) => look::run(&args),
        Some(Verb::Info(args)) => info::run(&args),
    };
    match outcome {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::CheckFailed) => ExitCode::from(1),
        Err(error) => {
            out::error(&error);
            ExitCode::from(2)
        }
    }
}
