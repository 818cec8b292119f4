//! Panics of other crates, as errors.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};

/// The number of contained functions that run now.
static RUNNING: AtomicUsize = AtomicUsize::new(0);

/// Runs a function of another crate that may panic on bad input. A panic is an error with its message, without other effects.
///
/// # Errors
/// The function panicked.
pub fn contained<T>(function: impl FnOnce() -> T) -> Result<T, String> {
    RUNNING.fetch_add(1, Ordering::Relaxed);
    let result = catch_unwind(AssertUnwindSafe(function));
    RUNNING.fetch_sub(1, Ordering::Relaxed);
    result.map_err(|panic| message(panic.as_ref()).to_owned())
}

/// Whether a panic may belong to a contained function, so that it must not end the process.
pub fn is_active() -> bool {
    RUNNING.load(Ordering::Relaxed) > 0
}

pub fn message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("a panic without a message")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error_with_its_message() {
        assert_eq!(contained(|| 3), Ok(3));
        let places: [u8; 0] = [];
        let error = contained(|| places[std::hint::black_box(7)]).unwrap_err();
        assert_eq!(error, "index out of bounds: the len is 0 but the index is 7");
    }
}
