//! Named interface points, and the interface DOFs that a reduced structure keeps.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::csv::{CsvTable, read_text};
use super::error::StructureError;
use super::nodes::WeightedNodes;
use decore_quantity::words::nearest;

/// Names of the six DOFs of a point in the order of their numbers: displacements in m, rotations in rad.
pub const DOF_NAMES: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// A point of the structure that can carry a hammer, a fixture or a sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct InterfacePoint {
    /// Unique name.
    pub name: String,
    /// Role in the table (`mount`, `fixture`, ...); for information only, may be empty.
    pub role: String,
    /// Position of its DOFs in the finite element matrices.
    pub place: PointPlace,
    /// Coordinates x, y, z in m.
    pub position_m: [f64; 3],
}

/// Position of a point's DOFs in the finite element matrices.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum PointPlace {
    /// Nowhere: there are no matrices (modal table).
    #[default]
    None,
    /// In consecutive rows.
    Rows {
        /// Row of the x displacement, counted from 0.
        first: usize,
        /// Number of rows of the point: 3 (displacements) or 6 (and rotations); none: from the labels of the rows.
        dofs: Option<usize>,
    },
    /// In the rows that carry the label of a node.
    Node {
        /// Number of the node.
        node: i64,
        /// Node whose directions 1 to 3 are the point's rotations (the rotation node of a CalculiX rigid body).
        rotation_node: Option<i64>,
    },
    /// In the rows of several nodes: its DOFs are their weighted means.
    Nodes(WeightedNodes),
}

/// The table of interface points, in the order of its file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct InterfacePoints {
    points: Vec<InterfacePoint>,
}

impl InterfacePoints {
    /// A table from its points.
    ///
    /// # Errors
    /// A name that is empty or appears twice, a coordinate that is not finite.
    pub fn new(points: Vec<InterfacePoint>) -> Result<Self, StructureError> {
        for (index, point) in points.iter().enumerate() {
            let name = &point.name;
            if name.is_empty() || points[..index].iter().any(|other| other.name == *name) {
                return Err(StructureError::argument(
                    "interface point",
                    "a unique, non-empty name",
                    format!("\"{name}\""),
                ));
            }
            if point.position_m.iter().any(|value| !value.is_finite()) {
                let found = format!("{:?}", point.position_m);
                return Err(StructureError::argument(format!("interface point {name}"), "finite coordinates", found));
            }
        }
        Ok(Self { points })
    }

    /// Reads a CSV table with the columns `name`, `x_m`, `y_m`, `z_m`, if wanted `role`, and, for finite element matrices, where the
    /// point is: `first_row_0based` (row of its x displacement; with `dofs` 3 or 6, which only rows with labels can do
    /// without), or `node` (for matrices with labels; with `rotation_node` where the rotations have a node of their own,
    /// empty if not). Several nodes, with blanks between them, are a point that moves as their mean; `weights` has their weights, empty
    /// for equal ones. Other columns are an error.
    ///
    /// # Errors
    /// File, line and reason.
    pub fn read(path: &Path) -> Result<Self, StructureError> {
        Self::parse(&path.display().to_string(), &read_text(path)?)
    }

    /// Like [`InterfacePoints::read`], from text; `file` is the name that errors carry.
    ///
    /// # Errors
    /// As for [`InterfacePoints::read`].
    pub fn parse(file: &str, text: &str) -> Result<Self, StructureError> {
        const KNOWN: [&str; 10] =
            ["name", "role", "x_m", "y_m", "z_m", "first_row_0based", "dofs", "node", "rotation_node", "weights"];
        let table = CsvTable::parse(file, text)?;
        let (name, role) = (table.column("name")?, table.column("role").ok());
        let axes = [table.column("x_m")?, table.column("y_m")?, table.column("z_m")?];
        if let Some(other) = table.header.iter().find(|column| !KNOWN.contains(&column.as_str())) {
            let reason = format!("unknown column \"{other}\"; expected {}", KNOWN.join(", "));
            return Err(table.fault(table.header_line, reason));
        }
        let places = PlaceColumns::new(&table)?;
        let mut points: Vec<InterfacePoint> = Vec::with_capacity(table.rows.len());
        for index in 0..table.rows.len() {
            let new_name = |text: &str| {
                let unique = !text.is_empty() && points.iter().all(|point| point.name != text);
                unique.then(|| text.to_owned())
            };
            let mut position_m = [0.0; 3];
            for (value, &axis) in position_m.iter_mut().zip(&axes) {
                *value = table.number(index, axis)?;
            }
            points.push(InterfacePoint {
                name: table.field(index, name, "a unique, non-empty name", new_name)?,
                role: match role {
                    Some(role) => table.field(index, role, "text", |text| Some(text.to_owned()))?,
                    None => String::new(),
                },
                place: places.read(&table, index)?,
                position_m,
            });
        }
        Ok(Self { points })
    }

