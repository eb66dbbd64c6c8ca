//! Runs decoders of other packages: damaged bytes give an error, not a panic.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    /// Whether this thread is in a decoder.
    static SHIELDED: Cell<bool> = const { Cell::new(false) };
}

/// Runs a decoder of another package. Returns `None` if it panics, and prints nothing.
///
/// Use it only if the caller then refuses the input as damaged, and the call leaves no partial state behind.
pub fn shielded<T>(decode: impl FnOnce() -> T) -> Option<T> {
    static QUIET: Once = Once::new();
    QUIET.call_once(|| {
        let report = take_hook();
        set_hook(Box::new(move |panic| {
            if !SHIELDED.get() {
                report(panic);
            }
        }));
    });
    SHIELDED.set(true);
    let result = catch_unwind(AssertUnwindSafe(decode));
    SHIELDED.set(false);
    result.ok()
}

#[cfg(test)]
mod tests {
    use super::shielded;

    #[test]
    fn a_panic_is_nothing() {
        let bytes: &[u8] = &[1, 2, 3];
        assert_eq!(shielded(|| bytes.iter().sum::<u8>()), Some(6));
        assert_eq!(shielded(|| bytes.iter().map(|byte| byte / (byte - 2)).sum::<u8>()), None);
    }
}
