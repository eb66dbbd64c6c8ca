//! When cores are out: tests of cores give the law of the dose that they need, and the dataset the time until a row reaches it.
//!
//! ```text
//! table of tests --read--> tests --+--> law of the dose --result--> doses with intervals
//! dataset --course--> dose over time of each core point --+--> times until the cores of each row are out
//! ```

mod course;
mod error;
mod read;
mod result;
mod solve;
mod text;

pub use error::CoresError;
pub use result::{CoreTest, CoreTests, DoseAtShare, RowTimes};
pub use solve::{CoreSettings, OutTimes, solve};
