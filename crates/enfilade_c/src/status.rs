//! Outcomes of calls: codes, messages, and the border that no panic crosses.

use crate::lent::Caller;
use crate::threads;
use enfilade::geom::PolygonError;
use enfilade::{EditError, MeshError, OccluderMeshError, SceneError, Unsuited, UnsuitedMethod, ViewError};
use std::any::Any;
use std::ffi::c_char;
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Outcome of a call. Each function returns one, and leaves its results 0 and the objects unchanged unless it says otherwise.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnfiladeStatus {
    /// The call succeeded.
    Ok = 0,
    /// A pointer is null that must not be.
    NullArgument = 1,
    /// A handle names no object of its type: it was freed, or never was one.
    BadHandle = 2,
    /// An id names nothing: it was removed, or is of another object.
    NoSuchId = 3,
    /// A number, a count, a stride, a flag or a text is invalid.
    BadArgument = 4,
    /// Positions or indices of a mesh or an outline break a rule.
    BadMesh = 5,
    /// A matrix, a camera or a viewport breaks a rule.
    BadView = 6,
    /// A portal, a method or a room breaks a rule of scenes.
    BadScene = 7,
    /// A file cannot be read, or breaks a rule of its format.
    BadFile = 8,
    /// More memory would be needed than the limit.
    TooLarge = 9,
    /// The array for results is too short. It holds as many as it has room for, and the count is that of all.
    BufferTooSmall = 10,
    /// The header that the caller was compiled with is not that of the library.
    WrongVersion = 11,
    /// Another thread is using the object, and a call that changes an object must be alone.
    Busy = 12,
    /// An earlier call on this object returned ENFILADE_STATUS_PANIC. It can only be freed.
    Unusable = 13,
    /// A fault in the library. Please report it with the message.
    Panic = 14,
}

/// What went wrong: filled in by each call that is given one, also if nothing did.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladeError {
    /// As the call returned it.
    pub status: EnfiladeStatus,
    /// Always 0.
    pub reserved: u32,
    /// Index of what was refused in the array that was passed (of the first, if several were), or ENFILADE_NO_INDEX.
    pub index: u64,
    /// Stable code of the broken rule, such as `mesh/index-out-of-range`; ends with a null character. Empty on success.
    pub code: [c_char; 48],
    /// The message: UTF-8, cut to fit, ends with a null character. Empty on success.
    pub message: [c_char; 448],
}

/// Value of `index` in an EnfiladeError that is about no element of an array.
pub const ENFILADE_NO_INDEX: u64 = u64::MAX;

/// Why a call failed.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) status: EnfiladeStatus,
    code: &'static str,
    message: String,
    index: u64,
}

impl Failure {
    pub(crate) fn new(status: EnfiladeStatus, code: &'static str, message: impl Display) -> Failure {
        Failure {
            status,
            code,
            message: message.to_string(),
            index: ENFILADE_NO_INDEX,
        }
    }

    /// Names the element that was refused.
    pub(crate) fn at(self, index: usize) -> Failure {
        Failure {
            index: index as u64,
            ..self
        }
    }
}

/// Returns the failure of an invalid argument.
pub(crate) fn refuse(code: &'static str, message: impl Display) -> Failure {
    Failure::new(EnfiladeStatus::BadArgument, code, message)
}

/// Returns an error unless all numbers are finite.
pub(crate) fn check_finite(name: &str, numbers: &[impl Copy + Into<f64>]) -> Result<(), Failure> {
    if numbers.iter().all(|&number| number.into().is_finite()) {
        return Ok(());
    }
    Err(refuse("c/not-finite", format_args!("{name} is not finite")))
}

impl<'a> Caller<'a> {
    /// Runs the body of a call, and returns and reports its outcome to `error`, if that is not null.
    pub(crate) fn call(
        self,
        error: *mut EnfiladeError,
        body: impl FnOnce(&Caller<'a>) -> Result<(), Failure>,
    ) -> EnfiladeStatus {
        // What a panic leaves of an object is behind its lock, which then refuses all further calls.
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            threads::start_none();
            body(&self)
        }));
        let failure = match outcome {
            Ok(Ok(())) => None,
            Ok(Err(failure)) => Some(failure),
            Err(panic) => Some(of_panic(panic)),
        };
        if let Some(error) = self.maybe_out(error) {
            error.set(EnfiladeError::of(failure.as_ref()));
        }
        failure.map_or(EnfiladeStatus::Ok, |failure| failure.status)
    }
}

