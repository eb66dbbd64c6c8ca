//! Reads files up to the maximum size of their kind, so that a wrong name (a device, results of another program) costs neither memory nor
//! time. Writes files under a temporary name until they are complete: [`Staged`].

mod shield;
mod staged;

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::Path;

pub use shield::shielded;
pub use staged::{Staged, is_passing_name, rename};

/// Largest size of a pipe or device, which has no known size.
const MOST_STREAMED: u64 = 64_000_000;

/// A kind of file and the most bytes that it may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limit {
    /// Kind of file, for messages.
    pub kind: &'static str,
    /// The most bytes.
    pub bytes: u64,
}

impl Limit {
    /// Studies, hammers and structures in TOML.
    pub const TOML: Self = Self { kind: "a study, hammer or structure file", bytes: 4_000_000 };
    /// Tables of interface points and modes.
    pub const POINTS: Self = Self { kind: "a table of points or modes", bytes: 64_000_000 };
    /// Tables of a design's rows.
    pub const ROWS: Self = Self { kind: "a table of rows", bytes: 256_000_000 };
    /// Matrices and their tables.
    pub const MATRIX: Self = Self { kind: "a matrix file", bytes: 64_000_000_000 };
    /// Limit for the files that describe a dataset.
    pub const DATASET: Self = Self { kind: "a file about a dataset", bytes: 256_000_000 };
    /// A part of a table, or the rows that wait for it: as large as the memory of the process that wrote them.
    pub const PART: Self = Self { kind: "a part of a dataset", bytes: 16_000_000_000 };
    /// Progress and owner of a sweep: a few lines.
    pub const STATUS: Self = Self { kind: "the status of a dataset", bytes: 1_000_000 };
    /// A reduced machine that was kept.
    pub const REDUCED: Self = Self { kind: "a reduced machine", bytes: 4_000_000_000 };
}

/// The bytes of a file.
///
/// # Errors
/// The system's; [`ErrorKind::FileTooLarge`] beyond the limit, with its figure.
pub fn read(path: &Path, limit: Limit) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    let known = file.metadata()?;
    let most = if known.is_file() { limit.bytes } else { limit.bytes.min(MOST_STREAMED) };
    let mut bytes = Vec::new();
    if known.len() <= most {
        // One byte more than there should be: the end is seen without growing.
        bytes.try_reserve_exact(usize::try_from(known.len()).unwrap_or(usize::MAX).saturating_add(1))?;
        file.take(most + 1).read_to_end(&mut bytes)?;
    }
    if known.len() > most || bytes.len() as u64 > most {
        let message = format!("it has more than {} MB, the most for {}", most / 1_000_000, limit.kind);
        return Err(io::Error::new(ErrorKind::FileTooLarge, message));
    }
    Ok(bytes)
}

/// The text of a file in UTF-8.
///
/// # Errors
/// As [`read`]; [`ErrorKind::InvalidData`] for other encodings: the message names the encoding, or the first wrong line.
pub fn read_text(path: &Path, limit: Limit) -> io::Result<String> {
    let bytes = read(path, limit)?;
    let refused = |found: String| {
        let advice = "save it as UTF-8 (Notepad: Save as, Encoding: UTF-8; PowerShell: Set-Content -Encoding utf8)";
        io::Error::new(ErrorKind::InvalidData, format!("{found}: {advice}"))
    };
    if let Some(encoding) = encoding(&bytes) {
        return Err(refused(format!("the file is encoded as {encoding}")));
    }
    String::from_utf8(bytes).map_err(|error| {
        let (valid, rest) = error.as_bytes().split_at(error.utf8_error().valid_up_to());
        let line = valid.iter().filter(|byte| **byte == b'\n').count() + 1;
        let byte = rest.first().copied().unwrap_or_default();
        refused(format!("line {line} is not UTF-8 text (byte 0x{byte:02x})"))
    })
}

/// Encoding by its byte order mark, or by the zeros that other encodings put between ASCII characters.
fn encoding(bytes: &[u8]) -> Option<&'static str> {
    let zeros = |from: usize| bytes.iter().take(512).skip(from).step_by(2).filter(|byte| **byte == 0).count();
    let half = bytes.len().min(512) / 2;
    match bytes {
        [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] => Some("UTF-32"),
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => Some("UTF-16"),
        _ if half > 4 && zeros(0).max(zeros(1)) > half * 3 / 4 => Some("UTF-16"),
        _ => None,
    }
}
