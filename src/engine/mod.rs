//! From a study to rows that run: the study checked against its machines, the machines reduced, a row, a dataset.
//!
//! Nothing here prints or draws.

mod error;
mod info;
mod inputs;
mod machine;
mod prepared;
mod rows;

pub use error::EngineError;
pub use info::dataset_info;
pub use machine::{Machine, SourceModel, reduction_settings};
pub use prepared::{Engine, RowScene};
pub use rows::{Rows, constrained};
