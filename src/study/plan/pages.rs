//! Pages of a Parquet file. Their stated sizes are compared with the available bytes before decoding.
//!
//! Decoders allocate memory by the numbers in a page's header. The header is a struct of Thrift's compact protocol. Only the few numbers
//! that determine memory are read here.

use std::io::{self, Read};

use flate2::read::MultiGzDecoder;
use parquet::basic::Compression;
use parquet::file::metadata::ColumnChunkMetaData;

/// Most bytes that a page may unpack to; writers cut pages at 1 MB.
const MOST_PAGE_BYTES: u64 = 100_000_000;
/// Least bytes of a value in a dictionary.
const LEAST_VALUE_BYTES: u64 = 4;
/// Structs within structs of a page's head: more are none of its.
const DEEPEST: usize = 8;

/// Types of Thrift's compact protocol.
mod kind {
    pub const TRUE: u8 = 1;
    pub const FALSE: u8 = 2;
    pub const BYTE: u8 = 3;
    pub const SHORT: u8 = 4;
    pub const INT: u8 = 5;
    pub const LONG: u8 = 6;
    pub const DOUBLE: u8 = 7;
    pub const BINARY: u8 = 8;
    pub const LIST: u8 = 9;
    pub const SET: u8 = 10;
    pub const STRUCT: u8 = 12;
}

/// Contents of a page's header.
#[derive(Debug, Default, PartialEq, Eq)]
struct PageHead {
    unpacked: u64,
    packed: u64,
    dictionary_values: u64,
}

/// Holds the pages of a column to the bytes of its file.
///
/// # Errors
/// What is wrong, in words.
pub(super) fn check(bytes: &[u8], column: &ColumnChunkMetaData) -> Result<(), String> {
    let (start, length) = column.byte_range();
    let mut rest = usize::try_from(start)
        .ok()
        .zip(usize::try_from(length).ok())
        .and_then(|(start, length)| bytes.get(start..start.checked_add(length)?))
        .ok_or_else(|| "its column lies outside of it: it is damaged or truncated".to_owned())?;
    while !rest.is_empty() {
        let page = PageHead::read(&mut rest).and_then(|head| {
            let (page, behind) = rest.split_at_checked(usize::try_from(head.packed).ok()?)?;
            rest = behind;
            Some((head, page))
        });
        let Some((head, page)) = page else { return Err("a page is damaged".to_owned()) };
        if head.unpacked > MOST_PAGE_BYTES || head.dictionary_values > head.unpacked / LEAST_VALUE_BYTES {
            return Err(format!(
                "a page states {} bytes and {} values in a dictionary: expected at most {MOST_PAGE_BYTES} bytes, and \
                 {LEAST_VALUE_BYTES} of them for each value",
                head.unpacked, head.dictionary_values
            ));
        }
        if matches!(column.compression(), Compression::GZIP(_)) && unpacks_beyond(page, head.unpacked) {
            return Err(format!("a page unpacks to more than the {} bytes that it states", head.unpacked));
        }
    }
    Ok(())
}

/// Whether gzip bytes unpack to more than `most`; other packings give their decoders a limit.
fn unpacks_beyond(packed: &[u8], most: u64) -> bool {
    let mut left = MultiGzDecoder::new(packed).take(most + 1);
    io::copy(&mut left, &mut io::sink()).is_ok_and(|unpacked| unpacked > most)
}

impl PageHead {
    /// Reads a head off the bytes; `None` if it is none.
    fn read(rest: &mut &[u8]) -> Option<Self> {
        let mut head = Self::default();
        let mut field = 0;
        while let Some(what) = next_field(rest, &mut field)? {
            match (field, what) {
                (2, kind::INT) => head.unpacked = signed(rest)?.try_into().ok()?,
                (3, kind::INT) => head.packed = signed(rest)?.try_into().ok()?,
                (7, kind::STRUCT) => head.dictionary_values = dictionary_values(rest)?,
                (_, what) => skip(rest, what, DEEPEST)?,
            }
        }
        Some(head)
    }
}

