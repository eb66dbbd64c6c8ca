//! Matrices from and to the files of finite element programs.
//!
//! Every reader takes plain and gzip files and gives both triangles. Repeated entries are summed. The format declares whether a file
//! holds one triangle or both, or the entries show it; a mixture is an error. Errors contain file, line and reason.
//!
//! A format is a file in `formats` and a line in the list of `formats/mod.rs`, see [`MatrixFormat`].

mod archive;
mod axes;
mod bulk;
mod columns;
mod dofs;
mod entry;
mod formats;
mod labelled;
mod lines;
mod nodes_file;
mod read;
mod rows;
mod source;
mod station;
mod superelement;
mod triplets;
mod units;
mod write;

pub use formats::{ExportFormat, MatrixFormat};
pub use source::{MatrixFile, ModelFiles, Units};
pub(super) use triplets::symmetric;
pub use write::write_model;
