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
mod table;
mod uff;

use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;

pub use compare::{MeasuredCurve, MeasuredMode, MeasuredReport, MeasuredSettings, compare};
pub(super) use uff::{UffMode, is_uff, modes as uff_modes};

use super::error::StructureError;
use super::points::DOF_NAMES;
use crate::files::{self, Limit};

/// Where a signal was taken: a place and a translation with its sign.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct MeasuredDof {
    /// Name of an interface point, or number of a node.
    pub place: String,
    /// 0 to 2: x, y, z.
    pub axis: usize,
    /// Whether the positive signal is along the negative axis.
    pub reversed: bool,
}

impl MeasuredDof {
    /// The direction in the machine's coordinates, a unit vector.
    pub fn direction(&self) -> [f64; 3] {
        let mut direction = [0.0; 3];
        if let Some(component) = direction.get_mut(self.axis) {
            *component = if self.reversed { -1.0 } else { 1.0 };
        }
        direction
    }

    /// `12.z`, `R5.-x`.
    fn parse(text: &str) -> Option<Self> {
        let (place, direction) = text.rsplit_once('.')?;
        let (reversed, name) = match direction.strip_prefix('-') {
            Some(name) => (true, name),
            None => (false, direction.strip_prefix('+').unwrap_or(direction)),
        };
        let axis = DOF_NAMES[..3].iter().position(|known| known.eq_ignore_ascii_case(name))?;
        (!place.is_empty()).then(|| Self { place: place.to_owned(), axis, reversed })
    }
}

impl std::fmt::Display for MeasuredDof {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        let sign = if self.reversed { "-" } else { "" };
        write!(formatter, "{}.{sign}{}", self.place, DOF_NAMES.get(self.axis).copied().unwrap_or_default())
    }
}

/// A measured mobility: velocity at one place per force at another.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredFrf {
    /// Where the velocity was taken.
    pub response: MeasuredDof,
    /// Where the force acted.
    pub force: MeasuredDof,
    /// Frequencies in Hz, positive, rising.
    pub frequency_hz: Vec<f64>,
    /// Real and imaginary part in m/(s N).
    pub mobility: Vec<[f64; 2]>,
}

/// Quantity of motion of a frequency response.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Motion {
    Displacement,
    Velocity,
    Acceleration,
}

impl Motion {
    /// A value per force as velocity per force: times `j omega`, 1 or `1 / (j omega)`.
    fn mobility(self, omega: f64, [re, im]: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Displacement => [-omega * im, omega * re],
            Self::Velocity => [re, im],
            Self::Acceleration => [im / omega, -re / omega],
        }
    }
}

/// Reads frequency responses from a file of data sets 58 (UFF, UNV; text or binary), or from a CSV table with the columns `response`,
/// `force` (point or node with direction, `R5.z`, `12.-x`), `frequency_hz` and a pair `mobility_re`, `mobility_im`, `receptance_re`, ...
/// or `accelerance_re`, ...
///
/// # Errors
/// File, line and reason; a file without a frequency response.
pub fn read_measured(path: &Path) -> Result<Vec<MeasuredFrf>, StructureError> {
    let file = path.display().to_string();
    let bytes = files::read(path, Limit::MATRIX)
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

impl MeasuredReport {
    /// The proposed damping ratios as a table that [`read_damping_ratios`] reads.
    pub fn damping_table(&self) -> String {
        table::damping_table(&self.proposed_damping_ratio)
    }
}
