//! Abaqus matrix text (`*MATRIX OUTPUT`): entries by node and direction (`FORMAT=MATRIX INPUT`) or by row (`COORDINATE`).

use std::io::Write;

use sprs::CsMat;

use super::dofs::{direction, number};
use super::labelled::LabelledMatrix;
use super::lines::Lines;
use super::triplets::{MOST_ROWS, Triplets};
use crate::structure::error::StructureError;
use crate::structure::model::DofLabel;

/// What a file holds.
pub(super) enum AbaqusMatrix {
    /// Node, direction, node, direction, value.
    Labelled(LabelledMatrix),
    /// Row, column, value.
    Coordinate(CsMat<f64>),
}

/// Reads a matrix; the number of words of its first line tells which form it has. `listed`: rows by the list of rows.
pub(super) fn parse(file: &str, bytes: &[u8], listed: Option<usize>) -> Result<AbaqusMatrix, StructureError> {
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
            entries.assemble_as_found(file, order).map(AbaqusMatrix::Coordinate)
        }
        _ => Ok(AbaqusMatrix::Labelled(labelled)),
    }
}

fn label(lines: &Lines, node: &str, dof: &str) -> Result<DofLabel, StructureError> {
    let parsed = node.parse().ok().zip(direction(dof));
    parsed
        .map(|(node, dof)| DofLabel { node, dof })
        .ok_or_else(|| lines.fault(format!("expected a node and a direction 0 to 6, found \"{node}\" and \"{dof}\"")))
}

/// Writes the lower triangle by node and direction, 17 digits.
pub(super) fn write(out: &mut dyn Write, matrix: &CsMat<f64>, labels: &[DofLabel]) -> std::io::Result<()> {
    for (column, (label, view)) in labels.iter().zip(matrix.outer_iterator()).enumerate() {
        for (row, value) in view.iter().filter(|(row, _)| *row >= column) {
            let Some(other) = labels.get(row) else { continue };
            let (i, j) = (number(other.dof), number(label.dof));
            writeln!(out, "{},{i}, {},{j}, {value:.17e}", other.node, label.node)?;
        }
    }
    Ok(())
}
