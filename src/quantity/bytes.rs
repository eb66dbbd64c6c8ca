//! Cells as bytes: a tag, then a number or a text's length, then the text.

use super::value::{Cell, Value};

/// No cell begins with it or a larger one.
pub const FREE_TAG: u8 = 5;

/// Appends a cell, as [`super::take_cells`] takes it.
#[inline]
pub fn put_cell(bytes: &mut Vec<u8>, cell: Cell<'_>) {
    let (tag, number) = match cell {
        None => return bytes.push(0),
        Some(Value::Real(value)) => (1, value.to_bits()),
        Some(Value::Count(value)) => (2, value),
        Some(Value::Integer(value)) => (3, value.cast_unsigned()),
        Some(Value::Text(text)) => (4, text.len() as u64),
    };
    let mut head = [tag; 9];
    head[1..].copy_from_slice(&number.to_le_bytes());
    bytes.extend_from_slice(&head);
    if let Some(Value::Text(text)) = cell {
        bytes.extend_from_slice(text.as_bytes());
    }
}

/// Takes a cell off the front of bytes; `None` if they do not begin with a whole one.
pub(super) fn take_cell<'a>(bytes: &mut &'a [u8]) -> Option<Cell<'a>> {
    let (tag, rest) = bytes.split_first()?;
    if *tag == 0 {
        *bytes = rest;
        return Some(None);
    }
    let (number, mut rest) = rest.split_first_chunk()?;
    let number = u64::from_le_bytes(*number);
    let value = match tag {
        1 => Value::Real(f64::from_bits(number)),
        2 => Value::Count(number),
        3 => Value::Integer(number.cast_signed()),
        4 => {
            let (text, behind) = rest.split_at_checked(usize::try_from(number).ok()?)?;
            rest = behind;
            Value::Text(std::str::from_utf8(text).ok()?)
        }
        _ => return None,
    };
    *bytes = rest;
    Some(Some(value))
}
