//! Nastran DMIG entries in bulk data or punch files: small, large and free field.

use std::io::Write;

use sprs::CsMat;

use super::dofs::{direction, number};
use super::labelled::LabelledMatrix;
use super::lines::Lines;
use crate::structure::error::StructureError;
use crate::structure::model::DofLabel;

/// One entry of the bulk data: its fields without the card's name, four or eight per line.
struct Card {
    line: usize,
    fields: Vec<String>,
}

/// Reads the matrix of this name.
pub(super) fn parse(file: &str, bytes: &[u8], name: &str) -> Result<LabelledMatrix, StructureError> {
    let mut lines = Lines::new(file, bytes);
    let mut matrix = LabelledMatrix::default();
    let mut header: Option<usize> = None;
    let mut columns = 0;
    let mut names: Vec<String> = Vec::new();
    let mut pending = next_card(&mut lines, None)?;
    while let Some((card, following)) = pending {
        let field = |index: usize| card.fields.get(index).map_or("", String::as_str);
        let own = field(0).eq_ignore_ascii_case(name);
        if field(1) == "0" && !field(2).is_empty() {
            if !own && !names.contains(&field(0).to_owned()) {
                names.push(field(0).to_owned());
            }
            if own {
                header = Some(card.line);
                check_header(&lines, &card)?;
            }
        } else if own {
            if header.is_none() {
                return Err(lines.fault_at(card.line, format!("a column of {name} before its header")));
            }
            columns += 1;
            read_column(&lines, &card, &mut matrix)?;
        }
        pending = next_card(&mut lines, following)?;
    }
    if header.is_none() {
        let reason = format!(
            "no DMIG matrix {name}; found: {}",
            if names.is_empty() { "none".into() } else { names.join(", ") }
        );
        return Err(StructureError::Matrix { file: file.to_owned(), reason });
    }
    if columns == 0 {
        return Err(lines.fault(format!("the file is cut short: matrix {name} has a header but no column")));
    }
    Ok(matrix)
}

type Next = Option<(Card, Option<String>)>;

/// The next DMIG card, and the line after it. `current` is a line that was read already.
fn next_card(lines: &mut Lines, current: Option<String>) -> Result<Next, StructureError> {
    let mut first = current;
    loop {
        if first.is_none() {
            if !lines.advance_past(&["$"])? {
                return Ok(None);
            }
            first = Some(lines.text.clone());
        }
        let text = first.take().unwrap_or_default();
        let mnemonic = text.split([' ', ',', '*']).next().unwrap_or_default();
        if !mnemonic.eq_ignore_ascii_case("DMIG") {
            continue;
        }
        let mut card = Card { line: lines.number, fields: split(lines, &text)? };
        while lines.advance_past(&["$"])? {
            if !lines.text.starts_with(['*', '+', ' ', ',', '\t']) {
                return Ok(Some((card, Some(lines.text.clone()))));
            }
            card.fields.extend(split(lines, &lines.text.clone())?);
        }
        return Ok(Some((card, None)));
    }
}

/// Fields after the first: by commas, or by columns of 8 or 16 characters.
fn split(lines: &Lines, text: &str) -> Result<Vec<String>, StructureError> {
    if !text.is_ascii() {
        return Err(lines.fault("expected plain characters"));
    }
    let large = text.split([',', ' ']).next().is_some_and(|first| first.contains('*')) || text.starts_with('*');
    let (count, width) = if large { (4, 16) } else { (8, 8) };
    if text.contains(',') {
        let mut fields: Vec<String> = text.split(',').skip(1).map(|field| field.trim().to_owned()).collect();
        fields.resize(fields.len().div_ceil(4).max(1) * 4, String::new());
        fields.truncate(count);
        return Ok(fields);
    }
    let field = |index: usize| {
        let begin = (8 + index * width).min(text.len());
        text[begin..(begin + width).min(text.len())].trim().to_owned()
    };
    Ok((0..count).map(field).collect())
}

fn check_header(lines: &Lines, card: &Card) -> Result<(), StructureError> {
    let field = |index: usize| card.fields.get(index).map_or("", String::as_str);
    if !matches!(field(2), "1" | "6") {
        let reason = format!("form {} of {}: expected 6 (symmetric) or 1 (square)", field(2), field(0));
        return Err(lines.fault_at(card.line, reason));
    }
    if !matches!(field(3), "1" | "2") {
        let reason = format!("type {} of {}: expected 1 or 2 (real)", field(3), field(0));
        return Err(lines.fault_at(card.line, reason));
    }
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
    let field = |index: usize| card.fields.get(index).map_or("", String::as_str);
    let column = label(field(1), field(2))?;
    matrix.mention(column);
    let mut entries = 0;
    for group in card.fields.get(4..).unwrap_or_default().chunks(4) {
        if group.iter().all(String::is_empty) {
            continue;
        }
        let [node, dof, value, ..] = group else { return Err(fault("a row without a value".to_owned())) };
        let value = super::lines::parse_number(value)
            .ok_or_else(|| fault(format!("expected a finite number, found \"{value}\"")))?;
        matrix.push(label(node, dof)?, column, value);
        entries += 1;
    }
    if entries == 0 {
        return Err(fault("a column without entries (is the file cut short?)".to_owned()));
    }
    Ok(())
}

/// Writes the upper triangle in large field, ten digits as Nastran does.
pub(super) fn write(out: &mut dyn Write, name: &str, matrix: &CsMat<f64>, labels: &[DofLabel]) -> std::io::Result<()> {
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
