//! Which factor of a sweep matters: what [`crate::analysis`] finds in the rows of a dataset, with what the study's design says
//! of them and what became of each row.
//!
//! ```text
//! tables --dataset--> Table --whole units--> analysis --> Sensitivity --> text, JSON, Parquet
//! study text --study--> DesignOutline --^
//! ```
//!
//! A Saltelli design has Sobol' indices, Morris trajectories have elementary effects. Rows that failed, are missing or lack an
//! output take the block or trajectory that they belong to with them, and every result says so.

mod analyse;
mod columns;
mod dependence;
mod error;
mod neighbours;
mod reach;
mod result;
mod table;
mod text;
mod units;

pub use analyse::{DEFAULT_OUTPUTS, SensitivitySettings, analyse, check};
pub use columns::columns;
pub use error::SensitivityError;
pub use result::{
    Index, IndexName, Intervals, LeftOut, Method, OutputSensitivity, Sensitivity, UnitName, Used, Widths,
};
pub use table::{FactorColumn, OutputColumn, Table};
pub use text::four_digits;
pub use units::{Units, Whole};
