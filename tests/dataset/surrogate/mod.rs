//! Surrogates: models of plain tables, and of datasets by the command.

mod datasets;
mod honest;
mod models;
