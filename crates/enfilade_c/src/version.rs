//! Versions of the header and of the library.

use crate::status::{EnfiladeStatus, Failure};

/// Version of this header: 10000 x major + 100 x minor + patch. Functions that create an object take it, and compare it with
/// the library's.
pub const ENFILADE_VERSION: u32 = 100;

/// Returns the version of the library, as ENFILADE_VERSION is that of the header.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub extern "C" fn enfilade_version() -> u32 {
    ENFILADE_VERSION
}

/// Returns an error unless programs with this version of the header can use the library: before 1.0 the same minor version,
/// then the same major version and no later minor one.
pub(crate) fn check_version(header: u32) -> Result<(), Failure> {
    let [(major, minor), (own_major, own_minor)] =
        [header, ENFILADE_VERSION].map(|version| (version / 10_000, version / 100 % 100));
    let fits = major == own_major
        && if major == 0 {
            minor == own_minor
        } else {
            minor <= own_minor
        };
    if fits {
        return Ok(());
    }
    let name = |version: u32| format!("{}.{}.{}", version / 10_000, version / 100 % 100, version % 100);
    Err(Failure::new(
        EnfiladeStatus::WrongVersion,
        "c/wrong-version",
        format_args!(
            "the header is version {}, the library {}; compile with the header of the library",
            name(header),
            name(ENFILADE_VERSION)
        ),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_version_is_that_of_the_crate() {
        let numbers = env!("CARGO_PKG_VERSION")
            .split('.')
            .map(|number| number.parse::<u32>().expect("a number"));
        let version = numbers.fold(0, |sum, number| 100 * sum + number);
        assert_eq!(version, ENFILADE_VERSION);
        for (header, fits) in [
            (100, true),
            (199, true),
            (200, false),
            (0, false),
            (10_100, false),
        ] {
            assert_eq!(check_version(header).is_ok(), fits, "{header}");
        }
    }
}
