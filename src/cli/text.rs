//! Texts in and out: numbers for people, and output that a closed pipe does not turn into a panic.

use std::fmt::Display;
use std::io::Write;

use super::exit::Failure;
use crate::engine::Engine;

/// Writes a line to standard output.
pub(super) fn say(line: &dyn Display) {
    // A reader that has gone (`decore scene ... | head`) wants no more.
    let _ = writeln!(std::io::stdout(), "{line}");
}

/// Writes a line to standard error.
pub(super) fn tell(line: &dyn Display) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Most threads that can be asked for; many more would starve the machine before any row is run.
const MOST_THREADS: usize = 1024;

/// Reads a number of threads.
pub(super) fn threads(text: &str) -> Result<usize, String> {
    let number = text.parse::<usize>().ok().filter(|number| *number <= MOST_THREADS);
    number.ok_or_else(|| format!("expected a whole number from 0 (as many as the machine has) to {MOST_THREADS}"))
}

/// A row asked for on the command line must be one of the study's.
pub(super) fn check_row(engine: &Engine, row: usize) -> Result<(), Failure> {
    let last = engine.study().row_count() - 1;
    if row <= last {
        return Ok(());
    }
    Err(Failure::Argument(format!("--row is {row}, but the study has the rows 0 to {last}")))
}

/// `1 row`, `2 rows`.
pub(super) fn plural(count: usize, noun: &str) -> String {
    if count == 1 { format!("1 {noun}") } else { format!("{count} {noun}s") }
}

/// A number to six significant digits; with an exponent only where it would be long.
pub(super) fn six_digits(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    if !(1e-4..1e8).contains(&size) {
        return format!("{value:.5e}");
    }
    // Digits before the point after rounding to six: 9.999999 has two.
    let rounded: f64 = format!("{size:.5e}").parse().unwrap_or(size);
    let decimals = (5 - rounded.log10().floor() as i32).max(0) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::{six_digits, threads};

    #[test]
    fn numbers_have_six_digits() {
        let cases = [
            (0.0, "0"),
            (12.345_678_9, "12.3457"),
            (9.999_999_6, "10.0000"),
            (-0.001_234_567_8, "-0.00123457"),
            (72_026.165_574, "72026.2"),
            (55_148_150.83, "55148151"),
            (3.2e9, "3.20000e9"),
            (-5.2e-7, "-5.20000e-7"),
            (f64::NAN, "NaN"),
        ];
        for (value, text) in cases {
            assert_eq!(six_digits(value), text);
        }
    }

    #[test]
    fn absurd_numbers_of_threads_are_refused() {
        assert_eq!((threads("0"), threads("1024")), (Ok(0), Ok(1024)));
        for text in ["1025", "-1", "two", ""] {
            assert!(threads(text).is_err(), "{text}");
        }
    }
}
