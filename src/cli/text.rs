//! Texts in and out: numbers for people, and the one way in which commands print.

use std::borrow::Cow;
use std::fmt::{Display, Write as _};
use std::io::{self, ErrorKind, Write};
use std::path::Path;

use anstyle::{AnsiColor, Style};
use console::Term;

use super::caller::Caller;
use super::exit::Failure;
use decore_model::run::MOST_THREADS;
use decore_study::engine::{Engine, RowRunner};

/// Longest line of a message; a quoted file must not fill a log.
const LONGEST_LINE: usize = 2000;
/// Columns of help texts in a file or a pipe.
const HELP_COLUMNS: usize = 100;

/// Writes a line to standard output: all that commands print passes here.
///
/// # Errors
/// [`Failure::Print`]: a full disk and the like. A reader that has gone is none.
pub(super) fn print_line(line: &dyn Display) -> Result<(), Failure> {
    let text = line.to_string();
    if let Some(caller) = Caller::current() {
        caller.keep(|result| result.text += &(text + "\n"));
        return Ok(());
    }
    printed(writeln!(io::stdout(), "{}", printable(&text)))
}

/// What came of a text for standard output. A reader that has gone (`decore scene ... | head -1`) has enough: the command goes
/// on without it and ends with its own code.
///
/// # Errors
/// As [`print_line`].
pub(super) fn printed(written: io::Result<()>) -> Result<(), Failure> {
    // Part of a line may still be kept back.
    match written.and_then(|()| io::stdout().flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::Print(error)),
        _ => Ok(()),
    }
}

/// Labels of messages with their colours, as clap has them.
const LABELS: [(&str, AnsiColor); 4] = [
    ("error:", AnsiColor::Red),
    ("warning:", AnsiColor::Yellow),
    ("note:", AnsiColor::Cyan),
    ("help:", AnsiColor::Green),
];

/// Writes a message to standard error. On a terminal, lines end where it does and the label (`error:`, `warning:`, `note:`, `help:`)
/// has a colour unless `NO_COLOR` is set; elsewhere very long lines are cut.
pub(super) fn eprint_line(line: &dyn Display) {
    let text = line.to_string();
    if let Some(caller) = Caller::current() {
        return caller.keep(|result| result.notes.push(text));
    }
    let columns = Term::stderr().size_checked().map(|(_, columns)| usize::from(columns));
    let lines: Vec<String> = text
        .split('\n')
        .map(|line| {
            let line = printable(&cut(line)).into_owned();
            match columns {
                Some(columns) if !is_quoted(&line) => fit(&line, columns).trim_end_matches('\n').to_owned(),
                _ => line,
            }
        })
        .map(|line| labelled(&line))
        .collect();
    // anstream takes the colours out where they are not wanted.
    let _ = writeln!(anstream::stderr(), "{}", lines.join("\n"));
}

/// Writes an error of the parser of the command line, in its colours, to standard error; on a terminal, lines end where it does.
pub(super) fn eprint_styled(text: &str) {
    let columns = Term::stderr().size_checked().map(|(_, columns)| usize::from(columns));
    let fitted = columns.map_or_else(|| text.to_owned(), |columns| fit(text, columns));
    let _ = write!(anstream::stderr(), "{fitted}");
}

/// Whether a line quotes a file, or marks the place below: its columns must stay.
fn is_quoted(line: &str) -> bool {
    line.trim_start_matches(|c: char| c == ' ' || c.is_ascii_digit()).starts_with('|')
}

/// A line with its label in colour.
fn labelled(line: &str) -> String {
    match LABELS.iter().find(|(label, _)| line.starts_with(label)) {
        None => line.to_owned(),
        Some((label, color)) => {
            let style = Style::new().bold().fg_color(Some((*color).into()));
            format!("{style}{label}{style:#}{}", &line[label.len()..])
        }
    }
}

/// A text without what makes a terminal do more than show it: control characters but line breaks and tabs, and marks that
/// reverse the direction of writing, stand as `\uXXXX`, which a string of JSON reads back. Titles, names and quoted lines come
/// from files of others.
fn printable(text: &str) -> Cow<'_, str> {
    let acts = |c: char| {
        (c.is_control() && c != '\n' && c != '\t') || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if !text.contains(acts) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if acts(c) {
            // Writing to a string cannot fail.
            let _ = write!(shown, "\\u{:04x}", u32::from(c));
        } else {
            shown.push(c);
        }
    }
    Cow::Owned(shown)
}

/// A line, or its beginning and how much is left out.
fn cut(line: &str) -> Cow<'_, str> {
    match line.char_indices().nth(LONGEST_LINE) {
        None => Cow::Borrowed(line),
        Some((end, _)) => {
            let (shown, rest) = line.split_at(end);
            Cow::Owned(format!("{shown}... ({} more characters)", rest.chars().count()))
        }
    }
}

/// Reads a number of threads.
pub(super) fn threads(text: &str) -> Result<usize, String> {
    let number = text.parse::<usize>().ok().filter(|number| *number <= MOST_THREADS);
    number.ok_or_else(|| format!("expected a whole number from 0 (one thread per core) to {MOST_THREADS}"))
}

