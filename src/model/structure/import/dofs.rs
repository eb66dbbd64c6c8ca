//! Lists of the labels of a matrix's rows.

use std::fmt::Write as _;

use super::lines::Lines;
use super::rows::{MatrixRows, direction, number};
use super::superelement;
use crate::structure::error::StructureError;
use crate::structure::label::DofLabel;
use crate::structure::points::DOF_NAMES;

/// Reads the table of a Nastran superelement, or a list of row labels, one line per row: `12.3` (CalculiX `.dof`), `12 3`,
/// `5 12 3` (row first), with directions 1 to 6 (0: a modal coordinate) or names as `UX`, `ROTZ`, `x`, `rz` (ANSYS
/// `.mapping`; a first line without numbers is a heading). The node's coordinates may follow the direction (`12.3 0.5 0 1.2`,
/// `12 3 0.5 0 1.2`).
pub(super) fn parse_rows(file: &str, bytes: &[u8]) -> Result<MatrixRows, StructureError> {
    if superelement::is_table(file, bytes)? {
        return superelement::parse(file, bytes);
    }
    let mut lines = Lines::new(file, bytes);
    let mut rows = MatrixRows::default();
    let mut heading = true;
    while lines.advance_past(&["#"])? {
        let words: Vec<&str> = lines.text.split([' ', '\t', ',']).filter(|word| !word.is_empty()).collect();
        let row = rows.labels.len() + 1;
        let (label, place) = match words[..] {
            [one] => (one.split_once('.').and_then(|(node, dof)| label(node, dof)), None),
            [one, x, y, z] => (one.split_once('.').and_then(|(node, dof)| label(node, dof)), Some([x, y, z])),
            [node, dof] => (label(node, dof), None),
            [number, node, dof] if number.parse() == Ok(row) => (label(node, dof), None),
            [node, dof, x, y, z] => (label(node, dof), Some([x, y, z])),
            [number, node, dof, x, y, z] if number.parse() == Ok(row) => (label(node, dof), Some([x, y, z])),
            _ => (None, None),
        };
        match label {
            Some(label) => {
                rows.labels.push(label);
                if let Some([x, y, z]) = place {
                    let place = [lines.number_in(x)?, lines.number_in(y)?, lines.number_in(z)?];
                    rows.nodes.positions.insert(label.node, place);
                }
            }
            None if heading && words.iter().all(|word| word.parse::<f64>().is_err()) => {}
            None => {
                let reason = format!(
                    "expected node and direction of row {row} (for instance 12.3, 12 3 or {row} 12 UZ, coordinates may follow), found \"{}\"",
                    lines.text.trim()
                );
                return Err(lines.fault(reason));
            }
        }
        heading = false;
    }
    if rows.labels.is_empty() {
        return Err(lines.fault("the list of rows is empty"));
    }
    Ok(rows)
}

fn label(node: &str, dof: &str) -> Option<DofLabel> {
    const ANSYS: [&str; 6] = ["UX", "UY", "UZ", "ROTX", "ROTY", "ROTZ"];
    let node = node.parse().ok()?;
    let named = |names: &[&str; 6]| names.iter().position(|name| name.eq_ignore_ascii_case(dof));
    let dof = named(&ANSYS).or_else(|| named(&DOF_NAMES)).or_else(|| direction(dof))?;
    Some(DofLabel { node, dof })
}

/// A list that [`parse_rows`] reads: `node.direction` per line.
pub(super) fn write_dofs(labels: &[DofLabel]) -> String {
    let mut text = String::new();
    for label in labels {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}.{}", label.node, number(label.dof));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::label::SCALAR;

    #[test]
    fn forms_of_a_row() {
        let dof = |node, dof| DofLabel { node, dof };
        let read = |text: &str| parse_rows("d", text.as_bytes()).expect("valid").labels;
        assert_eq!(read("10.1\n10.6\n-3.2\n"), [dof(10, 0), dof(10, 5), dof(-3, 1)]);
        assert_eq!(read("# rows\n10 1\n12, 3\n7 0\n"), [dof(10, 0), dof(12, 2), dof(7, SCALAR)]);
        assert_eq!(read(" Eqn Node DOF\n 1 10 UX\n 2 10 ROTZ\n"), [dof(10, 0), dof(10, 5)]);
        let placed = parse_rows("d", b"10 1 0.5 0 1.25\n2 10 2 0.5 0 1.25\n").expect("valid");
        assert_eq!((placed.labels.len(), placed.nodes.positions[&10]), (2, [0.5, 0.0, 1.25]));
        let placed = parse_rows("d", b"10.1 0.5 0 1.25\n10.2\n").expect("valid");
        assert_eq!((placed.labels.len(), placed.nodes.positions[&10]), (2, [0.5, 0.0, 1.25]));
        for (text, line) in [("10.7\n", 1), ("10.1\n10\n", 2), ("1 10 UX\n3 10 UY\n", 2), ("", 1), ("x\ny\n", 2)] {
            let error = parse_rows("d", text.as_bytes()).expect_err(text).to_string();
            assert!(error.starts_with(&format!("d, line {line}: ")), "{error}");
        }
    }
}
