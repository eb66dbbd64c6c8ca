//! Long texts on a terminal: shown page by page by the user's pager.

use std::io::{IsTerminal, Write, stdout};
use std::process::{Command, Stdio};

use anstream::ColorChoice;
use console::Term;

use super::exit::Failure;
use super::text::printed;

/// Writes a text with colours to standard output, through a pager if it is longer than the terminal. Elsewhere the colours are left out.
///
/// # Errors
/// As [`printed`].
pub(super) fn show(text: &str) -> Result<(), Failure> {
    let text = format!("{}\n", text.trim_end());
    let height = Term::stdout().size_checked().map(|(rows, _)| usize::from(rows));
    let is_long = height.is_some_and(|height| text.lines().count() + 1 > height);
    if is_long && stdout().is_terminal() && page(&text) {
        return Ok(());
    }
    printed(anstream::stdout().write_all(text.as_bytes()))
}

/// Shows a text in the pager that `PAGER` names, else in `less -R` (`more` on Windows); whether that succeeded.
fn page(text: &str) -> bool {
    let named = std::env::var("PAGER").ok().filter(|pager| !pager.trim().is_empty());
    let mut command = match named {
        Some(pager) if cfg!(windows) => shell(&["cmd", "/C"], &pager),
        Some(pager) => shell(&["sh", "-c"], &pager),
        None if cfg!(windows) => Command::new("more.com"),
        None => Command::new("less"),
    };
    // For less by whatever name: colours, and no page for a text that fits.
    if std::env::var_os("LESS").is_none() {
        command.env("LESS", "FRX");
    }
    let colours = anstream::AutoStream::choice(&stdout()) != ColorChoice::Never;
    let text = if colours { text.to_owned() } else { anstream::adapter::strip_str(text).to_string() };
    let Ok(mut pager) = command.stdin(Stdio::piped()).spawn() else { return false };
    if let Some(mut input) = pager.stdin.take() {
        // A reader who has seen enough closes the pager.
        let _ = input.write_all(text.as_bytes());
    }
    // 127: the shell found no such program.
    pager.wait().is_ok_and(|status| status.code() != Some(127))
}

fn shell(shell: &[&str; 2], line: &str) -> Command {
    let mut command = Command::new(shell[0]);
    command.args([shell[1], line]);
    command
}
