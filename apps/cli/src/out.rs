//! Prints reports on standard output, and notes, warnings and the error message on standard error.

use anyhow::{Context, Result};
use std::fmt::Display;
use std::io::{self, ErrorKind, Write};

/// Prints text on standard output.
pub(crate) fn print(text: &str) -> Result<()> {
    let mut stdout = io::stdout().lock();
    printed(
        stdout
            .write_all(without_controls(text).as_bytes())
            .and_then(|()| stdout.flush()),
    )
}

/// Converts the result of printing. A closed pipe (`| head`) is not an error.
pub(crate) fn printed(result: io::Result<()>) -> Result<()> {
    match result {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(error).context("cannot write to standard output")
        }
        _ => Ok(()),
    }
}

/// Prints a warning. Warnings do not change the exit code.
pub(crate) fn warn(text: impl Display) {
    note(format_args!("warning: {text}"));
}

/// Prints the error that ends the program.
pub(crate) fn error(error: &anyhow::Error) {
    let os = error.chain().find_map(|cause| cause.downcast_ref::<io::Error>());
    let step = os.map_or("", |why| next_step(why.kind()));
    note(format_args!("error: {error:#}{step}"));
}

/// Returns a remedy for an error of the operating system, whose own message names only the failure.
fn next_step(failure: ErrorKind) -> &'static str {
    match failure {
        ErrorKind::NotFound => "; check the path",
        ErrorKind::PermissionDenied => "; change its permissions, or name another file",
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "; free some space, or name a file on another disk"
        }
        ErrorKind::ReadOnlyFilesystem => "; name a file on another disk",
        ErrorKind::InvalidFilename => "; choose a shorter name",
        ErrorKind::FileTooLarge => "; name a file on a file system that allows larger ones",
        // Text that is not UTF-8 and the like: the message before it names the violated rule.
        ErrorKind::InvalidData | ErrorKind::InvalidInput => "",
        _ => "; check the disk and try again",
    }
}

/// Prints a line on standard error. Does nothing if that is closed.
pub(crate) fn note(text: impl Display) {
    let _ = writeln!(io::stderr().lock(), "{}", without_controls(&text.to_string()));
}

/// Replaces control characters, which names from files may contain and terminals interpret.
fn without_controls(text: &str) -> String {
    text.replace(|c: char| c.is_control() && c != '\n', "\u{FFFD}")
}
