//! Positions of nodes from a separate file: `*NODE` blocks (Abaqus, CalculiX), `GRID` entries (Nastran), or a table.

use std::collections::BTreeMap;

use super::lines::Lines;
use super::rows::Nodes;
use super::superelement;
use crate::structure::error::StructureError;
use crate::structure::label::DofLabel;

/// Form of a list of nodes.
#[derive(Clone, Copy, PartialEq)]
enum Form {
    /// Blocks that begin with `*NODE`.
    Abaqus,
    /// Entries `GRID`.
    Nastran,
    /// Node, x, y, z per line.
    Table,
}

/// Reads the places of nodes in the unit of the file, and axes of displacements where the file states them. `labels`: rows of the
/// matrices.
///
/// # Errors
/// File, line and reason: no nodes, a line that is no node, a node at two places.
pub(super) fn parse(file: &str, bytes: &[u8], labels: &[DofLabel]) -> Result<Nodes, StructureError> {
    let nodes = match form(file, bytes)? {
        Form::Nastran => superelement::parse_nodes(file, bytes, labels)?,
        form => Nodes { positions: positions(file, bytes, form)?, axes: BTreeMap::new() },
    };
    if nodes.positions.is_empty() {
        let reason = "no nodes found: expected a *NODE block (Abaqus, CalculiX), GRID entries (Nastran), or lines of node, x, y, z";
        return Err(StructureError::Matrix { file: file.to_owned(), reason: reason.to_owned() });
    }
    Ok(nodes)
}

fn keyword(text: &str) -> String {
    text.split(',').next().unwrap_or_default().trim().to_ascii_uppercase()
}

fn form(file: &str, bytes: &[u8]) -> Result<Form, StructureError> {
    let mut lines = Lines::new(file, bytes);
    while lines.advance_past(&["#", "$", "**"])? {
        let text = lines.text.trim_start();
        if text.starts_with('*') && keyword(text) == "*NODE" {
            return Ok(Form::Abaqus);
        }
        let name = text.get(..4).unwrap_or_default();
        if name.eq_ignore_ascii_case("GRID") {
            return Ok(Form::Nastran);
        }
    }
    Ok(Form::Table)
}

fn positions(file: &str, bytes: &[u8], form: Form) -> Result<BTreeMap<i64, [f64; 3]>, StructureError> {
    let mut lines = Lines::new(file, bytes);
    let mut out: BTreeMap<i64, [f64; 3]> = BTreeMap::new();
    // A table may begin with a heading.
    let (mut within, mut heading) = (form == Form::Table, form == Form::Table);
    while lines.advance_past(&["#", "$", "**"])? {
        let text = lines.text.trim();
        if form == Form::Abaqus && text.starts_with('*') {
            within = keyword(text) == "*NODE";
            continue;
        }
        if !within {
            continue;
        }
        let words: Vec<&str> = match text.contains([',', ';']) {
            true => text.split([',', ';']).map(str::trim).collect(),
            false => text.split_whitespace().collect(),
        };
        let node = words.first().and_then(|word| word.parse::<i64>().ok());
        let Some(node) = node else {
            if std::mem::take(&mut heading) {
                continue;
            }
            return Err(lines.fault(format!("expected node, x, y, z, found \"{text}\"")));
        };
        heading = false;
        // Abaqus leaves out coordinates of 0 at the end, and may add the direction of a normal.
        let mut place = [0.0; 3];
        if words.len() < 4 && form == Form::Table {
            return Err(lines.fault(format!("expected node, x, y, z, found \"{text}\"")));
        }
        for (value, word) in place.iter_mut().zip(&words[1..]).filter(|(_, word)| !word.is_empty()) {
            *value = lines.number_in(word)?;
        }
        if out.insert(node, place).is_some_and(|other| other != place) {
            return Err(lines.fault(format!("node {node} is listed twice, at different places")));
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_of_every_form() {
        let labels = [7, 12].map(|node| DofLabel { node, dof: 0 });
        let read = |text: &str| parse("n", text.as_bytes(), &labels).map(|nodes| nodes.positions);
        let expected = BTreeMap::from([(7, [1.0, 2.5, 0.0]), (12, [-3.0, 0.0, 4e3])]);
        for text in [
            "*HEADING\nblock\n** note\n*Node, NSET=ALL\n7, 1., 2.5\n12,-3.,0.,4.E3\n*ELEMENT,TYPE=C3D8\n1,7,12\n",
            "*NODE\n7, 1., 2.5, 0.\n*NSET, NSET=A\n7,\n*NODE\n12,-3.,0.,4.D3\n",
            "GRID,7,,1.,2.5,0.\nGRID    12              -3.     0.      4.+3\n",
            "node,x,y,z\n7,1,2.5,0\n12,-3,0,4000\n",
            "7 1 2.5 0\n12 -3 0 4e3\n",
            "7;1;2.5;0\n12;-3;0;4e3\n",
        ] {
            assert_eq!(read(text), Ok(expected.clone()), "{text}");
        }
        for (text, wanted) in [
            ("", "n: no nodes found"),
            ("*NODE\n7,1,x,0\n", "n, line 2: expected a finite number, found \"x\""),
            ("7 1 2\n", "n, line 1: expected node, x, y, z"),
            ("7 1 2 3\n7 1 2 4\n", "n, line 2: node 7 is listed twice"),
        ] {
            let error = read(text).expect_err(text).to_string();
            assert!(error.starts_with(wanted), "{error}");
        }
    }
}
