//! Lints and tests the Bevy plugin: a workspace of its own in `crates/enfilade_bevy/`.

use crate::public_api::Workspace;
use crate::targets::{cargo, succeed};
use anyhow::{Context, Result};
use std::path::PathBuf;

#[derive(clap::Args)]
pub(crate) struct Args {
    /// Only what CI has time for: the tests without Bevy's renderer
    #[arg(long)]
    quick: bool,
    /// Draw 300 frames with the whole of Bevy, with and without Enfilade, of the scenes in ENFILADE_SCENES. Needs a
    /// Vulkan driver, as of Debian's package mesa-vulkan-drivers
    #[arg(long)]
    pictures: bool,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let workspace = Workspace::read()?;
    let folder = workspace.root.join("crates/enfilade_bevy");
    let cargo = |arguments: &[&str]| succeed(cargo().args(arguments).current_dir(&folder));
    if args.pictures {
        let scenes =
            PathBuf::from(std::env::var_os("ENFILADE_SCENES").context("ENFILADE_SCENES is not set")?);
        for scene in ["ifc_office_a", "sponza_crytek"] {
            let file = scenes.join(scene).with_extension("glb");
            let views = folder.join("pictures/views").join(scene).with_extension("jsonl");
            let paths = [&file, &views].map(|path| path.to_string_lossy().into_owned());
            cargo(&[
                "run",
                "--release",
                "-p",
                "enfilade_bevy_pictures",
                "--",
                &paths[0],
                &paths[1],
            ])?;
        }
        return Ok(());
    }
    cargo(&["fmt", "--all", "--check"])?;
    let without_renderer = ["--no-default-features", "--features", "gizmos"];
    if args.quick {
        return cargo(&[&["test", "--tests"], &without_renderer[..]].concat());
    }
    cargo(&[
        "clippy",
        "--workspace",
        "--all-targets",
        "--features",
        "gizmos",
        "--",
        "-D",
        "warnings",
    ])?;
    cargo(
        &[
            &["clippy", "--all-targets"],
            &without_renderer[..],
            &["--", "-D", "warnings"],
        ]
        .concat(),
    )?;
    cargo(&["test", "--features", "gizmos"])
}
