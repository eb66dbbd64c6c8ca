//! Measured frequency responses, and the machine's deviation from them.
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
    if let Some(way) = way_out(&bytes) {
        return Err(StructureError::Matrix { file, reason: way.to_owned() });
    }
    let found = if uff::is_uff(&bytes) { uff::responses(&file, &bytes)? } else { table::responses(&file, &bytes)? };
    if found.is_empty() {
        let reason = "no frequency response found: expected data sets 58 of function type 4, or a CSV table";
        return Err(StructureError::Matrix { file, reason: reason.to_owned() });
    }
    Ok(found)
}

/// Advice for a readable file from another program's file, by its first bytes.
fn way_out(bytes: &[u8]) -> Option<&'static str> {
    const FILES: [(&[u8], &str); 4] = [
        (
            b"MATLAB",
            "a file of MATLAB: write a table in it, `writetable(table(response, force, frequency_hz, mobility_re, mobility_im), 'frf.csv')`, or read it in Python with `scipy.io.loadmat`",
        ),
        (
            b"\x89HDF",
            "an HDF5 file (MATLAB 7.3 and others): read it in Python with `h5py` and write a CSV table with the columns response, force, frequency_hz, mobility_re, mobility_im",
        ),
        (
            b"TDSm",
            "a TDMS file of LabVIEW: read it in Python with `nptdms` and write a CSV table with the columns response, force, frequency_hz, mobility_re, mobility_im",
        ),
        (b"PK\x03\x04", "a spreadsheet or another archive: save the table as CSV"),
    ];
    FILES.iter().find(|(head, _)| bytes.starts_with(head)).map(|(_, way)| *way)
}

/// Reads damping ratios of modes: a CSV table with the columns `mode` (1, 2, 3, ...) and `damping_ratio`.
///
/// # Errors
/// File, line and reason.
pub fn read_damping_ratios(path: &Path) -> Result<Vec<f64>, StructureError> {
    table::read_damping_ratios(path)
}
