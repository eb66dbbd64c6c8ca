//! Sensitivity indices: against other programs, against closed forms, of datasets with failed rows, and of such as are given more.

mod coverage;
mod datasets;
#[cfg(unix)]
mod more_rows;
mod references;
