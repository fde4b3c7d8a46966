//! Writes the header of the C interface from its crate, or compares the committed one with it.
#![allow(clippy::print_stdout, reason = "a command prints what it does")]

use crate::public_api::Workspace;
use anyhow::{Context, Result, anyhow, ensure};
use cbindgen::{Builder, Config};

const PATH: &str = "crates/enfilade_c/include/enfilade.h";

#[derive(clap::Args)]
pub(crate) struct Args {
    /// Compare, and write nothing
    #[arg(long)]
    check: bool,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let workspace = Workspace::read()?;
    if args.check {
        return compare(&workspace);
    }
    let header = header(&workspace)?;
    let path = workspace.root.join(PATH);
    std::fs::write(&path, &header).with_context(|| path.display().to_string())?;
    println!("enfilade.h: {} lines", header.lines().count());
    Ok(())
}

/// Returns an error if the committed header is not that of the crate.
pub(crate) fn compare(workspace: &Workspace) -> Result<()> {
    let committed = std::fs::read_to_string(workspace.root.join(PATH)).context(PATH)?;
    ensure!(
        committed.replace("\r\n", "\n") == header(workspace)?,
        "{PATH} is not that of the crate; run `cargo xtask header`, and describe the change in CHANGELOG.md"
    );
    println!("enfilade.h: unchanged, {} lines", committed.lines().count());
    Ok(())
}

/// Returns the header: what it says first, the first example as a comment, and what cbindgen writes.
fn header(workspace: &Workspace) -> Result<String> {
    let folder = workspace.root.join("crates/enfilade_c");
    let read = |name: &str| {
        let path = folder.join(name);
        std::fs::read_to_string(&path).with_context(|| path.display().to_string())
    };
    let mut config = Config::from_file(folder.join("cbindgen.toml")).map_err(|why| anyhow!("{why}"))?;
    let introduction = read("include/introduction.txt")?;
    let example = read("examples/first.c")?;
    let text = introduction.replace("EXAMPLE\n", &indented(&example));
    let comment = text
        .lines()
        .map(|line| format!("// {line}").trim_end().to_owned());
    config.header = Some(comment.collect::<Vec<_>>().join("\n"));
    // In the order in which a reader needs them.
    let sources = [
        "version",
        "status",
        "threads",
        "ids",
        "mesh",
        "scene",
        "items",
        "portals",
        "view",
        "viewer",
        "query",
        "occlusion",
        "rooms",
    ];
    let mut builder = Builder::new().with_config(config);
    for source in sources {
        builder = builder.with_src(folder.join(format!("src/{source}.rs")));
    }
    let mut written = Vec::new();
    builder.generate()?.write(&mut written);
    let header = String::from_utf8(written)?;
    let lines = header.lines().map(str::trim_end);
    Ok(lines.collect::<Vec<_>>().join("\n") + "\n")
}

fn indented(text: &str) -> String {
    text.lines()
        .map(|line| format!("    {line}").trim_end().to_owned() + "\n")
        .collect()
}
