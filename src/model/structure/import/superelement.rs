//! DOF table of a Nastran superelement, from the punch files of its matrices (EXTSEOUT).
//!
//! `EXTRN` entries (in the `.pch`) list points and components in the order of the a-set, as in KAA and MAA. Assembly files (`.asm`) have
//! only `SECONCT`: its points then have all six directions, and its SPOINTs are modal coordinates. `GRID` and `CORD2R` give positions of
//! points and the axes of their displacements, for entries in the same file as DMIG entries too.

use std::collections::{BTreeMap, BTreeSet};

use super::bulk::{Card, Cards};
use super::lines::{Lines, parse_number};
use super::rows::{BASIC_AXES, MatrixRows, Nodes};
use crate::structure::error::StructureError;
use crate::structure::label::{DofLabel, SCALAR};

/// Entries that list points.
const LISTS: [&str; 3] = ["EXTRN", "SECONCT", "SPOINT"];
/// Entries with positions and axes of points.
const GRIDS: [&str; 8] = ["GRID", "GRDSET", "CORD1R", "CORD1C", "CORD1S", "CORD2R", "CORD2C", "CORD2S"];
/// Most points of one `THRU`.
const LONGEST_RANGE: i64 = 1_000_000;
/// Coordinate systems that may refer to one another.
const DEEPEST: usize = 50;

type Vector = [f64; 3];

/// Whether a list of rows is bulk data with a table of a superelement.
pub(super) fn is_table(file: &str, bytes: &[u8]) -> Result<bool, StructureError> {
    let mut lines = Lines::new(file, bytes);
    if !lines.advance_past(&["#"])? || lines.text.trim_start().starts_with(|c: char| c.is_ascii_digit() || c == '-') {
        return Ok(false);
    }
    loop {
        let name = lines.text.split([' ', ',', '*']).next().unwrap_or_default();
        if ["EXTRN", "SECONCT"].iter().any(|known| name.eq_ignore_ascii_case(known)) {
            return Ok(true);
        }
        if !lines.advance_past(&["$"])? {
            return Ok(false);
        }
    }
}

/// Origin of a system and its axes (columns) in the basic system.
#[derive(Clone, Copy)]
struct Frame {
    origin: Vector,
    axes: [Vector; 3],
}

const BASIC: Frame = Frame { origin: [0.0; 3], axes: BASIC_AXES };

/// A coordinate system as its entry gives it.
struct System {
    kind: String,
    reference: i64,
    points: [Vector; 3],
}

struct Grid {
    /// Systems of its coordinates and of its displacements; none: the system of `GRDSET`.
    systems: [Option<i64>; 2],
    at: Vector,
}

#[derive(Default)]
struct CsvTable {
    extrn: Vec<DofLabel>,
    connected: Vec<i64>,
    scalar: BTreeSet<i64>,
    grids: BTreeMap<i64, Grid>,
    /// Systems of grids that name none.
    usual: [i64; 2],
    systems: BTreeMap<i64, System>,
}

/// Reads the table of rows.
pub(super) fn parse(file: &str, bytes: &[u8]) -> Result<MatrixRows, StructureError> {
    let names = [&LISTS[..], &GRIDS].concat();
    CsvTable::of(&names, file, bytes)?.rows().map_err(|reason| StructureError::Matrix { file: file.to_owned(), reason })
}

/// Axes and positions of nodes with these labels, from the bulk data of the matrices.
pub(super) fn parse_nodes(file: &str, bytes: &[u8], labels: &[DofLabel]) -> Result<Nodes, StructureError> {
    CsvTable::of(&GRIDS, file, bytes)?.nodes(labels).map_err(|reason| StructureError::Matrix {
        file: file.to_owned(),
        reason: format!("{reason}; the matrix is along these axes: add their entry, or export it in the basic system"),
    })
}

