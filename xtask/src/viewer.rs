//! Builds and tests the viewer: a workspace of its own in `apps/viewer/`, with its renderer and its web page.
#![allow(clippy::print_stdout, reason = "a command prints what it finds")]

use crate::public_api::Workspace;
use crate::targets::{cargo, install, succeed};
use anyhow::{Context, Result, anyhow, bail, ensure};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use wasm_bindgen_cli_support::Bindgen;

const TARGET: &str = "wasm32-unknown-unknown";

#[derive(clap::Args)]
pub(crate) struct Args {
    /// Only what CI has time for: one test without a window, and a window in a virtual display
    #[arg(long)]
    quick: bool,
    /// Build the web page, and run its test
    #[arg(long)]
    web: bool,
    /// Build, and run no test
    #[arg(long)]
    no_test: bool,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let workspace = Workspace::read()?;
    if args.web {
        build_page(&workspace)?;
        if !args.no_test {
            test_page(&workspace)?;
        }
        return Ok(());
    }
    let cargo = |arguments: &[&str]| {
        let mut command = cargo();
        command
            .args(arguments)
            .current_dir(workspace.root.join("apps/viewer"));
        succeed(&mut command)
    };
    if args.no_test {
        return cargo(&["build", "--release"]);
    }
    let features = ["--features", "enfilade_wgpu/headless"];
    let with = |first: &[&str], last: &[&str]| cargo(&[first, &features, last].concat());
    cargo(&["fmt", "--all", "--check"])?;
    if args.quick {
        with(&["test", "--test", "interface"], &["keys"])?;
    } else {
        with(
            &["clippy", "--workspace", "--all-targets"],
            &["--", "-D", "warnings"],
        )?;
        with(&["test", "--workspace"], &[])?;
        // Built with the tests. It writes a picture where it runs.
        succeed(Command::new(workspace.target.join("debug/examples/palace")).current_dir(&workspace.target))?;
    }
    cargo(&["build"])?;
    test_window(&workspace)
}

/// Opens the viewer in a virtual display, presses keys, and looks at the pixels.
fn test_window(workspace: &Workspace) -> Result<()> {
    const SIZE: [usize; 2] = [1000, 640];
    let folder = workspace.target.join("virtual-display");
    // What an earlier run left must not pass for this one's screen.
    if folder.exists() {
        std::fs::remove_dir_all(&folder)?;
    }
    std::fs::create_dir_all(&folder)?;
    let server = Command::new("Xvfb")
        .args([
            ":83",
            "-screen",
            "0",
            &format!("{}x{}x24", SIZE[0], SIZE[1]),
            "-fbdir",
        ])
        .arg(&folder)
        .stderr(Stdio::null())
        .spawn()
        .context("the test needs Xvfb and xdotool: install Debian's packages xvfb and xdotool")?;
    let _server = Ended(server);
    let screen = Screen {
        file: folder.join("Xvfb_screen0"),
        size: SIZE,
    };
    wait("the virtual display", || screen.read().is_ok())?;
    let viewer = Command::new(workspace.target.join("debug/enfilade-viewer"))
        .args(["@enfilade", "--size", &format!("{}x{}", SIZE[0], SIZE[1])])
        .env("DISPLAY", ":83")
        .env_remove("WAYLAND_DISPLAY")
        .spawn()?;
    let mut viewer = Ended(viewer);
    let mut alive = || match viewer.0.try_wait()? {
        Some(status) => bail!("the viewer ended with {status}"),
        None => Ok(()),
    };
    let input = |arguments: &[&str]| succeed(Command::new("xdotool").args(arguments).env("DISPLAY", ":83"));
    // The palace is colourful; the panels alone are not.
    wait("the palace", || screen.colors().is_ok_and(|colors| colors > 5000))?;
    alive()?;
    input(&["search", "--sync", "--name", "Enfilade", "windowfocus"])?;
    input(&["mousemove", "450", "300"])?;
    // A key that moves is held until the picture shows it: between two slow frames a short press is lost.
    let presses: [(&[&str], &str, &[&str]); 3] = [
        (&["keydown", "w"], "a step forward", &["keyup", "w"]),
        (&["key", "f"], "the frozen set", &["keyup", "f"]),
        (&["keydown", "s"], "a flight out of it", &["keyup", "s"]),
    ];
    for (down, what, up) in presses {
        let before = screen.at_rest()?;
        input(down)?;
        wait(what, || {
            screen.read().is_ok_and(|now| {
                let pairs = before.iter().zip(&now);
                pairs.filter(|(before, now)| before != now).count() > 20_000
            })
        })?;
        input(up)?;
        alive()?;
        println!("{what}: seen in the window");
    }
    Ok(())
}

