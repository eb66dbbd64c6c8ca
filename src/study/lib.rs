//! Studies: the TOML file, and its meaning: a machine, a scene per row, and the design of the rows.
//!
//! [`Study::load`] reads the file and all files that it names (hammer files) once. [`CheckedStudy::new`] checks it against the interface
//! points of the machine and selects rows by its constraints. [`CheckedStudy::scene`] is a pure function of the row that reads no file.
//!
//! A row's values are set at their paths in the tree of the file's values, which is then read like any file. So a factor or `--set` can
//! vary everything that a file can contain.
//!
//! Three modules, each of which imports only those before it: `document` (a text with the places of its keys, paths into it, overrides),
//! `plan` (factors with their targets, the design), `resolve` (from values to a scene). `file` has the types of the file; [`Study`] and
//! [`CheckedStudy`] combine them.

mod checked;
mod constraints;
mod demand;
mod document;
pub mod engine;
pub mod expression;
mod factor_values;
mod file;
mod goal;
mod growth;
mod hash;
mod loaded;
mod outline;
mod plan;
mod resolve;
mod schema;
mod template;

pub use checked::CheckedStudy;
pub use demand::InterfaceDemand;
pub(crate) use document::error::InvalidRow;
pub use document::error::{FileLocation, Problem, StudyError};
pub use file::FactorRole;
pub use goal::{Goal, Limit};
pub use loaded::Study;
pub use outline::{DesignOutline, FactorOutline};
pub use plan::factor::FactorInfo;
pub use plan::table::{TableRow, column_names, column_rows, factor_rows, sparse_rows};
pub use resolve::placement::PointTable;
pub use resolve::structure::{CastingModel, StructureSettings, StructureSource, load_structure};
pub use schema::{hammer_file, hammer_schema, study_schema};
pub use template::template;
