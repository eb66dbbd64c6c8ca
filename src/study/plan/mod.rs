//! Factors of a study: domains and targets, and the design that draws them.
//!
//! Each file imports those before it only: `factor` (what a factor is), `pages` and `parquet` (Parquet files of
//! others), `delimited` (text files of others), `table` (rows from files), `kinds` (the kind of design),
//! `reader` (faults with their places), `drives` and `varies` (the two halves of a factor as typed), `design` (all of it).

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
