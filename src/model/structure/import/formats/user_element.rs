//! Matrices of Abaqus user elements, as Abaqus and CalculiX write substructures (`*SUBSTRUCTURE MATRIX OUTPUT`, `*ELEMENT MATRIX
//! OUTPUT`, each with `OUTPUT FILE=USER DEFINED`).
//!
//! ```text
//! *USER ELEMENT,NODES=3,LINEAR
//! ** ELEMENT NODES
//! ** 101, 102, 103
//! 1,2,3                  directions of the first node, and of the next ones
//! 3,1,2,3,4,5,6          from the third node on
//! *MATRIX,TYPE=STIFFNESS
//! 1.5E6,                 lower triangle, row after row
//! ```
//!
//! Entries of several elements are summed. Without the comment with the nodes the rows are numbered, and a list of rows names them.

use super::abaqus::{keyword, name};
use crate::structure::error::StructureError;
use crate::structure::import::entry::{Given, Imported, MatrixKind};
use crate::structure::import::labelled::LabelledMatrix;
use crate::structure::import::lines::Lines;
use crate::structure::import::rows::direction;
use crate::structure::import::triplets::{Storage, Triplets};
use crate::structure::label::DofLabel;

/// Most nodes of an element: its matrix is full.
const MOST_NODES: usize = 100_000;

/// Whether the first matrix of a file belongs to a user element.
pub(super) fn comes_first(file: &str, bytes: &[u8]) -> Result<bool, StructureError> {
    let mut lines = Lines::new(file, bytes);
    let mut begun = false;
    while lines.advance_past(&["**"])? {
        match keyword_of(&lines.text).as_deref() {
            Some("*USER ELEMENT") => return Ok(true),
            Some("*MATRIX" | "*MATRIX INPUT") => return Ok(false),
            Some(_) => begun = true,
            // Entries before any keyword.
            None if !begun => return Ok(false),
            None => {}
        }
    }
    Ok(false)
}

/// Reads the matrix of the requested kind.
pub(super) fn read(given: &Given) -> Result<Imported, StructureError> {
    let Given { file, bytes, kind, .. } = *given;
    let mut lines = Lines::new(file, bytes);
    let mut reader = Reader::new(kind);
    while lines.advance()? {
        reader.line(&lines)?;
    }
    reader.end_block(&lines)?;
    reader.finish(&lines)
}

/// The keyword of a line in capitals, where it begins one.
fn keyword_of(text: &str) -> Option<String> {
    let text = text.trim_start();
    let begins = text.starts_with('*') && !text.starts_with("**");
    begins.then(|| text.split(',').next().unwrap_or_default().trim().to_ascii_uppercase())
}

/// The value of a parameter of a keyword line, in capitals; empty for a parameter without one.
fn parameter(text: &str, name: &str) -> Option<String> {
    text.split(',').skip(1).find_map(|word| {
        let (key, value) = word.split_once('=').unwrap_or((word, ""));
        key.trim().eq_ignore_ascii_case(name).then(|| value.trim().to_ascii_uppercase())
    })
}

/// Contents of the following lines.
#[derive(Clone, Copy, PartialEq)]
enum Within {
    /// Nothing of use.
    Other,
    /// Directions of nodes, and the nodes in comments.
    Element,
    /// Values of the requested matrix; it begins at this line.
    Values(usize),
}

/// A user element.
struct Element {
    /// Line of its keyword.
    line: usize,
    /// Number of its nodes.
    size: usize,
    /// Whether both triangles are stored.
    full: bool,
    /// Nodes, from the comment.
    nodes: Vec<i64>,
    /// Directions from a node on, the node counted from 0.
    directions: Vec<(usize, Vec<usize>)>,
}

impl Element {
    fn begin(lines: &Lines) -> Result<Self, StructureError> {
        let size = parameter(&lines.text, "NODES").and_then(|nodes| nodes.parse().ok());
        let Some(size) = size.filter(|size| (1..=MOST_NODES).contains(size)) else {
            return Err(lines.fault(format!("expected NODES= from 1 to {MOST_NODES}, found \"{}\"", lines.text.trim())));
        };
        let full = parameter(&lines.text, "UNSYMM").is_some();
        Ok(Self { line: lines.number, size, full, nodes: Vec::new(), directions: Vec::new() })
    }

