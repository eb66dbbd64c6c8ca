//! A surrogate for predictions on a page: its figures as JSON, its rows and weights in the page's data.

use serde::Serialize;

use decore_lab::surrogate::{FactorSpace, Model, OutputModel, OutputSurrogate, ProcessFigures, RowsProcess};

/// A surrogate; offsets are of bytes in the page's data, numbers have eight each.
#[derive(Debug, Serialize)]
pub(super) struct ModelData {
    factors: Vec<FactorSpace>,
    /// Rows, and where their scaled places begin, row by row.
    rows: usize,
    points: usize,
    outputs: Vec<OutputData>,
}

#[derive(Debug, Serialize)]
struct OutputData {
    output: String,
    unit: String,
    description: String,
    /// Value of a constant output, which has no process.
    constant: Option<f64>,
    process: Option<ProcessData>,
    success: Option<SuccessData>,
}

#[derive(Debug, Serialize)]
struct ProcessData {
    figures: ProcessFigures,
    /// Places that it is fitted to.
    count: usize,
    /// Begin of the rows at these places, their weights and their numbers of runs.
    rows: usize,
    weights: usize,
    runs: usize,
}

#[derive(Debug, Serialize)]
struct SuccessData {
    everywhere: Option<f64>,
    scaling: Option<[f64; 2]>,
    process: Option<ProcessData>,
}

/// Appends a model to the page's data; returns its description.
pub(super) fn model_data(model: &Model, data: &mut Vec<u8>) -> ModelData {
    let rows = model.points.rows();
    let points: Vec<f64> = (0..rows).flat_map(|row| model.points.row(row).to_vec()).collect();
    ModelData {
        factors: model.surrogate.factors.clone(),
        rows,
        points: append(&points, data),
        outputs: (model.surrogate.outputs.iter().zip(&model.outputs))
            .map(|(figures, of)| output(figures, of, data))
            .collect(),
    }
}

fn output(figures: &OutputSurrogate, of: &OutputModel, data: &mut Vec<u8>) -> OutputData {
    let own = figures.process.as_ref().zip(of.process.as_ref());
    let success = figures.success.as_ref().map(|success| SuccessData {
        everywhere: success.everywhere.or_else(|| success.process.is_none().then_some(success.share)),
        scaling: success.scaling,
        process: success.process.as_ref().zip(of.success.as_ref()).map(|(figures, of)| process(figures, of, data)),
    });
    OutputData {
        output: figures.output.clone(),
        unit: figures.unit.clone(),
        description: figures.description.clone(),
        constant: of.constant,
        process: own.map(|(figures, of)| process(figures, of, data)),
        success,
    }
}

fn process(figures: &ProcessFigures, of: &RowsProcess, data: &mut Vec<u8>) -> ProcessData {
    let rows: Vec<f64> = of.rows.iter().map(|row| *row as f64).collect();
    ProcessData {
        figures: figures.clone(),
        count: rows.len(),
        rows: append(&rows, data),
        weights: append(of.process.row_weights(), data),
        runs: append(of.process.places().runs(), data),
    }
}

/// Appends numbers at a multiple of eight bytes; returns where they begin.
fn append(values: &[f64], data: &mut Vec<u8>) -> usize {
    data.resize(data.len().next_multiple_of(8), 0);
    let offset = data.len();
    data.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    offset
}
