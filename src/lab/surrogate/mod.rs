//! Surrogates: [`decore_statistics::regression`] applied to the rows of a dataset, and stored in a file that predicts rows without
//! running them.
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
pub use file::{PREDICTOR, from_bytes, read, to_bytes, write};
pub(crate) use fit::{Derived, fit_derived};
pub use fit::{SurrogateSettings, fit, fit_with};
pub use model::{Model, OutputModel, RowsProcess};
pub use predict::{QueryRow, predict, predict_rows};
pub use result::{OutputSurrogate, ProcessFigures, Surrogate};
pub use space::FactorSpace;
pub(crate) use space::text_places;
pub(crate) use success::{SuccessModel, fit_success};
