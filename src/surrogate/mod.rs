//! Surrogates: what [`crate::regression`] makes of the rows of a dataset, kept in a file that predicts rows not run.
//!
//! ```text
//! tables --dataset, sensitivity--> Table --fit--> Model --file--> Parquet --+--file--> Model --predict--> columns
//! study text --study--> DesignOutline --^           |                       +--NumPy--> the same figures
//!                                                   +--> Surrogate --> text, JSON
//! ```

mod error;
mod file;
mod fit;
mod levels;
mod model;
mod predict;
mod result;
mod rows;
mod space;
mod success;
mod text;

pub use error::SurrogateError;
pub use file::{PREDICTOR, read, write};
pub use fit::{Derived, SurrogateSettings, fit, fit_derived};
pub use model::{Model, OutputModel, RowsProcess};
pub use predict::{Predicted, Row, predict, predict_rows};
pub use result::{ChaosFigures, OutputSurrogate, ProcessFigures, SuccessFigures, Surrogate};
pub use space::{FactorSpace, text_places};
pub use success::{SuccessModel, fit_success};
