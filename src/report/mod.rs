//! Summary of a dataset as plain text: how the rows ended, the best rows, ranges of the outputs, where the tables are.

mod summary;
mod text;

pub use summary::{BestRow, DEFAULT_RANKING, Figure, Range, Report, ReportSettings, summarise};
