//! Linear algebra as a thin adapter: matrices of `nalgebra` and `sprs` go in and out, `faer` computes. Nothing else in the crate calls
//! `faer`.
//!
//! Every routine runs on the calling thread, so results do not depend on the number of threads. Studies gain more from running rows in
//! parallel.

mod dense;
mod draws;
mod lanczos;
mod ordering;
mod panel;
mod pencil;
mod update;

pub use dense::{
    SymmetricEigen, cholesky, cholesky_inverse, multiply, multiply_transposed, solve_lower, solve_lower_transposed,
    symmetric_eigen, symmetric_eigenvalues,
};
pub use lanczos::{Below, PencilModes, lowest_eigenvalue, modes_below};
pub use pencil::{PencilFactor, SymmetricPencil};
pub use update::{UpdatedPairs, updated_pairs};

use thiserror::Error;

/// A factorisation or an eigensolution that could not be completed.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum LinalgError {
    /// Cholesky met a pivot that is not positive.
    #[error("the matrix of order {order} is not positive definite")]
    NotPositiveDefinite {
        /// Number of rows.
        order: usize,
    },
    /// The matrix is not square, or the sizes of two operands differ.
    #[error("sizes do not match: {left:?} and {right:?} (rows, columns)")]
    Shape {
        /// Rows and columns of the first operand.
        left: (usize, usize),
        /// Rows and columns of the second operand.
        right: (usize, usize),
    },
    /// An LDL' factorisation met a pivot that is 0.
    #[error("the matrix of order {order} has a pivot that is 0")]
    ZeroPivot {
        /// Number of rows.
        order: usize,
    },
    /// The eigenvalue iteration found another number of eigenvalues than the inertia of the shifted matrix.
    #[error("found {found} of the {counted} eigenvalues that lie below the limit")]
    Incomplete {
        /// Eigenvalues found.
        found: usize,
        /// Number of existing eigenvalues.
        counted: usize,
    },
    /// The eigenvalue iteration did not converge.
    #[error("the eigenvalues of the matrix of order {order} did not converge")]
    NoConvergence {
        /// Number of rows.
        order: usize,
    },
    /// A NaN or an infinite entry.
    #[error("the matrix of order {order} has an entry that is not finite")]
    NotFinite {
        /// Number of rows.
        order: usize,
    },
    /// The factor does not fit into memory, or its size overflows the index type.
    #[error("not enough memory for the factor of the matrix of order {order}")]
    OutOfMemory {
        /// Number of rows.
        order: usize,
    },
}
