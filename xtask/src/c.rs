//! Builds and installs the C interface, and runs its examples in C, C++ and Python under memory checkers.
#![allow(clippy::print_stdout, reason = "a command prints what it does")]

use crate::header;
use crate::public_api::Workspace;
use crate::targets::{cargo, succeed};
use anyhow::{Context, Result, bail, ensure};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

#[derive(clap::Args)]
pub(crate) struct Args {
    /// Only what CI has time for: the header, and two C examples under AddressSanitizer
    #[arg(long)]
    quick: bool,
    /// Take the debug library as it was built with the whole workspace
    #[arg(long, requires = "quick")]
    as_built: bool,
}

#[derive(clap::Args)]
pub(crate) struct InstallArgs {
    /// Folder to install to: gets include/enfilade.h, the libraries, and the files for CMake and pkg-config
    prefix: PathBuf,
}

/// Where examples and tests are, from the root of the workspace.
const EXAMPLES: &str = "crates/enfilade_c/examples";

/// A small file with rooms, portals and cameras.
const SCENE: &str = "crates/enfilade_scenes/src/palace.glb";

/// What the first example prints.
const FIRST: &str = "item 0 is visible\nitem 1 is hidden\n";

/// What rustc says that its libraries need: `rustc --print native-static-libs`.
const NEEDED: &str = "-lgcc_s -lutil -lrt -lpthread -lm -ldl -lc";

const WARNINGS: [&str; 4] = ["-Wall", "-Wextra", "-pedantic", "-Werror"];

pub(crate) fn run(args: &Args) -> Result<()> {
    let workspace = Workspace::read()?;
    header::compare(&workspace)?;
    if args.quick {
        if !args.as_built {
            run_cargo(&workspace, &["build", "--package", "enfilade_c"])?;
        }
        return sanitized(&workspace, "debug");
    }
    find_programs(&["cmake", "pkg-config", "valgrind", "python3", "c++"])?;
    run_cargo(&workspace, &["build", "--release", "--package", "enfilade_c"])?;
    sanitized(&workspace, "release")?;
    let folder = workspace.target.join("c");
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    let prefix = folder.join("installed");
    install_to(&workspace, &prefix)?;
    by_pkg_config(&workspace, &folder, &prefix)?;
    by_cmake(&workspace, &folder, &prefix)?;
    under_valgrind(&workspace, &folder)?;
    in_python(&workspace, &prefix)?;
    with_another_version(&workspace, &folder, &prefix)?;
    let fuzz = [
        "run",
        "--release",
        "--package",
        "enfilade_c",
        "--example",
        "fuzz",
        "--",
        "60",
        "1",
    ];
    run_cargo(&workspace, &fuzz)?;
    println!("the C interface passes");
    Ok(())
}

pub(crate) fn install(args: &InstallArgs) -> Result<()> {
    let workspace = Workspace::read()?;
    let prefix = std::path::absolute(&args.prefix)?;
    install_to(&workspace, &prefix)?;
    println!(
        "installed to {0}; compile with PKG_CONFIG_PATH={0}/lib/pkgconfig and pkg-config enfilade, or with \
         CMAKE_PREFIX_PATH={0} and find_package(enfilade); where the system does not look for libraries there, run \
         programs with LD_LIBRARY_PATH={0}/lib, or as root run ldconfig once",
        prefix.display()
    );
    Ok(())
}

/// Builds the libraries optimized, and copies what programs need to a folder.
fn install_to(workspace: &Workspace, prefix: &Path) -> Result<()> {
    let version = env!("CARGO_PKG_VERSION");
    let minor = version.rsplit_once('.').map_or(version, |(minor, _)| minor);
    let soname = format!("libenfilade_c.so.{minor}");
    let build = |kind: &str, flags: &[&str]| {
        let first = [
            "rustc",
            "--release",
            "--package",
            "enfilade_c",
            "--lib",
            "--crate-type",
            kind,
            "--",
        ];
        run_cargo(workspace, &[&first, flags].concat())
    };
    build("staticlib", &[])?;
    let is_elf = cfg!(all(unix, not(target_vendor = "apple")));
    let link = format!("-Clink-arg=-Wl,-soname,{soname}");
    let flags = [&*link];
    build("cdylib", if is_elf { &flags } else { &[] })?;
    let lib = prefix.join("lib");
    for folder in ["include", "lib/pkgconfig", "lib/cmake/enfilade"] {
        fs::create_dir_all(prefix.join(folder))?;
    }
    let built = workspace.target.join("release");
    let names: &[&str] = if cfg!(windows) {
        &["enfilade_c.lib", "enfilade_c.dll", "enfilade_c.dll.lib"]
    } else if cfg!(target_vendor = "apple") {
        &["libenfilade_c.a", "libenfilade_c.dylib"]
    } else {
        &["libenfilade_c.a", "libenfilade_c.so"]
    };
    for name in names {
        let to = lib.join(name);
        // A link of an earlier installation must not be followed.
        let _ = fs::remove_file(&to);
        fs::copy(built.join(name), &to).with_context(|| to.display().to_string())?;
    }
    #[cfg(unix)]
    if is_elf {
        let file = format!("libenfilade_c.so.{version}");
        fs::rename(lib.join("libenfilade_c.so"), lib.join(&file))?;
        for link in [&*soname, "libenfilade_c.so"] {
            let _ = fs::remove_file(lib.join(link));
            std::os::unix::fs::symlink(&file, lib.join(link))?;
        }
        // Programs that are linked with the library as Cargo built it look for that name, too.
        let _ = fs::remove_file(built.join(&soname));
        std::os::unix::fs::symlink("libenfilade_c.so", built.join(&soname))?;
    }
    let source = workspace.root.join("crates/enfilade_c");
    fs::copy(
        source.join("include/enfilade.h"),
        prefix.join("include/enfilade.h"),
    )?;
    let fill = |name: &str, to: &str| -> Result<()> {
        let text = fs::read_to_string(source.join("cmake").join(name)).with_context(|| name.to_owned())?;
        let needed = if is_elf { NEEDED } else { "" };
        let text = text.replace("@VERSION@", version).replace("@NEEDED@", needed);
        fs::write(prefix.join(to), text).with_context(|| to.to_owned())
    };
    fill("enfilade.pc.in", "lib/pkgconfig/enfilade.pc")?;
    fill(
        "enfilade-config.cmake.in",
        "lib/cmake/enfilade/enfilade-config.cmake",
    )?;
    fill(
        "enfilade-config-version.cmake.in",
        "lib/cmake/enfilade/enfilade-config-version.cmake",
    )
}