/// The number of values that the head of a dictionary's page states.
fn dictionary_values(rest: &mut &[u8]) -> Option<u64> {
    let (mut values, mut field) = (0, 0);
    while let Some(what) = next_field(rest, &mut field)? {
        match (field, what) {
            (1, kind::INT) => values = signed(rest)?.try_into().ok()?,
            (_, what) => skip(rest, what, DEEPEST)?,
        }
    }
    Some(values)
}

/// The type of a struct's next field, whose number goes to `field`; `Some(None)` at the struct's end.
fn next_field(rest: &mut &[u8], field: &mut i64) -> Option<Option<u8>> {
    let byte = take(rest, 1)?.first().copied()?;
    if byte == 0 {
        return Some(None);
    }
    *field = match byte >> 4 {
        0 => signed(rest)?,
        step => field.checked_add(i64::from(step))?,
    };
    Some(Some(byte & 0x0f))
}

/// Passes over a value.
fn skip(rest: &mut &[u8], what: u8, depth: usize) -> Option<()> {
    match what {
        kind::TRUE | kind::FALSE => {}
        kind::BYTE => drop(take(rest, 1)?),
        kind::SHORT | kind::INT | kind::LONG => drop(unsigned(rest)?),
        kind::DOUBLE => drop(take(rest, 8)?),
        kind::BINARY => {
            let length = usize::try_from(unsigned(rest)?).ok()?;
            take(rest, length)?;
        }
        kind::LIST | kind::SET => {
            let byte = take(rest, 1)?.first().copied()?;
            let count = if byte >> 4 == 0x0f { unsigned(rest)? } else { u64::from(byte >> 4) };
            for _ in 0..count {
                match byte & 0x0f {
                    // In a list they take a byte; for fields the type contains the value.
                    kind::TRUE | kind::FALSE => drop(take(rest, 1)?),
                    inner => skip(rest, inner, depth.checked_sub(1)?)?,
                }
            }
        }
        kind::STRUCT => {
            let mut field = 0;
            while let Some(inner) = next_field(rest, &mut field)? {
                skip(rest, inner, depth.checked_sub(1)?)?;
            }
        }
        _ => return None,
    }
    Some(())
}

/// A whole number, seven bits a byte.
fn unsigned(rest: &mut &[u8]) -> Option<u64> {
    let mut value = 0_u64;
    for shift in (0..64).step_by(7) {
        let byte = take(rest, 1)?.first().copied()?;
        value |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Some(value);
        }
    }
    None
}

/// A whole number whose last bit is its sign.
fn signed(rest: &mut &[u8]) -> Option<i64> {
    let value = unsigned(rest)?;
    Some((value >> 1).cast_signed() ^ -(value & 1).cast_signed())
}

fn take<'a>(rest: &mut &'a [u8], count: usize) -> Option<&'a [u8]> {
    let (taken, left) = rest.split_at_checked(count)?;
    *rest = left;
    Some(taken)
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    /// A head: page type 2, 1000 bytes, 40 packed, a check sum, a dictionary of 7 values in encoding 0 that is sorted.
    const HEAD: &[u8] = &[0x15, 4, 0x15, 0xd0, 0x0f, 0x15, 80, 0x15, 9, 0x3c, 0x15, 14, 0x15, 0, 0x11, 0, 0];

    #[test]
    fn heads_are_read_as_they_are_written() {
        let bytes = [HEAD, b"rest"].concat();
        let mut rest = bytes.as_slice();
        let head = PageHead::read(&mut rest);
        assert_eq!(head, Some(PageHead { unpacked: 1000, packed: 40, dictionary_values: 7 }));
        assert_eq!(rest, b"rest");
        for length in 0..HEAD.len() {
            assert_eq!(PageHead::read(&mut &HEAD[..length]), None, "{length} bytes");
        }
    }

    #[test]
    fn gzip_is_held_to_the_size_stated() {
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
        packed.write_all(&[7; 5000]).expect("written");
        let packed = packed.finish().expect("packed");
        assert!(unpacks_beyond(&packed, 4999) && !unpacks_beyond(&packed, 5000));
    }
}
