//! Frequency responses as a CSV table.

use std::collections::BTreeMap;
use std::path::Path;

use super::response::{MeasuredDof, MeasuredFrf, Motion};
use crate::structure::csv::{CsvTable, read_text};
use crate::structure::error::StructureError;

const COLUMNS: [(&str, Motion); 3] =
    [("receptance", Motion::Displacement), ("mobility", Motion::Velocity), ("accelerance", Motion::Acceleration)];

/// Reads the responses, in the order in which they appear first.
pub(super) fn responses(file: &str, bytes: &[u8]) -> Result<Vec<MeasuredFrf>, StructureError> {
    let text = std::str::from_utf8(bytes).map_err(|_| StructureError::Matrix {
        file: file.to_owned(),
        reason: "neither text nor data sets 58: expected a UFF file (its first line is -1) or a CSV table".to_owned(),
    })?;
    let table = CsvTable::parse(file, text)?;
    let (response, force, frequency) =
        (table.column("response")?, table.column("force")?, table.column("frequency_hz")?);
    let pair = COLUMNS.iter().find_map(|(name, motion)| {
        let column = |part: &str| table.column(&format!("{name}_{part}")).ok();
        Some((column("re")?, column("im")?, *motion))
    });
    let Some((re, im, motion)) = pair else {
        let reason = "expected columns mobility_re and mobility_im in m/(s N), receptance_re, ..._im in m/N, or accelerance_re, ..._im in m/(s2 N)";
        return Err(table.fault(table.header_line, reason.to_owned()));
    };
    let mut out: Vec<MeasuredFrf> = Vec::new();
    let mut known: BTreeMap<(MeasuredDof, MeasuredDof), usize> = BTreeMap::new();
    for row in 0..table.rows.len() {
        let dof =
            |column| table.field(row, column, "point or node with direction, as R5.z or 12.-x", MeasuredDof::parse);
        let (response, force) = (dof(response)?, dof(force)?);
        let place = *known.entry((response.clone(), force.clone())).or_insert(out.len());
        if place == out.len() {
            out.push(MeasuredFrf { response, force, frequency_hz: Vec::new(), mobility: Vec::new() });
        }
        let frf = &mut out[place];
        let last = frf.frequency_hz.last().copied().unwrap_or(0.0);
        let hz = table.number(row, frequency)?;
        let value = [table.number(row, re)?, table.number(row, im)?];
        if hz == 0.0 {
            continue;
        }
        if hz <= last {
            let line = table.rows.get(row).map_or(0, |(line, _)| *line);
            return Err(table.fault(line, format!("frequency_hz: expected more than {last}, found {hz}")));
        }
        frf.frequency_hz.push(hz);
        frf.mobility.push(motion.mobility(std::f64::consts::TAU * hz, value));
    }
    Ok(out)
}

/// Damping ratios as a table that [`read_damping_ratios`] reads.
pub(super) fn damping_table(ratios: &[f64]) -> String {
    let rows = ratios.iter().zip(1..).map(|(ratio, mode)| format!("{mode},{ratio:e}\n"));
    std::iter::once("mode,damping_ratio\n".to_owned()).chain(rows).collect()
}

/// Reads damping ratios, one line per mode.
pub(super) fn read_damping_ratios(path: &Path) -> Result<Vec<f64>, StructureError> {
    let table = CsvTable::parse(&path.display().to_string(), &read_text(path)?)?;
    let [mode, ratio] = [table.column("mode")?, table.column("damping_ratio")?];
    let row = |row: usize| {
        table.field(row, mode, "the numbers of modes from 1 on", |text| {
            text.parse().ok().filter(|at: &usize| *at == row + 1)
        })?;
        table.field(row, ratio, "a ratio from 0 to below 1", |text| {
            text.parse().ok().filter(|value: &f64| (0.0..1.0).contains(value))
        })
    };
    (0..table.rows.len()).map(row).collect()
}