impl CsvTable {
    /// Of the entries of these names.
    fn of(names: &[&str], file: &str, bytes: &[u8]) -> Result<Self, StructureError> {
        let mut cards = Cards::new(file, bytes);
        let mut table = Self::default();
        while let Some(card) = cards.next(names)? {
            let fault = |reason: String| cards.lines.fault_at(card.line, format!("{}: {reason}", card.name));
            table.read(&card).map_err(fault)?;
        }
        Ok(table)
    }

    fn read(&mut self, card: &Card) -> Result<(), String> {
        match card.name.as_str() {
            "EXTRN" => self.read_extrn(card),
            "SECONCT" => {
                let words: Vec<&str> = card.fields.iter().skip(8).map(String::as_str).collect();
                // Points of this superelement, each with the point that it connects to.
                self.connected.extend(points(&words, 2)?);
                Ok(())
            }
            "SPOINT" => {
                let words: Vec<&str> = card.fields.iter().map(String::as_str).collect();
                self.scalar.extend(points(&words, 1)?);
                Ok(())
            }
            "GRID" => {
                let at = vector(card, 2)?;
                let system = |field: &str| (!field.is_empty()).then(|| whole(field, None)).transpose();
                let systems = [system(card.field(1))?, system(card.field(5))?];
                self.grids.insert(whole(card.field(0), None)?, Grid { systems, at });
                Ok(())
            }
            "GRDSET" => {
                self.usual = [whole(card.field(1), Some(0))?, whole(card.field(5), Some(0))?];
                Ok(())
            }
            // Systems by three points have no coordinates of their own.
            kind if kind.starts_with("CORD1") => {
                for field in [0, 4] {
                    if let Ok(id) = whole(card.field(field), None) {
                        let system = System { kind: kind.to_owned(), reference: 0, points: [[0.0; 3]; 3] };
                        self.systems.insert(id, system);
                    }
                }
                Ok(())
            }
            kind => {
                let points = [vector(card, 2)?, vector(card, 5)?, vector(card, 8)?];
                let system = System { kind: kind.to_owned(), reference: whole(card.field(1), Some(0))?, points };
                self.systems.insert(whole(card.field(0), None)?, system);
                Ok(())
            }
        }
    }

    fn read_extrn(&mut self, card: &Card) -> Result<(), String> {
        for pair in card.fields.chunks(2).filter(|pair| pair.iter().any(|field| !field.is_empty())) {
            let [point, components] = pair else { return Err("a point without components".to_owned()) };
            let node = whole(point, None)?;
            if matches!(components.as_str(), "0" | "") {
                self.extrn.push(DofLabel { node, dof: SCALAR });
                continue;
            }
            for digit in components.chars() {
                let dof = digit.to_digit(10).filter(|digit| (1..=6).contains(digit));
                let dof = dof.ok_or_else(|| format!("expected components 1 to 6 or 0, found \"{components}\""))?;
                self.extrn.push(DofLabel { node, dof: dof as usize - 1 });
            }
        }
        Ok(())
    }

    fn rows(&self) -> Result<MatrixRows, String> {
        let assumed = self.extrn.is_empty();
        let labels = if assumed { self.connected_labels()? } else { self.extrn.clone() };
        let mut seen = BTreeSet::new();
        if let Some(twice) = labels.iter().find(|label| !seen.insert(**label)) {
            return Err(format!("point {} component {} is in the list of rows twice", twice.node, twice.dof + 1));
        }
        let nodes = self.nodes(&labels)?;
        Ok(MatrixRows { labels, nodes, assumed })
    }

    /// Axes and places of the nodes that some labels name.
    fn nodes(&self, labels: &[DofLabel]) -> Result<Nodes, String> {
        let mut out = Nodes::default();
        let nodes: BTreeSet<i64> = labels.iter().filter(|label| label.dof != SCALAR).map(|label| label.node).collect();
        for (node, grid) in self.grids.iter().filter(|(node, _)| nodes.contains(node)) {
            let [place, displacement] = [0, 1].map(|of| grid.systems[of].unwrap_or(self.usual[of]));
            let frame = self.frame(displacement, DEEPEST);
            let frame = frame.map_err(|reason| format!("displacements of GRID {node}: {reason}"))?;
            out.axes.insert(*node, frame.axes);
            // An unknown position is no error: only the centre of mass needs it.
            if let Ok(frame) = self.frame(place, DEEPEST) {
                out.positions.insert(*node, frame.point(grid.at));
            }
        }
        Ok(out)
    }