    /// Writes the table for [`InterfacePoints::parse`]. A file has one way to give rows; the first point's is used.
    pub fn to_csv(&self) -> String {
        let first = self.points.first().map(|point| &point.place);
        let by_node = matches!(first, Some(PointPlace::Node { .. } | PointPlace::Nodes(_)));
        let has_weights = self.points.iter().any(|point| matches!(point.place, PointPlace::Nodes(_)));
        let place = match (by_node, has_weights) {
            (true, true) => &["node", "rotation_node", "weights"][..],
            (true, false) => &["node", "rotation_node"],
            (false, _) => &["first_row_0based", "dofs"],
        };
        let head = ["name", "role", "x_m", "y_m", "z_m"].iter().chain(place).map(|name| (*name).to_owned());
        let rows = self.points.iter().map(|point| {
            let own = match &point.place {
                PointPlace::None => Default::default(),
                PointPlace::Rows { first, dofs } => [first.to_string(), text(*dofs), String::new()],
                PointPlace::Node { node, rotation_node } => [node.to_string(), text(*rotation_node), String::new()],
                PointPlace::Nodes(nodes) => {
                    let (nodes, weights): (Vec<_>, Vec<_>) =
                        nodes.iter().map(|(node, weight)| (node.to_string(), weight.to_string())).unzip();
                    [nodes.join(" "), String::new(), weights.join(" ")]
                }
            };
            let at = point.position_m.map(|x| format!("{x:e}"));
            let fields = [point.name.clone(), point.role.clone()].into_iter().chain(at);
            fields.chain(own.into_iter().take(place.len())).collect::<Vec<String>>()
        });
        let mut writer = csv::Writer::from_writer(Vec::new());
        // Memory takes all that is written.
        let _ = std::iter::once(head.collect()).chain(rows).try_for_each(|row| writer.write_record(&row));
        String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
    }

    /// Sets the number of rows of every point that gives its first row, if the point's `rows` are three or six.
    pub(super) fn state_dofs<'r>(&mut self, rows: impl Iterator<Item = &'r [Option<usize>; 6]>) {
        for (point, rows) in self.points.iter_mut().zip(rows) {
            if let PointPlace::Rows { dofs: dofs @ None, .. } = &mut point.place {
                *dofs = Some(rows.iter().flatten().count()).filter(|count| matches!(count, 3 | 6));
            }
        }
    }

    /// All points, in the order of the table.
    pub fn iter(&self) -> impl Iterator<Item = &InterfacePoint> {
        self.points.iter()
    }

    /// The point of this name.
    ///
    /// # Errors
    /// An unknown name, with the nearest known one.
    pub fn get(&self, name: &str) -> Result<&InterfacePoint, StructureError> {
        self.points.iter().find(|point| point.name == name).ok_or_else(|| StructureError::UnknownPoint {
            name: name.to_owned(),
            nearest: nearest(name, self.points.iter().map(|point| point.name.as_str())),
        })
    }
}

/// Columns with the rows of a point.
enum PlaceColumns {
    None,
    Rows { first: usize, dofs: Option<usize> },
    Node { node: usize, rotation_node: Option<usize>, weights: Option<usize> },
}

