//! Formats numbers and I/O errors for messages.

use std::io::{Error, ErrorKind};

/// Rounds a number to four significant digits.
pub(crate) fn short(number: f64) -> f64 {
    format!("{number:.3e}").parse().unwrap_or(number)
}

/// Formats a size, such as `12.3 MB`, in powers of a thousand.
pub(crate) fn bytes(number: u64) -> String {
    let (unit, name) = match number {
        1 => (1.0, "byte"),
        0..1_000 => (1.0, "bytes"),
        1_000..1_000_000 => (1e3, "kB"),
        1_000_000..1_000_000_000 => (1e6, "MB"),
        _ => (1e9, "GB"),
    };
    format!("{} {name}", short(number as f64 / unit))
}

/// Describes why a file cannot be read, and how to fix it.
pub(crate) fn unreadable(why: &Error) -> String {
    match why.kind() {
        ErrorKind::NotFound => "there is no such file; check its path".to_owned(),
        ErrorKind::PermissionDenied => {
            "permission is denied; change its permissions, or name a copy".to_owned()
        }
        ErrorKind::OutOfMemory => {
            "there is not enough memory; close other programs, or split the file".to_owned()
        }
        _ => format!("{why}; copy it to another disk and try again"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        let said = [0, 999, 12_345, 1_073_741_824, u64::MAX].map(bytes);
        assert_eq!(
            said,
            ["0 bytes", "999 bytes", "12.35 kB", "1.074 GB", "18450000000 GB"]
        );
        assert_eq!([-12.345678, 0.1, 3e38].map(short), [-12.35, 0.1, 3e38]);
    }
}
