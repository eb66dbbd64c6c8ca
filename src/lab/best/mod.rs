//! The answer to a study's goal: values of the decision factors, expected results over the uncertain factors, and their confidence.
//!
//! ```text
//! datasets --surrogate--> Models --+
//! study --> Space: decisions, nodes +--> Pool: what is expected of decisions --> rows to learn, rows to check, Answer
//!                                  robust: averages, quantiles
//! ```
//!
//! `plan` decides the rows: rows to learn, runs that compare places (`rivals`), checks. `trials` reads the runs of decisions.
//!
//! Each step is a function of the study, the settings and the earlier rows. After an interruption the same rows are chosen again.

mod added;
mod answer;
mod checks;
mod error;
mod model;
mod plan;
mod result;
mod rivals;
pub mod robust;
mod search;
mod space;
mod task;
mod text;
mod trials;
mod view;

pub use added::{ADDED_COLUMNS, added_file, added_folder, read_added};
pub use error::BestError;
pub use plan::{Step, expected, learn, next};
pub use result::{Answer, Verdict};
pub use task::{Added, BestSettings, Purpose, There, question};
pub use view::{AnswerView, ShownValue, Track, answer_view};
