//! Tests `tools/cluster/`, which runs shards on several machines: a Python package, in a virtual environment of its own.

use crate::public_api::Workspace;
use crate::targets::{cargo, succeed};
use anyhow::{Context, Result};
use std::process::Command;

/// Builds the program, installs the package, and bakes tiles while workers are killed.
pub(crate) fn run() -> Result<()> {
    let workspace = Workspace::read()?;
    succeed(
        cargo()
            .args(["build", "--release", "--package", "enfilade-cli"])
            .current_dir(&workspace.root),
    )?;
    let environment = workspace.target.join("cluster-python");
    let mut python = Command::new("python3");
    succeed(python.args(["-m", "venv"]).arg(&environment))
        .context("the test needs Python 3.10 or newer with venv: install Debian's package python3-venv")?;
    let python = environment.join("bin/python");
    let package = workspace.root.join("tools/cluster");
    succeed(
        Command::new(&python)
            .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"])
            .arg(&package),
    )?;
    succeed(
        Command::new(&python)
            .args(["-B", "-m", "unittest", "discover", "--start-directory"])
            .arg(package.join("tests"))
            .env("ENFILADE", workspace.target.join("release/enfilade")),
    )
}
