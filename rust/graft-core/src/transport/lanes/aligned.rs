//! Arrays that begin on a cache line, so that no vector of them straddles two.

use std::ops::{Deref, DerefMut};

/// Bytes of a cache line, and of the widest vector.
const LINE: usize = 64;

/// A fixed number of values from a cache line on.
#[derive(Debug)]
pub struct Aligned<T> {
    // A few values before those asked for.
    values: Vec<T>,
    first: usize,
}

impl<T: Copy> Aligned<T> {
    /// `len` times the same value.
    #[must_use]
    pub fn new(value: T, len: usize) -> Self {
        let spare = LINE.div_ceil(size_of::<T>()) - 1;
        let mut values = vec![value; len + spare];
        let first = ((values.as_ptr().addr().wrapping_neg() % LINE) / size_of::<T>()).min(spare);
        values.truncate(first + len);
        Self { values, first }
    }
}

impl<T> Deref for Aligned<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        &self.values[self.first..]
    }
}

impl<T> DerefMut for Aligned<T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.values[self.first..]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_begin_on_a_line() {
        for len in [0, 1, 7, 64] {
            let array = Aligned::new(1.5_f32, len);
            assert_eq!((array.as_ptr().addr() % LINE, array.len()), (0, len));
            assert!(array.iter().all(|x| x.to_bits() == 1.5_f32.to_bits()));
        }
    }
}
