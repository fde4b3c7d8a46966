//! Lints and tests the Bevy plugin: a workspace of its own in `crates/enfilade_bevy/`.

use crate::public_api::Workspace;
use crate::targets::{cargo, succeed};
use anyhow::{Context, Result};
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub(crate) struct Args {
    /// Only what CI has time for: the tests without Bevy's renderer
    #[arg(long)]
    quick: bool,
    /// Draw 300 frames with the whole of Bevy, with and without Enfilade, of the palace and two scenes in
    /// ENFILADE_SCENES, and 100 of the palace with its rooms. Needs a Vulkan driver, as of Debian's package mesa-vulkan-drivers
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
        let palace = workspace.root.join("target/palace_plain.glb");
        let manifest = workspace.root.join("tools/palace/Cargo.toml");
        succeed(
            crate::targets::cargo()
                .args(["run", "--release", "--manifest-path"])
                .args([&manifest, Path::new("--"), &palace, Path::new("--plain")]),
        )?;
        let in_scenes = |name: &str| scenes.join(name);
        let runs = [
            (&palace, "palace_rooms", "100", None),
            // Flies through walls.
            (&palace, "palace", "300", Some("--without-rooms")),
            (&in_scenes("ifc_office_a.glb"), "ifc_office_a", "300", None),
            (&in_scenes("sponza_crytek.glb"), "sponza_crytek", "300", None),
        ];
        for (scene, views, frames, option) in runs {
            let views = folder.join("pictures/views").join(views).with_extension("jsonl");
            let mut run = crate::targets::cargo();
            run.args(["run", "--release", "-p", "enfilade_bevy_pictures", "--"]);
            run.args([scene, &views])
                .arg(frames)
                .args(option)
                .current_dir(&folder);
            succeed(&mut run)?;
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
    cargo(&[&["run", "--example", "rooms"], &without_renderer[..]].concat())?;
    cargo(&["test", "--features", "gizmos"])
}
