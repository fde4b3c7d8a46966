//! Tests that take too long for every change: run before a release.
#![allow(clippy::print_stdout, reason = "a command prints what it runs")]

use crate::public_api::Workspace;
use crate::targets::cargo;
use anyhow::{Context, Result, ensure};
use std::time::Instant;

#[derive(clap::Args)]
pub(crate) struct Args {
    /// Run only the steps whose command contains one of these [default: all]
    #[arg(value_name = "PART")]
    parts: Vec<String>,
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
    let steps: [&[&str]; 18] = [
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
        &["test", "--release", "--manifest-path", "tools/palace/Cargo.toml"],
        &["test", "--release", "--manifest-path", "tools/town/Cargo.toml"],
        &["test", "--release", "--manifest-path", "benches/micro/Cargo.toml"],
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
    let wanted = |line: &String| args.parts.is_empty() || args.parts.iter().any(|part| line.contains(part));
    let root = Workspace::read()?.root;
    let mut failed = Vec::new();
    let mut count = 0;
    for step in steps {
        let line = format!("cargo {}", step.join(" "));
        if !wanted(&line) {
            continue;
        }
        println!("\n== {line} ==");
        let start = Instant::now();
        let passed = cargo()
            .args(step)
            .current_dir(&root)
            .status()
            .with_context(|| line.clone())?
            .success();
        println!(
            "== {}, {:.0} s: {line}",
            if passed { "passed" } else { "failed" },
            start.elapsed().as_secs_f64()
        );
        if !passed {
            failed.push(line);
        }
        count += 1;
    }
    ensure!(
        count > 0,
        "no step contains {}; give no argument to run all",
        args.parts.join(", ")
    );
    ensure!(failed.is_empty(), "failed: {}", failed.join("; "));
    println!("\nall {count} steps passed");
    Ok(())
}
