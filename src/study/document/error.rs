//! Errors of studies: place, expected value, remedy.

use std::fmt;
use std::ops::Range;
use std::path::PathBuf;

/// Largest number of reported errors of a file.
pub(super) const MOST_FAULTS: usize = 20;
/// Most characters of a line that are shown, about the fault, and of a key.
const SHOWN: usize = 160;

/// Reason why a study cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// A file could not be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// Faults in the text, in the order of their places; at least one.
    #[error("{}", Listing(problems))]
    Invalid {
        /// The faults.
        problems: Vec<Problem>,
    },
}

impl StudyError {
    /// The faults in the text; empty if a file could not be read.
    pub fn problems(&self) -> &[Problem] {
        match self {
            Self::Read { .. } => &[],
            Self::Invalid { problems } => problems,
        }
    }

    /// An error if there are problems.
    pub(crate) fn from_problems(problems: Vec<Problem>) -> Result<(), Self> {
        if problems.is_empty() {
            return Ok(());
        }
        Err(Self::several(problems))
    }

    /// The error of at least one problem, sorted by place.
    pub(crate) fn several(mut problems: Vec<Problem>) -> Self {
        problems.sort_by(|a, b| {
            let order = |problem: &Problem| (problem.place.line, problem.place.column);
            let files = a.place.file.cmp(&b.place.file);
            files.then_with(|| order(a).cmp(&order(b)))
        });
        problems.dedup();
        Self::Invalid { problems }
    }

    /// The error of one problem.
    pub(crate) fn one(problem: Problem) -> Self {
        Self::several(vec![problem])
    }
}

/// A row of a study that describes no scene that can be simulated.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct InvalidRow {
    /// The fault, with the paths of the values.
    pub reason: String,
}

/// A place in a file. Lines and columns count from 1, columns in characters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileLocation {
    /// Name of the file as it was given.
    pub file: String,
    /// Line; `None` if the fault belongs to no line, e.g. a missing table.
    pub line: Option<usize>,
    /// Column; `None` if the fault belongs to no line.
    pub column: Option<usize>,
    /// Text of the line.
    pub source_line: String,
    /// Number of characters at fault, at least 1.
    pub width: usize,
}

impl FileLocation {
    /// A whole file.
    pub(crate) fn in_file(file: &str) -> Self {
        Self { file: file.to_string(), line: None, column: None, source_line: String::new(), width: 1 }
    }

    /// A byte range of a text whose lines begin at `begins`; a range over several lines is cut at the end of its first.
    pub(crate) fn in_text(file: &str, (text, begins): (&str, &[usize]), span: Range<usize>) -> Self {
        let at = |offset: usize| {
            let bounded = offset.min(text.len());
            (0..=bounded).rev().find(|&i| text.is_char_boundary(i)).unwrap_or(0)
        };
        let (start, end) = (at(span.start), at(span.end.max(span.start)));
        let number = begins.partition_point(|begin| *begin <= start).max(1);
        let line_start = begins.get(number - 1).copied().unwrap_or(0);
        let line = text.get(line_start..).unwrap_or("").lines().next().unwrap_or("");
        let column = text.get(line_start..start).unwrap_or("").chars().count() + 1;
        let covered = text.get(start..end).unwrap_or("").lines().next().unwrap_or("");
        Self {
            file: file.to_string(),
            line: Some(number),
            column: Some(column),
            source_line: line.to_string(),
            width: covered.chars().count().max(1),
        }
    }
}

/// One fault.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Place of the fault.
    pub place: FileLocation,
    /// Path of the key; empty for a fault of syntax.
    pub key: String,
    /// The fault.
    pub message: String,
    /// Expected value, if it is not part of the message.
    pub expected: Option<String>,
    /// The nearest known key or name.
    pub nearest: Option<String>,
}

impl Problem {
    pub(crate) fn new(place: FileLocation, key: impl Into<String>, message: impl Into<String>) -> Self {
        Self { place, key: key.into(), message: message.into(), expected: None, nearest: None }
    }

    pub(crate) fn expected(mut self, expected: impl Into<String>) -> Self {
        self.expected = Some(expected.into());
        self
    }

    pub(crate) fn nearest(mut self, nearest: Option<String>) -> Self {
        self.nearest = nearest;
        self
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}", self.place.file)?;
        if let (Some(line), Some(column)) = (self.place.line, self.place.column) {
            write!(formatter, ":{line}:{column}")?;
        }
        write!(formatter, ": ")?;
        match self.key.char_indices().nth(SHOWN) {
            _ if self.key.is_empty() => {}
            None => write!(formatter, "`{}`: ", self.key)?,
            Some((end, _)) => write!(formatter, "`{}...`: ", &self.key[..end])?,
        }
        write!(formatter, "{}", self.message)?;
        if let (Some(line), Some(column)) = (self.place.line, self.place.column) {
            let number = line.to_string();
            let margin = " ".repeat(number.len());
            let left_out = (column - 1).saturating_sub(SHOWN / 2);
            let shown: String = self.place.source_line.chars().skip(left_out).take(SHOWN).collect();
            let before = column - 1 - left_out;
            // Tabs are kept so that the caret stays below its column.
            let indent: String = shown.chars().take(before).map(|c| if c == '\t' { c } else { ' ' }).collect();
            let carets = "^".repeat(self.place.width.min(SHOWN - before));
            write!(formatter, "\n {margin} |\n {number} | {shown}\n {margin} | {indent}{carets}")?;
        }
        if let Some(expected) = &self.expected {
            write!(formatter, "\n  expected: {expected}")?;
        }
        if let Some(nearest) = &self.nearest {
            write!(formatter, "\n  did you mean `{nearest}`?")?;
        }
        Ok(())
    }
}

/// Shows faults one below the other.
struct Listing<'a>(&'a [Problem]);

impl fmt::Display for Listing<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, problem) in self.0.iter().enumerate() {
            let separator = if index == 0 { "" } else { "\n\n" };
            write!(formatter, "{separator}{problem}")?;
        }
        if self.0.len() >= MOST_FAULTS {
            write!(formatter, "\n\n(the first {MOST_FAULTS} faults; there may be more)")?;
        }
        Ok(())
    }
}
