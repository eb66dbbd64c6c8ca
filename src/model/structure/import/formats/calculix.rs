//! CalculiX (`*FREQUENCY, SOLVER=MATRIXSTORAGE`): `.sti` and `.mas` hold `row column value` of one triangle, `.dof` the rows.

use std::io::Write;

use sprs::CsMat;

use crate::structure::error::StructureError;
use crate::structure::import::entry::{Form, Format, Given, Imported, Named, RowLabels};
use crate::structure::import::lines::Lines;
use crate::structure::import::triplets::{Storage, Triplets};

pub(super) const FORMAT: Format = Format {
    endings: &["sti", "mas"],
    read,
    forms: &[Form {
        name: "calculix",
        files: ["model.sti", "model.mas", "model.dam"],
        rows: RowLabels::Needed,
        loss: None,
        write,
    }],
};

fn read(given: &Given) -> Result<Imported, StructureError> {
    let order = given.listed.ok_or_else(|| StructureError::Matrix {
        file: given.file.to_owned(),
        reason: "CalculiX matrices need their .dof file: name it as dof_file".to_owned(),
    })?;
    parse(given.file, given.bytes, order).map(Imported::Rows)
}

/// Reads a `.sti` or `.mas` file of `order` rows.
fn parse(file: &str, bytes: &[u8], order: usize) -> Result<CsMat<f64>, StructureError> {
    let mut lines = Lines::new(file, bytes);
    let mut entries = Triplets::default();
    let mut lower: Option<bool> = None;
    while lines.advance_past(&[])? {
        let words: Vec<&str> = lines.text.split_whitespace().collect();
        let [row, column, value] = words[..] else {
            return Err(lines.fault(format!("expected row, column and value, found \"{}\"", lines.text.trim())));
        };
        let (row, column) = (lines.index_in(row, order, "row")?, lines.index_in(column, order, "column")?);
        if row != column && *lower.get_or_insert(row > column) != (row > column) {
            return Err(lines.fault("expected one triangle only, found entries of both"));
        }
        entries.push(row, column, lines.number_in(value)?);
    }
    // CalculiX writes every diagonal entry, the last one at the very end: a file that stops before it was cut.
    let last = entries.rows.last().copied().max(entries.columns.last().copied());
    if last.is_none_or(|last| last as usize + 1 != order) {
        let found = last.map_or(0, |last| last + 1);
        return Err(
            lines.fault(format!("the file is truncated: it ends at row {found} of {order} (rows by the dof_file)"))
        );
    }
    entries.assemble(file, order, Storage::OneTriangle)
}

/// Writes the upper triangle by columns, 17 digits.
fn write(out: &mut dyn Write, named: &Named) -> std::io::Result<()> {
    for (column, view) in named.matrix.outer_iterator().enumerate() {
        let mut diagonal = false;
        for (row, value) in view.iter().filter(|(row, _)| *row <= column) {
            diagonal |= row == column;
            writeln!(out, "{} {} {value:.17e}", row + 1, column + 1)?;
        }
        if !diagonal {
            writeln!(out, "{} {} {:.17e}", column + 1, column + 1, 0.0)?;
        }
    }
    Ok(())
}
