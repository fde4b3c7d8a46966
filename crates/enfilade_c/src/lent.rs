//! Arguments of C: the only place that follows pointers.
//!
//! A [`Caller`] stands for the promise of one call, that its pointers are what the header says. All reads are unaligned and
//! copy, so nothing is assumed of a pointer but that the bytes are there; null, overflow and short strides are errors.
#![allow(unsafe_code, reason = "pointers of C are followed here, and nowhere else")]

use crate::status::{EnfiladeStatus, Failure, refuse};
use std::ffi::{CStr, c_char};
use std::marker::PhantomData;

/// Types for which all bytes are a valid value: numbers, raw pointers, and structs of them.
///
/// # Safety
/// `Self` is `Copy`, and valid for any bytes.
pub(crate) unsafe trait Plain: Copy {}

macro_rules! plain {
    ($($of:ty),+ $(,)?) => {
        // SAFETY: numbers and raw pointers, or `repr(C)` structs of them alone.
        $(unsafe impl Plain for $of {})+
    };
}
plain!(
    u8,
    u16,
    u32,
    u64,
    f32,
    f64,
    [f32; 3],
    [f32; 4],
    [f32; 6],
    [f32; 16],
    [f64; 3],
    [f64; 16],
    crate::items::EnfiladeItem,
    crate::items::EnfiladeItemOptions,
    crate::mesh::EnfiladeMeshPart,
    crate::query::EnfiladeCapsule,
    crate::query::EnfiladeLocation,
    crate::rooms::EnfiladeRoomOptions,
    crate::scene::EnfiladeMaterial,
    crate::scene::EnfiladeReadOptions,
    crate::view::EnfiladeCamera,
    crate::view::EnfiladeView,
    crate::viewer::EnfiladeDrawOptions,
    crate::viewer::EnfiladeViewerOptions,
);

/// Largest number of elements of an array.
const MOST: usize = u32::MAX as usize;

/// The promise of a C caller about the pointers of one call.
pub(crate) struct Caller<'a>(PhantomData<&'a ()>);

/// An array of the caller: elements `stride` bytes apart.
#[derive(Clone, Copy)]
pub(crate) struct List<'a, T> {
    first: *const u8,
    stride: usize,
    count: usize,
    lent: PhantomData<&'a T>,
}

/// Where a result goes.
pub(crate) struct Out<'a, T> {
    to: *mut T,
    lent: PhantomData<&'a mut T>,
}

/// An array of the caller that takes results, and the number that it takes.
pub(crate) struct Buffer<'a, T> {
    to: *mut T,
    capacity: usize,
    count: Out<'a, usize>,
}

