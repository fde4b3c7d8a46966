//! Tests that take too long for every change: run before a release.
#![allow(clippy::print_stdout, reason = "a command prints what it runs")]

use crate::targets::cargo;
use anyhow::{Context, Result, ensure};

#[derive(clap::Args)]
pub(crate) struct Args {
    /// Number of random scenes
    #[arg(long, default_value_t = 20_000)]
    scenes: u64,
    /// Views of each built-in and real scene
    #[arg(long, default_value_t = 16)]
    views: usize,
}

/// Runs other commands and the ignored tests, each in its own process, so that a crash fails only its step.
pub(crate) fn run(args: &Args) -> Result<()> {
    let [scenes, views] = [args.scenes.to_string(), args.views.to_string()];
    let steps: [&[&str]; 15] = [
        // It writes a picture where it runs.
        &["run", "--release"],
        &["xtask", "fuzz-scenes", &scenes],
        &["xtask", "verify", "--views", &views, "--strict-views", &views],
        &["xtask", "targets", "wasm", "wasm-simd128", "aarch64"],
        &["xtask", "rooms", "--check", "--lines", "20000"],
        &["xtask", "c"],
        &["xtask", "web"],
        &["xtask", "viewer"],
        &["xtask", "viewer", "--web"],
        &["xtask", "bevy"],
        &["xtask", "bevy", "--pictures"],
        &["xtask", "cluster"],
        &["test", "--release", "--workspace", "--", "--ignored"],
        // Makes LODs by the C++ meshoptimizer, which also checks our decoder.
        &[
            "test",
            "--release",
            "-p",
            "enfilade_import",
            "--features",
            "levels",
        ],
        &[
            "test",
            "--release",
            "-p",
            "enfilade_import",
            "--features",
            "levels",
            "--lib",
            "levels::",
            "--",
            "--ignored",
        ],
    ];
    let mut failed = Vec::new();
    for step in steps {
        let line = format!("cargo {}", step.join(" "));
        println!("\n== {line} ==");
        let status = cargo().args(step).status();
        if !status.with_context(|| line.clone())?.success() {
            failed.push(line);
        }
    }
    ensure!(failed.is_empty(), "failed: {}", failed.join("; "));
    println!("\nall steps passed");
    Ok(())
}