impl PlaceColumns {
    fn new(table: &CsvTable) -> Result<Self, StructureError> {
        let column = |name: &str| table.column(name).ok();
        let (first, dofs) = (column("first_row_0based"), column("dofs"));
        let (node, rotation_node, weights) = (column("node"), column("rotation_node"), column("weights"));
        match (first, node) {
            (Some(_), Some(_)) => {
                let reason =
                    "columns \"first_row_0based\" and \"node\" both give the rows of a point; give one of them"
                        .to_owned();
                Err(table.fault(table.header_line, reason))
            }
            (Some(first), None) if rotation_node.or(weights).is_none() => Ok(Self::Rows { first, dofs }),
            (None, Some(node)) if dofs.is_none() => Ok(Self::Node { node, rotation_node, weights }),
            (None, None) if dofs.or(rotation_node).or(weights).is_none() => Ok(Self::None),
            _ => {
                let reason =
                    "column \"dofs\" goes with \"first_row_0based\", \"rotation_node\" and \"weights\" with \"node\""
                        .to_owned();
                Err(table.fault(table.header_line, reason))
            }
        }
    }

    fn read(&self, table: &CsvTable, index: usize) -> Result<PointPlace, StructureError> {
        Ok(match *self {
            Self::None => PointPlace::None,
            Self::Rows { first, dofs } => PointPlace::Rows {
                first: table.field(index, first, "a row counted from 0", |text| text.parse().ok())?,
                dofs: match dofs {
                    None => None,
                    Some(dofs) => table.field(index, dofs, "3 or 6, or nothing", |text| match text {
                        "" => Some(None),
                        "3" => Some(Some(3)),
                        "6" => Some(Some(6)),
                        _ => None,
                    })?,
                },
            },
            Self::Node { node, rotation_node, weights } => {
                let nodes: Vec<i64> =
                    table.field(index, node, "the number of a node, or several with blanks between them", numbers)?;
                let rotation_node = match rotation_node {
                    None => None,
                    Some(column) => table.field(index, column, "the number of a node, or nothing", |text| {
                        if text.is_empty() { Some(None) } else { text.parse().ok().map(Some) }
                    })?,
                };
                let given = match weights {
                    None => None,
                    Some(column) => {
                        let expected = "one number per node with blanks between them, or nothing";
                        table.field(index, column, expected, |text| {
                            if text.is_empty() { Some(None) } else { numbers::<f64>(&table.with_point(text)).map(Some) }
                        })?
                    }
                };
                let fault = |reason: String| table.fault_in(index, reason);
                let weighted = WeightedNodes::new(&nodes, given.as_deref())
                    .map_err(|reason| fault(format!("node: the point {reason}")))?;
                match (weighted.single(), rotation_node) {
                    (Some(node), rotation_node) => PointPlace::Node { node, rotation_node },
                    (None, None) => PointPlace::Nodes(weighted),
                    (None, Some(_)) => {
                        let reason = "rotation_node: expected nothing for a point that is several nodes";
                        return Err(fault(reason.to_owned()));
                    }
                }
            }
        })
    }
}

/// Numbers with blanks between them; `None` for no number or other text.
fn numbers<T: std::str::FromStr>(text: &str) -> Option<Vec<T>> {
    let numbers: Option<Vec<T>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
    numbers.filter(|numbers| !numbers.is_empty())
}

/// One interface DOF: a point and one of its six directions.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct InterfaceDof {
    /// Name of the point.
    pub point: String,
    /// 0 to 5, see [`DOF_NAMES`].
    pub dof: usize,
}

/// The DOFs that a reduced structure gives access to, and where its points are.
#[derive(Debug, Clone)]
pub struct Interface {
    points: InterfacePoints,
    index: BTreeMap<String, [Option<usize>; 6]>,
    len: usize,
}

impl Interface {
    /// `rows[i]`: DOF and its row in the interface displacement `u_b`. Several DOFs may share a row.
    pub(super) fn new(points: InterfacePoints, rows: &[(InterfaceDof, usize)]) -> Self {
        let mut index: BTreeMap<String, [Option<usize>; 6]> = BTreeMap::new();
        for (key, row) in rows {
            if let Some(slot) = index.entry(key.point.clone()).or_default().get_mut(key.dof) {
                *slot = Some(*row);
            }
        }
        let len = rows.iter().map(|(_, row)| row + 1).max().unwrap_or(0);
        Self { points, index, len }
    }

