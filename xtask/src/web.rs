//! Builds the npm package: the `.wasm` files with their JavaScript side, the TypeScript around them, the demo pages; runs
//! its tests in headless Chromium; and builds the viewer's page.
#![allow(clippy::print_stdout, reason = "a command prints what it finds")]

use crate::public_api::Workspace;
use crate::targets::{cargo, install, succeed};
use crate::viewer;
use anyhow::{Context, Result, anyhow, ensure};
use std::path::Path;
use std::process::Command;
use wasm_bindgen_cli_support::Bindgen;

const TARGET: &str = "wasm32-unknown-unknown";

#[derive(clap::Args)]
pub(crate) struct Args {
    /// Only what CI has time for: the core module with SIMD, and the smoke test
    #[arg(long)]
    quick: bool,
    /// Build, and run no test
    #[arg(long)]
    no_test: bool,
    /// Leave out the modules for browsers without SIMD, which take LLVM minutes
    #[arg(long)]
    simd_only: bool,
}

/// A module of the package, and whether it uses SIMD. Both builds of a module share their JavaScript side.
#[derive(Clone, Copy)]
struct Module {
    name: &'static str,
    /// Features of `enfilade_web`.
    features: &'static str,
}

const CORE: Module = Module {
    name: "core",
    features: "",
};

const FILES: Module = Module {
    name: "files",
    features: "files",
};

impl Module {
    /// Builds the module into `web/wasm/`. Without SIMD it takes minutes, even without link-time optimization, which does not
    /// finish in ten for all methods: LLVM is slow at kernels in scalar code.
    fn build(self, workspace: &Workspace, simd: bool) -> Result<()> {
        let (flags, lto) = match simd {
            true => ("-Ctarget-feature=+simd128", "fat"),
            false => ("", "off"),
        };
        succeed(
            cargo()
                // Not `crate-type` in its Cargo.toml: link-time optimization is left out if there is an rlib too.
                .args(["rustc", "--lib", "--crate-type", "cdylib"])
                .args(["--profile", "web", "--package", "enfilade_web"])
                .args(["--target", TARGET, "--features", self.features])
                .env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS", flags)
                .env("CARGO_PROFILE_WEB_LTO", lto)
                .current_dir(&workspace.root),
        )?;
        let built = workspace.target.join(TARGET).join("web/enfilade_web.wasm");
        let wasm = workspace.root.join("web/wasm");
        let folder = if simd {
            wasm.clone()
        } else {
            workspace.target.join("web-plain")
        };
        Bindgen::new()
            .input_path(built)
            .out_name(self.name)
            .web(true)
            .and_then(|bindgen| {
                bindgen
                    .typescript(true)
                    .omit_default_module_path(true)
                    .generate(&folder)
            })
            .map_err(|why| anyhow!("wasm-bindgen, for {}: {why:#}", folder.display()))?;
        if simd {
            // Known to the newest libraries of TypeScript only.
            let types = wasm.join(format!("{}.d.ts", self.name));
            let text = std::fs::read_to_string(&types)?;
            let lines = text.lines().filter(|line| !line.contains("[Symbol.dispose]"));
            std::fs::write(&types, lines.collect::<Vec<_>>().join("\n"))?;
        } else {
            let script = format!("{}.js", self.name);
            let [here, there] = [&wasm, &folder].map(|folder| std::fs::read(folder.join(&script)));
            ensure!(here? == there?, "{script} differs without SIMD");
            let module = format!("{}_bg.wasm", self.name);
            std::fs::copy(
                folder.join(module),
                wasm.join(format!("{}_plain_bg.wasm", self.name)),
            )?;
        }
        Ok(())
    }
}

/// Runs npm or one of its programs in `web/`.
fn npm(web: &Path, arguments: &[&str]) -> Result<()> {
    succeed(Command::new("npm").args(arguments).current_dir(web))
        .context("the npm package needs Node.js 20 or newer, with npm")
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let workspace = Workspace::read()?;
    let web = workspace.root.join("web");
    install(TARGET)?;
    for simd in [true, false] {
        if simd || !(args.quick || args.simd_only) {
            CORE.build(&workspace, simd)?;
            if !args.quick {
                FILES.build(&workspace, simd)?;
            }
        }
    }
    for license in ["LICENSE-APACHE", "LICENSE-MIT"] {
        std::fs::copy(workspace.root.join(license), web.join(license)).context(license)?;
    }
    npm(&web, &["ci", "--no-audit", "--no-fund", "--prefer-offline"])?;
    npm(&web, &["run", if args.quick { "build:quick" } else { "build" }])?;
    npm(&web, &["run", "sizes"])?;
    if !args.quick && !args.simd_only {
        viewer::build_page(&workspace)?;
    }
    if args.no_test {
        return Ok(());
    }
    let chromium = [
        "/usr/bin/chromium",
        "/usr/bin/chromium-browser",
        "/usr/bin/google-chrome",
    ];
    ensure!(
        chromium.iter().any(|path| Path::new(path).exists()),
        "the tests need Chromium: install Debian's package chromium, or the like"
    );
    if args.quick {
        return npm(&web, &["run", "test:quick"]);
    }
    // The tests compare visible sets with those of the program.
    succeed(
        cargo()
            .args(["build", "--release", "--package", "enfilade-cli"])
            .current_dir(&workspace.root),
    )?;
    succeed(
        Command::new("npm")
            .args(["run", "test"])
            .env("ENFILADE_PROGRAM", workspace.target.join("release/enfilade"))
            .current_dir(&web),
    )
}