    fn connected_labels(&self) -> Result<Vec<DofLabel>, String> {
        let mut labels = Vec::new();
        for &node in &self.connected {
            if self.grids.contains_key(&node) {
                labels.extend((0..SCALAR).map(|dof| DofLabel { node, dof }));
            } else if self.scalar.contains(&node) {
                labels.push(DofLabel { node, dof: SCALAR });
            } else {
                return Err(format!("SECONCT names point {node}, which has neither a GRID nor an SPOINT entry"));
            }
        }
        Ok(labels)
    }

    /// A rectangular system in the basic one, by way of those that it refers to.
    fn frame(&self, id: i64, depth: usize) -> Result<Frame, String> {
        if id == 0 {
            return Ok(BASIC);
        }
        let system = self.systems.get(&id).ok_or_else(|| format!("coordinate system {id} is not in the file"))?;
        if system.kind != "CORD2R" {
            return Err(format!("coordinate system {id} is a {}: expected a rectangular one, CORD2R", system.kind));
        }
        if depth == 0 {
            return Err(format!("coordinate system {id} refers to itself"));
        }
        let reference = self.frame(system.reference, depth - 1)?;
        let [origin, on_z, in_xz] = system.points.map(|point| reference.point(point));
        let flat = || format!("the three points of coordinate system {id} lie on a line");
        let z = unit(minus(on_z, origin)).ok_or_else(flat)?;
        let y = unit(cross(z, minus(in_xz, origin))).ok_or_else(flat)?;
        Ok(Frame { origin, axes: [cross(y, z), y, z] })
    }
}

impl Frame {
    /// A point of this system in the basic one.
    fn point(&self, [x, y, z]: Vector) -> Vector {
        let [a, b, c] = self.axes;
        std::array::from_fn(|i| self.origin[i] + x * a[i] + y * b[i] + z * c[i])
    }
}

fn minus(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|i| a[i] - b[i])
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: Vector) -> Option<Vector> {
    let length = a.iter().map(|x| x * x).sum::<f64>().sqrt();
    (length > 0.0).then(|| a.map(|x| x / length))
}

/// A number of a point or system; blank is the default, if there is one.
fn whole(field: &str, default: Option<i64>) -> Result<i64, String> {
    match (field, default) {
        ("", Some(default)) => Ok(default),
        _ => field.parse().map_err(|_| format!("expected a whole number, found \"{field}\"")),
    }
}

/// Three coordinates from a field on; blanks are 0.
fn vector(card: &Card, from: usize) -> Result<Vector, String> {
    let mut out = [0.0; 3];
    for (value, field) in out.iter_mut().zip(from..) {
        let text = card.field(field);
        if !text.is_empty() {
            *value = parse_number(text).ok_or_else(|| format!("expected a finite number, found \"{text}\""))?;
        }
    }
    Ok(out)
}