    /// Every DOF with its row, by name of the point and direction.
    pub(super) fn dofs(&self) -> Vec<(InterfaceDof, usize)> {
        let of_point = |(point, rows): (&String, &[Option<usize>; 6])| {
            let point = point.clone();
            let dofs = rows.iter().enumerate().filter_map(|(dof, row)| Some((dof, (*row)?)));
            dofs.map(move |(dof, row)| (InterfaceDof { point: point.clone(), dof }, row)).collect::<Vec<_>>()
        };
        self.index.iter().flat_map(of_point).collect()
    }

    /// Coordinates of all points.
    pub fn points(&self) -> &InterfacePoints {
        &self.points
    }

    /// Number of rows of the interface displacement.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether no DOF is kept.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Row of a point's DOF in the interface displacement `u_b`.
    ///
    /// # Errors
    /// An unknown point, or a direction that was not kept.
    pub fn row_of(&self, point: &str, dof: usize) -> Result<usize, StructureError> {
        let rows = self.index.get(point).copied().unwrap_or_default();
        if let Some(row) = rows.get(dof).copied().flatten() {
            return Ok(row);
        }
        self.points.get(point)?;
        let kept: Vec<&str> = DOF_NAMES.iter().zip(rows).filter_map(|(name, row)| row.map(|_| *name)).collect();
        Err(StructureError::DofNotKept {
            point: point.to_owned(),
            dof: DOF_NAMES.get(dof).map_or_else(|| dof.to_string(), |name| (*name).to_owned()),
            kept: if kept.is_empty() { "none".to_owned() } else { kept.join(" ") },
        })
    }

    /// Weighted rows of the translation of a set of points along `direction`; directions with component 0 need no DOF.
    pub(super) fn translation(
        &self,
        points: &[(String, f64)],
        direction: [f64; 3],
    ) -> Result<Vec<(usize, f64)>, StructureError> {
        if direction.iter().any(|value| !value.is_finite()) || direction == [0.0; 3] {
            return Err(StructureError::argument(
                "direction",
                "a finite vector other than 0",
                format!("{direction:?}"),
            ));
        }
        require_weights(points)?;
        let mut rows = Vec::with_capacity(3 * points.len());
        for (point, weight) in points {
            for (dof, component) in direction.iter().enumerate().filter(|(_, value)| **value != 0.0) {
                rows.push((self.row_of(point, dof)?, weight * component));
            }
        }
        Ok(rows)
    }
}

/// A weighted set of points must not be empty, its weights finite.
pub(super) fn require_weights(points: &[(String, f64)]) -> Result<(), StructureError> {
    if points.is_empty() {
        return Err(StructureError::argument("points", "at least one interface point", "none"));
    }
    match points.iter().find(|(_, weight)| !weight.is_finite()) {
        Some((point, weight)) => Err(StructureError::argument(format!("weight of {point}"), "a finite number", weight)),
        None => Ok(()),
    }
}