    fn read_directions(&mut self, lines: &Lines) -> Result<(), StructureError> {
        let words: Vec<&str> = lines.text.split(',').map(str::trim).filter(|word| !word.is_empty()).collect();
        let (from, words) = match (self.directions.last(), &words[..]) {
            (None, words) => (0, words),
            (Some((last, _)), [position, words @ ..]) => {
                let from = position.parse::<usize>().ok().filter(|from| (last + 2..=self.size).contains(from));
                let from = from.ok_or_else(|| {
                    lines.fault(format!(
                        "expected the position of a node from {} to {} and its directions, found \"{}\"",
                        last + 2,
                        self.size,
                        lines.text.trim()
                    ))
                })?;
                (from - 1, words)
            }
            (Some(_), []) => return Ok(()),
        };
        let found: Option<Vec<usize>> = words.iter().map(|word| direction(word)).collect();
        let found = found.filter(|found| !found.is_empty()).ok_or_else(|| {
            lines.fault(format!(
                "expected directions 1 to 6 of displacements and rotations, found \"{}\"",
                lines.text.trim()
            ))
        })?;
        self.directions.push((from, found));
        Ok(())
    }

    /// Position and direction of every row.
    fn rows(&self) -> Vec<(usize, usize)> {
        let of = |position: usize| {
            let known = self.directions.partition_point(|(from, _)| *from <= position);
            self.directions[..known].last()
        };
        (0..self.size)
            .flat_map(|at| of(at).into_iter().flat_map(move |(_, dofs)| dofs.iter().map(move |dof| (at, *dof))))
            .collect()
    }

    /// Node and direction of every row; none if the file does not name the nodes.
    fn labels(&self, lines: &Lines) -> Result<Option<Vec<DofLabel>>, StructureError> {
        if self.nodes.is_empty() {
            return Ok(None);
        }
        if self.nodes.len() != self.size {
            let reason = format!(
                "NODES={}, but {} nodes are listed in the comment ** ELEMENT NODES: correct one of them",
                self.size,
                self.nodes.len()
            );
            return Err(lines.fault_at(self.line, reason));
        }
        Ok(Some(self.rows().into_iter().map(|(at, dof)| DofLabel { node: self.nodes[at], dof }).collect()))
    }
}

/// The file as far as it is read.
struct Reader {
    kind: MatrixKind,
    within: Within,
    element: Option<Element>,
    values: Vec<f64>,
    labelled: LabelledMatrix,
    /// Entries and number of rows of an element without nodes.
    numbered: Option<(Triplets, usize)>,
    /// Types of matrices with their lines.
    types: Vec<String>,
    found: bool,
}

impl Reader {
    fn new(kind: MatrixKind) -> Self {
        let mut labelled = LabelledMatrix::default();
        labelled.storage = Some(Storage::Both);
        Self {
            kind,
            within: Within::Other,
            element: None,
            values: Vec::new(),
            labelled,
            numbered: None,
            types: Vec::new(),
            found: false,
        }
    }

    fn line(&mut self, lines: &Lines) -> Result<(), StructureError> {
        let text = lines.text.trim();
        if let Some(word) = keyword_of(text) {
            self.end_block(lines)?;
            return self.begin_block(&word, lines);
        }
        match (self.within, text.strip_prefix("**")) {
            (Within::Element, Some(comment)) => {
                let words = comment.split(',').map(str::trim).filter(|word| !word.is_empty());
                let nodes: Option<Vec<i64>> = words.map(|word| word.parse().ok()).collect();
                if let (Some(element), Some(nodes)) = (&mut self.element, nodes) {
                    element.nodes.extend(nodes);
                }
            }
            (_, Some(_)) | (Within::Other, None) => {}
            (_, None) if text.is_empty() => {}
            (Within::Element, None) => {
                if let Some(element) = &mut self.element {
                    element.read_directions(lines)?;
                }
            }
            (Within::Values(_), None) => {
                for word in text.split([',', ' ', '\t']).filter(|word| !word.is_empty()) {
                    self.values.push(lines.number_in(word)?);
                }
            }
        }
        Ok(())
    }

