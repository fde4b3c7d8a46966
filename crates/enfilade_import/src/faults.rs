//! Collects the errors in rooms, portals and terrain of a file, so that its author sees all of them at once.

use crate::warning::{WarningKind, Warnings};
use crate::{AuthoringError, BrokenRule, ReadOptions};
use std::fmt;

/// All errors in the rooms, portals and terrain that the author marked. Displays as a single error, or as a list with
/// one error per line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AuthoringErrors {
    first: Vec<AuthoringError>,
    count: usize,
    of_portals: usize,
    of_terrain: usize,
}

/// Maximum number of stored errors: a hostile file could have more than fit in memory.
const MAX_KEPT: usize = 1000;
/// Maximum number of printed errors: one terminal page.
const MAX_PRINTED: usize = 20;

impl AuthoringErrors {
    /// Returns the errors in the order in which they were found; the first 1,000 if there are more.
    pub fn first(&self) -> &[AuthoringError] {
        &self.first
    }

    /// Returns the number of errors. Counts at most 20 pairs of overlapping rooms.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Returns `true` if [`ReadOptions::skip_bad_portals`] opens the file: all errors concern portals and mirrors.
    pub fn can_be_skipped(&self) -> bool {
        self.of_portals == self.count
    }

    /// Returns `true` if [`ReadOptions::flat`] opens the file: no error concerns terrain.
    pub fn flat_ignores_them(&self) -> bool {
        self.of_terrain == 0
    }

    fn push(&mut self, subject: Subject, error: AuthoringError) {
        self.count += 1;
        self.of_portals += usize::from(subject == Subject::Portal);
        self.of_terrain += usize::from(subject == Subject::Terrain);
        if self.first.len() < MAX_KEPT {
            self.first.push(error);
        }
    }
}

impl fmt::Display for AuthoringErrors {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if let [only] = &*self.first {
            return only.fmt(f);
        }
        write!(f, "{} errors in its rooms, portals or terrain:", self.count)?;
        for error in self.first.iter().take(MAX_PRINTED) {
            write!(f, "\n  {error}")?;
        }
        match self.count.saturating_sub(MAX_PRINTED) {
            0 => Ok(()),
            more => write!(f, "\n  and {more} more"),
        }
    }
}

/// The subject of an error; it decides which option opens the file nevertheless.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Subject {
    /// A portal or a mirror, which can be skipped.
    Portal,
    /// A terrain, which is also read in a flat file.
    Terrain,
    /// A room or any other mark.
    Room,
}

/// Collects authoring errors while a file is read; turns those that the options tolerate into warnings.
#[derive(Debug, Default)]
pub(crate) struct Faults {
    errors: AuthoringErrors,
    skips_portals: bool,
    flat: bool,
}

impl Faults {
    pub(crate) fn new(options: &ReadOptions) -> Faults {
        Faults {
            errors: AuthoringErrors::default(),
            skips_portals: options.skip_bad_portals,
            flat: options.flat,
        }
    }

    /// Returns `true` if invalid portals are skipped; later stages must then cope without them.
    pub(crate) fn skips_portals(&self) -> bool {
        self.skips_portals
    }

    /// Records an error, or a warning if the options tolerate it.
    pub(crate) fn report(&mut self, subject: Subject, error: AuthoringError, warnings: &mut Warnings) {
        match subject {
            Subject::Portal | Subject::Room if self.flat => {
                warnings.name(WarningKind::IgnoredMarks, || error.to_string());
            }
            Subject::Portal if self.skips_portals => warnings.skipped_portal(&error),
            _ => self.errors.push(subject, error),
        }
    }

    /// Returns all recorded errors.
    ///
    /// # Errors
    /// [`BrokenRule::Authoring`] if any error was recorded.
    pub(crate) fn into_result(self) -> Result<(), BrokenRule> {
        if self.errors.count == 0 {
            return Ok(());
        }
        Err(BrokenRule::Authoring(Box::new(self.errors)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(subjects: impl IntoIterator<Item = Subject>) -> AuthoringErrors {
        let mut errors = AuthoringErrors::default();
        for (number, subject) in subjects.into_iter().enumerate() {
            let node = format!("node {number}");
            errors.push(subject, AuthoringError::TouchesNoRoom { node });
        }
        errors
    }

    #[test]
    fn one_error_is_a_line_and_many_are_a_bounded_list() {
        assert!(found([Subject::Room]).to_string().starts_with("node 0 touches"));
        let many = found([Subject::Portal; 5000]);
        assert_eq!((many.count(), many.first().len()), (5000, MAX_KEPT));
        let text = many.to_string();
        assert!(text.starts_with("5000 errors in its"), "{text}");
        assert_eq!(text.lines().count(), 1 + MAX_PRINTED + 1);
        assert!(text.ends_with("\n  and 4980 more"), "{text}");
        assert_eq!(found([Subject::Portal; 20]).to_string().lines().count(), 21);
    }

    #[test]
    fn what_the_options_ignore_depends_on_what_the_errors_are_about() {
        use Subject::{Portal, Room, Terrain};
        for (subjects, can_be_skipped, flat_ignores_them) in [
            (&[Portal, Portal][..], true, true),
            (&[Portal, Room], false, true),
            (&[Portal, Terrain], false, false),
        ] {
            let errors = found(subjects.iter().copied());
            assert_eq!(errors.can_be_skipped(), can_be_skipped, "{subjects:?}");
            assert_eq!(errors.flat_ignores_them(), flat_ignores_them, "{subjects:?}");
        }
    }
}
