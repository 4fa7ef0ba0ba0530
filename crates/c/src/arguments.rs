//! Reads arguments (handles, texts, arrays) through pointers from C, and writes results. All accesses to memory of the
//! caller are here.
//!
//! A null pointer, a pointer that is not aligned and a length that no array can have are errors. Whether other pointers are valid can not
//! be checked: the header requires it.

use std::ffi::{CStr, c_char};
use std::marker::PhantomData;

use crate::status::{Failure, Outcome};
use crate::structs::{clearance_named_value, clearance_pair, clearance_pose};

/// Types of which every bit pattern is a value, so that C may fill them with anything.
///
/// # Safety
/// Only numbers, raw pointers, and `repr(C)` structs of these.
pub unsafe trait Plain: Copy {}

// SAFETY: numbers and raw pointers.
unsafe impl Plain for u8 {}
// SAFETY: as above.
unsafe impl Plain for u32 {}
// SAFETY: as above.
unsafe impl Plain for f64 {}
// SAFETY: as above.
unsafe impl Plain for *const c_char {}
// SAFETY: a struct of two pointers.
unsafe impl Plain for clearance_pair {}
// SAFETY: a struct of a pointer and a number.
unsafe impl Plain for clearance_named_value {}
// SAFETY: a struct of numbers.
unsafe impl Plain for clearance_pose {}

/// Arguments of one call from C. References to them live no longer than the call.
#[derive(Clone, Copy, Debug)]
pub struct Arguments<'c>(PhantomData<&'c ()>);

impl<'c> Arguments<'c> {
    /// Only `status::call` makes one, for a function that C calls.
    pub(crate) fn of_this_call() -> Self {
        Self(PhantomData)
    }

    /// An object of the caller: a handle, or a struct that is passed by its address.
    pub fn object<T>(self, pointer: *const T, name: &str) -> Outcome<&'c T> {
        self.object_or_none(pointer, name)?.ok_or_else(|| is_null(name))
    }

    /// As [`Self::object`], but may be null.
    pub fn object_or_none<T>(self, pointer: *const T, name: &str) -> Outcome<Option<&'c T>> {
        check_alignment(pointer, name)?;
        // SAFETY: it is aligned, and null or valid for this call, as the header requires of handles and structs. Objects that other
        // threads use at the same time are Sync; for others the header forbids it.
        Ok(unsafe { pointer.as_ref() })
    }

    /// An object that the call changes.
    pub fn object_mut<T>(self, pointer: *mut T, name: &str) -> Outcome<&'c mut T> {
        check_alignment(pointer, name)?;
        // SAFETY: as in `object_or_none`. The header forbids any other use of an object while a function changes it.
        unsafe { pointer.as_mut() }.ok_or_else(|| is_null(name))
    }

    /// A text.
    pub fn text(self, pointer: *const c_char, name: &str) -> Outcome<&'c str> {
        self.text_or_none(pointer, name)?.ok_or_else(|| is_null(name))
    }

    /// As [`Self::text`], but may be null.
    pub fn text_or_none(self, pointer: *const c_char, name: &str) -> Outcome<Option<&'c str>> {
        if pointer.is_null() {
            return Ok(None);
        }
        // SAFETY: the header requires texts to end with NUL and to stay unchanged during the call.
        let text = unsafe { CStr::from_ptr(pointer) };
        let text =
            text.to_str().map_err(|_| Failure::argument(format!("{name} is not UTF-8: convert it")))?;
        Ok(Some(text))
    }

    /// An array of `count` elements; may be null if it has none.
    pub fn array<T: Plain>(self, pointer: *const T, count: usize, name: &str) -> Outcome<&'c [T]> {
        if count == 0 {
            return Ok(&[]);
        }
        check_array(pointer, count, name)?;
        // SAFETY: it is neither null nor too long, and aligned; the header requires `count` elements that do not change during the
        // call. Every bit pattern is a value of a `Plain` type.
        Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
    }

    /// Writes a result of one element.
    pub fn write<T>(self, out: *mut T, value: T, name: &str) -> Outcome {
        check_array(out, 1, name)?;
        // SAFETY: it is neither null nor misaligned; the header requires room for one element.
        unsafe { out.write(value) };
        Ok(())
    }

    /// Rejects a place that can not have `count` results, before they are computed.
    pub fn check_room<T>(self, out: *mut T, count: usize, name: &str) -> Outcome {
        if count == 0 { Ok(()) } else { check_array(out, count, name) }
    }

    /// Writes an array of results, for which the caller has room for `count`.
    pub fn write_array<T: Plain>(self, out: *mut T, count: usize, values: &[T], name: &str) -> Outcome {
        if count != values.len() {
            let needed = values.len();
            return Err(Failure::argument(format!(
                "{name} has room for {count}, but must have for {needed}"
            )));
        }
        if count == 0 {
            return Ok(());
        }
        check_array(out, count, name)?;
        // SAFETY: it is neither null nor misaligned; the header requires room for `count` elements, apart from all objects of this
        // library.
        unsafe { std::ptr::copy_nonoverlapping(values.as_ptr(), out, count) };
        Ok(())
    }

    /// Moves an object to the heap and passes its ownership to the caller.
    pub fn write_handle<T>(self, out: *mut *mut T, object: T, name: &str) -> Outcome {
        check_array(out, 1, name)?;
        self.write(out, Box::into_raw(Box::new(object)), name)
    }

    /// Takes an object back and drops it; null is ignored.
    pub fn release<T>(self, handle: *mut T, name: &str) -> Outcome {
        check_alignment(handle, name)?;
        if !handle.is_null() {
            // SAFETY: the header requires a handle of this library that was not freed before and is not used any more; all of them
            // come from `Box::into_raw`.
            drop(unsafe { Box::from_raw(handle) });
        }
        Ok(())
    }
}

fn is_null(name: &str) -> Failure {
    Failure::argument(format!("{name} is null, but must be given"))
}

fn check_alignment<T>(pointer: *const T, name: &str) -> Outcome {
    if pointer.is_aligned() {
        Ok(())
    } else {
        Err(Failure::argument(format!("{name} is not a valid pointer: it is not aligned")))
    }
}

fn check_array<T>(pointer: *const T, count: usize, name: &str) -> Outcome {
    if pointer.is_null() {
        return Err(is_null(name));
    }
    check_alignment(pointer, name)?;
    let most = isize::MAX.unsigned_abs() / size_of::<T>().max(1);
    if count <= most {
        Ok(())
    } else {
        Err(Failure::argument(format!("{name} can not have {count} elements: give their number")))
    }
}
