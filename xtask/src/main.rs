//! Developer commands: `cargo xtask verify`, `fuzz-scenes`, `fingerprint`, `targets`, `public-api`, `ci-long`, `charts`,
//! `lines`, `rooms`, `web`, `viewer`, `bevy`, `header`, `c`, `c-install`, `cluster` and `scenes`.
#![forbid(unsafe_code)]

mod bevy;
mod c;
mod charts;
mod ci_long;
mod cluster;
mod fingerprint;
mod fuzz_scenes;
mod header;
mod lines;
mod public_api;
mod rooms;
mod scenes;
mod targets;
mod verify;
mod viewer;
mod web;

use clap::Parser;

/// Commands for those who work on Enfilade.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
enum Task {
    /// Holds every method against the reference on many views of many scenes; takes hours
    Verify(verify::Args),
    /// Tests every method on small random scenes that are hard to get right, from hard viewpoints
    FuzzScenes(fuzz_scenes::Args),
    /// Writes the visible sets and picture hashes of all methods to a file, and compares it with an earlier one
    Fingerprint(fingerprint::Args),
    /// Runs the laws on other targets (WebAssembly, aarch64) and compares visible sets and pictures with this machine's
    Targets(targets::Args),
    /// Compares the public API of the libraries, signatures included, with the committed listings
    PublicApi(public_api::Args),
    /// Runs what is too long for `.ci/run`: the above, and the tests that are ignored elsewhere; takes hours
    CiLong(ci_long::Args),
    /// Measures every method on every scene, and draws the book's charts of it; takes half an hour
    Charts(charts::Args),
    /// Writes the header of the C interface, or compares it with the crate
    Header(header::Args),
    /// Builds the C interface, its examples in C, C++ and Python, and runs them under memory checkers
    C(c::Args),
    /// Installs the C interface: header, libraries, files for CMake and pkg-config
    CInstall(c::InstallArgs),
    /// Tests `tools/cluster/`: shards on several machines, whose workers are killed
    Cluster,
    /// Counts the lines of code of each crate, without blank lines, comments, docs and tests
    Lines(lines::Args),
    /// Compares the rooms and doors found in buildings with the true ones
    Rooms(rooms::Args),
    /// Builds the npm package in `web/`, and tests it
    Web(web::Args),
    /// Tests the Bevy plugin in `crates/enfilade_bevy/`
    Bevy(bevy::Args),
    /// Builds and tests the viewer in `apps/viewer/`, or its web page
    Viewer(viewer::Args),
    /// Lists the real scenes, where they are published, and checks a folder of them
    Scenes(scenes::Args),
}

fn main() -> anyhow::Result<()> {
    if public_api::run_as_rustdoc()? {
        return Ok(());
    }
    match Task::parse() {
        Task::Verify(args) => verify::run(&args),
        Task::FuzzScenes(args) => fuzz_scenes::run(&args),
        Task::Fingerprint(args) => fingerprint::run(&args),
        Task::Targets(args) => targets::run(&args),
        Task::PublicApi(args) => public_api::run(&args),
        Task::CiLong(args) => ci_long::run(&args),
        Task::Charts(args) => charts::run(&args),
        Task::Header(args) => header::run(&args),
        Task::C(args) => c::run(&args),
        Task::CInstall(args) => c::install(&args),
        Task::Cluster => cluster::run(),
        Task::Lines(args) => lines::run(&args),
        Task::Rooms(args) => rooms::run(&args),
        Task::Web(args) => web::run(&args),
        Task::Bevy(args) => bevy::run(&args),
        Task::Viewer(args) => viewer::run(&args),
        Task::Scenes(args) => scenes::run(&args),
    }
}
