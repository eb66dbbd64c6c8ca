//! Which factor of a sweep matters: what [`decore_statistics::analysis`] finds in the rows of a dataset, with what the study's design says
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

pub(crate) use analyse::DEFAULT_OUTPUTS;
pub use analyse::{SensitivitySettings, analyse, check};
pub use columns::columns;
pub use error::SensitivityError;
pub(crate) use result::{LeftOut, UnitName};
pub use result::{Sensitivity, Widths};
pub(crate) use table::OutputColumn;
pub use table::{FactorColumn, Table};
pub(crate) use text::four_digits;
pub(crate) use units::Units;