/// A process that ends with this value.
struct Ended(Child);

impl Drop for Ended {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The screen of a virtual display: a window dump of X, 32 bits a pixel.
struct Screen {
    file: PathBuf,
    size: [usize; 2],
}

impl Screen {
    /// Returns the pixels.
    fn read(&self) -> Result<Vec<u32>> {
        let bytes = std::fs::read(&self.file)?;
        let number = |at: usize| -> Option<usize> {
            let four = bytes.get(4 * at..4 * at + 4)?;
            Some(u32::from_be_bytes(four.try_into().ok()?) as usize)
        };
        // The size of the header, and the number of colours of 12 bytes each that follow it.
        let start = number(0)
            .zip(number(19))
            .map(|(header, colors)| header + 12 * colors);
        let end = start.map(|start| start + 4 * self.size[0] * self.size[1]);
        let pixels = start.zip(end).and_then(|(start, end)| bytes.get(start..end));
        let pixels = pixels.context("the screen is not there yet")?;
        let pixel = |four: &[u8]| u32::from_ne_bytes([four[0], four[1], four[2], 0]);
        Ok(pixels.chunks_exact(4).map(pixel).collect())
    }

    /// Returns the pixels once they have not changed for a while: nothing moves any more.
    fn at_rest(&self) -> Result<Vec<u32>> {
        let mut last = self.read()?;
        wait("a picture at rest", || {
            std::thread::sleep(Duration::from_millis(700));
            self.read().is_ok_and(|now| {
                let rests = now == last;
                last = now;
                rests
            })
        })?;
        Ok(last)
    }

    /// Returns the number of different colours.
    fn colors(&self) -> Result<usize> {
        let mut pixels = self.read()?;
        pixels.sort_unstable();
        pixels.dedup();
        Ok(pixels.len())
    }
}

fn wait(what: &str, mut is_there: impl FnMut() -> bool) -> Result<()> {
    const PATIENCE: Duration = Duration::from_secs(120);
    let start = Instant::now();
    while !is_there() {
        ensure!(
            start.elapsed() < PATIENCE,
            "{what} does not appear within {PATIENCE:?}"
        );
        std::thread::sleep(Duration::from_millis(100));
    }
    Ok(())
}

/// Builds the page into the folder `viewer-web` beside the programs.
pub(crate) fn build_page(workspace: &Workspace) -> Result<()> {
    install(TARGET)?;
    succeed(
        cargo()
            .args(["build", "--lib", "--profile", "web", "--target", TARGET])
            .env(
                "CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS",
                "-Ctarget-feature=+simd128",
            )
            .current_dir(workspace.root.join("apps/viewer")),
    )?;
    let folder = page_folder(workspace);
    std::fs::create_dir_all(&folder)?;
    let built = workspace.target.join(TARGET).join("web/enfilade_viewer.wasm");
    Bindgen::new()
        .input_path(built)
        .out_name("viewer")
        .web(true)
        .and_then(|bindgen| {
            bindgen
                .typescript(false)
                // Names of functions are a fifth of the code.
                .remove_name_section(true)
                .omit_default_module_path(true)
                .generate(&folder)
        })
        .map_err(|why| anyhow!("wasm-bindgen, for {}: {why:#}", folder.display()))?;
    for file in ["index.html", "page.js"] {
        std::fs::copy(
            workspace.root.join("apps/viewer/page").join(file),
            folder.join(file),
        )
        .context(file)?;
    }
    println!(
        "built {}: publish it as it is, or `enfilade view --web`",
        folder.display()
    );
    Ok(())
}

fn page_folder(workspace: &Workspace) -> PathBuf {
    workspace.target.join("viewer-web")
}

/// Opens the page in headless Chromium.
fn test_page(workspace: &Workspace) -> Result<()> {
    let web = workspace.root.join("web");
    if !web.join("node_modules/playwright-core").is_dir() {
        let install = ["ci", "--no-audit", "--no-fund", "--prefer-offline"];
        succeed(Command::new("npm").args(install).current_dir(&web))?;
    }
    succeed(
        cargo()
            .arg("build")
            .current_dir(workspace.root.join("apps/viewer")),
    )?;
    let program: &Path = &workspace.target.join("debug/enfilade-viewer");
    succeed(
        Command::new("node")
            .args(["--test", "apps/viewer/page/page.test.mjs"])
            .env("ENFILADE_VIEWER", program)
            .env("ENFILADE_WEB", &web)
            .current_dir(&workspace.root),
    )
}
