//! Text files line by line, plain or gzip, with the place of every fault.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;

use crate::structure::error::{FileFault, StructureError};
use decore_files::Limit;

/// Longest line; no format has longer ones.
const LONGEST_LINE: u64 = 1_000_000;
/// Most characters of a message that quotes a line.
const LONGEST_REASON: usize = 1000;
/// A packed file unpacks to so many bytes whatever its size, and to so many times its size beyond: exported matrices have a tenth.
const FREE_UNPACKED: u64 = 16_000_000;
const MOST_UNPACKED: u64 = 100;
/// Most lines without a word in a row.
const MOST_SKIPPED: usize = 1_000_000;

/// The bytes of a file.
pub(super) fn read_bytes(path: &Path) -> Result<Vec<u8>, StructureError> {
    decore_files::read(path, Limit::MATRIX)
        .map_err(|error| StructureError::Read { file: path.display().to_string(), reason: error.to_string() })
}

/// Whether bytes are gzip, by the first two.
pub(super) fn is_packed(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1f, 0x8b])
}

/// Bytes as they are, or unpacked where they are gzip.
pub(super) fn unpacked(bytes: &[u8]) -> Box<dyn Read + '_> {
    if !is_packed(bytes) {
        return Box::new(bytes);
    }
    Box::new(Unpacked { reader: MultiGzDecoder::new(bytes), left: most_unpacked(bytes.len()) })
}

/// Most bytes that so many packed bytes may unpack to.
pub(super) fn most_unpacked(packed: usize) -> u64 {
    FREE_UNPACKED.max(MOST_UNPACKED.saturating_mul(packed as u64))
}

/// Unpacks no more than the packed bytes justify.
struct Unpacked<R> {
    reader: R,
    left: u64,
}

impl<R: Read> Read for Unpacked<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let read = self.reader.read(buffer)?;
        self.left = self.left.checked_sub(read as u64).ok_or_else(|| {
            let message = format!("it unpacks to more than {MOST_UNPACKED} times its size, which no matrix does");
            std::io::Error::new(std::io::ErrorKind::FileTooLarge, message)
        })?;
        Ok(read)
    }
}

/// Line reader that knows its file and line number.
pub(super) struct Lines<'a> {
    pub file: &'a str,
    reader: BufReader<Box<dyn Read + 'a>>,
    raw: Vec<u8>,
    /// The current line without its end.
    pub text: String,
    /// Line number, from 1.
    pub number: usize,
}

impl<'a> Lines<'a> {
    pub fn new(file: &'a str, bytes: &'a [u8]) -> Self {
        Self { file, reader: BufReader::new(unpacked(bytes)), raw: Vec::new(), text: String::new(), number: 0 }
    }

    pub fn fault(&self, reason: impl Into<String>) -> StructureError {
        self.fault_at(self.number, reason)
    }

    pub fn fault_at(&self, line: usize, reason: impl Into<String>) -> StructureError {
        let mut reason = reason.into();
        if let Some((end, _)) = reason.char_indices().nth(LONGEST_REASON) {
            reason.truncate(end);
            reason += "...";
        }
        FileFault { file: self.file.to_owned(), line, reason }.into()
    }