    fn begin_block(&mut self, word: &str, lines: &Lines) -> Result<(), StructureError> {
        self.within = Within::Other;
        match word {
            "*USER ELEMENT" => {
                self.element = Some(Element::begin(lines)?);
                self.within = Within::Element;
            }
            "*MATRIX" => {
                let of = parameter(&lines.text, "TYPE").unwrap_or_default();
                self.types.push(format!("{of} (line {})", lines.number));
                if of != keyword(self.kind) {
                    return Ok(());
                }
                if parameter(&lines.text, "INPUT").is_some() {
                    return Err(lines.fault("the values are in another file (INPUT=): put them behind this line"));
                }
                if self.element.is_none() {
                    return Err(lines.fault("a matrix before its *USER ELEMENT"));
                }
                self.within = Within::Values(lines.number);
            }
            _ => {}
        }
        Ok(())
    }

    /// Takes the values of a matrix that ends here.
    fn end_block(&mut self, lines: &Lines) -> Result<(), StructureError> {
        let Within::Values(line) = std::mem::replace(&mut self.within, Within::Other) else { return Ok(()) };
        let values = std::mem::take(&mut self.values);
        let Some(element) = &self.element else { return Ok(()) };
        let order = element.rows().len();
        let expected = if element.full { order * order } else { order * (order + 1) / 2 };
        if values.len() != expected {
            let (nodes, of) = (element.size, if element.full { "" } else { " of the lower triangle" });
            let reason = format!(
                "expected {expected} values{of} for {order} rows of {nodes} nodes, found {}: is the file truncated, or are directions missing behind *USER ELEMENT?",
                values.len()
            );
            return Err(lines.fault_at(line, reason));
        }
        let pairs: Box<dyn Iterator<Item = (usize, usize)>> = match element.full {
            true => Box::new((0..order).flat_map(|row| (0..order).map(move |column| (row, column)))),
            false => Box::new((0..order).flat_map(|row| (0..=row).map(move |column| (row, column)))),
        };
        let mirrored = |row: usize, column: usize| !element.full && row != column;
        if let Some(labels) = element.labels(lines)? {
            for ((row, column), value) in pairs.zip(values) {
                self.labelled.push(labels[row], labels[column], value);
                if mirrored(row, column) {
                    self.labelled.push(labels[column], labels[row], value);
                }
            }
        } else {
            if self.found {
                let reason = "a second user element, but the file does not name the nodes: expected a comment ** ELEMENT NODES and the nodes behind *USER ELEMENT";
                return Err(lines.fault_at(element.line, reason));
            }
            let mut entries = Triplets::default();
            for ((row, column), value) in pairs.zip(values) {
                entries.push(row as u32, column as u32, value);
                if mirrored(row, column) {
                    entries.push(column as u32, row as u32, value);
                }
            }
            self.numbered = Some((entries, order));
        }
        self.found = true;
        Ok(())
    }

    fn finish(self, lines: &Lines) -> Result<Imported, StructureError> {
        if !self.found {
            let hint = match self.kind {
                MatrixKind::Mass => {
                    "; CalculiX writes no mass of a substructure: take the whole model with *FREQUENCY, SOLVER=MATRIXSTORAGE"
                }
                _ => "",
            };
            let reason = format!(
                "no {}: expected *MATRIX, TYPE={} behind *USER ELEMENT, found TYPE {}{hint}",
                name(self.kind),
                keyword(self.kind),
                if self.types.is_empty() { "none".to_owned() } else { self.types.join(", ") }
            );
            return Err(StructureError::Matrix { file: lines.file.to_owned(), reason });
        }
        match self.numbered {
            Some(_) if !self.labelled.labels().is_empty() => {
                let reason =
                    "some user elements name their nodes in a comment ** ELEMENT NODES, others do not: expected all";
                Err(StructureError::Matrix { file: lines.file.to_owned(), reason: reason.to_owned() })
            }
            Some((entries, order)) => entries.assemble(lines.file, order, Storage::Both).map(Imported::Rows),
            None => Ok(Imported::Labels(self.labelled)),
        }
    }
}
