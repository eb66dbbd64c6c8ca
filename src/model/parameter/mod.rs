//! Declaration of parameters: name, type, default, unit, range, source and text in one place.
//!
//! The macro `parameters!` makes the struct with its documentation, defaults, reader and writer, the JSON schema with ranges, and the
//! check. A parameter without a range does not compile. Tests compare the files that follow from declarations (`schemas/`,
//! `studies/hammers/default.toml`). To rewrite these files, run
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
