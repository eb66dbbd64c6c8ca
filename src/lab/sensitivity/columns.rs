//! The indices as a table: a row per output and index.

use super::result::{Index, OutputSensitivity, Sensitivity};
use decore_dataset::TableColumn;
use decore_quantity::CellColumn;

/// A row per output and index, in the order of the result.
pub fn columns(found: &Sensitivity) -> Vec<TableColumn> {
    let rows: Vec<(&OutputSensitivity, &Index)> =
        found.outputs.iter().flat_map(|output| output.indices.iter().map(move |index| (output, index))).collect();
    let text = |name: &str, description: &str, value: &dyn Fn(&OutputSensitivity, &Index) -> String| TableColumn {
        name: name.to_owned(),
        unit: String::new(),
        description: description.to_owned(),
        values: CellColumn::texts(rows.iter().map(|(output, index)| value(output, index))),
    };
    let real = |name: &str, description: &str, value: &dyn Fn(&Index) -> Option<f64>| TableColumn {
        name: name.to_owned(),
        unit: "1".to_owned(),
        description: description.to_owned(),
        values: CellColumn::reals(rows.iter().map(|(_, index)| value(index).unwrap_or(f64::NAN))),
    };
    let count = |name: &str, description: &str, value: &dyn Fn(&OutputSensitivity) -> u64| TableColumn {
        name: name.to_owned(),
        unit: "1".to_owned(),
        description: description.to_owned(),
        values: CellColumn::integers(rows.iter().map(|(output, _)| value(output).cast_signed())),
    };
    let factor = |index: &Index, place: usize| index.factors.get(place).cloned().unwrap_or_default();
    vec![
        text("output", "Column of the table of runs.", &|output, _| output.output.clone()),
        text("index", "Name of the index, as in JSON.", &|_, index| index.index.name().to_owned()),
        text("factor", "Name of the factor, as in the study.", &|_, index| factor(index, 0)),
        text("second_factor", "The other factor of a pair; empty for one factor.", &|_, index| factor(index, 1)),
        real("value", "The index; mu_star, mu and sigma in the output's unit, which `output_unit` has.", &|index| {
            index.value
        }),
        real("low", "Lower end of its interval; NaN where there is none.", &|index| index.interval.map(|ends| ends[0])),
        real("high", "Upper end of its interval; NaN where there is none.", &|index| {
            index.interval.map(|ends| ends[1])
        }),
        text("output_unit", "Unit of the output.", &|output, _| output.unit.clone()),
        count("units_used", "Blocks, trajectories or rows that were used.", &|output| output.used.whole),
        count("units", "Blocks, trajectories or rows of the design.", &|output| output.used.of),
    ]
}
