//! Arrays of NumPy in a ZIP archive (`.npz`).

use std::collections::BTreeMap;
use std::io::Read;

use flate2::read::DeflateDecoder;

use super::lines::most_unpacked;
use crate::structure::error::StructureError;

/// End of the archive, its directory and an entry of it, by their first bytes.
const END: &[u8] = b"PK\x05\x06";
const LISTED: &[u8] = b"PK\x01\x02";
const ENTRY: &[u8] = b"PK\x03\x04";
/// The end is the last of the file but for a comment of up to so many bytes.
const LONGEST_COMMENT: usize = 65_535;
/// Most arrays that are read.
const MOST_ARRAYS: usize = 1000;
const EXPECTED: &str = "expected a file of scipy.sparse.save_npz";

/// Values of an array in the order of the file.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Numbers {
    Whole(Vec<i64>),
    Real(Vec<f64>),
    /// One text.
    Text(String),
}

/// All arrays of an archive, by their names without `.npy`.
///
/// # Errors
/// A file that is no archive, is truncated, is damaged, or unpacks to more than its size justifies; arrays of other types.
pub(super) fn arrays(file: &str, bytes: &[u8]) -> Result<BTreeMap<String, Numbers>, StructureError> {
    let fault = |reason: String| StructureError::Matrix { file: file.to_owned(), reason };
    let mut left = most_unpacked(bytes.len());
    let mut out = BTreeMap::new();
    for listed in directory(bytes).map_err(fault)? {
        let Some(name) = listed.name.strip_suffix(".npy") else { continue };
        let unpacked = listed.unpack(bytes, left).map_err(|reason| fault(format!("array \"{name}\": {reason}")))?;
        left -= unpacked.len() as u64;
        let array = array(&unpacked).map_err(|reason| fault(format!("array \"{name}\": {reason}")))?;
        out.insert(name.to_owned(), array);
    }
    Ok(out)
}

/// An entry of the archive's directory.
struct Listed {
    name: String,
    packed: bool,
    checksum: u32,
    size: usize,
    unpacked_size: usize,
    at: usize,
}

fn number<const N: usize>(bytes: &[u8], at: usize) -> Option<u64> {
    let field = bytes.get(at..at.checked_add(N)?)?;
    Some(field.iter().rev().fold(0, |value, byte| (value << 8) | u64::from(*byte)))
}

fn directory(bytes: &[u8]) -> Result<Vec<Listed>, String> {
    let cut = || format!("the file is truncated or no archive: {EXPECTED}");
    let tail = bytes.len().saturating_sub(LONGEST_COMMENT + 22);
    let end = bytes[tail..].windows(END.len()).rposition(|window| window == END).map(|at| tail + at).ok_or_else(cut)?;
    let (count, start) = (number::<2>(bytes, end + 10), number::<4>(bytes, end + 16));
    let (Some(count), Some(start)) = (count, start) else { return Err(cut()) };
    if start == u64::from(u32::MAX) {
        return Err("an archive of more than 4 GB: write the matrix as Matrix Market".to_owned());
    }
    if count as usize > MOST_ARRAYS {
        return Err(format!("{count} arrays: {EXPECTED}"));
    }
    let mut at = start as usize;
    let mut out = Vec::new();
    for _ in 0..count {
        let (listed, length) = listed(bytes, at).ok_or_else(cut)?;
        out.push(listed);
        at += length;
    }
    Ok(out)
}

/// An entry of the directory and its length.
fn listed(bytes: &[u8], at: usize) -> Option<(Listed, usize)> {
    if bytes.get(at..at.checked_add(4)?)? != LISTED {
        return None;
    }
    let field = |offset: usize| number::<2>(bytes, at + offset).map(|value| value as usize);
    let (name, extra, comment) = (field(28)?, field(30)?, field(32)?);
    let listed = Listed {
        name: String::from_utf8_lossy(bytes.get(at + 46..at + 46 + name)?).into_owned(),
        packed: match field(10)? {
            0 => false,
            8 => true,
            _ => return None,
        },
        checksum: number::<4>(bytes, at + 16)? as u32,
        size: number::<4>(bytes, at + 20)? as usize,
        unpacked_size: number::<4>(bytes, at + 24)? as usize,
        at: number::<4>(bytes, at + 42)? as usize,
    };
    Some((listed, 46 + name + extra + comment))
}

impl Listed {
    fn unpack(&self, bytes: &[u8], left: u64) -> Result<Vec<u8>, String> {
        let cut = || "the file is truncated or damaged: write it again".to_owned();
        if bytes.get(self.at..self.at.saturating_add(4)) != Some(ENTRY) {
            return Err(cut());
        }
        let field = |offset: usize| number::<2>(bytes, self.at + offset).map(|value| value as usize);
        let (name, extra) = field(26).zip(field(28)).ok_or_else(cut)?;
        let from = self.at + 30 + name + extra;
        let packed = bytes.get(from..from.saturating_add(self.size)).ok_or_else(cut)?;
        if self.unpacked_size as u64 > left {
            return Err("it unpacks to far more than the size of the file, which no matrix does".to_owned());
        }
        let mut out = Vec::new();
        let limit = self.unpacked_size as u64 + 1;
        let read = match self.packed {
            true => DeflateDecoder::new(packed).take(limit).read_to_end(&mut out),
            false => packed.take(limit).read_to_end(&mut out),
        };
        let mut sum = flate2::Crc::new();
        sum.update(&out);
        if read.is_err() || out.len() != self.unpacked_size || sum.sum() != self.checksum {
            return Err(cut());
        }
        Ok(out)
    }
}

