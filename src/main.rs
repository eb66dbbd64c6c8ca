//! The `decore` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    decore::cli::run()
}
