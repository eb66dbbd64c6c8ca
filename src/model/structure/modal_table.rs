//! A structure given by its modes.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::DMatrix;

use super::csv::{CsvTable, read_text};
use super::error::StructureError;
use super::measured::uff::{self, UffMode, is_uff};
use super::points::{DOF_NAMES, InterfaceDof, InterfacePoints, PointPlace};

/// Measured or computed modes of a machine, mass-normalised.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalTable {
    /// Natural frequencies in Hz, rising, zero or positive.
    pub frequency_hz: Vec<f64>,
    /// Damping ratios xi.
    pub damping_ratio: Vec<f64>,
    /// Interface DOFs, in the order of the columns.
    pub dofs: Vec<InterfaceDof>,
    /// Modal displacements in 1/sqrt(kg), rotations in rad/(m sqrt(kg)): one row per DOF, one column per mode.
    pub shapes: DMatrix<f64>,
}

impl ModalTable {
    /// Reads the normal modes of a universal file (data sets 55), or a CSV table with the columns `mode` (rising whole number),
    /// `frequency_hz` (rising), `damping_ratio`, then one
    /// column per interface DOF named by point and direction: `R5.z`, `R5.rx`.
    ///
    /// # Errors
    /// File, line and reason.
    pub fn read(path: &Path) -> Result<Self, StructureError> {
        let text = read_text(path)?;
        let file = path.display().to_string();
        if is_uff(text.as_bytes()) {
            return Self::of_modes(&file, &uff::modes(&file, text.as_bytes())?);
        }
        Self::parse(&file, &text)
    }

    /// From the normal modes of a universal file, over all nodes; a DOF's point is the node's number.
    fn of_modes(file: &str, modes: &[UffMode]) -> Result<Self, StructureError> {
        let fault = |reason: String| StructureError::Matrix { file: file.to_owned(), reason };
        let mut rows: BTreeMap<(i64, usize), usize> = BTreeMap::new();
        for (node, values) in modes.iter().flat_map(|mode| &mode.shape) {
            for dof in 0..values.len().min(DOF_NAMES.len()) {
                let next = rows.len();
                rows.entry((*node, dof)).or_insert(next);
            }
        }
        let mut shapes = DMatrix::zeros(rows.len(), modes.len());
        for (column, mode) in modes.iter().enumerate() {
            if mode.shape.len() != modes[0].shape.len() {
                return Err(fault(format!(
                    "mode {} at {} Hz has other nodes than the first one",
                    column + 1,
                    mode.frequency_hz
                )));
            }
            for (node, values) in &mode.shape {
                for (dof, value) in values.iter().enumerate() {
                    if let Some(row) = rows.get(&(*node, dof)) {
                        shapes[(*row, column)] = *value;
                    }
                }
            }
        }
        let mut dofs = vec![InterfaceDof { point: String::new(), dof: 0 }; rows.len()];
        for ((node, dof), row) in rows {
            dofs[row] = InterfaceDof { point: node.to_string(), dof };
        }
        Ok(Self {
            frequency_hz: modes.iter().map(|mode| mode.frequency_hz).collect(),
            damping_ratio: modes.iter().map(|mode| mode.damping_ratio).collect(),
            dofs,
            shapes,
        })
    }

    /// The table with the names of points for numbers of their nodes, and without nodes where no point stands.
    pub(super) fn at_points(&self, points: &InterfacePoints) -> Self {
        let by_node: BTreeMap<String, &str> = points
            .iter()
            .filter_map(|point| match &point.place {
                PointPlace::Node { node, .. } => Some((node.to_string(), point.name.as_str())),
                _ => None,
            })
            .collect();
        if by_node.is_empty() {
            return self.clone();
        }
        let named = |dof: &InterfaceDof| by_node.get(&dof.point).map_or(dof.point.as_str(), |name| *name).to_owned();
        let kept: Vec<usize> =
            (0..self.dofs.len()).filter(|row| points.get(&named(&self.dofs[*row])).is_ok()).collect();
        let dofs = kept.iter().map(|row| InterfaceDof { point: named(&self.dofs[*row]), dof: self.dofs[*row].dof });
        Self { dofs: dofs.collect(), shapes: self.shapes.select_rows(&kept), ..self.clone() }
    }

