//! Harwell-Boeing text, as ANSYS writes it (`HBMAT`): real symmetric assembled matrices, one triangle by columns.

use std::io::Write;
use std::ops::RangeInclusive;

use crate::structure::error::StructureError;
use crate::structure::import::entry::{Form, Format, Given, Imported, Named, RowLabels};
use crate::structure::import::lines::Lines;
use crate::structure::import::triplets::{MOST_ROWS, Storage, Triplets};

pub(super) const FORMAT: Format = Format {
    endings: &["matrix", "rsa", "hb"],
    read,
    forms: &[Form {
        name: "harwell_boeing",
        files: ["K.matrix", "M.matrix", "D.matrix"],
        rows: RowLabels::Unused,
        loss: None,
        write,
    }],
};

/// Most numbers per line and most characters of one.
const WIDEST: usize = 1000;

/// Numbers per line and their width.
#[derive(Clone, Copy)]
struct Layout {
    count: usize,
    width: usize,
}

/// Reads a matrix.
fn read(given: &Given) -> Result<Imported, StructureError> {
    let Given { file, bytes, .. } = *given;
    let mut lines = Lines::new(file, bytes);
    let mut line = |wanted: &str| -> Result<String, StructureError> {
        if !lines.advance()? {
            return Err(lines.fault(format!("the file is truncated: {wanted} expected")));
        }
        Ok(lines.text.clone())
    };
    line("the title")?;
    let cards = line("the numbers of lines")?;
    let kind = line("type and size of the matrix")?;
    let formats = line("the formats")?;
    let right_hand_sides = cards.split_whitespace().nth(4).is_some_and(|count| count != "0");
    if right_hand_sides {
        line("the format of right-hand sides")?;
    }
    let words: Vec<&str> = kind.split_whitespace().collect();
    let size = |index: usize| words.get(index)?.parse::<usize>().ok().filter(|size| *size <= MOST_ROWS);
    let kind = words.first().copied().unwrap_or_default().to_ascii_uppercase();
    if !matches!(kind.as_str(), "RSA" | "RUA") {
        let reason = format!("expected type RSA or RUA (real, assembled), found \"{kind}\"");
        return Err(lines.fault_at(3, reason));
    }
    let (Some(rows), Some(columns), Some(count)) = (size(1), size(2), size(3)) else {
        return Err(
            lines.fault_at(3, format!("expected rows, columns and entries (at most {MOST_ROWS}) after the type"))
        );
    };
    if rows != columns || rows == 0 {
        return Err(lines.fault_at(3, format!("expected a square matrix, found {rows} rows and {columns} columns")));
    }
    let layouts: Vec<Layout> = formats.split('(').skip(1).filter_map(layout).collect();
    let [pointers_as, indices_as, values_as, ..] = layouts[..] else {
        return Err(lines.fault_at(4, format!("expected three formats as (1I14)(1I14)(1D25.15), found \"{formats}\"")));
    };
    let pointers =
        integers(&mut lines, Section { layout: pointers_as, count: columns + 1 }, 1..=count + 1, "column pointer")?;
    let indices = integers(&mut lines, Section { layout: indices_as, count }, 1..=rows, "row index")?;
    let mut entries = Triplets::default();
    let (mut column, mut at) = (0, 0);
    numbers(&mut lines, Section { layout: values_as, count }, "value", |lines, text| {
        while pointers.get(column + 1).is_some_and(|end| *end <= at + 1) {
            column += 1;
        }
        entries.push((indices[at] - 1) as u32, column as u32, lines.number_in(text)?);
        at += 1;
        Ok(())
    })?;
    if !pointers.is_sorted() || pointers.first() != Some(&1) || pointers.last() != Some(&(count + 1)) {
        let reason = format!("the column pointers must rise from 1 to {}", count + 1);
        return Err(StructureError::Matrix { file: file.to_owned(), reason });
    }
    if !right_hand_sides && lines.advance_past(&[])? {
        return Err(lines.fault(format!("more than the {count} values that line 3 announces")));
    }
    // Symmetric files hold a triangle; of ANSYS 9 there are some with both.
    let both = kind == "RUA";
    let matrix = if both { entries.assemble(file, rows, Storage::Both) } else { entries.assemble_as_found(file, rows) };
    matrix.map(Imported::Rows)
}