/// Compiles both C examples with AddressSanitizer and UndefinedBehaviorSanitizer, and runs them.
fn sanitized(workspace: &Workspace, profile: &str) -> Result<()> {
    find_programs(&["cc"])?;
    let folder = workspace.target.join("c-sanitized");
    fs::create_dir_all(&folder)?;
    let library = workspace.target.join(profile).join("libenfilade_c.a");
    ensure!(
        library.is_file(),
        "{} is missing; build enfilade_c first",
        library.display()
    );
    for name in ["first", "tour"] {
        let program = folder.join(name);
        succeed(
            compiler(workspace, "cc", "c11")
                .args([
                    "-g",
                    "-O1",
                    "-fsanitize=address,undefined",
                    "-fno-sanitize-recover=all",
                ])
                .arg("-I")
                .arg(workspace.root.join("crates/enfilade_c/include"))
                .arg(format!("{EXAMPLES}/{name}.c"))
                .arg(&library)
                .args(NEEDED.split(' '))
                .arg("-o")
                .arg(&program),
        )?;
        check_example(workspace, name, Command::new(&program))?;
    }
    println!("the examples in C pass under AddressSanitizer");
    Ok(())
}

/// Compiles the first example by what pkg-config says, for the shared and for the static library.
fn by_pkg_config(workspace: &Workspace, folder: &Path, prefix: &Path) -> Result<()> {
    for (name, flags) in [
        ("shared", &["--cflags", "--libs"][..]),
        ("static", &["--cflags", "--libs", "--static"]),
    ] {
        let found = Command::new("pkg-config")
            .args(flags)
            .arg("enfilade")
            .env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig"))
            .stderr(Stdio::inherit())
            .output()?;
        ensure!(found.status.success(), "pkg-config does not know enfilade");
        let mut found = String::from_utf8(found.stdout)?;
        if name == "static" {
            found = found.replace("-lenfilade_c", "-l:libenfilade_c.a");
        }
        let program = folder.join(format!("first-{name}"));
        succeed(
            compiler(workspace, "cc", "c11")
                .arg(format!("{EXAMPLES}/first.c"))
                .args(found.split_whitespace())
                .arg("-o")
                .arg(&program),
        )?;
        let mut command = Command::new(&program);
        if name == "shared" {
            command.env("LD_LIBRARY_PATH", prefix.join("lib"));
        }
        check_example(workspace, "first", command)?;
        println!("pkg-config, {name} library: passes");
    }
    Ok(())
}

/// Builds the project of examples, in C and C++, and runs them.
fn by_cmake(workspace: &Workspace, folder: &Path, prefix: &Path) -> Result<()> {
    for kind in ["shared", "static"] {
        let build = folder.join(format!("cmake-{kind}"));
        succeed(
            Command::new("cmake")
                .arg("-S")
                .arg(workspace.root.join(EXAMPLES))
                .arg("-B")
                .arg(&build)
                .arg(format!("-DCMAKE_PREFIX_PATH={}", prefix.display()))
                .arg(format!("-DENFILADE_LIBRARY={kind}"))
                .arg("-DCMAKE_BUILD_TYPE=RelWithDebInfo"),
        )?;
        succeed(Command::new("cmake").arg("--build").arg(&build))?;
        for name in ["first", "tour", "scene"] {
            check_example(workspace, name, Command::new(build.join(name)))?;
        }
        println!("CMake, {kind} library: the examples in C and C++ pass");
    }
    Ok(())
}