impl<'a> Caller<'a> {
    /// Begins a call.
    ///
    /// # Safety
    /// Until the end of `'a`, each pointer that is passed to a method is null or points to as many elements as the method says,
    /// to write to if it writes, which nobody else accesses at the same time.
    pub(crate) unsafe fn new() -> Caller<'a> {
        Caller(PhantomData)
    }

    /// Reads a value.
    pub(crate) fn one<T: Plain>(&self, from: *const T, name: &str) -> Result<T, Failure> {
        self.maybe(from).ok_or_else(|| null(name))
    }

    /// Reads a value; `None` for null.
    pub(crate) fn maybe<T: Plain>(&self, from: *const T) -> Option<T> {
        // SAFETY: not null, so there is a value, by the promise of the caller; any bytes are one.
        (!from.is_null()).then(|| unsafe { from.read_unaligned() })
    }

    /// Reads `N` numbers.
    pub(crate) fn numbers<T: Plain, const N: usize>(
        &self,
        from: *const T,
        name: &str,
    ) -> Result<[T; N], Failure>
    where
        [T; N]: Plain,
    {
        self.one(from.cast(), name)
    }

    /// Borrows an array of `count` elements, `stride` bytes apart; 0 for one right after the other.
    pub(crate) fn list<T: Plain>(
        &self,
        first: *const T,
        stride: usize,
        count: usize,
        name: &str,
    ) -> Result<List<'a, T>, Failure> {
        let stride = if stride == 0 { size_of::<T>() } else { stride };
        if stride < size_of::<T>() {
            return Err(refuse(
                "c/short-stride",
                format_args!(
                    "{name} has a stride of {stride} bytes; its elements have {}",
                    size_of::<T>()
                ),
            ));
        }
        self.check_span(first.cast(), stride, count, name)?;
        Ok(List {
            first: first.cast(),
            stride,
            count,
            lent: PhantomData,
        })
    }

    /// Borrows aligned elements, one right after the other.
    pub(crate) fn slice<T: Plain>(
        &self,
        first: *const T,
        count: usize,
        name: &str,
    ) -> Result<&'a [T], Failure> {
        self.check_span(first.cast(), size_of::<T>(), count, name)?;
        if count == 0 {
            return Ok(&[]);
        }
        check_aligned(first, name)?;
        // SAFETY: not null, aligned, shorter than `isize::MAX`, and there, by the promise of the caller.
        Ok(unsafe { std::slice::from_raw_parts(first, count) })
    }

    /// Borrows aligned elements to write to.
    pub(crate) fn slice_mut<T: Plain>(
        &self,
        first: *mut T,
        count: usize,
        name: &str,
    ) -> Result<&'a mut [T], Failure> {
        self.check_span(first.cast(), size_of::<T>(), count, name)?;
        if count == 0 {
            return Ok(&mut []);
        }
        check_aligned(first, name)?;
        // SAFETY: as in `slice`; nobody else accesses it, by the promise of the caller.
        Ok(unsafe { std::slice::from_raw_parts_mut(first, count) })
    }

    /// Borrows a text that ends with a null byte; empty for a null pointer.
    pub(crate) fn text(&self, from: *const c_char, name: &str) -> Result<&'a str, Failure> {
        if from.is_null() {
            return Ok("");
        }
        // SAFETY: not null, and it ends with a null byte, by the promise of the caller.
        let text = unsafe { CStr::from_ptr(from) }.to_str();
        text.map_err(|_| refuse("c/not-utf-8", format_args!("{name} is not UTF-8")))
    }

    /// Returns where a result goes, and clears it: results of a call that fails are 0.
    pub(crate) fn out<T>(&self, to: *mut T, name: &str) -> Result<Out<'a, T>, Failure> {
        self.maybe_out(to).ok_or_else(|| null(name))
    }

    /// As [`Caller::out`]; `None` for null.
    pub(crate) fn maybe_out<T>(&self, to: *mut T) -> Option<Out<'a, T>> {
        if to.is_null() {
            return None;
        }
        // SAFETY: not null, so there is room for a value, by the promise of the caller.
        unsafe { to.cast::<u8>().write_bytes(0, size_of::<T>()) };
        Some(Out {
            to,
            lent: PhantomData,
        })
    }

    /// Returns an array of `capacity` elements that takes results.
    pub(crate) fn buffer<T>(
        &self,
        to: *mut T,
        capacity: usize,
        count: *mut usize,
        name: &str,
    ) -> Result<Buffer<'a, T>, Failure> {
        let count = self.out(count, "count")?;
        if !to.is_null() {
            self.check_span(to.cast(), size_of::<T>(), capacity, name)?;
        }
        Ok(Buffer { to, capacity, count })
    }

    /// Checks that an array is not null, unless it is empty, and does not wrap around the address space.
    fn check_span(&self, first: *const u8, stride: usize, count: usize, name: &str) -> Result<(), Failure> {
        if count == 0 {
            return Ok(());
        }
        if first.is_null() {
            return Err(null(name));
        }
        let end = stride
            .checked_mul(count)
            .filter(|&bytes| bytes <= isize::MAX as usize && count <= MOST)
            .and_then(|bytes| first.addr().checked_add(bytes));
        if end.is_none() {
            return Err(refuse(
                "c/count",
                format_args!("{name} has {count} elements, more than there can be"),
            ));
        }
        Ok(())
    }
}

impl<'a, T: Plain> List<'a, T> {
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    pub(crate) fn iter(&self) -> impl ExactSizeIterator<Item = T> + use<'a, T> {
        let list = *self;
        (0..self.count).map(move |number| {
            // SAFETY: `number` is below the count, for which `Caller::list` checked that no offset overflows.
            unsafe { list.first.add(number * list.stride).cast::<T>().read_unaligned() }
        })
    }

    /// Returns the bytes from the first element to the end of the last, and the stride.
    pub(crate) fn bytes(&self) -> (&'a [u8], usize) {
        let Some(before) = self.count.checked_sub(1) else {
            return (&[], self.stride);
        };
        let length = before * self.stride + size_of::<T>();
        // SAFETY: bytes have no alignment, and these are within the array of `Caller::list`.
        (
            unsafe { std::slice::from_raw_parts(self.first, length) },
            self.stride,
        )
    }
}

impl<T> Out<'_, T> {
    /// Writes the result.
    pub(crate) fn set(&self, value: T) {
        // SAFETY: `Caller::out` was given room for a value.
        unsafe { self.to.write_unaligned(value) };
    }
}

impl<T> Buffer<'_, T> {
    /// Writes results, as many as there is room for, and their number. A null array takes none.
    ///
    /// # Errors
    /// If there is an array, and it is too short.
    pub(crate) fn fill(self, results: impl IntoIterator<Item = T>) -> Result<(), Failure> {
        let capacity = if self.to.is_null() { 0 } else { self.capacity };
        let mut count = 0;
        for result in results {
            if count < capacity {
                // SAFETY: below the capacity of an array that `Caller::buffer` was given.
                unsafe { self.to.add(count).write_unaligned(result) };
            }
            count += 1;
        }
        self.count.set(count);
        if count > capacity && !self.to.is_null() {
            return Err(Failure::new(
                EnfiladeStatus::BufferTooSmall,
                "c/buffer-too-small",
                format_args!("there are {count} results, and the array has room for {capacity}"),
            ));
        }
        Ok(())
    }
}

fn check_aligned<T>(first: *const T, name: &str) -> Result<(), Failure> {
    if first.is_aligned() {
        return Ok(());
    }
    let needed = align_of::<T>();
    Err(refuse(
        "c/misaligned",
        format_args!("{name} is not at a multiple of {needed} bytes"),
    ))
}

fn null(name: &str) -> Failure {
    Failure::new(
        EnfiladeStatus::NullArgument,
        "c/null-argument",
        format_args!("{name} is null"),
    )
}