/// Reads a relative standard error.
pub(super) fn wanted_error(text: &str) -> Result<f64, String> {
    let share = text.parse::<f64>().ok().filter(|share| *share > 0.0 && *share < 1.0);
    share.ok_or_else(|| "expected a number between 0 and 1, e.g. 0.01 for 1 %".to_owned())
}

/// A row asked for on the command line must be one of the study's.
pub(super) fn check_row(engine: &Engine, row: usize) -> Result<(), Failure> {
    let last = engine.checked().row_count() - 1;
    if row <= last {
        return Ok(());
    }
    let rows = if last == 0 { "row 0 only (it has no design)".to_owned() } else { format!("the rows 0 to {last}") };
    Err(Failure::Argument(format!("--row is {row}, but the study has {rows}")))
}

/// Columns of the terminal that reads; `None` for a file or a pipe.
pub(super) fn terminal_columns() -> Option<usize> {
    let own = Caller::current().is_none().then(Term::stdout);
    own?.size_checked().map(|(_, columns)| usize::from(columns))
}

/// Width of help texts in columns: the terminal's width, else the variable `COLUMNS`, else 100.
pub(super) fn help_columns() -> usize {
    let set = || std::env::var("COLUMNS").ok()?.parse::<usize>().ok().filter(|columns| *columns > 0);
    Term::stdout().size_checked().map(|(_, columns)| usize::from(columns)).or_else(set).unwrap_or(HELP_COLUMNS)
}

/// Wraps each line of a text to a width. Wrapped lines start two blanks further in. Words stay whole.
pub(super) fn fit(text: &str, columns: usize) -> String {
    let mut fitted = String::with_capacity(text.len());
    for line in text.lines() {
        let indent = line.chars().take_while(|c| *c == ' ').count();
        fitted.push_str(&" ".repeat(indent));
        wrap(&mut fitted, line.trim_start().split(' '), ([indent, indent + 2], columns));
    }
    fitted
}

/// Wraps a text behind `head`. Wrapped lines start below the text. Words stay whole.
pub(super) fn hang(head: &str, text: &str, columns: usize) -> String {
    let (mut hung, indent) = (head.to_owned(), head.chars().count());
    wrap(&mut hung, text.split_whitespace(), ([indent, indent], columns));
    hung
}

/// Adds words and the end of the line. `used` columns of the first line are taken, the others start at `indent`.
fn wrap<'w>(to: &mut String, words: impl Iterator<Item = &'w str>, ([mut used, indent], columns): ([usize; 2], usize)) {
    for (index, word) in words.enumerate() {
        let length = width(word);
        if index > 0 && used + 1 + length > columns {
            to.push('\n');
            to.push_str(&" ".repeat(indent));
            used = indent;
        } else if index > 0 {
            to.push(' ');
            used += 1;
        }
        to.push_str(word);
        used += length;
    }
    to.push('\n');
}

/// Columns of a word; colours (`ESC [ ... m`) take none.
fn width(word: &str) -> usize {
    let mut parts = word.split("\u{1b}[");
    let first = parts.next().map_or(0, |part| part.chars().count());
    first + parts.map(|part| part.split_once('m').map_or(part, |(_, rest)| rest).chars().count()).sum::<usize>()
}

/// A path as one word of a command that people copy to a shell: as it is where no shell reads anything in it, else in quotes. Those
/// are a POSIX shell's; on Windows, where no name holds a double one, such as `cmd` and PowerShell take.
pub(super) fn shell_word(path: &Path) -> String {
    let text = path.to_string_lossy();
    let plain = |c: char| c.is_ascii_alphanumeric() || "@%+=:,./-_".contains(c) || (cfg!(windows) && c == '\\');
    match !text.is_empty() && text.chars().all(plain) {
        true => text.into_owned(),
        false if cfg!(windows) => format!("\"{text}\""),
        false => format!("'{}'", text.replace('\'', "'\\''")),
    }
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
    use super::{LONGEST_LINE, cut, fit, printable, six_digits, threads};

    #[test]
    fn terminals_get_no_orders() {
        assert_eq!(printable("a\tb\nµ ü"), "a\tb\nµ ü");
        let shown = printable("\u{1b}[2J\r\u{7f}\u{9b}31m\u{202e}");
        assert_eq!(shown, "\\u001b[2J\\u000d\\u007f\\u009b31m\\u202e");
        let read: String = serde_json::from_str(&format!("\"{shown}\"")).expect("JSON");
        assert_eq!(read, "\u{1b}[2J\r\u{7f}\u{9b}31m\u{202e}");
    }

    #[test]
    fn long_lines_are_cut() {
        let long = "ü".repeat(LONGEST_LINE + 5);
        assert_eq!(cut(&long[..2 * LONGEST_LINE]), long[..2 * LONGEST_LINE]);
        assert!(cut(&long).ends_with("ü... (5 more characters)"));
    }

    #[test]
    fn lines_end_where_the_terminal_does() {
        assert_eq!(fit("  a bb ccc dddd\nshort", 8), "  a bb\n    ccc\n    dddd\nshort\n");
        assert_eq!(fit("a   b", 80), "a   b\n");
        // Colours take no columns.
        assert_eq!(fit("\u{1b}[1m\u{1b}[31merror:\u{1b}[0m a b", 8), "\u{1b}[1m\u{1b}[31merror:\u{1b}[0m a\n  b\n");
    }

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
