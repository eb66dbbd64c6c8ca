//! The difference of two datasets: their rows matched by the values of the factors, and outputs that differ by more than
//! they scatter.
//!
//! # What belongs together
//!
//! Two rows match if all factors have equal values: to the last bit, whole numbers and real ones alike. Of rows with the same
//! values in one dataset (repetitions, a study without factors) the first matches the first, the second the second.
//!
//! # When an output differs
//!
//! A row and ten twins span a range of each main output, of which `<output>_scatter` is the half, `s` (estimated where there are
//! fewer or more). The rows may be anywhere within theirs. Their outputs `a` and `b` lie beyond their scatter where these ranges cannot meet:
//!
//! ```text
//! |a - b| > 2 (s_a + s_b)
//! ```
//!
//! If only one dataset has twins, the other one is assumed to have the same scatter. Without twins, or for an output without a scatter, two
//! numbers differ if `|a - b| > relative * max(|a|, |b|)`. Texts differ if they are unequal and neither row has a twin with another text.
//! An output that only one of the two rows has differs.
//!
//! Outputs are compared of rows that are done in both; rows of different status are listed by themselves.
//!
//! # Memory
//!
//! 56 bytes per row of each dataset for the matching, and a quarter of a gigabyte for the outputs that are looked at together.

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