/// As [`Caller::call`], for calls without pointers.
pub(crate) fn border(call: impl FnOnce() -> Result<(), Failure>) -> EnfiladeStatus {
    match catch_unwind(AssertUnwindSafe(call)) {
        Ok(outcome) => outcome.map_or_else(|failure| failure.status, |()| EnfiladeStatus::Ok),
        Err(_) => EnfiladeStatus::Panic,
    }
}

fn of_panic(panic: Box<dyn Any + Send>) -> Failure {
    let message = (panic.downcast_ref::<&str>().copied())
        .or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no message")
        .to_owned();
    // A value that panics when it is dropped must not do so across the border.
    std::mem::forget(panic);
    Failure::new(EnfiladeStatus::Panic, "c/panic", message)
}

impl EnfiladeError {
    fn of(failure: Option<&Failure>) -> EnfiladeError {
        let (code, message) = failure.map_or(("", ""), |failure| (failure.code, &failure.message));
        EnfiladeError {
            status: failure.map_or(EnfiladeStatus::Ok, |failure| failure.status),
            reserved: 0,
            index: failure.map_or(ENFILADE_NO_INDEX, |failure| failure.index),
            code: characters(code),
            message: characters(message),
        }
    }
}

/// Returns a text with a null byte at its end, cut between two characters if it is too long.
pub(crate) fn characters<const N: usize>(text: &str) -> [c_char; N] {
    let mut characters = [0; N];
    let end = text.floor_char_boundary_below(N);
    for (to, &byte) in characters.iter_mut().zip(&text.as_bytes()[..end]) {
        *to = byte as c_char;
    }
    characters
}

trait Cut {
    /// Returns the largest length below `limit` that ends between two characters.
    fn floor_char_boundary_below(&self, limit: usize) -> usize;
}

impl Cut for str {
    fn floor_char_boundary_below(&self, limit: usize) -> usize {
        let longest = self.len().min(limit.saturating_sub(1));
        let boundary = (0..=longest).rev().find(|&end| self.is_char_boundary(end));
        boundary.unwrap_or(0)
    }
}

impl From<MeshError> for Failure {
    fn from(why: MeshError) -> Failure {
        let part = match why {
            MeshError::NotFinite { part, .. }
            | MeshError::TooFar { part, .. }
            | MeshError::IndexOutOfRange { part, .. }
            | MeshError::ShortStride { part, .. }
            | MeshError::CornersLeft { part, .. }
            | MeshError::BadFace { part, .. } => Some(part),
            _ => None,
        };
        let failure = Failure::new(EnfiladeStatus::BadMesh, why.code(), &why);
        match part {
            Some(part) => failure.at(part),
            None => failure,
        }
    }
}

impl From<OccluderMeshError> for Failure {
    fn from(why: OccluderMeshError) -> Failure {
        let failure = Failure::new(EnfiladeStatus::BadMesh, why.code(), why);
        match why {
            OccluderMeshError::IndexOutOfRange { triangle, .. }
            | OccluderMeshError::NotFinite { triangle, .. } => failure.at(triangle),
            _ => failure,
        }
    }
}

impl From<PolygonError> for Failure {
    fn from(why: PolygonError) -> Failure {
        let failure = Failure::new(EnfiladeStatus::BadMesh, why.code(), why);
        match why {
            PolygonError::NotFinite(corner)
            | PolygonError::TooFar(corner)
            | PolygonError::NotFlat { corner, .. }
            | PolygonError::NotConvex(corner) => failure.at(corner),
            _ => failure,
        }
    }
}

impl From<ViewError> for Failure {
    fn from(why: ViewError) -> Failure {
        Failure::new(EnfiladeStatus::BadView, why.code(), why)
    }
}

impl From<EditError> for Failure {
    fn from(why: EditError) -> Failure {
        let status = match why {
            EditError::NoSuchItem { .. } | EditError::NoSuchSector { .. } | EditError::RemovedSector(_) => {
                EnfiladeStatus::NoSuchId
            }
            EditError::CustomSector(_) | EditError::TooManyOpenings(_) => EnfiladeStatus::BadScene,
            _ => EnfiladeStatus::BadArgument,
        };
        Failure::new(status, why.code(), why)
    }
}

