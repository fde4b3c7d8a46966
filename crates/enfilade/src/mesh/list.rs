//! Lists of plain numbers that meshes share with their clones, and with the bytes that they were read from.

use bytemuck::Pod;
use bytes::Bytes;
use std::fmt;
use std::marker::PhantomData;
use std::ops::Deref;

/// A list of numbers, immutable: those of a vector, or bytes of a file that is mapped into memory. Clones share it.
pub(super) struct List<T> {
    /// Whole values, aligned as `T`.
    bytes: Bytes,
    of: PhantomData<T>,
}

/// A vector, as the owner of bytes.
struct Owner<T>(Vec<T>);

impl<T: Pod> AsRef<[u8]> for Owner<T> {
    fn as_ref(&self) -> &[u8] {
        bytemuck::cast_slice(&self.0)
    }
}

impl<T: Pod + Send> From<Vec<T>> for List<T> {
    fn from(mut values: Vec<T>) -> List<T> {
        values.shrink_to_fit();
        List {
            bytes: Bytes::from_owner(Owner(values)),
            of: PhantomData,
        }
    }
}

impl<T: Pod + Send> List<T> {
    /// Returns the list in these bytes, in the order of the machine: in place if they are aligned, else as a copy.
    ///
    /// # Panics
    /// If they are no whole values.
    pub(super) fn from_bytes(bytes: Bytes) -> List<T> {
        // An empty slice of a buffer has no place of its own.
        if bytes.is_empty() || bytemuck::try_cast_slice::<u8, T>(&bytes).is_err() {
            return List::from(bytemuck::allocation::pod_collect_to_vec::<u8, T>(&bytes));
        }
        List {
            bytes,
            of: PhantomData,
        }
    }
}

impl<T: Pod> Deref for List<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        bytemuck::cast_slice(&self.bytes)
    }
}

impl<T: Pod + Send> Default for List<T> {
    fn default() -> List<T> {
        List::from(Vec::new())
    }
}

impl<T> Clone for List<T> {
    fn clone(&self) -> List<T> {
        List {
            bytes: self.bytes.clone(),
            of: PhantomData,
        }
    }
}

impl<T: Pod + fmt::Debug> fmt::Debug for List<T> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_in_place_where_they_are_aligned_and_copied_elsewhere() {
        let numbers: Vec<u32> = (0..9).collect();
        let shared = Bytes::from_owner(Owner(numbers.clone()));
        let whole = List::<u32>::from_bytes(shared.clone());
        assert_eq!(
            (&*whole, whole.as_ptr().cast::<u8>()),
            (&numbers[..], shared.as_ptr())
        );
        let moved: Vec<u8> = [&[7][..], &shared].concat();
        let moved = Bytes::from(moved).slice(1..);
        assert_eq!(&*List::<u32>::from_bytes(moved), &numbers[..]);
        assert!(List::<[f32; 3]>::from_bytes(shared.slice(4..4)).is_empty());
        assert!(List::<[f32; 3]>::default().is_empty());
    }
}
