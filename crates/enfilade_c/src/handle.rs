//! Handles: numbers in the shape of pointers, which nothing follows.
//!
//! A table knows which object each handle names. Numbers are not used twice, so a handle that is null, freed, of another type
//! or random is an error, never a crash. Each object has a lock that is only tried: a call that would have to wait for
//! another thread fails instead.

use crate::status::{EnfiladeStatus, Failure};
use std::any::Any;
use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock, RwLock, RwLockReadGuard, RwLockWriteGuard, TryLockError};

/// A type of handles.
pub(crate) trait Handle {
    /// What a handle names.
    type Object: Send + Sync + 'static;
    /// What messages call it.
    const NAME: &'static str;
}

/// An object that a call uses; stays until its end, even if it is freed meanwhile.
pub(crate) struct InUse<T> {
    object: Arc<RwLock<T>>,
    name: &'static str,
}

type Table = HashMap<usize, Arc<dyn Any + Send + Sync>>;

fn table() -> &'static RwLock<Table> {
    static TABLE: OnceLock<RwLock<Table>> = OnceLock::new();
    TABLE.get_or_init(RwLock::default)
}

/// Returns a new handle of an object.
pub(crate) fn create<H: Handle>(object: H::Object) -> Result<*mut H, Failure> {
    // Multiples of 16, as pointers mostly are.
    static NEXT: AtomicUsize = AtomicUsize::new(16);
    let next = |number: usize| number.checked_add(16);
    let number = NEXT.fetch_update(Ordering::Relaxed, Ordering::Relaxed, next);
    let number = number.map_err(|_| {
        Failure::new(
            EnfiladeStatus::TooLarge,
            "c/handles",
            "no handle is left; restart the program",
        )
    })?;
    let object: Arc<RwLock<H::Object>> = Arc::new(RwLock::new(object));
    // Nothing panics while the table is locked.
    let mut table = table().write().unwrap_or_else(|poisoned| poisoned.into_inner());
    table.insert(number, object);
    Ok(std::ptr::without_provenance_mut(number))
}

/// Returns the object of a handle.
pub(crate) fn find<H: Handle>(handle: *const H) -> Result<InUse<H::Object>, Failure> {
    if handle.is_null() {
        return Err(Failure::new(
            EnfiladeStatus::NullArgument,
            "c/null-argument",
            format_args!("the {} is null", H::NAME),
        ));
    }
    let table = table().read().unwrap_or_else(|poisoned| poisoned.into_inner());
    let object = table.get(&handle.addr()).cloned();
    drop(table);
    match object.and_then(|object| object.downcast().ok()) {
        Some(object) => Ok(InUse {
            object,
            name: H::NAME,
        }),
        None => Err(no_object::<H>()),
    }
}

/// Forgets a handle. Its object goes with the last call that uses it.
pub(crate) fn free<H: Handle>(handle: *mut H) -> Result<(), Failure> {
    if handle.is_null() {
        return Ok(());
    }
    let mut table = table().write().unwrap_or_else(|poisoned| poisoned.into_inner());
    let is_one = table
        .get(&handle.addr())
        .is_some_and(|object| object.is::<RwLock<H::Object>>());
    let object = is_one.then(|| table.remove(&handle.addr()));
    drop(table);
    // Dropped without the lock: it may take long.
    object.map(drop).ok_or_else(no_object::<H>)
}

fn no_object<H: Handle>() -> Failure {
    Failure::new(
        EnfiladeStatus::BadHandle,
        "c/bad-handle",
        format_args!("this is no handle of a {}, or it was freed", H::NAME),
    )
}

impl<T> InUse<T> {
    /// Returns the object, to be shared with other calls that only read.
    pub(crate) fn read(&self) -> Result<RwLockReadGuard<'_, T>, Failure> {
        self.object.try_read().map_err(|why| self.refusal(&why))
    }

    /// Returns the object, to change it.
    pub(crate) fn write(&self) -> Result<RwLockWriteGuard<'_, T>, Failure> {
        self.object.try_write().map_err(|why| self.refusal(&why))
    }

    fn refusal<G>(&self, why: &TryLockError<G>) -> Failure {
        let name = self.name;
        match why {
            TryLockError::WouldBlock => Failure::new(
                EnfiladeStatus::Busy,
                "c/busy",
                format_args!("another thread is using the {name}; calls that change it must be alone"),
            ),
            TryLockError::Poisoned(_) => Failure::new(
                EnfiladeStatus::Unusable,
                "c/unusable",
                format_args!("a call that changed the {name} failed half-way; free it"),
            ),
        }
    }
}
