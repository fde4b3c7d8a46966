//! `view`: starts the viewer, a program of its own, because graphics libraries take minutes to build.

use crate::Outcome;
use crate::args::ViewArgs;
use anyhow::{Context, Result, bail};
use std::env::consts::EXE_SUFFIX;
use std::io::ErrorKind;
use std::path::PathBuf;
use std::process::Command;

/// Starts the viewer beside this program, or else the one on the path, and waits until it ends.
pub(crate) fn run(args: &ViewArgs) -> Result<Outcome> {
    let name = format!("enfilade-viewer{EXE_SUFFIX}");
    let here = std::env::current_exe().context("cannot tell where this program is")?;
    let beside = here.with_file_name(&name);
    let program = if beside.is_file() {
        beside
    } else {
        PathBuf::from(&name)
    };
    match Command::new(&program).args(&args.arguments).status() {
        Ok(status) if status.success() => Ok(Outcome::Done),
        Ok(_) => Ok(Outcome::Failed),
        Err(why) if why.kind() == ErrorKind::NotFound => bail!(
            "there is no {name} beside {}, nor on the path; `cargo build --release --manifest-path \
             apps/viewer/Cargo.toml` builds it in a few minutes",
            here.display()
        ),
        Err(why) => Err(why).with_context(|| format!("cannot start {}", program.display())),
    }
}
