//! Compares two datasets: matches their rows by the values of the factors, and finds outputs that differ by more than their scatter.
//!
//! # What belongs together
//!
//! Two rows match if all factors are equal, to the last bit. Rows with equal factors in one dataset (repetitions, a study without
//! factors) match in their order.
//!
//! # When an output differs
//!
//! A row and its ten twins span a range of each main output. `<output>_scatter` is half of this range, `s` (estimated for another number
//! of twins). Each row lies anywhere within its range. Two outputs `a` and `b` differ if these ranges cannot overlap:
//!
//! ```text
//! |a - b| > 2 (s_a + s_b)
//! ```
//!
//! If only one dataset has twins, the other one is assumed to have the same scatter. Without twins, or for an output without a scatter, two
//! numbers differ if `|a - b| > relative * max(|a|, |b|)`. Texts differ if they are unequal and neither row has a twin with another text.
//! An output that only one of the two rows has differs.
//!
//! Outputs are compared for rows that are done in both datasets. Rows with different status are listed separately.
//!
//! # Memory
//!
//! Matching needs 56 bytes per row of each dataset. Outputs that are compared at the same time need a quarter of a gigabyte.

mod compare;
mod error;
mod matching;
mod outputs;
mod result;
mod settings;

pub use compare::compare;
pub use error::ComparisonError;
pub use result::{Comparison, Listed, OutputDifference, PairDifference, Side};
pub use settings::ComparisonSettings;