    /// Like [`ModalTable::read`], from text; `file` is the name that errors carry.
    ///
    /// # Errors
    /// As for [`ModalTable::read`].
    pub fn parse(file: &str, text: &str) -> Result<Self, StructureError> {
        const FIXED: [&str; 3] = ["mode", "frequency_hz", "damping_ratio"];
        let table = CsvTable::parse(file, text)?;
        let [mode, frequency, damping] = [table.column(FIXED[0])?, table.column(FIXED[1])?, table.column(FIXED[2])?];
        let mut columns = Vec::new();
        for (column, name) in table.header.iter().enumerate().filter(|(_, name)| !FIXED.contains(&name.as_str())) {
            let dof = parse_dof(name).ok_or_else(|| {
                let reason =
                    format!("column \"{name}\": expected point.direction, direction one of {}", DOF_NAMES.join(" "));
                table.fault(table.header_line, reason)
            })?;
            columns.push((column, dof));
        }
        if columns.is_empty() {
            let reason = "no column of an interface DOF (for instance R5.z)".to_owned();
            return Err(table.fault(table.header_line, reason));
        }
        let modes = table.rows.len();
        let mut out = Self {
            frequency_hz: Vec::with_capacity(modes),
            damping_ratio: Vec::with_capacity(modes),
            dofs: columns.iter().map(|(_, dof)| dof.clone()).collect(),
            shapes: DMatrix::zeros(columns.len(), modes),
        };
        let mut last_mode = 0_u64;
        let mut last_frequency = 0.0;
        for index in 0..modes {
            last_mode = table.field(index, mode, "whole numbers from 1 that rise", |text| {
                text.parse().ok().filter(|number| *number > last_mode)
            })?;
            last_frequency = table.field(index, frequency, "frequencies >= 0 that rise", |text| {
                text.parse().ok().filter(|value: &f64| value.is_finite() && *value >= last_frequency)
            })?;
            out.frequency_hz.push(last_frequency);
            out.damping_ratio.push(table.field(index, damping, "a ratio >= 0", |text| {
                text.parse().ok().filter(|value: &f64| value.is_finite() && *value >= 0.0)
            })?);
            for (row, (column, _)) in columns.iter().enumerate() {
                out.shapes[(row, index)] = table.number(index, *column)?;
            }
        }
        Ok(out)
    }

    /// Holds for every table that was read; a table built in memory may break it.
    pub(super) fn validate(&self) -> Result<(), StructureError> {
        let (dofs, modes) = (self.dofs.len(), self.frequency_hz.len());
        if dofs == 0 || modes == 0 || self.damping_ratio.len() != modes || self.shapes.shape() != (dofs, modes) {
            let expected = format!("{modes} damping ratios, shapes of {dofs} x {modes}, at least one DOF and mode");
            let found = format!("{} and {:?}", self.damping_ratio.len(), self.shapes.shape());
            return Err(StructureError::argument("modal table", expected, found));
        }
        let valid = |values: &[f64]| values.iter().all(|value| value.is_finite() && *value >= 0.0);
        if !valid(&self.frequency_hz) || !valid(&self.damping_ratio) || !self.frequency_hz.is_sorted() {
            let expected = "frequencies that rise and damping ratios, all >= 0";
            return Err(StructureError::argument("modal table", expected, "another value"));
        }
        if self.shapes.iter().any(|value| !value.is_finite()) {
            return Err(StructureError::argument("modal table", "finite modal displacements", "NaN or infinity"));
        }
        match self.dofs.iter().find(|dof| dof.dof >= DOF_NAMES.len()) {
            Some(dof) => Err(StructureError::argument(format!("direction of {}", dof.point), "0 to 5", dof.dof)),
            None => Ok(()),
        }
    }
}

/// `R5.rx` is point R5, direction 3; the point's name may contain dots.
fn parse_dof(name: &str) -> Option<InterfaceDof> {
    let (point, direction) = name.rsplit_once('.')?;
    let dof = DOF_NAMES.iter().position(|known| *known == direction)?;
    (!point.is_empty()).then(|| InterfaceDof { point: point.to_owned(), dof })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "mode,frequency_hz,damping_ratio,R5.z,T5.z\n1,3.5,0.02,0.1,-0.2\n2,16,0.01,0.3,0.4\n";

    #[test]
    fn reads_what_it_says() {
        let table = ModalTable::parse("m.csv", TABLE).expect("valid");
        assert_eq!(table.frequency_hz, [3.5, 16.0]);
        assert_eq!(table.damping_ratio, [0.02, 0.01]);
        assert_eq!(table.dofs[1], InterfaceDof { point: "T5".to_owned(), dof: 2 });
        assert_eq!(table.shapes, DMatrix::from_row_slice(2, 2, &[0.1, 0.3, -0.2, 0.4]));
    }

    #[test]
    fn faults_name_the_line() {
        let fails = |text: &str, wanted: &str| {
            let error = ModalTable::parse("m.csv", text).expect_err(wanted).to_string();
            assert!(error.contains(wanted), "{error}");
        };
        fails(&TABLE.replace("T5.z", "T5.q"), "line 1: column \"T5.q\": expected point.direction");
        fails(
            &TABLE.replace(",R5.z,T5.z", "").replace(",0.1,-0.2", "").replace(",0.3,0.4", ""),
            "no column of an interface",
        );
        fails(&TABLE.replace("2,16", "1,16"), "line 3: mode: expected whole numbers from 1 that rise, found \"1\"");
        fails(&TABLE.replace("2,16", "2,3"), "line 3: frequency_hz: expected frequencies >= 0 that rise");
        fails(&TABLE.replace("0.01", "-0.01"), "line 3: damping_ratio: expected a ratio >= 0");
        fails(&TABLE.replace("0.4", "inf"), "line 3: T5.z: expected a finite number");
    }
}
