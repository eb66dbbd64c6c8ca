//! Summary of a dataset.
