//! Sensitivity indices of plain tables of numbers. Independent of studies and datasets.
//!
//! - [`sobol()`]: shares of the variance, from the blocks of a Saltelli design.
//! - [`morris()`]: elementary effects, from trajectories.
//! - [`given()`]: first-order indices by ranks, correlation ratios, PAWN and HSIC, from any rows.
//! - [`shapley()`]: Shapley effects, from any rows, also of factors that depend on each other.
//! - [`spread()`]: whether rows are laid out too evenly for estimators that compare neighbours.
//! - [`Bootstrap`]: confidence intervals by resampling whole blocks, trajectories or rows.
//!
//! All figures are the same for any number of threads. Threads run whole replicates, each in one order, with random numbers addressed by
//! (seed, replicate, draw).

mod error;
mod estimate;
mod factor;
mod given;
mod hsic;
mod morris;
mod pawn;
mod shapley;
mod sobol;
mod spread;

pub use error::AnalysisError;
pub use estimate::{Bootstrap, Estimate};
pub use factor::{FactorValues, drawn_rows, kruskal_wallis, rank_correlation, rank_correlation_p_value};
pub use given::given;
pub use morris::{Effects, Reach, Trajectories, morris};
pub use shapley::{MOST_SHAPLEY_FACTORS, shapley, shapley_rows};
pub use sobol::{Estimator, SaltelliBlocks, SobolIndices, sobol};
pub use spread::spread;
