//! Nastran OUTPUT4 files: text and binary, dense and sparse columns, both byte orders, integers of 32 and 64 bits.
//!
//! A file holds any number of matrices. Only the requested one is read, whatever the shape and type of the others. An error lists the
//! contents of the file. A name that occurs several times is selected by number, `MAA#2`.

mod binary;
mod contents;
mod text;
mod write;

use std::borrow::Cow;
use std::io::Read;

use self::binary::Records;
use self::contents::Contents;
use self::write::{write_binary, write_text};
use crate::structure::error::StructureError;
use crate::structure::import::entry::{Form, Format, Given, Imported, RowLabels};
use crate::structure::import::lines::{Lines, is_packed, unpacked};

pub(super) const FORMAT: Format = Format {
    endings: &["op4"],
    read,
    forms: &[
        Form {
            name: "op4",
            files: ["K.op4", "M.op4", "D.op4"],
            rows: RowLabels::Unused,
            loss: None,
            write: write_text,
        },
        Form {
            name: "op4_binary",
            files: ["K.op4", "M.op4", "D.op4"],
            rows: RowLabels::Unused,
            loss: None,
            write: write_binary,
        },
    ],
};

/// Reads the symmetric matrix of this name, without regard to case.
fn read(given: &Given) -> Result<Imported, StructureError> {
    let Given { file, bytes, name, listed, .. } = *given;
    let whole = if is_packed(bytes) { Cow::Owned(unpack(file, bytes)?) } else { Cow::Borrowed(bytes) };
    let mut contents = Contents::new(name);
    match Records::detect(file, &whole) {
        Some(records) => binary::read(records, &mut contents)?,
        None => text::read(Lines::new(file, &whole), &mut contents)?,
    }
    let (header, entries) = contents.into_matrix(file)?;
    entries.justify(file, header.rows, listed)?;
    let matrix = match header.storage() {
        Some(storage) => entries.assemble(file, header.rows, storage),
        None => entries.assemble_as_found(file, header.rows),
    };
    matrix.map(Imported::Rows)
}

fn unpack(file: &str, bytes: &[u8]) -> Result<Vec<u8>, StructureError> {
    let mut whole = Vec::new();
    unpacked(bytes).read_to_end(&mut whole).map_err(|error| StructureError::Matrix {
        file: file.to_owned(),
        reason: format!("the file is truncated or damaged ({error})"),
    })?;
    Ok(whole)
}
