//! Listings of the public API, signatures included, so that no change of it goes unnoticed.
//!
//! Source: rustdoc's JSON, which is unstable: its format changes with the compiler, and stable compilers write it only
//! where `RUSTC_BOOTSTRAP` is set.
#![allow(clippy::print_stdout, reason = "a command prints what it finds")]

use crate::targets::cargo;
use anyhow::{Context, Result, ensure};
use public_api::Builder;
use std::collections::HashSet;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

#[derive(clap::Args)]
pub(crate) struct Args {
    /// Write the listings instead of comparing with them
    #[arg(long)]
    bless: bool,
}

/// The libraries whose API is listed, each in its `public-api.txt`. That of `enfilade_c` is its header.
const CRATES: [&str; 8] = [
    "enfilade",
    "enfilade_bake",
    "enfilade_detail",
    "enfilade_draw",
    "enfilade_import",
    "enfilade_stream",
    "enfilade_sync",
    "enfilade_walk",
];

/// Version of rustdoc's JSON that the pinned `public-api` reads.
const FORMAT: u64 = 57;

/// Holds the path of the rustdoc that cargo would run by itself.
const RUSTDOC: &str = "ENFILADE_XTASK_RUSTDOC";

pub(crate) fn run(args: &Args) -> Result<()> {
    let workspace = Workspace::read()?;
    let mut different = Vec::new();
    for name in CRATES {
        let json = workspace.document(name)?;
        let listing = listing(&json).with_context(|| json.display().to_string())?;
        let path = workspace.root.join(format!("crates/{name}/public-api.txt"));
        let committed = fs::read_to_string(&path)
            .unwrap_or_default()
            .replace("\r\n", "\n");
        if committed == listing {
            println!("{name}: unchanged, {} lines", listing.lines().count());
            continue;
        }
        println!("{name}: changed");
        print_differences(&committed, &listing);
        if args.bless {
            fs::write(&path, listing).with_context(|| path.display().to_string())?;
        } else {
            different.push(name);
        }
    }
    ensure!(
        different.is_empty(),
        "the public API of {} differs from public-api.txt; if that is intended, run `cargo xtask public-api --bless` and \
         describe the change in CHANGELOG.md",
        different.join(", ")
    );
    Ok(())
}

/// Runs rustdoc in place of this program where [`Workspace::document`] made cargo call it, and returns `true` if so.
///
/// `RUSTC_BOOTSTRAP` is set for rustdoc alone: build scripts read it too, and would build all dependencies anew.
pub(crate) fn run_as_rustdoc() -> Result<bool> {
    let Some(rustdoc) = std::env::var_os(RUSTDOC) else {
        return Ok(false);
    };
    let args = std::env::args_os().skip(1);
    let status = Command::new(rustdoc)
        .args(args)
        .env("RUSTC_BOOTSTRAP", "1")
        .status();
    ensure!(status.context("rustdoc")?.success(), "rustdoc failed");
    Ok(true)
}

/// Folders of the workspace.
pub(crate) struct Workspace {
    pub(crate) root: PathBuf,
    pub(crate) target: PathBuf,
}

impl Workspace {
    pub(crate) fn read() -> Result<Self> {
        let metadata = cargo()
            .args(["metadata", "--no-deps", "--format-version", "1"])
            .stderr(Stdio::inherit())
            .output()?;
        ensure!(metadata.status.success(), "cargo metadata failed");
        let metadata: serde_json::Value = serde_json::from_slice(&metadata.stdout)?;
        let path = |key: &str| metadata[key].as_str().map(PathBuf::from).context(key.to_owned());
        Ok(Self {
            root: path("workspace_root")?,
            target: path("target_directory")?,
        })
    }

    /// Writes the documentation of a library with all features as JSON and returns the file's path.
    fn document(&self, name: &str) -> Result<PathBuf> {
        let rustdoc = std::env::var_os("RUSTDOC").unwrap_or_else(|| OsString::from("rustdoc"));
        let status = cargo()
            .args([
                "rustdoc",
                "--quiet",
                "--package",
                name,
                "--lib",
                "--all-features",
                "--",
            ])
            .args([
                "-Z",
                "unstable-options",
                "--output-format",
                "json",
                "--cap-lints",
                "allow",
            ])
            .env("RUSTDOC", std::env::current_exe()?)
            .env(RUSTDOC, rustdoc)
            .current_dir(&self.root)
            .status()?;
        ensure!(status.success(), "cargo rustdoc --package {name} failed");
        Ok(self.target.join("doc").join(name).with_extension("json"))
    }
}

/// Derived and auto traits that are listed, the latter where a type lacks them.
const LISTED_IMPLS: [&str; 8] = [
    " core::clone::Clone for ",
    " core::cmp::",
    " core::default::Default for ",
    " core::fmt::Debug for ",
    " core::hash::Hash for ",
    " core::marker::Copy for ",
    " !core::marker::Send for ",
    " !core::marker::Sync for ",
];

/// Returns the public items, one per line. Omits blanket impls, the methods of derived traits and most auto traits.
fn listing(json: &Path) -> Result<String> {
    let text = fs::read_to_string(json)?;
    let format = serde_json::from_str::<serde_json::Value>(&text)?["format_version"].as_u64();
    ensure!(
        format == Some(FORMAT),
        "rustdoc wrote JSON of format {}, and the pinned public-api reads {FORMAT}; use the Rust version that CI uses, or \
         update `public-api` in Cargo.toml",
        format.map_or("unknown".to_owned(), |format| format.to_string())
    );
    let items = |with_derived: bool| {
        let api = Builder::from_rustdoc_json(json)
            .omit_blanket_impls(true)
            .omit_auto_trait_impls(!with_derived)
            .omit_auto_derived_impls(!with_derived)
            .build()?;
        anyhow::Ok(api.items().map(|item| item.to_string()).collect::<Vec<_>>())
    };
    let written: HashSet<String> = items(false)?.into_iter().collect();
    let mut lines = items(true)?;
    lines.retain(|line| {
        let is_listed = || LISTED_IMPLS.iter().any(|of| line.contains(of));
        written.contains(line) || line.starts_with("impl") && is_listed()
    });
    Ok(lines.join("\n") + "\n")
}

/// Prints the lines that only one listing has; enough to see a change, and moved lines are none.
fn print_differences(committed: &str, now: &str) {
    for (sign, lines, others) in [('-', committed, now), ('+', now, committed)] {
        let others: HashSet<&str> = others.lines().collect();
        for line in lines.lines().filter(|line| !others.contains(line)) {
            println!("{sign} {line}");
        }
    }
}