impl From<SceneError> for Failure {
    fn from(why: SceneError) -> Failure {
        let (status, code) = match &why {
            SceneError::Unsuited { why, .. } => (status_of(why), why.reason.code()),
            SceneError::NoSuchSector { .. }
            | SceneError::RemovedSector(_)
            | SceneError::RemovedPortal(_)
            | SceneError::NoSuchOpening { .. } => (EnfiladeStatus::NoSuchId, why.code()),
            _ => (EnfiladeStatus::BadScene, why.code()),
        };
        Failure::new(status, code, why)
    }
}

impl From<UnsuitedMethod> for Failure {
    fn from(why: UnsuitedMethod) -> Failure {
        Failure::new(status_of(&why), why.reason.code(), why)
    }
}

fn status_of(why: &UnsuitedMethod) -> EnfiladeStatus {
    match why.reason {
        Unsuited::TooLarge { .. } => EnfiladeStatus::TooLarge,
        _ => EnfiladeStatus::BadScene,
    }
}

#[cfg(test)]
#[allow(unsafe_code, reason = "calls as C does")]
mod tests {
    use super::*;
    use crate::handle::{self, Handle};
    use std::ffi::CStr;

    struct Counter;

    impl Handle for Counter {
        type Object = u32;
        const NAME: &'static str = "counter";
    }

    /// Calls, and returns the status, the code and the message.
    fn called(body: impl FnOnce() -> Result<(), Failure>) -> (EnfiladeStatus, String, String) {
        let mut error = EnfiladeError::of(None);
        // SAFETY: nothing but the error is followed.
        let status = unsafe { Caller::new() }.call(&mut error, |_| body());
        assert_eq!(error.status, status);
        // SAFETY: both end with a null byte.
        let [code, message] = [&error.code[..], &error.message[..]]
            .map(|text| unsafe { CStr::from_ptr(text.as_ptr()).to_str().expect("UTF-8").to_owned() });
        (status, code, message)
    }

    #[test]
    fn a_panic_in_a_change_leaves_an_object_that_can_only_be_freed() {
        let counter = handle::create::<Counter>(0).expect("a handle");
        let (status, code, message) = called(|| {
            let counter = handle::find(counter)?;
            let mut counter = counter.write()?;
            *counter += 1;
            panic!("a fault at {}", *counter)
        });
        let expected = (EnfiladeStatus::Panic, "c/panic", "a fault at 1");
        assert_eq!((status, &*code, &*message), expected);
        let (status, ..) = called(|| handle::find(counter)?.read().map(|_| ()));
        assert_eq!(status, EnfiladeStatus::Unusable);
        let [first, second] = [(); 2].map(|()| border(|| handle::free(counter)));
        assert_eq!([first, second], [EnfiladeStatus::Ok, EnfiladeStatus::BadHandle]);
    }

    #[test]
    fn a_call_that_would_have_to_wait_is_refused() {
        let counter = handle::create::<Counter>(0).expect("a handle");
        let found = handle::find(counter).expect("it is there");
        let reading = found.read().expect("nobody writes");
        assert_eq!(
            called(|| handle::find(counter)?.read().map(|_| ())).0,
            EnfiladeStatus::Ok
        );
        let (status, code, _) = called(|| handle::find(counter)?.write().map(|_| ()));
        assert_eq!((status, &*code), (EnfiladeStatus::Busy, "c/busy"));
        drop(reading);
        let (status, code, message) = called(|| handle::find(counter)?.write().map(|_| ()));
        assert_eq!((status, &*code, &*message), (EnfiladeStatus::Ok, "", ""));
        // An object that is in use stays until the end of the call.
        let writing = found.write().expect("nobody else");
        assert_eq!(border(|| handle::free(counter)), EnfiladeStatus::Ok);
        assert_eq!(*writing, 0);
    }

    #[test]
    fn a_long_message_is_cut_between_characters() {
        let long = "ü".repeat(400);
        let (_, _, message) = called(|| Err(refuse("c/long", &long)));
        assert_eq!(message, "ü".repeat(223));
    }
}
