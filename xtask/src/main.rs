//! Commands for those who work on Enfilade: `cargo xtask verify`.
#![forbid(unsafe_code)]

mod verify;

use clap::Parser;

/// Commands for those who work on Enfilade.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
enum Task {
    /// Holds every method against the reference on many views of many scenes; takes hours
    Verify(verify::Args),
}

fn main() -> anyhow::Result<()> {
    let Task::Verify(args) = Task::parse();
    verify::run(&args)
}
