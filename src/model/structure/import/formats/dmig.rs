//! Nastran DMIG entries in bulk data or punch files: small, large and free field. Where GRID and CORD2R entries stand in the same
//! file, the matrix is along the axes that they state.

use std::io::Write;

use crate::structure::error::StructureError;
use crate::structure::import::bulk::{Card, Cards};
use crate::structure::import::entry::{Form, Format, Given, Imported, Named, RowLabels};
use crate::structure::import::labelled::LabelledMatrix;
use crate::structure::import::lines::{Lines, parse_number};
use crate::structure::import::rows::{direction, number};
use crate::structure::import::superelement;
use crate::structure::import::triplets::Storage;
use crate::structure::label::DofLabel;

const LOSS: &str = "DMIG entries have ten digits: enough for a reduced model, but the lowest frequencies of a whole one move (by \
    parts of a per cent where the stiffness is ill-conditioned); all other formats keep 17 digits";

pub(super) const FORMAT: Format = Format {
    endings: &["pch", "bdf", "dmig"],
    read,
    forms: &[Form {
        name: "dmig",
        files: ["K.pch", "M.pch", "D.pch"],
        rows: RowLabels::NumberedFromOne,
        loss: Some(LOSS),
        write,
    }],
};

/// Reads the matrix of this name.
fn read(given: &Given) -> Result<Imported, StructureError> {
    let Given { file, bytes, name, .. } = *given;
    let mut cards = Cards::new(file, bytes);
    let mut matrix = LabelledMatrix::default();
    let mut header: Option<usize> = None;
    let mut names: Vec<String> = Vec::new();
    while let Some(card) = cards.next(&["DMIG"])? {
        let field = |index: usize| card.field(index);
        let own = field(0).eq_ignore_ascii_case(name);
        let begins = field(1) == "0" && !field(2).is_empty();
        match (own, begins, header) {
            (true, true, None) => {
                header = Some(card.line);
                read_header(&cards.lines, &card, &mut matrix)?;
            }
            (true, true, Some(first)) => {
                let reason = format!(
                    "a second matrix {name}, the first begins at line {first}: expected one of each name; keep that which is meant (was a punch file appended to another?)"
                );
                return Err(cards.lines.fault_at(card.line, reason));
            }
            (true, false, None) => {
                return Err(cards.lines.fault_at(card.line, format!("a column of {name} before its header")));
            }
            (true, false, Some(_)) => read_column(&cards.lines, &card, &mut matrix)?,
            (false, true, _) if !names.contains(&field(0).to_owned()) => names.push(field(0).to_owned()),
            (false, ..) => {}
        }
    }
    if header.is_none() {
        let reason = format!(
            "no DMIG matrix {name}; found: {}",
            if names.is_empty() { "none".into() } else { names.join(", ") }
        );
        return Err(StructureError::Matrix { file: file.to_owned(), reason });
    }
    require_columns(&cards.lines, name, &matrix)?;
    matrix.nodes = superelement::parse_nodes(file, bytes, matrix.labels())?;
    Ok(Imported::Labels(matrix))
}

/// Checks that columns exist, and that every coupled row has the column with its diagonal.
fn require_columns(lines: &Lines, name: &str, matrix: &LabelledMatrix) -> Result<(), StructureError> {
    if matrix.columns().next().is_none() {
        return Err(lines.fault(format!("the file is truncated: matrix {name} has a header but no column")));
    }
    if let Some(DofLabel { node, dof }) = matrix.without_diagonal() {
        let dof = number(dof);
        return Err(lines.fault(format!(
            "the file is truncated: in matrix {name} node {node} direction {dof} is coupled to others, but its own entry ({node}, {dof}) of the diagonal is missing"
        )));
    }
    Ok(())
}

/// Reads the form (a square matrix has all entries, a symmetric one a triangle, in some files both) and, if given, the number of columns.
fn read_header(lines: &Lines, card: &Card, matrix: &mut LabelledMatrix) -> Result<(), StructureError> {
    let field = |index: usize| card.field(index);
    if !matches!(field(2), "1" | "6") {
        let reason = format!("form {} of {}: expected 6 (symmetric) or 1 (square)", field(2), field(0));
        return Err(lines.fault_at(card.line, reason));
    }
    if !matches!(field(3), "1" | "2") {
        let reason = format!("type {} of {}: expected 1 or 2 (real)", field(3), field(0));
        return Err(lines.fault_at(card.line, reason));
    }
    matrix.storage = (field(2) == "1").then_some(Storage::Both);
    matrix.stated_columns = field(7).parse().ok();
    Ok(())
}

fn read_column(lines: &Lines, card: &Card, matrix: &mut LabelledMatrix) -> Result<(), StructureError> {
    let fault = |reason: String| lines.fault_at(card.line, reason);
    let label = |node: &str, dof: &str| {
        let parsed =
            node.parse().ok().filter(|node: &i64| *node > 0).zip(direction(if dof.is_empty() { "0" } else { dof }));
        parsed.map(|(node, dof)| DofLabel { node, dof }).ok_or_else(|| {
            fault(format!("expected a grid point and a component 0 to 6, found \"{node}\" and \"{dof}\""))
        })
    };
    let field = |index: usize| card.field(index);
    let column = label(field(1), field(2))?;
    matrix.begin_column(column);
    let mut entries = 0;
    for group in card.fields.get(4..).unwrap_or_default().chunks(4) {
        if group.iter().all(String::is_empty) {
            continue;
        }
        let [node, dof, value, ..] = group else { return Err(fault("a row without a value".to_owned())) };
        let value = parse_number(value).ok_or_else(|| fault(format!("expected a finite number, found \"{value}\"")))?;
        matrix.push(label(node, dof)?, column, value);
        entries += 1;
    }
    if entries == 0 {
        return Err(fault("a column without entries (is the file truncated?)".to_owned()));
    }
    Ok(())
}

/// Writes the upper triangle in large field, ten digits as Nastran does.
fn write(out: &mut dyn Write, named: &Named) -> std::io::Result<()> {
    let Named { name, matrix, labels } = *named;
    writeln!(out, "DMIG    {name:<8}{:>8}{:>8}{:>8}{:>8}{:>24}", 0, 6, 2, 0, matrix.rows())?;
    for (label, (column, view)) in labels.iter().zip(matrix.outer_iterator().enumerate()) {
        let entries: Vec<(usize, f64)> = view
            .iter()
            .filter(|(row, value)| *row <= column && **value != 0.0)
            .map(|(row, value)| (row, *value))
            .collect();
        if entries.is_empty() {
            continue;
        }
        writeln!(out, "DMIG*   {name:<8}{:>24}{:>16}", label.node, number(label.dof))?;
        for (row, value) in entries {
            let Some(row) = labels.get(row) else { continue };
            writeln!(out, "*       {:>16}{:>16}{}", row.node, number(row.dof), fortran(value))?;
        }
    }
    Ok(())
}

/// `%16.9E` with the exponent letter D.
fn fortran(value: f64) -> String {
    let text = format!("{value:.9e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{:>16}", format!("{mantissa}D{sign}{:02}", exponent.abs()))
}
