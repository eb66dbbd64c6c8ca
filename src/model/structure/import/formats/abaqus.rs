//! Abaqus matrix text (`*MATRIX OUTPUT`): entries by node and direction (`FORMAT=MATRIX INPUT`) or by row (`COORDINATE`). A file
//! may hold several matrices in blocks of `*MATRIX, TYPE=`. Superelements (`*USER ELEMENT`) are read by [`user_element`].

use std::io::Write;

use super::user_element;
use crate::structure::error::StructureError;
use crate::structure::import::entry::{Form, Format, Given, Imported, MatrixKind, Named, RowLabels};
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
        rows: RowLabels::Distinct,
        loss: None,
        write,
    }],
};

/// Reads a matrix: the block of the file, or of several the one whose keyword names the requested matrix.
fn read(given: &Given) -> Result<Imported, StructureError> {
    let Given { file, bytes, kind, listed, .. } = *given;
    if user_element::comes_first(file, bytes)? {
        return user_element::read(given);
    }
    let mut lines = Lines::new(file, bytes);
    let mut entries = Entries::default();
    let mut met: Vec<Block> = Vec::new();
    let mut ahead = Some(Block::default());
    while lines.advance_past(&["**"])? {
        if lines.text.starts_with('*') {
            ahead = Some(Block::begin(&lines)?);
            continue;
        }
        if let Some(block) = ahead.take() {
            let other = met.iter().find(|other| other.may_be(kind)).filter(|_| block.may_be(kind));
            if let Some(Block { line, .. }) = other {
                let reason = format!(
                    "a second block of entries that may be the {}, the first begins at line {line}: expected one with TYPE={}; put them into files of their own",
                    name(kind),
                    keyword(kind)
                );
                return Err(lines.fault(reason));
            }
            // Entries before any keyword begin where they stand.
            let line = if block.line == 0 { lines.number } else { block.line };
            met.push(Block { line, ..block });
        }
        if met.last().is_some_and(|block| block.may_be(kind)) {
            entries.read(&lines)?;
        }
    }
    if !met.is_empty() && !met.iter().any(|block| block.may_be(kind)) {
        let found: Vec<String> = met
            .iter()
            .map(|Block { line, matrix }| format!("{} (line {line})", matrix.as_deref().unwrap_or("")))
            .collect();
        let reason =
            format!("no {}: expected *MATRIX, TYPE={}, found TYPE {}", name(kind), keyword(kind), found.join(", "));
        return Err(StructureError::Matrix { file: file.to_owned(), reason });
    }
    entries.finish(&lines, listed)
}

pub(super) fn name(kind: MatrixKind) -> &'static str {
    match kind {
        MatrixKind::Stiffness => "stiffness",
        MatrixKind::Mass => "mass",
        MatrixKind::Damping => "damping",
    }
}

pub(super) fn keyword(kind: MatrixKind) -> &'static str {
    match kind {
        MatrixKind::Stiffness => "STIFFNESS",
        MatrixKind::Mass => "MASS",
        MatrixKind::Damping => "VISCOUS DAMPING",
    }
}

/// Entries after a keyword as `*MATRIX, TYPE=STIFFNESS`, or before the first one.
#[derive(Default)]
struct Block {
    /// Line of its keyword, or of its first entry; 0 before it is known.
    line: usize,
    /// The matrix that its keyword names, in capitals, where it names one: by `TYPE` of `*MATRIX`, by `MATRIX` of `*MATRIX INPUT`,
    /// whose `TYPE` is the shape.
    matrix: Option<String>,
}

impl Block {
    fn begin(lines: &Lines) -> Result<Self, StructureError> {
        let words: Vec<String> = lines.text.split(',').map(|word| word.trim().to_ascii_uppercase()).collect();
        if words.first().is_some_and(|word| word == "*USER ELEMENT") {
            return Err(lines.fault("a user element behind other matrices: put it into a file of its own"));
        }
        let named_by = match words.first().map(String::as_str) {
            Some("*MATRIX") => "TYPE",
            Some("*MATRIX INPUT") => "MATRIX",
            _ => return Ok(Self { line: lines.number, matrix: None }),
        };
        let mut parameters = words.iter().filter_map(|word| word.split_once('='));
        let matrix = parameters.find(|(name, _)| name.trim() == named_by).map(|(_, value)| value.trim().to_owned());
        Ok(Self { line: lines.number, matrix })
    }

    /// Whether this can be the requested matrix: of its type, or of none.
    fn may_be(&self, kind: MatrixKind) -> bool {
        self.matrix.as_ref().is_none_or(|matrix| matrix == keyword(kind))
    }
}

/// Entries that are read so far; the number of words of the first line gives their form.
#[derive(Default)]
struct Entries {
    labelled: LabelledMatrix,
    numbered: Triplets,
    words_per_line: usize,
    order: usize,
}

impl Entries {
    fn read(&mut self, lines: &Lines) -> Result<(), StructureError> {
        let words: Vec<&str> = lines.text.split([' ', '\t', ',']).filter(|word| !word.is_empty()).collect();
        if self.words_per_line == 0 {
            self.words_per_line = words.len();
        }
        match words[..] {
            [row, column, value] if self.words_per_line == 3 => {
                let index = |word, what| lines.index_in(word, MOST_ROWS, what);
                let (row, column) = (index(row, "row")?, index(column, "column")?);
                self.order = self.order.max(row.max(column) as usize + 1);
                self.numbered.push(row, column, lines.number_in(value)?);
            }
            [node, dof, other, other_dof, value] if self.words_per_line == 5 => {
                let (row, column) = (label(lines, node, dof)?, label(lines, other, other_dof)?);
                self.labelled.push(row, column, lines.number_in(value)?);
            }
            _ => {
                let reason = format!(
                    "expected node, direction, node, direction, value (or row, column, value) on every line, found \"{}\"",
                    lines.text.trim()
                );
                return Err(lines.fault(reason));
            }
        }
        Ok(())
    }

    fn finish(self, lines: &Lines, listed: Option<usize>) -> Result<Imported, StructureError> {
        match self.words_per_line {
            0 => Err(lines.fault("the file is empty: entries of a matrix expected")),
            3 => {
                self.numbered.justify(lines.file, self.order, listed)?;
                self.numbered.assemble_as_found(lines.file, self.order).map(Imported::Rows)
            }
            _ => Ok(Imported::Labels(self.labelled)),
        }
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
