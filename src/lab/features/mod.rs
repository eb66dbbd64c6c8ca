//! The flat table that a predictor is trained on: what the tables of a dataset say of each casting in each run, in one row.
//!
//! ```text
//! signals --octaves--> SignalRows --+
//! runs, blows --dataset--> Struck --+
//! study text --study--> outline ----+--> table of columns --file--> Parquet, CSV
//! factors, design's groups --groups, splits--^ |
//!                                             +--dictionary--> JSON, CSV
//!                                             +--croissant, card--> what the files are, for catalogues and for readers
//! ```
//!
//! What needs time signals (the casting's acceleration, root mean squares of its velocity in bands) is in the table for the runs
//! of which the study keeps the means of that velocity; a dataset without them has no such columns.

mod binders;
mod card;
mod column;
mod croissant;
mod dictionary;
mod error;
mod export;
mod figures;
mod file;
mod groups;
mod hammers;
mod leakage;
mod octaves;
mod plan;
mod settings;
mod signals;
mod splits;
mod struck;
mod table;

pub use column::{FeatureColumn, Role};
pub use error::FeaturesError;
pub use export::{export, files};
pub use groups::GroupBy;
pub use settings::{FeatureSettings, Format};
pub use splits::Splits;
pub use table::{Features, features};
