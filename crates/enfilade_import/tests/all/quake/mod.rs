//! Files of portals and compiled maps: what is read, and what is refused.

mod ambient;
mod broken;
mod carved;
mod formats;
mod leaks;
mod light;
pub(crate) mod little;
mod located;
mod lumps;
mod maps;
mod outline;
mod rebuilt;
mod rebuilt_maps;
mod rewritten;
mod rooms;
mod rows;
mod sight;
mod spoilt;

use enfilade_import::{PortalFile, PrtError};

#[track_caller]
fn reads(text: &str) -> PortalFile {
    PortalFile::parse(text.as_bytes()).unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
fn refusal(text: &str) -> PrtError {
    match PortalFile::parse(text.as_bytes()) {
        Ok(_) => panic!("it is read: {text}"),
        Err(error) => error,
    }
}