/// `1I14)`, `3E26.16)`, `1P,3E25.16)`.
fn layout(text: &str) -> Option<Layout> {
    let text = text.split(')').next()?.to_ascii_uppercase();
    let text = text.rsplit(',').next()?.trim();
    let letter = text.find(['I', 'E', 'D', 'F', 'G'])?;
    let count = if letter == 0 { 1 } else { text[..letter].trim_start_matches("1P").parse().ok()? };
    let width: usize = text[letter + 1..].split('.').next()?.trim().parse().ok()?;
    let sound = |number: &usize| (1..=WIDEST).contains(number);
    (sound(&count) && sound(&width)).then_some(Layout { count, width })
}

/// A section of a file: so many numbers, in this layout.
struct Section {
    layout: Layout,
    count: usize,
}

fn numbers(
    lines: &mut Lines,
    Section { layout, count }: Section,
    what: &str,
    mut take: impl FnMut(&Lines, &str) -> Result<(), StructureError>,
) -> Result<(), StructureError> {
    let mut left = count;
    while left > 0 {
        if !lines.advance()? {
            return Err(lines.fault(format!("the file is truncated: {what} {} of {count} expected", count - left + 1)));
        }
        if !lines.text.is_ascii() {
            return Err(lines.fault("expected numbers"));
        }
        for index in 0..layout.count.min(left) {
            let text = &lines.text;
            let begin = (index * layout.width).min(text.len());
            take(lines, &text[begin..(begin + layout.width).min(text.len())])?;
            left -= 1;
        }
    }
    Ok(())
}

fn integers(
    lines: &mut Lines,
    section: Section,
    sound: RangeInclusive<usize>,
    what: &str,
) -> Result<Vec<usize>, StructureError> {
    let mut out = Vec::new();
    numbers(lines, section, what, |lines, text| match text.trim().parse::<usize>() {
        Ok(number) if sound.contains(&number) => {
            out.push(number);
            Ok(())
        }
        _ => Err(lines.fault(format!(
            "{what}: expected {} to {}, found \"{}\"",
            sound.start(),
            sound.end(),
            text.trim()
        ))),
    })?;
    Ok(out)
}

/// Writes the lower triangle by columns, 17 digits.
fn write(out: &mut dyn Write, named: &Named) -> std::io::Result<()> {
    let Named { name, matrix, .. } = *named;
    let order = matrix.rows();
    let (mut pointers, mut indices, mut values) = (vec![1], Vec::new(), Vec::new());
    for (column, view) in matrix.outer_iterator().enumerate() {
        for (row, value) in view.iter().filter(|(row, _)| *row >= column) {
            indices.push(row + 1);
            values.push(*value);
        }
        pointers.push(indices.len() + 1);
    }
    writeln!(out, "{name:<72}{:<8}", "DECORE")?;
    let (p, i) = (pointers.len(), indices.len());
    writeln!(out, "{:>14}{p:>14}{i:>14}{i:>14}{:>14}", p + 2 * i, 0)?;
    writeln!(out, "{:<14}{order:>14}{order:>14}{i:>14}{:>14}", "RSA", 0)?;
    writeln!(out, "{:<16}{:<16}{:<20}{:<20}", "(1I14)", "(1I14)", "(1E26.17)", "(1E26.17)")?;
    for number in pointers.iter().chain(&indices) {
        writeln!(out, "{number:>14}")?;
    }
    for value in values {
        writeln!(out, "{:>26}", format!("{value:.17E}"))?;
    }
    Ok(())
}
