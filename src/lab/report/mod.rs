//! Summary of a dataset as plain text: status of the rows, best rows, ranges of the outputs, paths of the tables.

mod charts;
mod numbers;
mod numerical;
mod precision;
mod summary;
mod text;

pub use charts::{Charts, Paper};
pub use summary::{
    BestRow, DEFAULT_RANKING, NamedValue, Report, ReportSettings, WANTED_ERROR, WorstResidual, summarise,
};
