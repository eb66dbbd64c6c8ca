//! The rows of a design as a table.

use std::collections::BTreeMap;

use super::info::dataset_info;
use crate::CheckedStudy;
use decore_dataset::{DatasetInfo, FactorColumn, RowRecord, TableColumn};
use decore_quantity::{CellColumn, Kind, Value};

/// Columns of a design's rows: the index of the row, then the factors, including derived ones. Also the metadata of their table about the
/// study, whose machines need not be reduced.
pub fn design_table(study: &CheckedStudy) -> (DatasetInfo, Vec<TableColumn>) {
    let info = dataset_info(study, BTreeMap::new(), BTreeMap::new(), None);
    let rows: Vec<Vec<Value>> = (0..study.row_count()).map(|row| study.row_values(row)).collect();
    let index = TableColumn {
        name: RowRecord::row.name.to_owned(),
        unit: RowRecord::row.unit.to_owned(),
        description: RowRecord::row.description(),
        values: CellColumn::integers(0..rows.len() as i64),
    };
    let factor = |(place, factor): (usize, &FactorColumn)| {
        let cells = || rows.iter().filter_map(move |row| row.get(place));
        let number = |value: &Value| value.number().unwrap_or(f64::NAN);
        let whole = |value: &Value| match value {
            Value::Integer(value) => Some(*value),
            _ => None,
        };
        TableColumn {
            name: format!("factor_{}", factor.name),
            unit: factor.unit.clone(),
            description: factor.description.clone(),
            values: match factor.kind {
                Kind::Real | Kind::Count => CellColumn::reals(cells().map(number)),
                Kind::Integer => CellColumn::integers(cells().filter_map(whole)),
                Kind::Text | Kind::Category => CellColumn::texts(cells().map(ToString::to_string)),
            },
        }
    };
    let columns = [index].into_iter().chain(info.factors.iter().enumerate().map(factor)).collect();
    (info, columns)
}