/// Every `stride`-th point of a list in which `a THRU b` stands for all from a to b.
fn points(words: &[&str], stride: usize) -> Result<Vec<i64>, String> {
    let words: Vec<&str> = words.iter().copied().filter(|word| !word.is_empty()).collect();
    let (mut out, mut at) = (Vec::new(), 0);
    while let Some(word) = words.get(at) {
        let first = whole(word, None)?;
        if words.get(at + 1).is_some_and(|word| word.eq_ignore_ascii_case("THRU")) {
            let last = whole(words.get(at + 2).copied().unwrap_or_default(), None)?;
            if !(first..=first.saturating_add(LONGEST_RANGE)).contains(&last) {
                return Err(format!("{first} THRU {last}: expected a rising range of at most {LONGEST_RANGE} points"));
            }
            out.extend(first..=last);
            at += 3 * stride;
        } else {
            out.push(first);
            at += stride;
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PUNCH: &str = "\
BEGIN SUPER       75
$ a comment
EXTRN          3  123456      11     135 2995001       0
GRID*                  3                 6.000000000E+02 0.000000000E+00
*        3.000000000E+02               0               0               0
GRID,11,10,1.,2.,3.,10
CORD2R*               10               0 1.000000000E+00 0.000000000E+00
*        0.000000000E+00 2.000000000E+00 0.000000000E+00 0.000000000E+00
*        0.000000000E+00 0.100000000E+01 0.000000000E+00
";

    fn rows(text: &str) -> Result<MatrixRows, String> {
        assert!(is_table("s", text.as_bytes()).expect("text"));
        parse("s", text.as_bytes()).map_err(|error| error.to_string())
    }

    #[test]
    fn extrn_lists_rows_and_cord2r_turns_them() {
        let table = rows(PUNCH).expect("valid");
        let of = |node: i64, dofs: &[usize]| dofs.iter().map(|dof| DofLabel { node, dof: *dof }).collect::<Vec<_>>();
        let expected = [of(3, &[0, 1, 2, 3, 4, 5]), of(11, &[0, 2, 4]), of(2995001, &[SCALAR])].concat();
        assert_eq!(table.labels, expected);
        assert!(!table.assumed);
        assert_eq!(table.nodes.positions[&3], [600.0, 0.0, 300.0]);
        let usual = rows(&(PUNCH.replace(",3.,10\n", ",3.\n") + "GRDSET,,,,,,10\n")).expect("valid");
        assert_eq!((usual.nodes.axes[&11], usual.nodes.axes[&3]), (table.nodes.axes[&11], BASIC_AXES));
        assert_eq!((usual.nodes.positions[&11], usual.nodes.positions[&3]), ([4.0, 1.0, 2.0], [600.0, 0.0, 300.0]));
        // z along the basic x, x towards (0, 1, 0) from (1, 0, 0): (0, 1, 0) once z is taken out, y = z x x = (0, 0, 1).
        assert_eq!(table.nodes.axes[&11], [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);
        assert_eq!(table.nodes.positions[&11], [4.0, 1.0, 2.0]);
    }

    #[test]
    fn seconct_stands_for_all_directions() {
        let text = "$\nSECONCT       75       0\n               3       3      11      11\n         2990001    THRU 2990003 \
                    2990001    THRU 2990003\nSPOINT   2990001    THRU 2990003\nGRID,3\nGRID,11\n";
        let table = rows(text).expect("valid");
        assert_eq!((table.labels.len(), table.assumed), (15, true));
        assert_eq!(table.labels[12], DofLabel { node: 2_990_001, dof: SCALAR });
    }

    #[test]
    fn what_a_table_cannot_mean_is_an_error() {
        let fails = |text: &str, wanted: &str| {
            let error = rows(text).expect_err(wanted);
            assert!(error.contains(wanted), "{error}");
        };
        fails("EXTRN,3,127\n", "s, line 1: EXTRN: expected components 1 to 6 or 0, found \"127\"");
        fails("EXTRN,3,12,3,2\n", "point 3 component 2 is in the list of rows twice");
        fails("EXTRN,3,12\nGRID,3,,0.,0.,0.,7\n", "GRID 3: coordinate system 7 is not in the file");
        fails("EXTRN,3,12\nGRID,3,,,,,7\nCORD2C,7\n", "system 7 is a CORD2C: expected a rectangular one");
        fails("EXTRN,3,12\nGRID,3,,,,,7\nCORD2R,7,7,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n", "system 7 refers to itself");
        fails("EXTRN,3,12\nGRID,3,,,,,7\nCORD2R,7\n", "the three points of coordinate system 7 lie on a line");
        fails("SECONCT,1,0,,,,,,\n,3,3\n", "SECONCT names point 3, which has neither a GRID nor an SPOINT");
        fails("EXTRN,3,1\nSPOINT,1,THRU,9000000000000000000\n", "at most 1000000 points");
        assert!(!is_table("s", b" Eqn Node DOF\n 1 10 UX\n").expect("text"));
    }
}
