//! Chooses the rows to run next: where the surrogates are uncertain, or where they promise a better row.
//!
//! ```text
//! dataset --surrogate--> Model --+
//! study, seed --> candidates ----+--acquisition--> rows of the next batch
//! ```
//!
//! A batch is a function of the study, the seed and the earlier rows. After an interruption the same rows are proposed again.

mod acquisition;
mod candidates;
mod climb;
mod constant;
mod error;
mod goal;
mod progress;
mod propose;
mod separate;

pub use acquisition::{Learned, LimitSide, Seeking, Side, improving, learning};
pub use climb::{LEAST_DISTANCE, highest_peak, is_apart};
pub use error::RefinementError;
pub use goal::{Aim, Goal, Limit, Target};
pub use progress::Progress;
pub(crate) use propose::places;
pub use propose::{CAUTIOUS, Proposal, RefinementSettings, SHARP_NOISE, propose};
