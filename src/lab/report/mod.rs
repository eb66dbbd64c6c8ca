//! Summary of a dataset as plain text: how the rows ended, the best rows, ranges of the outputs, where the tables are.

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
