//! Studies: the TOML file as typed, and what it means: a machine, a scene per row, and the design of the rows.
//!
//! [`Study::load`] reads the file and everything it names (hammer files) once; [`CheckedStudy::new`] holds it to the interface
//! points of the machine and lets its constraints choose the rows; [`CheckedStudy::scene`] is a pure function of the row that
//! touches no file.
//!
//! A row's values are put at their paths into the tree of the file's values, which is then read like any file: whatever
//! the file can say, a factor or a `--set` can vary.
//!
//! Three rooms, each of which imports those before it only: `document` (a text with the places of its keys, paths into it, values
//! set over it), `plan` (what each factor is and drives, the design), `resolve` (from values to a scene). What is typed is in
//! `file`; [`Study`] and [`CheckedStudy`] put them together.

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
