//! Runs the laws on other targets, and compares visible sets and pictures there with those of this machine, bit for bit.
//!
//! The package `conformance` makes the reports, on each target the same code. WebAssembly runs in Node.js, without any
//! import: no clock, no file, no thread. Foreign processors are emulated by QEMU.
#![allow(clippy::print_stdout, reason = "a command prints what it finds")]

use crate::fingerprint::compare;
use crate::public_api::Workspace;
use anyhow::{Context, Result, ensure};
use conformance::{BROKEN, report, scenes};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

#[derive(clap::Args)]
pub(crate) struct Args {
    /// Targets to compare this machine with
    #[arg(default_values = ["wasm", "wasm-simd128"])]
    targets: Vec<Target>,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Target {
    /// wasm32-unknown-unknown without SIMD; needs node
    Wasm,
    /// wasm32-unknown-unknown with simd128; needs node
    #[value(name = "wasm-simd128")]
    WasmSimd128,
    /// aarch64-unknown-linux-musl; needs qemu-aarch64
    Aarch64,
}

impl Target {
    fn triple(self) -> &'static str {
        match self {
            Target::Wasm | Target::WasmSimd128 => "wasm32-unknown-unknown",
            Target::Aarch64 => "aarch64-unknown-linux-musl",
        }
    }

    /// Builds `conformance`, and returns the path of the program.
    fn build(self, workspace: &Workspace) -> Result<PathBuf> {
        const LIBRARY: &[&str] = &["rustc", "--lib", "--crate-type", "cdylib"];
        let (command, flags, made, kept) = match self {
            // Scalar kernels are not optimized across the units of the crate in eight minutes.
            Target::Wasm => (LIBRARY, "-Clto=off", "conformance.wasm", "conformance-plain.wasm"),
            Target::WasmSimd128 => (
                LIBRARY,
                "-Ctarget-feature=+simd128",
                "conformance.wasm",
                "conformance-simd128.wasm",
            ),
            // The linker and the C library that come with Rust: no cross compiler is needed.
            Target::Aarch64 => (
                &["build", "--bin", "conformance"][..],
                "-Clinker=rust-lld",
                "conformance",
                "conformance-aarch64",
            ),
        };
        let triple = self.triple();
        install(triple)?;
        let flags_of = format!(
            "CARGO_TARGET_{}_RUSTFLAGS",
            triple.to_uppercase().replace('-', "_")
        );
        succeed(
            cargo()
                .args(command)
                .args(["--release", "--package", "conformance", "--target", triple])
                .env(flags_of, flags)
                .current_dir(&workspace.root),
        )?;
        let folder = workspace.target.join(triple).join("release");
        // The next target may overwrite what cargo made.
        std::fs::copy(folder.join(made), folder.join(kept)).with_context(|| made.to_owned())?;
        Ok(folder.join(kept))
    }

    /// Runs the program, and returns what it prints.
    fn run(self, program: &Path, workspace: &Workspace) -> Result<String> {
        let mut command = match self {
            Target::Wasm | Target::WasmSimd128 => {
                let mut node = Command::new("node");
                node.arg(workspace.root.join("xtask/conformance/run.mjs"));
                node
            }
            Target::Aarch64 => Command::new("qemu-aarch64"),
        };
        let output = command.arg(program).stderr(Stdio::inherit()).output();
        let output = output.with_context(|| {
            let name = command.get_program().display();
            format!("{name} cannot be started: install Debian's nodejs or qemu-user, or the like")
        })?;
        ensure!(output.status.success(), "{} failed", program.display());
        Ok(String::from_utf8(output.stdout)?)
    }
}

/// Installs the standard library for a target, unless it is there.
pub(crate) fn install(triple: &str) -> Result<()> {
    let mut rustc = Command::new("rustc");
    let folder = rustc
        .args(["--print", "target-libdir", "--target", triple])
        .output()?;
    if Path::new(String::from_utf8(folder.stdout)?.trim()).is_dir() {
        return Ok(());
    }
    succeed(Command::new("rustup").args(["target", "add", triple]))
}

/// Returns `cargo` by its name: the one that rustup puts on the path keeps its toolchain, whatever toolchain a file in the
/// folder of a dependency names.
pub(crate) fn cargo() -> Command {
    Command::new("cargo")
}

/// Runs a command, and returns an error if it fails.
pub(crate) fn succeed(command: &mut Command) -> Result<()> {
    let status = command.status().with_context(|| format!("{command:?}"))?;
    ensure!(status.success(), "failed: {command:?}");
    Ok(())
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let workspace = Workspace::read()?;
    let mut programs = Vec::new();
    for &target in &args.targets {
        programs.push((target, target.build(&workspace)?));
    }
    let all: Vec<_> = scenes().collect();
    let here = || {
        all.par_iter()
            .flat_map_iter(|named| report(named))
            .collect::<Vec<String>>()
    };
    let there = || {
        programs
            .par_iter()
            .map(|(target, program)| target.run(program, &workspace))
            .collect::<Vec<_>>()
    };
    let (here, there) = rayon::join(here, there);
    let broken: Vec<&str> = (here.iter().map(String::as_str))
        .filter(|line| line.starts_with(BROKEN))
        .collect();
    ensure!(broken.is_empty(), "on this machine:\n{}", broken.join("\n"));
    for ((_, program), there) in programs.iter().zip(there) {
        let name = program.file_name().unwrap_or_default().display().to_string();
        compare(&there?, &here).context(name.clone())?;
        println!(
            "{name}: the laws hold, and all {} lines are those of this machine",
            here.len()
        );
    }
    Ok(())
}
