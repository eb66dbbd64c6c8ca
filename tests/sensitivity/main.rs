//! Sensitivity indices: against other programs, against closed forms, and of datasets with failed rows.

mod coverage;
mod datasets;
mod references;
