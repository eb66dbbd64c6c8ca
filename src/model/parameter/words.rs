//! Texts about a parameter for documentation and messages, as literals.
//!
//! These macros have no path: derives that read documentation resolve macros only by their place in the text.

/// A range in words, as a literal.
#[rustfmt::skip]
macro_rules! parameter_words {
    ([finite]) => { "a finite number" };
    ([> 0]) => { "a positive number" };
    ([>= 0]) => { "zero or a positive number" };
    ([> $low:literal]) => { concat!("a number above ", $low) };
    ([>= $low:literal]) => { concat!($low, " or a number above") };
    ([> $low:literal, <= $high:literal]) => { concat!("a number above ", $low, " and not above ", $high) };
    ([>= $low:literal, < $high:literal]) => { concat!("a number from ", $low, " to below ", $high) };
    ([$low:literal ..]) => { concat!("a whole number not below ", $low) };
    ([$low:literal ..= $high:literal]) => { concat!("a whole number from ", $low, " to ", $high) };
}

/// Sentence after an entry's text in the documentation of its group: range, unit, default, source.
#[rustfmt::skip]
macro_rules! parameter_sentence {
    ([choice], $unit:tt, $source:tt $(, $default:expr)?) => { concat!("Default: ", $source, ".") };
    ([group], $unit:tt, $source:tt) => { "" };
    ([group], $unit:tt, $source:tt, $default:expr) => {
        concat!("Default `", stringify!($default), "` in ", $unit, " (", $source, ").")
    };
    ($range:tt, $unit:tt, "the preset's" $(, $default:expr)?) => {
        concat!("Takes ", parameter_words!($range), parameter_unit!($unit), "; default: the preset's.")
    };
    ($range:tt, $unit:tt, $source:tt, $default:expr) => {
        concat!("Takes ", parameter_words!($range), parameter_unit!($unit), "; default ", stringify!($default), " (", $source, ").")
    };
    ($range:tt, $unit:tt, $otherwise:tt) => {
        concat!("Takes ", parameter_words!($range), parameter_unit!($unit), "; ", $otherwise, ".")
    };
}

/// The unit after a number in a sentence.
#[rustfmt::skip]
macro_rules! parameter_unit {
    ("1") => { "" };
    ($unit:tt) => { concat!(" in ", $unit) };
}

/// Between which numbers a value usually lies, as a sentence behind another.
#[rustfmt::skip]
macro_rules! parameter_usual {
    ($unit:tt) => { "" };
    ("1", [$low:literal, $high:literal]) => { concat!(" Usually ", $low, " to ", $high, ".") };
    ($unit:tt, [$low:literal, $high:literal]) => { concat!(" Usually ", $low, " to ", $high, " ", $unit, ".") };
}
