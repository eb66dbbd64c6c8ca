//! Comparison of the published results with decore's for the same rig: M. Mariadass, R. Binder, F. Ettemeyer, W. Volk, D. Günther,
//! *Modeling De-Coring Tools with Coupled Multibody Simulation and Finite Element Analysis*, Appl. Mech. 2023, 4, 1206-1226.
//!
//! ```text
//! quoted: figures of the paper ------------------------+
//!                                                      +--groups--> PaperComparison
//! rig: studies/paper_rig.toml, compiled in --run--> ours
//! ```
//!
//! - `quoted`: figures of the paper, with table, figure or section
//! - `rig`: the rig as a study, its runs, and runs with one change that show the causes of differences
//! - `mobility`: velocity per force over frequency
//! - `lines`: lines of the arm's spectrum by window and span
//! - `compared`: the result as plain data
//! - `page`: the result as one HTML page
//! - `structure_groups`, `process_groups`: compared figures, their tolerances and the causes of differences

mod compared;
mod error;
mod lines;
mod mobility;
mod page;
mod process_groups;
mod quoted;
mod rig;
mod structure_groups;

pub use compared::{
    Against, Agreement, Evidence, EvidenceRow, FigureGroup, PaperComparison, PaperFigure, Tolerance, four_digits,
};
pub use error::PaperError;
pub use mobility::{Mobility, MobilityPeak};
pub use page::paper_page;
pub use quoted::CITATION;

/// Runs the paper's rig, and further runs that explain differences, and compares all with the paper's figures. Reads no file.
///
/// # Errors
/// [`PaperError`], of which none is known: the study is compiled in.
pub fn compare() -> Result<PaperComparison, PaperError> {
    let ours = rig::run()?;
    let groups = structure_groups::groups(&ours).into_iter().chain(process_groups::groups(&ours)?).collect();
    Ok(PaperComparison::new(groups, ours.mobility))
}
