//! Parameters declared once: name, type, default, unit, range, source and text of each stand together.
//!
//! The macro `parameters!` makes of a declaration the struct with its documentation, its defaults, its reader and writer, its JSON
//! schema with the ranges, and the check. A parameter without a range does not compile. Files that follow from declarations
//! (`schemas/`, `studies/hammers/default.toml`) are held to them by the tests, and written anew by
//!
//! ```text
//! DECORE_UPDATE_SCHEMAS=1 cargo test --release --test study
//! ```

#[macro_use]
mod words;
mod declare;
mod document;
mod entry;
mod range;
mod usual;

pub(crate) use declare::{check, default, kind, parameters, unusual};
pub use document::{document, lines};
pub(crate) use entry::Choice;
pub use entry::describe;
pub(crate) use entry::key;
pub use entry::{Parameter, ParameterKind, Parameters};
pub(crate) use range::range;
pub use range::{Fault, short};
pub(crate) use range::{Numbers, Range};
pub(crate) use usual::Usual;
