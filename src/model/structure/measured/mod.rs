//! Measured frequency responses, and how far the machine's own lie from them.
//!
//! ```text
//! UFF 58, CSV -> MeasuredFrf (mobility) --+
//!                                         +-> compare() -> MeasuredReport: curves, modes, proposed damping ratios
//! ReducedStructure -> modes at the points +
//! ```

mod compare;
mod fit;
mod peaks;
mod response;
mod table;
pub(super) mod uff;

use std::path::Path;

pub use compare::{MeasuredMode, MeasuredReport, MeasuredSettings, compare};
pub(crate) use response::MeasuredFrf;

use super::error::StructureError;
use decore_files::Limit;

/// Reads frequency responses from a file of data sets 58 (UFF, UNV; text or binary), or from a CSV table with the columns `response`,
/// `force` (point or node with direction, `R5.z`, `12.-x`), `frequency_hz` and a pair `mobility_re`, `mobility_im`, `receptance_re`, ...
/// or `accelerance_re`, ...
///
/// # Errors
/// File, line and reason; a file without a frequency response.
pub fn read_measured(path: &Path) -> Result<Vec<MeasuredFrf>, StructureError> {
    let file = path.display().to_string();
    let bytes = decore_files::read(path, Limit::MATRIX)
        .map_err(|error| StructureError::Read { file: file.clone(), reason: error.to_string() })?;
    let found = if uff::is_uff(&bytes) { uff::responses(&file, &bytes)? } else { table::responses(&file, &bytes)? };
    if found.is_empty() {
        let reason = "no frequency response found: expected data sets 58 of function type 4, or a CSV table";
        return Err(StructureError::Matrix { file, reason: reason.to_owned() });
    }
    Ok(found)
}

/// Reads damping ratios of modes: a CSV table with the columns `mode` (1, 2, 3, ...) and `damping_ratio`.
///
/// # Errors
/// File, line and reason.
pub fn read_damping_ratios(path: &Path) -> Result<Vec<f64>, StructureError> {
    table::read_damping_ratios(path)
}
