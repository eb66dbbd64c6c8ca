//! Models that predict rows of plain tables of numbers. Independent of studies and datasets.
//!
//! - [`GaussianProcess`]: a process with noise; errors of left-out rows follow without a new fit.
//! - [`PolynomialChaos`]: polynomials by least squares, for comparison.
//! - [`Success`]: probability that a row succeeds, if some fail.
//!
//! All figures are the same for any number of threads. Threads run whole searches, each in one order.

mod chaos;
mod error;
mod gaussian;
mod groups;
mod kernel;
mod likelihood;
mod minimise;
mod ordered;
mod places;
mod points;
mod residuals;
mod success;

pub use chaos::PolynomialChaos;
pub use error::RegressionError;
pub use gaussian::{FOLDS, GaussianProcess, LEAST_ROWS, Prediction, check};
pub use groups::Groups;
pub use kernel::Kernel;
pub use likelihood::{Hyperparameters, LEAST_NOISE};
pub use places::{Places, Spread};
pub use points::Points;
pub use residuals::Residuals;
pub use success::Success;
