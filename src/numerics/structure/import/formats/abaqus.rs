//! Abaqus matrix text (`*MATRIX OUTPUT`): entries by node and direction (`FORMAT=MATRIX INPUT`) or by row (`COORDINATE`).

use std::io::Write;

use crate::structure::error::StructureError;
use crate::structure::import::entry::{Form, Format, Given, Imported, Named, RowLabels};
use crate::structure::import::labelled::LabelledMatrix;
use crate::structure::import::lines::Lines;
use crate::structure::import::rows::{direction, number};
use crate::structure::import::triplets::{MOST_ROWS, Triplets};
use crate::structure::label::DofLabel;

pub(super) const FORMAT: Format = Format {
    endings: &[],
    read,
    forms: &[Form {
        name: "abaqus",
        files: ["STIF1.mtx", "MASS1.mtx", "DMPV1.mtx"],
        rows: RowLabels::Needed,
        loss: None,
        write,
    }],
};

/// Reads a matrix; the number of words of its first line tells which form it has.
fn read(given: &Given) -> Result<Imported, StructureError> {
    let Given { file, bytes, listed, .. } = *given;
    let mut lines = Lines::new(file, bytes);
    let mut labelled = LabelledMatrix::default();
    let mut entries = Triplets::default();
    let (mut words_per_line, mut order) = (0, 0);
    while lines.advance_past(&["**"])? {
        if lines.text.starts_with('*') {
            // A keyword as *MATRIX, TYPE=STIFFNESS of the MATRIX INPUT form.
            continue;
        }
        let words: Vec<&str> = lines.text.split([' ', '\t', ',']).filter(|word| !word.is_empty()).collect();
        if words_per_line == 0 {
            words_per_line = words.len();
        }
        match words[..] {
            [row, column, value] if words_per_line == 3 => {
                let index = |word, what| lines.index_in(word, MOST_ROWS, what);
                let (row, column) = (index(row, "row")?, index(column, "column")?);
                order = order.max(row.max(column) as usize + 1);
                entries.push(row, column, lines.number_in(value)?);
            }
            [node, dof, other, other_dof, value] if words_per_line == 5 => {
                let (row, column) = (label(&lines, node, dof)?, label(&lines, other, other_dof)?);
                labelled.push(row, column, lines.number_in(value)?);
            }
            _ => {
                let reason = format!(
                    "expected node, direction, node, direction, value (or row, column, value) on every line, found \"{}\"",
                    lines.text.trim()
                );
                return Err(lines.fault(reason));
            }
        }
    }
    match words_per_line {
        0 => Err(lines.fault("the file is empty: entries of a matrix expected")),
        3 => {
            entries.justify(file, order, listed)?;
            entries.assemble_as_found(file, order).map(Imported::Rows)
        }
        _ => Ok(Imported::Labels(labelled)),
    }
}

fn label(lines: &Lines, node: &str, dof: &str) -> Result<DofLabel, StructureError> {
    let parsed = node.parse().ok().zip(direction(dof));
    parsed
        .map(|(node, dof)| DofLabel { node, dof })
        .ok_or_else(|| lines.fault(format!("expected a node and a direction 0 to 6, found \"{node}\" and \"{dof}\"")))
}

/// Writes the lower triangle by node and direction, 17 digits.
fn write(out: &mut dyn Write, named: &Named) -> std::io::Result<()> {
    let Named { matrix, labels, .. } = *named;
    for (column, (label, view)) in labels.iter().zip(matrix.outer_iterator()).enumerate() {
        for (row, value) in view.iter().filter(|(row, _)| *row >= column) {
            let Some(other) = labels.get(row) else { continue };
            let (i, j) = (number(other.dof), number(label.dof));
            writeln!(out, "{},{i}, {},{j}, {value:.17e}", other.node, label.node)?;
        }
    }
    Ok(())
}
