//! Output that a closed pipe does not turn into a panic.

use std::fmt::Display;
use std::io::Write;

/// Writes a line to standard output.
pub(super) fn say(line: &dyn Display) {
    // A reader that has gone (`decore scene ... | head`) wants no more.
    let _ = writeln!(std::io::stdout(), "{line}");
}

/// Writes a line to standard error.
pub(super) fn tell(line: &dyn Display) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
