//! Status of a call, its error text, the version, and the guard that lets no panic leave the library.

use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::arguments::Arguments;
use crate::texts::c_text;

/// Status of a call. After every status but `CLEARANCE_STATUS_OK`, `clearance_last_error` has the reason, and results must not be used.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum clearance_status {
    /// The call succeeded. A collision is a result, and no error.
    Ok = 0,
    /// An argument is null, has a wrong length, or is used in a way that is not allowed: an error of the program.
    Argument = 1,
    /// The input is rejected: a faulty file, an unknown name, a number that is not finite or out of its range.
    Rejected = 2,
    /// An error of this library. Objects that the call was to change must not be used any more.
    Internal = 3,
}

/// Reason why a call fails.
#[derive(Debug)]
pub struct Failure {
    status: clearance_status,
    text: String,
}

impl Failure {
    /// An argument that does not fit the function.
    pub fn argument(text: impl Display) -> Self {
        Self { status: clearance_status::Argument, text: text.to_string() }
    }

    /// Input that the library rejects.
    pub fn rejected(text: impl Display) -> Self {
        Self { status: clearance_status::Rejected, text: text.to_string() }
    }

    /// The failure with the element that it is about in front.
    pub fn about(self, element: &str) -> Self {
        Self { text: format!("{element}: {}", self.text), ..self }
    }

    fn internal(panic: &(dyn Any + Send)) -> Self {
        let known = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let text = known.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
        let text = format!("internal error, please report it: {text}");
        Self { status: clearance_status::Internal, text }
    }
}

impl Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.text)
    }
}

/// Result of the body of a function.
pub type Outcome<T = ()> = Result<T, Failure>;

thread_local! {
    static LAST_ERROR: RefCell<Option<CString>> = const { RefCell::new(None) };
}

/// Runs the body of a function that C calls: no panic leaves it, and a failure is kept for `clearance_last_error`.
pub fn call(body: impl FnOnce(Arguments<'_>) -> Outcome) -> clearance_status {
    let run = || body(Arguments::of_this_call());
    let failure = match catch_unwind(AssertUnwindSafe(run)) {
        Ok(Ok(())) => return clearance_status::Ok,
        Ok(Err(failure)) => failure,
        Err(panic) => Failure::internal(&*panic),
    };
    let status = failure.status;
    // the thread may be about to end
    let _ = LAST_ERROR.try_with(|last| last.replace(Some(c_text(&failure.text))));
    status
}

/// Runs the body of a function that returns a value, and `default` if it fails.
pub fn call_for<T>(default: T, body: impl FnOnce(Arguments<'_>) -> Outcome<T>) -> T {
    let mut value = default;
    call(|arguments| {
        value = body(arguments)?;
        Ok(())
    });
    value
}

/// Text of the last error in this thread; empty if there was none. It names the element and says what to do.
///
/// The text is valid until the next failing call in this thread.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_last_error() -> *const c_char {
    let text = LAST_ERROR.try_with(|last| last.borrow().as_ref().map(|text| text.as_ptr()));
    text.ok().flatten().unwrap_or(c"".as_ptr())
}

/// Version of the library, such as `0.1.0`.
#[unsafe(no_mangle)]
pub extern "C" fn clearance_version() -> *const c_char {
    const VERSION: &CStr =
        match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
            Ok(version) => version,
            Err(_) => c"",
        };
    VERSION.as_ptr()
}