/// Reads a file of NumPy.
fn array(bytes: &[u8]) -> Result<Numbers, String> {
    let no_array = || "not an array of NumPy".to_owned();
    if !bytes.starts_with(b"\x93NUMPY") {
        return Err(no_array());
    }
    let (length, from): (_, usize) = match bytes.get(6).ok_or_else(no_array)? {
        1 => (number::<2>(bytes, 8), 10),
        _ => (number::<4>(bytes, 8), 12),
    };
    let length = length.ok_or_else(no_array)? as usize;
    let head = bytes.get(from..from.saturating_add(length)).ok_or_else(no_array)?;
    let head = String::from_utf8_lossy(head);
    let kind = quoted(&head, "'descr'").ok_or_else(no_array)?;
    let data = &bytes[from + length..];
    let (order, kind) = kind.split_at(kind.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(0));
    let big = order == ">";
    numbers(kind, big, data)
}

/// The text in quotes behind a key.
fn quoted<'a>(head: &'a str, key: &str) -> Option<&'a str> {
    let (_, rest) = head.split_once(key)?;
    let (_, rest) = rest.split_once('\'')?;
    rest.split_once('\'').map(|(text, _)| text)
}

fn numbers(kind: &str, big: bool, data: &[u8]) -> Result<Numbers, String> {
    let (letter, size) = kind.split_at(kind.len().min(1));
    let size: usize = size.parse().ok().filter(|size| (1..=256).contains(size)).ok_or("a type without a size")?;
    let width = if letter == "U" { 4 * size } else { size };
    if !data.len().is_multiple_of(width) {
        return Err("its values end within one: is the file damaged?".to_owned());
    }
    let little = |chunk: &[u8]| {
        let mut bytes = [0; 8];
        let used = &mut bytes[..chunk.len()];
        used.copy_from_slice(chunk);
        if big {
            used.reverse();
        }
        bytes
    };
    let chunks = data.chunks_exact(width);
    Ok(match (letter, size) {
        ("i", 4) => Numbers::Whole(
            chunks.map(|chunk| i64::from(u32::from_le_bytes(first_four(little(chunk))) as i32)).collect(),
        ),
        ("i", 8) => Numbers::Whole(chunks.map(|chunk| i64::from_le_bytes(little(chunk))).collect()),
        ("f", 4) => {
            Numbers::Real(chunks.map(|chunk| f64::from(f32::from_le_bytes(first_four(little(chunk))))).collect())
        }
        ("f", 8) => Numbers::Real(chunks.map(|chunk| f64::from_le_bytes(little(chunk))).collect()),
        ("b", 1) => Numbers::Whole(data.iter().map(|byte| i64::from(*byte)).collect()),
        ("S" | "U", _) => Numbers::Text(data.iter().filter(|byte| **byte != 0).map(|byte| char::from(*byte)).collect()),
        ("c", _) => return Err("complex numbers: expected real ones".to_owned()),
        _ => return Err(format!("numbers of the type {kind}: expected f8, f4, i8 or i4")),
    })
}

fn first_four(bytes: [u8; 8]) -> [u8; 4] {
    [bytes[0], bytes[1], bytes[2], bytes[3]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_of_every_type() {
        let file = |kind: &str, data: &[u8]| {
            let head = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': (1,), }}\n");
            let length = (head.len() as u16).to_le_bytes();
            [&b"\x93NUMPY\x01\x00"[..], &length, head.as_bytes(), data].concat()
        };
        for (kind, data, expected) in [
            ("<i4", &(-3_i32).to_le_bytes()[..], Numbers::Whole(vec![-3])),
            (">i8", &7_i64.to_be_bytes(), Numbers::Whole(vec![7])),
            ("<f4", &0.5_f32.to_le_bytes(), Numbers::Real(vec![0.5])),
            ("<f8", &0.1_f64.to_le_bytes(), Numbers::Real(vec![0.1])),
            ("|S3", b"csr", Numbers::Text("csr".to_owned())),
            ("|b1", &[1], Numbers::Whole(vec![1])),
            ("<U3", b"c\0\0\0s\0\0\0r\0\0\0", Numbers::Text("csr".to_owned())),
        ] {
            assert_eq!(array(&file(kind, data)), Ok(expected), "{kind}");
        }
        for (kind, data) in [("<c16", &[0; 16][..]), ("<f8", &[0; 7]), ("<f", &[0; 4]), ("", &[])] {
            assert!(array(&file(kind, data)).is_err(), "{kind}");
        }
        assert!(array(b"").is_err() && array(b"\x93NUMPY\x01\x00\xff\xff").is_err());
    }
}
