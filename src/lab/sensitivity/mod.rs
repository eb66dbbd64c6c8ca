//! Ranks the factors of a sweep: applies [`decore_statistics::analysis`] to the rows of a dataset, according to the study's design and
//! the status of each row.
//!
//! ```text
//! tables --dataset--> Table --whole units--> analysis --> Sensitivity --> text, JSON, Parquet
//! study text --study--> DesignOutline --^
//! ```
//!
//! A Saltelli design has Sobol' indices, Morris trajectories have elementary effects. A failed, missing or incomplete row removes its
//! whole block or trajectory. Every result lists such rows.

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
