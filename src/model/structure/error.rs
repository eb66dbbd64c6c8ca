//! Errors between a file and its modes.

use thiserror::Error;

use decore_math::linalg::LinalgError;

/// A fault at one place of a file.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{file}, line {line}: {reason}")]
pub struct FileFault {
    /// The file as it was named.
    pub file: String,
    /// Line, counted from 1.
    pub line: usize,
    /// Found and expected contents.
    pub reason: String,
}

/// Errors of this module.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StructureError {
    /// A file that cannot be opened or read.
    #[error("{file}: cannot be read: {reason}")]
    Read {
        /// The file as it was named.
        file: String,
        /// The system's reason.
        reason: String,
    },
    /// A file that cannot be written.
    #[error("{file}: cannot be written: {reason}")]
    Write {
        /// The file as it was named.
        file: String,
        /// The system's reason.
        reason: String,
    },
    /// A wrong or missing line.
    #[error(transparent)]
    Line(#[from] FileFault),
    /// A matrix as a whole that cannot be a mass or stiffness.
    #[error("{file}: {reason}")]
    Matrix {
        /// The file as it was named, or `mass`/`stiffness` of a model built in memory.
        file: String,
        /// The fault and the expected value.
        reason: String,
    },
    /// A name that the table of interface points does not have.
    #[error("unknown interface point \"{name}\"{}", suggestion(nearest))]
    UnknownPoint {
        /// Requested name.
        name: String,
        /// The nearest known name.
        nearest: Option<String>,
    },
    /// A point that the reduction did not keep in this direction.
    #[error(
        "interface point \"{point}\": direction {dof} is not in the reduced structure (kept: {kept}); add it to the interface"
    )]
    DofNotKept {
        /// Requested point.
        point: String,
        /// Requested direction.
        dof: String,
        /// The directions that are kept, separated by blanks.
        kept: String,
    },
    /// An argument that is out of its range.
    #[error("{name}: expected {expected}, found {found}")]
    Argument {
        /// Name of the argument.
        name: String,
        /// Expected value.
        expected: String,
        /// Found value.
        found: String,
    },
    /// A step of linear algebra that failed.
    #[error("{step}: {source}; {advice}")]
    Linalg {
        /// Failed step.
        step: &'static str,
        /// Cause.
        source: LinalgError,
        /// Remedy.
        advice: &'static str,
    },
    /// A direction of an interface point that the model does not have.
    #[error(
        "interface point \"{point}\": the model has no row for direction {dof} (it has: {known}); it is fixed or condensed \
         there, or its elements have no such direction: use another point or direction; a mount needs all six only where the \
         hammers' housings are added to the machine (`housings = \"add\"`)"
    )]
    NoSuchDof {
        /// Requested point.
        point: String,
        /// Requested direction.
        dof: String,
        /// The directions that the model has there, separated by blanks.
        known: String,
    },
    /// A direction of an interface point whose row is empty.
    #[error(
        "interface point \"{point}\": direction {dof} (row {row}) carries neither mass nor stiffness: it is fixed in the \
         finite element program or belongs to no element; use another point or direction; a mount needs all six only where the \
         hammers' housings are added to the machine (`housings = \"add\"`)"
    )]
    EmptyDof {
        /// Requested point.
        point: String,
        /// Requested direction.
        dof: String,
        /// Row of the matrices, counted from 1.
        row: usize,
    },
    /// No mode lies below the cut-off.
    #[error("no mode below {cutoff_hz} Hz; the lowest lies at {lowest_hz:.4} Hz: raise the cut-off frequency")]
    NoModes {
        /// Requested cut-off, in Hz.
        cutoff_hz: f64,
        /// The lowest natural frequency, in Hz.
        lowest_hz: f64,
    },
    /// A mass that is larger than the stiffness in every row.
    #[error(
        "stiffness and mass look exchanged: stiffness over mass reaches {highest_hz:.1e} Hz only; exchange the two files, or check \
         `units`"
    )]
    Exchanged {
        /// The highest frequency of a row alone, `sqrt(K_ii / M_ii) / 2 pi`, in Hz.
        highest_hz: f64,
    },
    /// More modes than any study needs.
    #[error(
        "at least {count} modes lie below {cutoff_hz} Hz (fixed_interface_cutoff_hz or cutoff_hz), of {order} rows: {}lower the cut-off",
        if *suspect { "stiffness and mass look as if they were in different units; check `units` of both files, or " } else { "" }
    )]
    TooManyModes {
        /// Modes below the cut-off, or as many of them as were counted.
        count: usize,
        /// The cut-off in Hz.
        cutoff_hz: f64,
        /// Rows of the model.
        order: usize,
        /// Whether stiffness and mass look as if they were in different units.
        suspect: bool,
    },
    /// Linear algebra that failed on matrices that look wrong.
    #[error("the matrices look wrong: {remarks} ({source})")]
    LooksWrong {
        /// Doubtful properties, separated by semicolons.
        remarks: String,
        /// Cause.
        source: Box<StructureError>,
    },
    /// A negative squared frequency: the stiffness is not positive semidefinite.
    #[error(
        "the stiffness is not positive semidefinite: smallest eigenvalue omega^2 = {omega_squared:.3e} 1/s2; check signs and units of the stiffness matrix"
    )]
    Indefinite {
        /// The smallest eigenvalue, in 1/s2.
        omega_squared: f64,
    },
}

fn suggestion(nearest: &Option<String>) -> String {
    nearest.as_ref().map(|name| format!("; the nearest known name is \"{name}\"")).unwrap_or_default()
}

impl StructureError {
    pub(super) fn argument(name: impl Into<String>, expected: impl Into<String>, found: impl ToString) -> Self {
        Self::Argument { name: name.into(), expected: expected.into(), found: found.to_string() }
    }

    /// Adds doubtful properties of the matrices to the error, if they may be its cause.
    pub(super) fn with_causes(self, remarks: &[String]) -> Self {
        let may_be = match &self {
            Self::Linalg { source, .. } => !matches!(source, LinalgError::OutOfMemory { .. }),
            Self::Indefinite { .. } => true,
            _ => false,
        };
        if !may_be || remarks.is_empty() {
            return self;
        }
        Self::LooksWrong { remarks: remarks.join("; "), source: Box::new(self) }
    }
}

/// Advice for errors that the matrices do not cause.
const MORE_MEMORY: &str = "raise the limit on memory (`ulimit -v`), or use a machine with more";

/// Adds the failed step and a remedy to an error.
pub(super) trait Step<T> {
    fn step(self, step: &'static str, advice: &'static str) -> Result<T, StructureError>;
}

impl<T> Step<T> for Result<T, LinalgError> {
    fn step(self, step: &'static str, advice: &'static str) -> Result<T, StructureError> {
        self.map_err(|source| {
            let advice = if matches!(source, LinalgError::OutOfMemory { .. }) { MORE_MEMORY } else { advice };
            StructureError::Linalg { step, source, advice }
        })
    }
}