/// Runs the examples in C and C++ under valgrind, with the debug library: optimized code may read a field that is not set before
/// it finds that it does not count, which valgrind takes for an error.
fn under_valgrind(workspace: &Workspace, folder: &Path) -> Result<()> {
    run_cargo(workspace, &["build", "--package", "enfilade_c"])?;
    let examples = [
        ("first", "first.c", "cc", "c11"),
        ("tour", "tour.c", "cc", "c11"),
        ("scene", "scene.cpp", "c++", "c++17"),
    ];
    for (name, file, program, standard) in examples {
        let built = folder.join(format!("{name}-for-valgrind"));
        succeed(
            compiler(workspace, program, standard)
                .arg("-g")
                .arg("-I")
                .arg(workspace.root.join("crates/enfilade_c/include"))
                .arg(format!("{EXAMPLES}/{file}"))
                .arg(workspace.target.join("debug/libenfilade_c.a"))
                .args(NEEDED.split(' '))
                .arg("-o")
                .arg(&built),
        )?;
        let mut valgrind = Command::new("valgrind");
        valgrind
            .args(["--quiet", "--error-exitcode=9", "--leak-check=full"])
            .args(["--errors-for-leak-kinds=definite", "--show-leak-kinds=definite"])
            .arg(format!(
                "--suppressions={}",
                workspace.root.join(EXAMPLES).join("valgrind.supp").display()
            ))
            .arg(built);
        // Without the file: valgrind takes minutes to read it.
        check_output(name, &mut valgrind)?;
        println!("valgrind: {file} passes");
    }
    Ok(())
}

fn in_python(workspace: &Workspace, prefix: &Path) -> Result<()> {
    let mut python = Command::new("python3");
    python
        .arg(workspace.root.join(EXAMPLES).join("look.py"))
        .arg(prefix.join("lib/libenfilade_c.so"));
    check_output("look.py", &mut python)?;
    println!("the example in Python passes");
    Ok(())
}

/// Compiles the first example with a header of another version, and expects an error when it runs.
fn with_another_version(workspace: &Workspace, folder: &Path, prefix: &Path) -> Result<()> {
    let header = fs::read_to_string(prefix.join("include/enfilade.h"))?;
    let other = header.replace("#define ENFILADE_VERSION 100", "#define ENFILADE_VERSION 200");
    ensure!(
        other != header,
        "enfilade.h does not define its version as expected"
    );
    let include = folder.join("other-version");
    fs::create_dir_all(&include)?;
    fs::write(include.join("enfilade.h"), other)?;
    let program = folder.join("first-of-other-version");
    succeed(
        compiler(workspace, "cc", "c11")
            .arg("-I")
            .arg(&include)
            .arg(format!("{EXAMPLES}/first.c"))
            .arg(prefix.join("lib/libenfilade_c.a"))
            .args(NEEDED.split(' '))
            .arg("-o")
            .arg(&program),
    )?;
    let output = Command::new(&program).output()?;
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    ensure!(
        output.status.code() == Some(1)
            && message.starts_with("c/wrong-version: the header is version 0.2.0"),
        "a program with another header ended with {} and said: {message}",
        output.status
    );
    println!("another version of the header: refused");
    Ok(())
}

fn compiler(workspace: &Workspace, program: &str, standard: &str) -> Command {
    let mut command = Command::new(program);
    command
        .arg(format!("-std={standard}"))
        .args(WARNINGS)
        .current_dir(&workspace.root);
    command
}

/// Runs an example, the tour with a file to read, and checks what it prints.
fn check_example(workspace: &Workspace, name: &str, mut command: Command) -> Result<()> {
    if name == "tour" {
        command.arg(workspace.root.join(SCENE));
    }
    check_output(name, &mut command)
}

fn check_output(name: &str, command: &mut Command) -> Result<()> {
    let output = command.stderr(Stdio::inherit()).output();
    let output = output.with_context(|| format!("{command:?}"))?;
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    let is_right = match name {
        "first" => printed == FIRST,
        "tour" => printed.ends_with("the tour is complete\n"),
        _ => printed.contains("visible"),
    };
    if output.status.success() && is_right {
        return Ok(());
    }
    bail!("{command:?} ended with {} and printed:\n{printed}", output.status)
}

fn run_cargo(workspace: &Workspace, arguments: &[&str]) -> Result<()> {
    succeed(cargo().args(arguments).current_dir(&workspace.root))
}

fn find_programs(programs: &[&str]) -> Result<()> {
    let is_there = |program: &&&str| {
        let mut command = Command::new(program);
        let command = command.arg("--version").stdout(Stdio::null());
        command.stderr(Stdio::null()).status().is_ok()
    };
    let missing: Vec<&str> = programs
        .iter()
        .filter(|program| !is_there(program))
        .copied()
        .collect();
    ensure!(
        missing.is_empty(),
        "{} not found: install Debian's packages gcc, g++, cmake, pkg-config, valgrind and python3, or the like",
        missing.join(", ")
    );
    Ok(())
}
