//! Factors of a study: domains and targets, and the design that draws them.
//!
//! Each file imports only those before it: `factor` (a factor), `pages` and `parquet` (foreign Parquet files), `delimited` (foreign text
//! files), `table` (rows from files), `kinds` (the kind of design), `reader` (errors with their places), `drives` and `varies` (the two
//! halves of a factor in the file), `design` (all of it).

mod delimited;
pub(super) mod design;
mod drives;
pub(super) mod factor;
pub(super) mod kinds;
mod pages;
mod parquet;
pub(super) mod reader;
pub(super) mod table;
mod varies;
