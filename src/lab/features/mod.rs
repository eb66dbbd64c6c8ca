//! Flat table for training predictors: one row per casting and run, from all tables of a dataset.
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
//! Figures that need time signals (the casting's acceleration, RMS velocities in bands) exist for runs whose means of that velocity are
//! stored. Other datasets have no such columns.

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