/// A number as a cell, which is empty without one.
fn text(number: Option<impl ToString>) -> String {
    number.map(|number| number.to_string()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "name,role,first_row_0based,x_m,y_m,z_m\nR1,mount,0,0.1,0,1\nR2,mount,6,0.2,0,1\n";

    #[test]
    fn names_are_found_or_the_nearest_is_suggested() {
        let points = InterfacePoints::parse("p.csv", TABLE).expect("valid");
        assert_eq!(points.get("R2").expect("known").position_m, [0.2, 0.0, 1.0]);
        let error = points.get("R22").expect_err("unknown").to_string();
        assert_eq!(error, "unknown interface point \"R22\"; the nearest known name is \"R2\"");
    }

    #[test]
    fn faults_name_the_line() {
        let fails = |text: &str, wanted: &str| {
            let error = InterfacePoints::parse("p.csv", text).expect_err(wanted).to_string();
            assert!(error.contains(wanted), "{error}");
        };
        fails("", "p.csv, line 1: the table is empty");
        fails("name,role,x_m,y_m,z_m\n", "line 2: the table has a header but no rows");
        fails("name,role,x_m,y_m\nA,m,0,0\n", "line 1: column \"z_m\" is missing");
        fails("name,role,x_m,y_m,z_m,mass\nA,m,0,0,0,1\n", "unknown column \"mass\"");
        fails("name,name,x_m,y_m,z_m\nA,m,0,0,0\n", "column \"name\" appears twice");
        fails(&TABLE.replace("R2", "R1"), "line 3: name: expected a unique, non-empty name, found \"R1\"");
        fails(&TABLE.replace("0.2", "NaN"), "line 3: x_m: expected a finite number, found \"NaN\"");
        fails(&TABLE.replace(",6,", ",-6,"), "line 3: first_row_0based: expected a row counted from 0, found \"-6\"");
        fails(&TABLE.replace(",6,", ","), "line 3: expected 6 fields as in the header, found 5");
    }

    #[test]
    fn several_nodes_with_weights() {
        let table = |fields: &str| {
            let text = format!("name,x_m,y_m,z_m,node,rotation_node,weights\nA,0,0,0,{fields}\n");
            InterfacePoints::parse("p.csv", &text).map(|points| (points.get("A").expect("known").place.clone(), points))
        };
        let nodes = |nodes: &[i64], weights: Option<&[f64]>| {
            PointPlace::Nodes(WeightedNodes::new(nodes, weights).expect("valid"))
        };
        let node = |rotation_node| PointPlace::Node { node: 12, rotation_node };
        for (fields, expected) in [
            ("12,,", node(None)),
            ("12,13,", node(Some(13))),
            ("12,,3", node(None)),
            ("12 13 14,,", nodes(&[12, 13, 14], None)),
            ("12  13 -14,,1 2.5 1e-3", nodes(&[12, 13, -14], Some(&[1.0, 2.5, 1e-3]))),
        ] {
            let (place, points) = table(fields).expect(fields);
            assert_eq!(place, expected);
            // Written and read again, the points are the same.
            assert_eq!(InterfacePoints::parse("again", &points.to_csv()).expect("valid"), points);
        }
        let fails = |fields: &str, wanted: &str| {
            let error = table(fields).expect_err(wanted).to_string();
            assert!(error.contains(&format!("p.csv, line 2: {wanted}")), "{error}");
        };
        let semicolons = "name;x_m;y_m;z_m;node;weights\nA;0;0;0;12 13;1,5 0,5\n";
        let points = InterfacePoints::parse("p.csv", semicolons).expect("valid");
        assert_eq!(points.get("A").expect("known").place, nodes(&[12, 13], Some(&[1.5, 0.5])));
        fails(",,", "node: expected the number of a node, or several");
        fails("12 x,,", "node: expected the number of a node, or several");
        fails("12 13 12,,", "node: the point has node 12 twice");
        fails("12 13,,1", "node: the point has 2 nodes but 1 weights");
        fails("12 13,,1 x", "weights: expected one number per node");
        fails("12 13,,1 0", "node: the point has the weight 0 of node 13");
        fails("12 13,,1 nan", "node: the point has the weight NaN of node 13");
        fails("12 13,14,", "rotation_node: expected nothing for a point that is several nodes");
        let error = InterfacePoints::parse("p.csv", "name,x_m,y_m,z_m,first_row_0based,weights\nA,0,0,0,0,1\n");
        assert!(error.expect_err("no nodes").to_string().contains("\"rotation_node\" and \"weights\" with \"node\""));
    }

    #[test]
    fn directions_that_were_not_kept_are_named() {
        let points = InterfacePoints::parse("p.csv", TABLE).expect("valid");
        let dof = |point: &str, dof| InterfaceDof { point: point.to_owned(), dof };
        let interface = Interface::new(points, &[(dof("R1", 2), 0), (dof("R1", 4), 1)]);
        assert_eq!(interface.row_of("R1", 4), Ok(1));
        let error = interface.row_of("R1", 0).expect_err("not kept").to_string();
        assert!(error.contains("direction x is not in the reduced structure (kept: z ry)"), "{error}");
        assert!(interface.row_of("R2", 2).expect_err("not kept").to_string().contains("kept: none"));
        assert!(interface.row_of("R1", 6).is_err());
        assert!(matches!(interface.row_of("Q", 0), Err(StructureError::UnknownPoint { .. })));
        assert!(interface.translation(&[], [0.0, 0.0, 1.0]).is_err());
        assert!(interface.translation(&[("R1".to_owned(), 1.0)], [0.0; 3]).is_err());
        assert!(interface.translation(&[("R1".to_owned(), f64::NAN)], [0.0, 0.0, 1.0]).is_err());
    }
}
