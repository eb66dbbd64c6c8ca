//! Models of plain tables of numbers: what a row not computed would give. Knows nothing of studies or datasets.
//!
//! - [`GaussianProcess`]: a process and noise, whose errors of rows left out are known without fitting anew.
//! - [`PolynomialChaos`]: polynomials by least squares, for comparison.
//! - [`Success`]: how likely a row succeeds, where some fail.
//!
//! All figures are the same for any number of threads: what runs in parallel is whole searches, each in one order.

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
