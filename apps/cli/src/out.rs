//! Printing: reports on standard output, warnings and the one error message on standard error.

use anyhow::{Context, Result};
use std::fmt::Display;
use std::io::{self, ErrorKind, Write};

/// Prints a text on standard output.
pub(crate) fn print(text: &str) -> Result<()> {
    let mut stdout = io::stdout().lock();
    printed(
        stdout
            .write_all(harmless(text).as_bytes())
            .and_then(|()| stdout.flush()),
    )
}

/// Says why printing failed. A reader that has gone away (`| head`) has what it wanted.
pub(crate) fn printed(result: io::Result<()>) -> Result<()> {
    match result {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(error).context("cannot write to standard output")
        }
        _ => Ok(()),
    }
}

/// Prints a warning, which changes no exit code.
pub(crate) fn warn(text: impl Display) {
    note(format_args!("warning: {text}"));
}

/// Prints why the program ends.
pub(crate) fn error(error: &anyhow::Error) {
    let os = error.chain().find_map(|cause| cause.downcast_ref::<io::Error>());
    let step = os.map_or("", |why| next_step(why.kind()));
    note(format_args!("error: {error:#}{step}"));
}

/// What to do about a failure of the operating system, which says only what failed.
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
        // Text that is not UTF-8 and the like: what goes before says which rule it breaks.
        ErrorKind::InvalidData | ErrorKind::InvalidInput => "",
        _ => "; check the disk and try again",
    }
}

/// Prints a line on standard error. Where that is closed there is nobody to tell.
pub(crate) fn note(text: impl Display) {
    let _ = writeln!(io::stderr().lock(), "{}", harmless(&text.to_string()));
}

/// Names come from files, and a terminal obeys control characters.
fn harmless(text: &str) -> String {
    text.replace(|c: char| c.is_control() && c != '\n', "\u{FFFD}")
}