    /// The next line, or `false` at the end of the file. Text is UTF-8, with or without a byte-order mark, or Latin-1 (as
    /// comments with umlauts are).
    pub fn advance(&mut self) -> Result<bool, StructureError> {
        self.raw.clear();
        self.text.clear();
        self.number += 1;
        let read = self.reader.by_ref().take(LONGEST_LINE + 1).read_until(b'\n', &mut self.raw);
        let read = read.map_err(|error| self.fault(format!("the file is truncated or damaged ({error})")))?;
        let marks: &[&[u8]] = if self.number == 1 { &[b"\xff\xfe", b"\xfe\xff"] } else { &[] };
        if marks.iter().any(|mark| self.raw.starts_with(mark)) {
            return Err(self.fault("not text in UTF-8: it begins as UTF-16 or binary; save it as plain text"));
        }
        let binary = |byte: &u8| *byte < b' ' && !matches!(*byte, b'\t' | b'\n' | b'\r' | 0x0c | 0x1a);
        if let Some(byte) = self.raw.iter().find(|byte| binary(byte)) {
            return Err(self.fault(format!("not text: a byte {byte} (is this another format?)")));
        }
        if read as u64 > LONGEST_LINE {
            return Err(self.fault("a line of more than a million characters (is this another format?)"));
        }
        match std::str::from_utf8(&self.raw) {
            Ok(text) => self.text.push_str(text),
            Err(_) => self.text.extend(self.raw.iter().map(|byte| char::from(*byte))),
        }
        if self.number == 1 && self.text.starts_with('\u{feff}') {
            self.text.remove(0);
        }
        self.text.truncate(self.text.trim_end_matches(['\n', '\r']).len());
        Ok(read > 0)
    }

    /// Moves to the next line that is not empty and does not begin with one of the comment marks; `false` at the end.
    pub fn advance_past(&mut self, comments: &[&str]) -> Result<bool, StructureError> {
        let before = self.number;
        while self.advance()? {
            let text = self.text.trim();
            if !text.is_empty() && !comments.iter().any(|mark| text.starts_with(mark)) {
                return Ok(true);
            }
            if self.number - before > MOST_SKIPPED {
                return Err(
                    self.fault("more than a million empty lines or comments in a row (is this another format?)")
                );
            }
        }
        Ok(false)
    }

    /// Like [`Lines::advance_past`]; the end of the file is an error.
    pub fn advance_to(&mut self, comments: &[&str], wanted: &str) -> Result<(), StructureError> {
        if self.advance_past(comments)? {
            return Ok(());
        }
        Err(self.fault(format!("the file is truncated: {wanted} expected")))
    }

    /// A finite number as Fortran or C write it: `1.5`, `1.5E+06`, `1.5D+06`, `1.5+6`.
    pub fn number_in(&self, word: &str) -> Result<f64, StructureError> {
        parse_number(word).ok_or_else(|| self.fault(format!("expected a finite number, found \"{}\"", word.trim())))
    }

    /// A row or column counted from 1, as an index from 0.
    pub fn index_in(&self, word: &str, order: usize, what: &str) -> Result<u32, StructureError> {
        match word.trim().parse::<usize>() {
            Ok(number) if (1..=order).contains(&number) => Ok((number - 1) as u32),
            _ => Err(self.fault(format!("{what} out of range: expected 1 to {order}, found \"{}\"", word.trim()))),
        }
    }
}

/// A finite number with an exponent letter E or D, or none at all.
pub(super) fn parse_number(word: &str) -> Option<f64> {
    let word = word.trim();
    let finite = |text: &str| text.parse::<f64>().ok().filter(|value| value.is_finite());
    let plain = word.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'+' | b'-' | b'.' | b'e' | b'E' | b'd' | b'D'));
    if !plain {
        return None;
    }
    if let Some(at) = word.find(['d', 'D']) {
        return finite(&format!("{}e{}", &word[..at], &word[at + 1..]));
    }
    finite(word).or_else(|| {
        let at = word.rfind(['+', '-']).filter(|at| *at > 0)?;
        finite(&format!("{}e{}", &word[..at], &word[at..]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fortran_numbers() {
        for (text, value) in
            [("1.5", 1.5), ("-6.788D+06", -6.788e6), ("1.5+6", 1.5e6), ("-1.5-6", -1.5e-6), ("2.E3", 2e3), ("7", 7.0)]
        {
            assert_eq!(parse_number(text), Some(value), "{text}");
        }
        for text in ["", "NaN", "inf", "1.5x", "1d2d3", "1e999", "-", "1+2+3"] {
            assert_eq!(parse_number(text), None, "{text}");
        }
    }
}
